"""swarmcensus: robot swarms with lying sensors agree on how much of a floor is black.

import swarmcensus as sc
results = sc.run(sc.Study.load("study.toml"), jobs=2)     # -> xarray.Dataset
trace   = sc.replay(results, setting=3, trial=0)          # -> xarray.Dataset, every round
figure  = sc.plot.lines(results, x="robots")              # -> matplotlib Figure
"""

import importlib
import sys
from typing import TYPE_CHECKING, Any

from swarmcensus.support.version import __version__

if TYPE_CHECKING:
    from swarmcensus import theory
    from swarmcensus.analysis.comparing.comparison import compare
    from swarmcensus.analysis.explaining.agreement import explain
    from swarmcensus.checks.checking import check
    from swarmcensus.evaluation.paper.reproducing import reproduce
    from swarmcensus.evaluation.ranking.board import leaderboard
    from swarmcensus.figures import plot
    from swarmcensus.live.frame import watch
    from swarmcensus.results.merging import merge
    from swarmcensus.results.remeasuring import remeasure
    from swarmcensus.results.replaying import replay
    from swarmcensus.results.store import frame, load, save
    from swarmcensus.results.summaries import summary
    from swarmcensus.robots.deploying import deploy
    from swarmcensus.runs.running import run
    from swarmcensus.runs.verifying import verify
    from swarmcensus.search.planning.planning import plan
    from swarmcensus.search.tuning.tuning import tune
    from swarmcensus.simulation.inferring import infer
    from swarmcensus.studies.study import Study
    from swarmcensus.support.errors import InputError, Interrupted

_HOME = {
    "InputError": "basics.errors",
    "Interrupted": "basics.errors",
    "Study": "studies.study",
    "check": "conformance.checking",
    "compare": "comparing.comparison",
    "deploy": "deployment.deploying",
    "explain": "explaining.agreement",
    "frame": "results.store",
    "infer": "simulation.inferring",
    "leaderboard": "ranking.board",
    "load": "results.store",
    "merge": "results.merging",
    "plan": "planning.planning",
    "plot": "figures.plot",
    "remeasure": "results.remeasuring",
    "replay": "results.replaying",
    "reproduce": "paper.reproducing",
    "run": "runs.running",
    "save": "results.store",
    "summary": "results.summaries",
    "theory": "theory",
    "tune": "tuning.tuning",
    "verify": "runs.verifying",
    "watch": "watching.frame",
}
__all__ = [
    "InputError",
    "Interrupted",
    "Study",
    "check",
    "compare",
    "deploy",
    "explain",
    "frame",
    "infer",
    "leaderboard",
    "load",
    "merge",
    "plan",
    "plot",
    "remeasure",
    "replay",
    "reproduce",
    "run",
    "save",
    "summary",
    "theory",
    "tune",
    "verify",
    "watch",
]


def __getattr__(name: str) -> Any:
    """Import on first use, so that the command line answers at once."""
    if name not in _HOME:
        raise AttributeError(f"module 'swarmcensus' has no attribute {name!r}", name=name, obj=sys.modules[__name__])
    home = importlib.import_module(f"swarmcensus.{_HOME[name]}")
    return home if home.__name__.endswith(f".{name}") else getattr(home, name)


def __dir__() -> list[str]:
    """The public names."""
    return [*__all__, "__version__"]


if "IPython" in sys.modules and (_shell := sys.modules["IPython"].get_ipython()) is not None:
    from swarmcensus.figures.notebook import register

    register(_shell)
    del register
