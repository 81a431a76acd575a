"""Compares brains within each world, paired trial by trial: `sc.compare`.

In: a dataset.
Out: a `Comparison`: measures, differences with intervals, p-values, ranks, and sentences about them.
Must not know: how trials were run, what is drawn.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
