"""Runs trials of a setting: batches, moving robots, single trials in full; and brains on recorded observations.

In: a Setting, a seed, trials, what to measure; or observations and links.
Out: a Batch of metrics, a trial in full, or a trace.
Must not know: files of results, how studies are run, other settings' results.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
