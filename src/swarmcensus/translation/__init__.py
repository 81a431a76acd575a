"""A brain as C: for boards, for simulators of robots and for chips, with the same bits as in CPython.

In: a brain, in the number formats of its robot.
Out: C as text, and a self-test; the pieces of boards' programs in `boards`.
Must not know: how a board's files are made of these, studies, worlds, results.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
