"""swarmcensus: robot swarms with lying sensors agree on how much of a floor is black.

import swarmcensus as sc
results = sc.run(sc.Study.load("study.toml"), jobs=2)     # -> xarray.Dataset
trace   = sc.replay(results, setting=3, trial=0)          # -> xarray.Dataset, every round
"""

import importlib
import sys
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from swarmcensus.errors import InputError, Interrupted
    from swarmcensus.merging import merge
    from swarmcensus.remeasuring import remeasure
    from swarmcensus.results import frame, load, save
    from swarmcensus.running import run
    from swarmcensus.studies import Study
    from swarmcensus.summaries import summary
    from swarmcensus.traces import infer, replay
    from swarmcensus.verifying import verify

_HOME = {
    "InputError": "errors",
    "Interrupted": "errors",
    "Study": "studies",
    "frame": "results",
    "infer": "traces",
    "load": "results",
    "merge": "merging",
    "remeasure": "remeasuring",
    "replay": "traces",
    "run": "running",
    "save": "results",
    "summary": "summaries",
    "verify": "verifying",
}
__all__ = [
    "InputError",
    "Interrupted",
    "Study",
    "frame",
    "infer",
    "load",
    "merge",
    "remeasure",
    "replay",
    "run",
    "save",
    "summary",
    "verify",
]


def __getattr__(name: str) -> Any:
    """Import on first use, so that the command line answers at once."""
    if name not in _HOME:
        raise AttributeError(f"module 'swarmcensus' has no attribute {name!r}", name=name, obj=sys.modules[__name__])
    return getattr(importlib.import_module(f"swarmcensus.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    """The public names."""
    return [*__all__, "__version__"]
