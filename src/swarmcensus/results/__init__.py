"""Results: arrays of values, the dataset, and its file, which is read, checked and merged.

In: values piece by piece, or a file.
Out: an xarray.Dataset, a file, and the studies that it was made from.
Must not know: who ran the trials and how, what is made of the numbers.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
