"""The evaluations that `reproduce` runs: the paper's own, and published results on rivals.

Each is a file next to this one, `paper.toml` and `rivals.toml`. There a claim names the function that measures it, and
perhaps one that explains why it does not hold and one that writes a note, as a text, or as a table with its arguments.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import xarray as xr

from swarmcensus.evaluation.paper import explanations, measures, rival_explanations, rival_measures
from swarmcensus.evaluation.paper.evidence import Claim, Range
from swarmcensus.results import finished, places_with
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.intervals import FEWEST

if TYPE_CHECKING:
    from swarmcensus.figures import Scale

INFINITE = float("inf")


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
        return self.caption, data.isel(setting=places_with(data, self.where)), self.local


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


@dataclass(frozen=True)
class Evaluation:
    """Figures, claims and the texts of their page. `name` is also the folder of the studies."""

    name: str
    title: str
    lead: str
    source: str
    about: str
    symbols: str
    settings: str  # the settings that claims are about
    figures: tuple[PaperFigure, ...]
    claims: tuple[Claim, ...]
    section: str  # printed before the section of a claim
    quoted: bool  # whether sentences are quoted word for word

    @property
    def parts(self) -> tuple[str, ...]:
        """The names that --only takes."""
        return (*(figure.name for figure in self.figures), "claims")


def evaluation(name: str) -> Evaluation:
    """The evaluation with this name. Raises InputError."""
    if name not in EVALUATIONS:
        known = ", ".join(EVALUATIONS)
        why = f"there is no {name!r} to reproduce: {did_you_mean(name, EVALUATIONS)}known are {known}"
        raise InputError(why, key="of", value=name)
    return EVALUATIONS[name]


def _read(name: str, measuring: ModuleType, explaining: ModuleType) -> Evaluation:
    """The evaluation of a file; its claims name functions of the two modules."""
    known = tomllib.loads(Path(__file__).with_name(f"{name}.toml").read_text(encoding="utf-8"))
    dots = known.pop("dots", "")
    contenders = {one: (where.pop("study"), where) for one, where in known.pop("contenders", {}).items()}
    figures = tuple(_figure(table, dots) for table in known.pop("figures", ()))
    claims = tuple(_claim(table, contenders, measuring, explaining) for table in known.pop("claims"))
    return Evaluation(name, figures=figures, claims=claims, **known)


def _figure(table: Mapping[str, Any], dots: str) -> PaperFigure:
    given = dict(table) | {"claims": tuple(table["claims"]), "text": table["text"].replace("{dots}", dots)}
    return PaperFigure(views=tuple(View(**panel) for panel in given.pop("panels")), **given)


def _claim(
    table: Mapping[str, Any],
    contenders: Mapping[str, tuple[str, Mapping[str, Any]]],
    measuring: ModuleType,
    explaining: ModuleType,
) -> Claim:
    """A claim; its studies are those that it names, and those of its contenders."""
    given = {"right": _range_of(table["threshold"])} | dict(table)
    measure = dict(given["measure"]) if isinstance(given["measure"], dict) else {"name": given["measure"]}
    studies = list(given.get("studies", ()))
    for key, value in measure.items():
        if key in ("first", "second"):
            measure[key] = contenders[value]
            studies.append(measure[key][0])
        elif key in ("others", "contenders"):
            measure[key] = [contenders[name] for name in value]
            studies += [study for study, _ in measure[key]]
        elif key == "of" and contenders:
            measure[key] = getattr(measuring, value)
    made = {"measure": _function(measuring, measure), "right": tuple(given["right"])}
    for key, module in (("note", measuring), ("explanation", explaining)):
        made |= {key: _function(module, given[key])} if key in given else {}
    return Claim(**given | made | {"studies": tuple(dict.fromkeys(studies))})


def _function(module: ModuleType, wanted: str | Mapping[str, Any]) -> Callable[..., Any]:
    """A function of a module by its name, or by a table of its name and arguments."""
    given = {"name": wanted} if isinstance(wanted, str) else dict(wanted)
    function: Callable[..., Any] = getattr(module, given.pop("name"))
    return partial(function, **given) if given else function


def _range_of(threshold: str) -> Range | None:
    """The range that words such as "below 0.05" and "within 0.8 to 1.25" mean; None for other words."""
    if found := re.fullmatch(r"within (\S+) to (\S+)", threshold):
        return float(found[1]), float(found[2])
    if found := re.match(r"(below|above) (-?\d\S*)", threshold):
        end = float(found[2])
        return (-INFINITE, end) if found[1] == "below" else (end, INFINITE)
    return None


PAPER = _read("paper", measures, explanations)
RIVALS = _read("rivals", rival_measures, rival_explanations)
EVALUATIONS = {each.name: each for each in (PAPER, RIVALS)}
