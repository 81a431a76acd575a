"""Runs studies: cuts them into tasks, runs these in threads or on a cluster, resumes, reports progress and verifies.

In: a Study and where its results go.
Out: a dataset; finished work is never lost.
Must not know: figures, claims, the command line.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
