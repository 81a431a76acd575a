"""The dataset: its schema, stored and opened, checked, merged, selected, summarised, remeasured, replayed, exported.

In: values piece by piece, or a file.
Out: an xarray.Dataset, a file, rows of a table, a trace.
Must not know: who ran the trials and how, what is drawn.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
