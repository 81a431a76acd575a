"""Closed forms to compare measurements with: exact distributions, bounds, mixing on networks, finite floors.

In: numbers and arrays, graphs.
Out: numbers and arrays.
Must not know: brains, studies, settings, results.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
