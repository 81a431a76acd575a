"""Takes a brain to robots: files for boards, `swarm` of processes that talk over sockets, and the `logs` of both.

In: a brain in the number formats of its robot, its sensor's accuracies and its radio; folders of logs.
Out: files for MicroPython and in C, size and speed on simulated chips; logs; traces, MCAP files and rosbags.
Must not know: results, figures.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
