"""Compares measurements with theory: `sc.explain`.

In: a dataset.
Out: an `Explanation` of one setting, or the agreement of all settings with theory.
Must not know: how trials were run, what is drawn.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
