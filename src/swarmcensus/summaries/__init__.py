"""What a dataset says: measures of settings, their intervals, cautions and labels, and its trials again.

In: a dataset or a results file; settings to be selected.
Out: numbers of settings, rows of a table, a dataset measured again, a trace.
Must not know: how a file keeps it, what is drawn.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
