"""Checks whether a brain file keeps the contract, and whether machine code and CPython agree.

In: a brain file.
Out: checks, each with a fault in a sentence, or none.
Must not know: settings, results, runs.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
