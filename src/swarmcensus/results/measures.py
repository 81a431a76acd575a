"""Measures: what brains are compared by, and the one number that each trial has of a measure.

Robots of a trial hear one another, so a trial counts once. Its number is the median over robots for errors and times,
which infinities and outliers do not move, and the mean for shares and for what is sent, which add up.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results.values import metric_of, metrics_in, robots_in
from swarmcensus.support.bootstrap import Statistic, centres
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import in_shell, option, wrong_option
from swarmcensus.support.quantities import PER_ROBOT, PER_TRIAL, QUANTITIES, TRUTH, Quantity

Floats = NDArray[np.float64]
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


def _measure(quantity: Quantity) -> Measure:
    assert quantity.low is not None
    meaning = quantity.compared or quantity.meaning
    return Measure(
        quantity.name, quantity.title, quantity.unit, meaning, quantity.low, quantity.statistic, quantity.share
    )


OURS = {name: _measure(quantity) for name, quantity in QUANTITIES.items() if quantity.low is not None}
USUAL = ("final_error", "convergence_round", "correct", "consensus_right", "consensus_round")
COSTS = ("messages_sent", "bytes_sent")
SIZES = {name: QUANTITIES[name].title for name in ("memory_bytes", "message_bytes")}  # bytes, of a setting
WAYS = {"low": True, "high": False}


def known(data: xr.Dataset) -> dict[str, Measure]:
    """The measures that these results have, by name; metric files that do not say BETTER are left out."""
    shipped = {name: measure for name, measure in OURS.items() if not lacks(data, name)}
    metrics = {name: metric_of(data, name) for name in metrics_in(data)}
    return shipped | {name: _of_file(data, name, file.low) for name, file in metrics.items() if file.low is not None}


def statistic_of(name: str) -> Statistic:
    """The statistic over robots and trials of a quantity: "mean" for shares and for what is sent, else "median"."""
    return QUANTITIES[name].statistic if name in QUANTITIES else "median"


def is_share(name: str) -> bool:
    """Whether a quantity is a share."""
    return name in QUANTITIES and QUANTITIES[name].share


def lacks(data: xr.Dataset, name: str) -> list[str]:
    """The variables that a quantity needs and these results lack."""
    return [variable for variable in inputs_of(name) if variable not in data]


def inputs_of(name: str) -> tuple[str, ...]:
    """The variables that a quantity is derived from; itself, if a run stores it."""
    known = QUANTITIES.get(name)
    if known is None or not known.inputs:
        return (name,)
    return (*(variable for variable in known.inputs if variable != TRUTH), *filter(None, [known.factor]))


def chosen(data: xr.Dataset, asked: Iterable[str] = ()) -> tuple[list[Measure], list[str]]:
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
        if colon and way not in WAYS:
            raise wrong_option("metric", text, "after the colon comes low or high, whichever is better")
        if name not in there and name not in files:
            raise wrong_option(
                "metric", text, f"{_absent(data, name, [*there, *(f for f in files if f not in there)])}"
            )
        if name not in there and not colon:
            raise wrong_option("metric", text, f"is low or high better? Write {name}:low or {name}:high")
        if name in measures:
            raise wrong_option("metric", text, f"{name} is given twice")
        measures[name] = there[name] if name in OURS or not colon else _of_file(data, name, WAYS[way])
        if name in OURS and colon and WAYS[way] != OURS[name].low:
            raise wrong_option("metric", text, f"of {name}, {'low' if OURS[name].low else 'high'} is better")
    if measures:
        return list(measures.values()), []
    cautions = [
        f"{name} is not compared, as its file does not say whether low or high is better: {_either(name)}"
        for name in files
        if name not in there
    ]
    usual = [there[name] for name in USUAL if name in there and not np.isnan(numbers(data, name)).all()]
    return usual + [measure for name, measure in there.items() if name in files], cautions


def _either(name: str) -> str:
    return (
        f"{option('metric', f'{name}:low')} or {name}:high" if in_shell() else f"metric='{name}:low' or '{name}:high'"
    )


def _absent(data: xr.Dataset, name: str, names: list[str]) -> str:
    if name in OURS:
        return f"these results have no variable {' and no '.join(lacks(data, name))}; there are {', '.join(names)}"
    return f"{did_you_mean(name, names)}there are {', '.join(names)}"


def _of_file(data: xr.Dataset, name: str, low: bool) -> Measure:
    about = data[name].attrs
    label = metric_of(data, name).label or name
    return Measure(name, label, str(about.get("units", "1")), str(about.get("long_name", name)), low)


def numbers(data: xr.Dataset, name: str) -> Floats:
    """The number of each trial, (setting, trial); NaN for trials that failed or have not run."""
    if "checkpoint" in data[inputs_of(name)[0]].dims:
        last = np.searchsorted(data["checkpoint"].values, data["rounds"].values, side="right") - 1
        at_checkpoints = data[name].transpose("setting", "checkpoint", "trial").values
        values = at_checkpoints[np.arange(len(last)), last]
        return np.asarray(np.where(last[:, np.newaxis] < 0, np.nan, values), np.float64)
    if name == "consensus_round" and "consensus_right" in data:  # agreement on a wrong option does not count as fast
        sound = data["consensus_right"].transpose("setting", "trial").values  # NaN if no option is right
        when = _known(data[name].transpose("setting", "trial").values)
        return np.where(np.isnan(sound), np.nan, np.where(sound == 1, when, np.inf))
    if name in QUANTITIES and (factor := QUANTITIES[name].factor):
        return np.asarray(numbers(data, inputs_of(name)[0]) * data[factor].values[:, np.newaxis], np.float64)
    array = data[inputs_of(name)[0]]
    if "robot" not in array.dims:
        return _known(array.transpose("setting", "trial").values)
    robots, sizes = robots_in(data).values, data.sizes
    out = np.empty((sizes["setting"], sizes["trial"]))
    step = max(1, BLOCK // max(1, sizes["trial"] * sizes["robot"]))
    for first in range(0, len(out), step):
        rows = slice(first, first + step)
        out[rows] = _over_robots(name, _made(data, name, rows), robots[rows])
    return out


def _over_robots(name: str, values: Floats, robots: NDArray[np.int64]) -> Floats:
    """The number of each trial, (setting, trial), from values (setting, trial, robot) of `robots` robots each."""
    reduced = QUANTITIES[name].over_robots if name in QUANTITIES else None
    if reduced is None:
        exists = np.arange(values.shape[2]) < robots[:, np.newaxis, np.newaxis]
        return centres(np.where(exists, values, np.nan), statistic_of(name))
    out = np.empty(values.shape[:2])
    for count in np.unique(robots).tolist():
        out[robots == count] = reduced(values[robots == count, :, :count])
    return out


def derivable(data: xr.Dataset) -> list[str]:
    """The names of quantities that are not stored, but can be computed from stored ones."""
    return [name for name, one in QUANTITIES.items() if name not in data and one.inputs and not lacks(data, name)]


def with_measure(data: xr.Dataset, name: str) -> xr.Dataset:
    """Results with a derived quantity as a new variable; unchanged if it is stored or cannot be derived."""
    if name not in derivable(data):
        return data
    about = {"units": OURS[name].unit, "long_name": OURS[name].meaning}
    if "robot" not in QUANTITIES[name].dims:
        return data.assign({name: (PER_TRIAL, numbers(data, name), about)})
    robots = robots_in(data).values[:, np.newaxis, np.newaxis]
    made = _made(data, name, slice(None))
    made = np.where(np.arange(made.shape[2]) < robots, made, np.nan)
    return data.assign({name: (PER_ROBOT, made, about)})


def _made(data: xr.Dataset, name: str, rows: slice) -> Floats:
    """The values of a quantity for some settings, (setting, trial, robot)."""
    quantity = QUANTITIES.get(name)
    if quantity is None or not quantity.inputs:
        return _input(data, name, rows)
    inputs = [_input(data, variable, rows) for variable in quantity.inputs]
    values = quantity.derive(*inputs) if quantity.derive else inputs[0]
    return values * _input(data, quantity.factor, rows) if quantity.factor else values


def _input(data: xr.Dataset, name: str, rows: slice) -> Floats:
    """A variable or TRUTH for some settings, (setting, trial, robot), with size 1 for dimensions that it lacks."""
    if name == TRUTH:
        return truth(data.isel(setting=rows))[:, :, np.newaxis]
    array = data[name].transpose("setting", "trial", "robot", missing_dims="ignore")
    values = _known(array.values[rows])
    return values.reshape(values.shape + (1,) * (3 - values.ndim))


def _known(values: NDArray[Any]) -> Floats:
    """Numbers as float64; negative whole numbers, which are missing, become NaN."""
    return np.where(values < 0, np.nan, values) if values.dtype.kind == "i" else np.asarray(values, np.float64)


def truth(data: xr.Dataset) -> Floats:
    """The true fill ratio, (setting, trial): see `truth` in docs/study-file.md."""
    nominal = np.broadcast_to(data["fill_ratio"].values[:, np.newaxis], (data.sizes["setting"], data.sizes["trial"]))
    if data.attrs.get("truth") != "floor":
        return np.asarray(nominal, np.float64)
    own = data["true_fill_ratio"].transpose("setting", "trial").values
    return np.where(np.isnan(own), nominal, own)
