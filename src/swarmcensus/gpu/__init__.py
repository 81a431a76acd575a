"""Runs batches of networks on a graphics card, with the bits of the CPU engine.

In: a Setting, a seed, trials, what to measure, as `simulation.run_batch` takes them.
Out: a Batch; or why a setting cannot run on a card.
Must not know: tasks, threads, files of results.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
