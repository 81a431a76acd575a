"""Runs trials of a setting: batches, moving robots, single trials in full, and the reference in CPython.

In: a Setting, a seed, trials, what to measure.
Out: a Batch of metrics, or a trial in full.
Must not know: datasets, files, threads, other settings' results.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
