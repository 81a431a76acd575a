"""Brains compared within each world, paired trial by trial: `sc.compare`.

In: a dataset.
Out: a `Comparison`: measures, differences with intervals, p-values, ranks, and sentences about them.
Must not know: who ran the trials and how, what is drawn.
"""
