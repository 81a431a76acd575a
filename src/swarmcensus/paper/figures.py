"""The paper's Figs. 2 to 5: the settings that each panel shows, and the text below each figure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from swarmcensus.results.structure import finished
from swarmcensus.statistics.intervals import FEWEST

if TYPE_CHECKING:
    from swarmcensus.figures.sheets import Scale


@dataclass(frozen=True)
class View:
    """One panel of a figure: the settings of `study` that have the coordinates `where`."""

    caption: str
    study: str
    where: Mapping[str, object]
    local: bool = False

    def panel(self, datasets: Mapping[str, xr.Dataset]) -> tuple[str, xr.Dataset, bool]:
        """The panel as the drawing functions take it."""
        data = datasets[self.study]
        mask = np.logical_and.reduce([data[name].values == value for name, value in self.where.items()])
        return self.caption, data.isel(setting=np.flatnonzero(mask)), self.local


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: its panels, the text below it, and the claims about it."""

    name: str
    title: str
    kind: str  # "scatter" or "decisions"
    views: tuple[View, ...]
    text: str
    claims: tuple[str, ...]
    scale: Scale = "log"  # of a scatter

    def caption(self, datasets: Mapping[str, xr.Dataset]) -> str:
        """The text, without its mention of intervals if there are too few trials for them."""
        parts = [view.panel(datasets)[1] for view in self.views if view.study in datasets]
        most = max((int(finished(part).sum(axis=1).max(initial=0)) for part in parts), default=0)
        return self.text if most >= FEWEST else self.text.replace(_CROSSES, "").replace(_LINE, "")


def _view(caption: str, topology: str, fill: float, study: str = "topologies") -> View:
    return View(caption, study, {"topology": topology, "robots": 100, "fill_ratio": fill})


def _moving(caption: str, density: float, fill: float) -> View:
    return View(caption, "moving", {"density": density, "robots": 25, "fill_ratio": fill})


_CROSSES = "; crosses that stand out are their 95 % intervals over trials"
_LINE = "a thin line through it is its 95 % interval over trials, and "
_DOTS = (
    "Every faint dot is one robot in one trial: to the right the time until its estimate settled, upwards how wrong it "
    "then was. The outlined dots are medians, a colour for each sensor accuracy, a black ring for the heterogeneous "
    f"swarm{_CROSSES}. Best is bottom left. "
)

FIGURES: tuple[PaperFigure, ...] = (
    PaperFigure(
        name="fig2",
        title="Fig. 2: alone and together, 100 robots, f = 0.55",
        kind="scatter",
        views=(
            View("local estimates, no communication", "local", {"robots": 100, "fill_ratio": 0.55}, local=True),
            _view("fully connected", "full", 0.55),
            _view("ring", "ring", 0.55),
            _view("scale-free", "scale-free", 0.55),
        ),
        text=_DOTS + "Panel (a) counts single observations, 10,000 in all; (b) to (d) count communication rounds of 10 "
        "observations each. Three things to look at: whether medians move down and left as sensors get better; how "
        "much higher those of poor sensors lie in (a) than in the other panels; and how much sooner the fully "
        "connected settle than robots on the ring and on the scale-free tree. The paper shows the same four panels.",
        claims=(
            *("low-error-055", "full-agrees", "full-first", "ring-like-line", "informed-first", "helps-poor"),
            *("grows", "mixed-055"),
        ),
    ),
    PaperFigure(
        name="fig3",
        title="Fig. 3: a blacker floor, and talking too early; 100 robots, scale-free",
        kind="scatter",
        views=(
            _view("f = 0.95, R = 10", "scale-free", 0.95),
            _view("f = 0.55, R = 1", "scale-free", 0.55, "same-rounds"),
        ),
        text=_DOTS + "Panel (a) is Fig. 2 (d) on a floor that is nearly all black: do good sensors lie further left? "
        "Estimates that are cut off at 1 have the error 1 - f, and make a streak. In panel (b) robots talk after "
        "every observation, and so have made a tenth of the observations by the last round: how much further right "
        "do they lie, and how much higher do errors reach? The paper shows the same two panels.",
        claims=(
            *("low-error-095", "mixed-095", "blacker-first-sparse", "blacker-first-full"),
            *("same-observations", "same-rounds"),
        ),
    ),
    PaperFigure(
        name="fig4",
        title="Fig. 4: how many robots decide rightly; 100 on a scale-free network, 25 that move",
        kind="decisions",
        views=(
            _view("scale-free, f = 0.55", "scale-free", 0.55),
            _view("scale-free, f = 0.95", "scale-free", 0.95),
            _moving("moving, D = 1, f = 0.55", 1.0, 0.55),
            _moving("moving, D = 1, f = 0.95", 1.0, 0.95),
        ),
        text="If the swarm were asked after so long: the share of robots, over all trials, that pick the right one of "
        f"ten bins. A diamond for each sensor accuracy, side by side; {_LINE}a dash "
        "over it says that not one robot of any trial erred. Columns of (a) and (b), in "
        "communication rounds of 10 observations, stand above those of (c) and (d), in ticks of one observation, after "
        "as many observations. Two things to look at: which swarms climb to the top, and how early the heterogeneous "
        "one comes close, whose robots with poor sensors depend on whom they hear. The paper shows these four panels.",
        claims=(
            *("consensus", "sooner-right", "consensus-moving", "mixed-consensus-moving", "mixed-sooner-moving"),
            "like-tree-moving",
        ),
    ),
    PaperFigure(
        name="fig5",
        title="Fig. 5: robots that move; 25 Khepera IV",
        kind="scatter",
        views=(
            _moving("D = 1, f = 0.55", 1.0, 0.55),
            _moving("D = 10, f = 0.55", 10.0, 0.55),
            _moving("D = 1, f = 0.95", 1.0, 0.95),
            _moving("D = 10, f = 0.95", 10.0, 0.95),
        ),
        text=_DOTS + "Time is in ticks of a tenth of a second, on a linear axis. Neighbours come and go: "
        "whenever they do, an estimate jumps towards what the new ones have seen, and settles only as robots come to "
        "differ little. Three things to look at: whether medians move left, and down, as sensors get better; whether "
        "they lie further left in the lower row, on the blacker floor; and where they go from left to right, as the "
        "swarm gets denser. Medians at the right edge are of swarms that have not settled when the run ends. The "
        "paper shows the same four panels.",
        claims=(
            *("denser-first", "denser-alike", "blacker-first-moving", "blacker-closer-moving", "grows-moving"),
            "impaired-moving",
        ),
        scale="log-y",
    ),
)
