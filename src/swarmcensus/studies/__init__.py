"""Studies: from tables and keys of a study file, over checks, to the grid of settings and their random addresses.

In: TOML text or Python values.
Out: a Study, its Settings, and the `COORDINATES` of the dataset in which they differ.
Must not know: how a setting is run, what is stored.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
