"""The paper's evaluation: its studies are run, figures drawn, claims checked and explained, on one page.

In: the paper's study files.
Out: datasets, figures, claims.json, index.html.
Must not know: the command line.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
