"""The paper's figures: the settings that each panel shows, and the text below each figure (see `paper.toml`)."""

from __future__ import annotations

import re
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
    """A figure of the paper: its panels, the text below it with what is about intervals in brackets, and its claims."""

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
        return re.sub(r"\[(.*?)\]", r"\1" if most >= FEWEST else "", self.text)
