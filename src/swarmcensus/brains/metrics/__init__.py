"""Metric files: found, checked against their contract, hashed; `library` has the shipped metrics.

In: a metric file, or the name of a shipped one or of one of another package.
Out: a Metric: its functions, the fields of its record, its unit and meaning.
Must not know: how metrics are compiled, brains, worlds, studies.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
