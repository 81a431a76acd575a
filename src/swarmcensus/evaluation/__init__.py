"""Evaluations that are shipped: `paper` has the paper's figures and claims, `ranking` is the leaderboard.

In: the shipped study files, and brain files of your own.
Out: datasets, figures, claims.json, pages.
Must not know: the command line.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
