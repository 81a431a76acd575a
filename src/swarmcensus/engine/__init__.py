"""Compiled loops and counter-based random numbers: what robots see, say and estimate, round by round or tick by tick.

In: a brain's source, arrays, keys.
Out: arrays of states, estimates and metrics.
Must not know: worlds by name, studies, settings, files of results.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
