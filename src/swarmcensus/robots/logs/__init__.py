"""What robots have logged: read, lived again by the same brain or another, and put into other tools' formats.

In: folders with logs of `swarmcensus.runtime.log`, and brains.
Out: what happened on each robot, whether its state can be lived again to the bit, traces, MCAP files and rosbags.
Must not know: how logs came to be, on boards or in processes.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
