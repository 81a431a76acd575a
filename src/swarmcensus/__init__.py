"""swarmcensus: robot swarms with lying sensors agree on how much of a floor is black.

import swarmcensus as sc
results = sc.run(sc.Study.load("study.toml"), jobs=2)     # -> xarray.Dataset
trace   = sc.replay(results, setting=3, trial=0)          # -> xarray.Dataset, every round
figure  = sc.plot.lines(results, x="robots")              # -> matplotlib Figure
"""

import sys
from typing import Any

import lazy_loader

_imported, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    if name not in __all__:  # with what Python needs to suggest a name
        raise AttributeError(f"module 'swarmcensus' has no attribute {name!r}", name=name, obj=sys.modules[__name__])
    return _imported(name)


if "IPython" in sys.modules and (_shell := sys.modules["IPython"].get_ipython()) is not None:
    from swarmcensus.figures import notebook

    notebook.register(_shell)
    del notebook
