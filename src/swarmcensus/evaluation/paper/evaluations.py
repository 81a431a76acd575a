"""The evaluations that `reproduce` runs: the paper's own, and published results on rivals.

Each is a file next to this one, `paper.toml` and `rivals.toml`. There a claim names a function of `measures.py`, what
this measures (functions of `quantities.py`), the contenders that it compares, and the worlds in which it does.
"""

from __future__ import annotations

import itertools
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from swarmcensus.evaluation.paper import measures, quantities
from swarmcensus.evaluation.paper.evidence import Claim, Contender, Needed
from swarmcensus.results import finished_trials
from swarmcensus.summaries import places_with
from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.intervals import FEWEST

if TYPE_CHECKING:
    from swarmcensus.figures import Scale


@dataclass(frozen=True)
class View:
    """One panel of a figure: the settings of `study` that have the coordinates `where`.

    `claim` is what is marked in it: an error that medians should be below, or a checkpoint by which all are right. On
    the paper's axes, a panel with an `own_limit` has errors up to its own highest.
    """

    caption: str
    study: str
    where: Mapping[str, object]
    local: bool = False
    claim: float | None = None
    own_limit: bool = False

    def panel(
        self, datasets: Mapping[str, xr.Dataset], *, as_paper: bool = False
    ) -> tuple[str, xr.Dataset, bool, float | None, float | None]:
        """The panel as the drawing functions take it."""
        data = datasets[self.study]
        part = data.isel(setting=places_with(data, self.where))
        limit = 1.05 * float(part["convergence_error"].max()) if as_paper and self.own_limit else None
        return self.caption, part, self.local, limit, self.claim


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper: its panels, the text below it with what is about intervals in brackets, and its claims.

    `quote` is from the caption in the paper; `claimed` is what the key says of the claims that panels mark.
    """

    name: str
    title: str
    kind: str  # "scatter" or "columns"
    views: tuple[View, ...]
    text: str
    claims: tuple[str, ...]
    quote: str
    claimed: str
    scale: Scale = "log"  # of a scatter

    def caption(self, datasets: Mapping[str, xr.Dataset], *, as_paper: bool = False) -> str:
        """The text, without its mention of intervals if there are too few trials for them, or none as in the paper."""
        parts = [view.panel(datasets)[1] for view in self.views if view.study in datasets]
        most = max((int(finished_trials(part).sum(axis=1).max(initial=0)) for part in parts), default=0)
        drawn = most >= FEWEST and not (as_paper and self.kind == "columns")
        return re.sub(r"\[(.*?)\]", r"\1" if drawn else "", self.text)


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


def _read(name: str) -> Evaluation:
    """The evaluation of a file."""
    known = tomllib.loads(Path(__file__).with_name(f"{name}.toml").read_text(encoding="utf-8"))
    dots = known.pop("dots", "")
    contenders, worlds = {}, known.pop("worlds", {})
    for each, where in known.pop("contenders").items():
        contenders[each] = Contender(each, where.pop("study"), where, where.pop("local", False))
    figures = tuple(_figure(table, dots) for table in known.pop("figures", ()))
    claims: dict[str, Claim] = {}
    for table in known.pop("claims"):
        like = claims.get(table.pop("like", ""))
        same = {"sentence": like.sentence, "section": like.section} if like else {}
        claims[table["id"]] = _claim(same | table, contenders, worlds)
    return Evaluation(name, figures=figures, claims=tuple(claims.values()), **known)


def _figure(table: dict[str, Any], dots: str) -> PaperFigure:
    views = tuple(View(**panel) for panel in table.pop("panels"))
    table |= {"claims": tuple(table["claims"]), "text": table["text"].replace("{dots}", dots)}
    return PaperFigure(views=views, **table)


def _claim(table: dict[str, Any], contenders: Mapping[str, Contender], worlds: Mapping[str, Any]) -> Claim:
    """A claim; its studies are those of its contenders."""
    studies: dict[str, None] = {}
    parts = []
    for measure in _several(table.pop("measure")):
        for key, value in measure.items():
            if key in ("first", "others", "contenders"):
                measure[key] = [contenders[name] for name in _several(value)]
                studies |= dict.fromkeys(contender.study for contender in measure[key])
            elif key == "of":
                measure[key] = [getattr(quantities, name) for name in _several(value)]
            elif key == "worlds":
                measure[key] = _worlds(_several(value), worlds)
            elif key == "accuracies":
                measure[key] = worlds[value]["accuracy"]
        parts.append(partial(getattr(measures, measure.pop("name")), **measure))
    needed = Needed.of(table.pop("threshold"), table.pop("right", ()))
    return Claim(needed=needed, measures=tuple(parts), studies=tuple(studies), **table)


def _several(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _worlds(wanted: Sequence[str | Mapping[str, Any]], known: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The worlds of tables, one after another, or of names, combined."""
    tables = [each for each in wanted if not isinstance(each, str)]
    names = [known[each] for each in wanted if isinstance(each, str)]
    worlds = []
    for axes in tables or [{key: value for table in names for key, value in table.items()}]:
        values = [_several(value) for value in axes.values()]
        worlds += [dict(zip(axes, world, strict=True)) for world in itertools.product(*values)]
    return worlds


PAPER = _read("paper")
RIVALS = _read("rivals")
EVALUATIONS = {each.name: each for each in (PAPER, RIVALS)}
