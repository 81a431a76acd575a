"""Searches by simulation: `planning` finds how many robots and minutes a mission takes, `tuning` a brain's parameters.

In: a mission, or a study with a brain and ranges of its parameters.
Out: plans with their intervals; the program with the values found, a log, and a comparison on other trials.
Must not know: the command line, figures.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
