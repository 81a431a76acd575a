"""The live page: one trial, simulated while it is watched or from robots' logs, in a browser or one HTML file.

In: a study, results or a folder of logs; requests of a page.
Out: frames as bytes, the memory of a robot as JSON, a server, an HTML file.
Must not know: the command line; how a page draws.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
