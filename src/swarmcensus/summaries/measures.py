"""Measures: what brains are compared by, and the one number that each trial has of a measure.

Robots of a trial hear one another, so a trial counts once. Its number is the median over robots for errors and times,
which infinities and outliers do not move, and the mean for shares and for what is sent, which add up.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import metric_of, metrics_in, origins_of, robots_in
from swarmcensus.simulation import sampling
from swarmcensus.studies import Wanted
from swarmcensus.summaries.labels import studies_in
from swarmcensus.support.bootstrap import Statistic, centres
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.intervals import Floats
from swarmcensus.support.options import in_shell, option, wrong_option
from swarmcensus.support.quantities import GOAL, QUANTITIES, TRUTH
from swarmcensus.support.toml_text import to_toml

BLOCK = 2**22  # numbers that are sorted at once


@dataclass(frozen=True)
class Measure:
    """A quantity that brains are compared by; `low` is whether less is better.

    `statistic` is taken over the robots of a trial, and over the trials of a setting. A `share` is printed in percent.
    """

    name: str
    label: str
    unit: str
    meaning: str
    low: bool = True
    statistic: Statistic = "median"
    share: bool = False

    @property
    def full_label(self) -> str:
        """The label, followed by the name if that differs: "exit (consensus_right)"."""
        return self.label if self.label.replace(" ", "_") == self.name else f"{self.label} ({self.name})"


MEASURES = {
    name: Measure(name, one.title, one.unit, one.compared or one.meaning, one.low, one.statistic, one.share)
    for name, one in QUANTITIES.items()
    if one.low is not None
}
DEFAULT_MEASURES = ("final_error", "convergence_round", "correct", "consensus_right", "right_consensus_round")
COSTS = ("messages_sent", "bytes_sent")
SIZES = {name: QUANTITIES[name].title for name in ("memory_bytes", "message_bytes")}  # bytes, of a setting
DIRECTIONS = {"low": True, "high": False}


def known(data: xr.Dataset) -> dict[str, Measure]:
    """The measures that these results have, by name; metric files that do not say BETTER are left out."""
    shipped = {name: measure for name, measure in MEASURES.items() if not missing_inputs(data, name)}
    metrics = {name: metric_of(data, name) for name in metrics_in(data)}
    return shipped | {name: _of_file(data, name, file.low) for name, file in metrics.items() if file.low is not None}


def statistic_of(name: str) -> Statistic:
    """The statistic over robots and trials of a quantity: "mean" for shares and for what is sent, else "median"."""
    return QUANTITIES[name].statistic if name in QUANTITIES else "median"


def is_share(name: str) -> bool:
    """Whether a quantity is a share."""
    return name in QUANTITIES and QUANTITIES[name].share


def missing_inputs(data: xr.Dataset, name: str) -> list[str]:
    """The variables that a quantity needs and these results lack."""
    missing = [variable for variable in inputs_of(name) if variable not in data]
    wants = name in QUANTITIES and GOAL in QUANTITIES[name].inputs
    return [*missing, *([GOAL] if wants and wanted_in(data).goal is None else [])]


def inputs_of(name: str) -> tuple[str, ...]:
    """The variables that a quantity is derived from; itself, if a run stores it."""
    known = QUANTITIES.get(name)
    if known is None or not known.inputs:
        return (name,)
    return (*(variable for variable in known.inputs if variable not in (TRUTH, GOAL)), *filter(None, [known.factor]))


def head_of(data: xr.Dataset, name: str) -> str:
    """The head of the column of a quantity or metric file in tables, without the sign of percent."""
    if name in metrics_in(data):
        return metric_of(data, name).label or name
    return QUANTITIES[name].title if name in QUANTITIES else name


def about(data: xr.Dataset, name: str) -> dict[str, Any]:
    """The unit and meaning of a quantity or metric file, for a column of a table."""
    if name in metrics_in(data):
        return {"unit": data[name].attrs["units"], "meaning": data[name].attrs["long_name"]}
    known = QUANTITIES.get(name)
    return {"unit": known.unit, "meaning": known.compared or known.meaning} if known else {}


def name_of(data: xr.Dataset, text: str, known: Collection[str]) -> str:
    """Which of the known names a text is: a name, or the head of a column, such as "K", "right %" or "final error".

    The text itself if it is none of them.
    """
    if text in known:
        return text
    plain = text.rstrip(" _%").replace(" ", "_").casefold()
    return next((n for n in known if plain in (n, head_of(data, n).replace(" ", "_").casefold())), text)


def choose_measures(data: xr.Dataset, asked: Iterable[str] = ()) -> tuple[list[Measure], list[str]]:
    """The named measures, such as "correct" or "my_metric:low"; by default the usual ones and all metric files.

    Also returns cautions about metric files that are left out since they do not say whether low or high is better.
    Raises InputError for an unknown measure or direction, and for a measure given twice.
    """
    there, files = known(data), metrics_in(data)
    if isinstance(asked, str):
        asked = [asked]
    measures: dict[str, Measure] = {}
    for text in asked:
        name, colon, way = text.partition(":")
        name = name_of(data, name, (*there, *files))
        if colon and way not in DIRECTIONS:
            raise wrong_option("metric", text, "after the colon comes low or high, whichever is better")
        if name not in there and name not in files:
            names = [*there, *(file for file in files if file not in there)]
            lacking = missing_inputs(data, name)
            no = f"these results have no variable {' and no '.join(lacking)}; " * (name in MEASURES)
            if GOAL in lacking:
                no = "the study of these results wants nothing, or merged studies want different things; "
            raise wrong_option("metric", text, f"{no or did_you_mean(name, names)}there are {', '.join(names)}")
        if name not in there and not colon:
            raise wrong_option("metric", text, f"is low or high better? Write {name}:low or {name}:high")
        if name in measures:
            raise wrong_option("metric", text, f"{name} is given twice")
        measures[name] = there[name] if name in MEASURES or not colon else _of_file(data, name, DIRECTIONS[way])
        if name in MEASURES and colon and DIRECTIONS[way] != MEASURES[name].low:
            raise wrong_option("metric", text, f"of {name}, {'low' if MEASURES[name].low else 'high'} is better")
    if measures:
        return list(measures.values()), []
    unsaid = "as its file does not say whether low or high is better"
    cautions = [f"{name} is not compared, {unsaid}: {_either(name)}" for name in files if name not in there]
    usual = [there[name] for name in DEFAULT_MEASURES if name in there and not np.isnan(numbers(data, name)).all()]
    return usual + [measure for name, measure in there.items() if name in files], cautions


def _either(name: str) -> str:
    shell = f"{option('metric', f'{name}:low')} or {name}:high"
    return shell if in_shell() else f"metric='{name}:low' or '{name}:high'"


def _of_file(data: xr.Dataset, name: str, low: bool) -> Measure:
    return Measure(name, head_of(data, name), **about(data, name), low=low)


def numbers(data: xr.Dataset, name: str) -> Floats:
    """The number of each trial, (setting, trial); NaN for trials that failed or have not run."""
    parts = [centres(sample(data, name, rows), statistic_of(name)) for rows in blocks(data)]
    return np.concatenate(parts) if parts else np.empty((0, data.sizes["trial"]))


def blocks(data: xr.Dataset) -> list[NDArray[np.intp]]:
    """The places of all settings, in blocks of which `sample` takes little memory."""
    settings, each = data.sizes["setting"], data.sizes["trial"] * data.sizes.get("robot", 1)
    step = max(1, BLOCK // max(1, each))
    return [np.arange(first, min(first + step, settings)) for first in range(0, settings, step)]


def sample(data: xr.Dataset, name: str, rows: NDArray[np.intp], checkpoint: int | None = None) -> Floats:
    """All numbers of a quantity in the settings at these places, (setting, trial, robot); NaN where there is none.

    A quantity of trials has size 1 along robots. What is measured at checkpoints is taken at round `checkpoint`, by
    default at the last one that a setting reaches.
    """
    quantity, robots = QUANTITIES.get(name), robots_in(data).values[rows]
    if name in data or quantity is None:
        values = _input(data, name, rows, checkpoint)
    else:
        inputs = [_input(data, variable, rows, checkpoint) for variable in quantity.inputs]
        values = quantity.derive(*inputs) if quantity.derive else inputs[0]
        values = values * _input(data, quantity.factor, rows, checkpoint) if quantity.factor else values
        if quantity.over_robots:
            out = np.empty((*values.shape[:2], 1))
            for count in np.unique(robots).tolist():
                out[robots == count, :, 0] = quantity.over_robots(values[robots == count, :, :count])
            return out
    if values.shape[2] > 1:
        values = np.where(np.arange(values.shape[2]) < robots[:, np.newaxis, np.newaxis], values, np.nan)
    return values


def derivable(data: xr.Dataset) -> list[str]:
    """The names of quantities that are not stored, but can be computed from stored ones."""
    derived = (name for name, one in QUANTITIES.items() if name not in data and one.inputs)
    return [name for name in derived if not missing_inputs(data, name)]


def at_checkpoints(data: xr.Dataset, name: str) -> bool:
    """Whether a quantity is measured at checkpoints."""
    return any("checkpoint" in data[one].dims for one in ([name] if name in data else inputs_of(name)))


def reached(data: xr.Dataset, checkpoint: int | None = None) -> NDArray[np.intp]:
    """The place of the checkpoint for each setting, by default the last one that it reaches; -1 if it ends before.

    Raises InputError if there is no such checkpoint.
    """
    known, rounds = data["checkpoint"].values, data["rounds"].values
    if checkpoint is None:
        return np.searchsorted(known, rounds, side="right") - 1
    if checkpoint not in known:
        after = ", ".join(map(str, known))
        raise wrong_option("checkpoint", checkpoint, f"decisions were recorded after round {after}")
    return np.where(rounds >= checkpoint, np.searchsorted(known, checkpoint), -1)


def _input(data: xr.Dataset, name: str, rows: NDArray[np.intp], checkpoint: int | None) -> Floats:
    """A variable, TRUTH or GOAL of some settings, (setting, trial, robot), with size 1 for dimensions that it lacks."""
    if name == TRUTH:
        return truth(data)[rows, :, np.newaxis]
    if name == GOAL:
        return _goals(data, rows)
    # without coordinates, which would take longer than all else
    array = data.variables[name].transpose("setting", "checkpoint", "trial", "robot", missing_dims="ignore")
    values = array.values[rows]
    if "checkpoint" in array.dims:
        place = reached(data, checkpoint)[rows]
        values = values[np.arange(len(rows)), place]
        values[place < 0] = np.nan
    values = np.where(values < 0, np.nan, values) if values.dtype.kind == "i" else np.asarray(values, np.float64)
    return values.reshape(values.shape + (1,) * (3 - values.ndim))


def wanted_in(data: xr.Dataset) -> Wanted:
    """What the studies of these results want; nothing if they want different things."""
    wanted = wants_of(data)
    return Wanted(**wanted[0]) if len(wanted) == 1 else Wanted()


def wants_of(data: xr.Dataset) -> list[dict[str, Any]]:
    """The different things that the studies of these results want."""
    return list({to_toml(one): one for study in studies_in(data) if (one := study.get("wanted"))}.values())


def _goals(data: xr.Dataset, rows: NDArray[np.intp]) -> Floats:
    """What is wanted of the robots of some settings, (setting, trial, robot); NaN for those that do not count."""
    wanted = wanted_in(data)
    goals = np.full((len(rows), data.sizes["trial"], data.sizes["robot"]), wanted.goal, np.float64)
    numbers = data["setting"].values[rows].tolist()
    fail = wanted.who == "working" and any(study.get("faults") for study in studies_in(data))
    for k, (study, setting) in enumerate(origins_of(data, numbers).values() if fail else ()):
        for place, trial in enumerate(data["trial"].values.tolist()):
            works = sampling.working(setting, study.seed, trial)
            goals[k, place, : len(works)][~works] = np.nan
    return goals


def truth(data: xr.Dataset) -> Floats:
    """The true fill ratio, (setting, trial): see `truth` in docs/study-file.md."""
    nominal = np.broadcast_to(data["fill_ratio"].values[:, np.newaxis], (data.sizes["setting"], data.sizes["trial"]))
    if "drawn_fill_ratio" in data:
        drawn = data["drawn_fill_ratio"].transpose("setting", "trial").values
        nominal = np.where(np.isnan(drawn), nominal, drawn)
    if data.attrs.get("truth") != "floor":
        return np.asarray(nominal, np.float64)
    own = data["true_fill_ratio"].transpose("setting", "trial").values
    return np.where(np.isnan(own), nominal, own)
