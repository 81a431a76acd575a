"""Brain, adversary and metric files: found, checked against a contract, loaded, hashed; `library` has shipped brains.

In: a file, or the name of a shipped one or of one of another package.
Out: a Brain: its functions, memory, message, parameters and source; also for an adversary with a brain that it wraps.
Must not know: how brains are compiled, worlds, studies.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
