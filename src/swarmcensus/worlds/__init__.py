"""What surrounds a mind: sensors, networks, floors, bodies, arenas, faults; each parsed, validated and drawn here.

In: values of a study's tables, keys.
Out: accuracies, links, colours, stops, as arrays.
Must not know: brains, studies, settings, what is measured.
"""
