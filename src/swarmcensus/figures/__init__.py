"""Figures and films: one function for each kind, from a dataset or a trace to a matplotlib Figure.

In: a dataset, a trace.
Out: a Figure, files of pictures.
Must not know: how trials are run, the paper's claims, the command line.
"""
