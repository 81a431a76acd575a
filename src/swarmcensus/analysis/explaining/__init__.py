"""Compares measurements with theory: `sc.explain`.

In: a dataset.
Out: an `Explanation` of one setting, or the agreement of all settings with theory.
Must not know: how trials were run, what is drawn.
"""
