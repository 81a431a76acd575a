"""Figures and films: one function for each kind, from a dataset or a trace to a matplotlib Figure.

In: a dataset, a trace.
Out: a Figure, files of pictures.
Must not know: how trials are run, the paper's claims, the command line.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
