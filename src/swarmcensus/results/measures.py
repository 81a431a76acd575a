"""What contenders are compared by: each measure with its direction, and the one number that a trial has of it.

Robots of a trial share a network and hear one another, so that a trial counts once. Of errors and times its number is
the median over robots, which infinities and stray robots do not move, of shares and of what is sent the mean, as those
add up.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.options import in_shell, option
from swarmcensus.results.values import metrics_in, robots_in
from swarmcensus.statistics.bootstrap import Statistic, centres

Floats = NDArray[np.float64]
BLOCK = 2**22  # numbers that are sorted at once


@dataclass(frozen=True)
class Measure:
    """Something that a trial has one number of; `low` is whether less of it is better.

    `statistic` is what that number is over the robots, and what a setting's is over its trials; `share` is whether it
    is one, to be printed in percent.
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
        """The label, with the name behind it where that is another word: "exit (consensus_right)"."""
        return self.label if self.label.replace(" ", "_") == self.name else f"{self.label} ({self.name})"


OURS = {
    one.name: one
    for one in (
        Measure("final_error", "final error", "1", "|x - f| after the last round"),
        Measure("convergence_error", "error at K", "1", "|x - f| at K"),
        Measure("convergence_round", "K", "rounds", "round of convergence"),
        Measure("correct", "right", "1", "robots in the correct bin at the last checkpoint", False, "mean", True),
        Measure("right_side", "right side", "1", "last estimates on f's side of one half", False, "mean", True),
        Measure("consensus_right", "exit", "1", "trials whose consensus is on the right option", False, "mean", True),
        Measure("consensus_round", "consensus", "rounds", "round of a consensus on the right option"),
        Measure("decided", "decided", "1", "robots that decided", False, "mean", True),
        Measure("decided_right", "decided right", "1", "robots that decided for the right option", False, "mean", True),
        Measure("decision_round", "decision", "rounds", "round of a robot's first decision"),
        Measure("decision_change", "last change", "rounds", "round of a robot's last change of its decision"),
        Measure("done", "done share", "1", "robots that are done", False, "mean", True),
        Measure("done_round", "done", "rounds", "round in which a robot is done"),
        Measure("done_error", "error when done", "1", "|x - f| of the estimate that a robot is done with"),
        Measure("interval_width", "width", "1", "mean width of the robots' intervals at the last checkpoint"),
        Measure("local_convergence_error", "local error at K", "1", "|x - f| of the local estimate at its K"),
        Measure("local_convergence_step", "local K", "observations", "convergence of the local estimate"),
        Measure("messages_sent", "messages", "messages", "messages sent by a robot", statistic="mean"),
        Measure("messages_heard", "heard", "messages", "messages heard by a robot", statistic="mean"),
        Measure("bytes_sent", "bytes", "bytes", "bytes sent by a robot", statistic="mean"),
    )
}
MADE_OF = {  # of measures that are no variable: the variables that they need
    "final_error": ("final_estimate",), "right_side": ("final_estimate",), "decided": ("decision",),
    "decided_right": ("decision", "right_option"), "done": ("done_round",), "done_error": ("done_estimate",),
    "bytes_sent": ("messages_sent", "message_bytes"),
}  # fmt: skip
USUAL = ("final_error", "convergence_round", "correct", "consensus_right", "consensus_round")
COSTS = ("messages_sent", "bytes_sent")
SIZES = {"memory_bytes": "memory", "message_bytes": "message"}  # bytes, of a setting
LOWER = dict.fromkeys(("first_right", "mean_error", "largest_jump", "swarm_right", "recovery_time"), True) | {
    "time_right": False
}
WAYS = {"low": True, "high": False}


def known(data: xr.Dataset) -> dict[str, Measure]:
    """All measures that these results have numbers of, by their names, but metrics whose direction nobody has told."""
    found = {name: one for name, one in OURS.items() if not lacks(data, name)}
    return found | {name: _of_file(data, name, LOWER[name]) for name in metrics_in(data) if name in LOWER}


def lacks(data: xr.Dataset, name: str) -> list[str]:
    """The variables that a measure of ours needs and results have not."""
    return [one for one in MADE_OF.get(name, (name,)) if one not in data]


def chosen(data: xr.Dataset, asked: Iterable[str] = ()) -> tuple[list[Measure], list[str]]:
    """The measures that are asked for, as "correct" or "my_metric:low", else the usual ones with all metrics of files.

    With them come cautions: of metrics that are left out, as nobody has told whether low or high is better. Raises
    InputError for a measure that is not there, a direction that is none and one given twice.
    """
    there, files = known(data), metrics_in(data)
    if isinstance(asked, str):
        asked = [asked]
    measures: dict[str, Measure] = {}
    for text in asked:
        name, colon, way = text.partition(":")
        if colon and way not in WAYS:
            raise InputError(f"{option('metric', text)}: after the colon comes low or high, whichever is better")
        if name not in there and name not in files:
            raise InputError(
                f"{option('metric', text)}: {_absent(data, name, [*there, *(f for f in files if f not in there)])}"
            )
        if name not in there and not colon:
            raise InputError(f"{option('metric', text)}: is low or high better? Write {name}:low or {name}:high")
        if name in measures:
            raise InputError(f"{option('metric', text)}: {name} is given twice")
        measures[name] = there[name] if name in OURS or not colon else _of_file(data, name, WAYS[way])
        if name in OURS and colon and WAYS[way] != OURS[name].low:
            raise InputError(f"{option('metric', text)}: of {name}, {'low' if OURS[name].low else 'high'} is better")
    if measures:
        return list(measures.values()), []
    cautions = [
        f"{name} is not compared, as nobody has told which way is better: {_either(name)}"
        for name in files
        if name not in there
    ]
    usual = [there[name] for name in USUAL if name in there and not np.isnan(numbers(data, name)).all()]
    return usual + [one for name, one in there.items() if name in files], cautions


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
    return Measure(name, name, str(about.get("units", "1")), str(about.get("long_name", name)), low)


def numbers(data: xr.Dataset, name: str) -> Floats:
    """The one number of each trial of a measure, (setting, trial): NaN of trials that have not run or failed."""
    if "checkpoint" in data[MADE_OF.get(name, (name,))[0]].dims:
        last = np.searchsorted(data["checkpoint"].values, data["rounds"].values, side="right") - 1
        found = data[name].transpose("setting", "checkpoint", "trial").values
        values = found[np.arange(len(last)), last]
        return np.asarray(np.where(last[:, np.newaxis] < 0, np.nan, values), np.float64)
    if name == "consensus_round" and "consensus_right" in data:  # who agrees on a lie is not the faster one
        sound = data["consensus_right"].transpose("setting", "trial").values  # NaN where no option is right
        when = _known(data[name].transpose("setting", "trial").values)
        return np.where(np.isnan(sound), np.nan, np.where(sound == 1, when, np.inf))
    if name == "bytes_sent":
        return np.asarray(numbers(data, "messages_sent") * data["message_bytes"].values[:, np.newaxis], np.float64)
    array = data[MADE_OF.get(name, (name,))[0]]
    if "robot" not in array.dims:
        return _known(array.transpose("setting", "trial").values)
    statistic = OURS[name].statistic if name in OURS else "median"
    values = array.transpose("setting", "trial", "robot").values
    robots = robots_in(data).values
    out = np.empty(values.shape[:2])
    step = max(1, BLOCK // max(1, values[0].size))
    for first in range(0, len(values), step):
        rows = slice(first, first + step)
        some = _made(data, name, rows)
        mine = np.arange(some.shape[2]) < robots[rows, np.newaxis, np.newaxis]
        out[rows] = centres(np.where(mine, some, np.nan), statistic)
    return out


def with_measure(data: xr.Dataset, name: str) -> xr.Dataset:
    """The same results with a measure of ours that is no variable as one more, of each robot; as they are otherwise."""
    if name in data or name not in MADE_OF or lacks(data, name):
        return data
    robots = robots_in(data).values[:, np.newaxis, np.newaxis]
    found = _made(data, name, slice(None))
    if name == "bytes_sent":
        found = found * data["message_bytes"].values[:, np.newaxis, np.newaxis]
    found = np.where(np.arange(found.shape[2]) < robots, found, np.nan)
    about = {"units": OURS[name].unit, "long_name": OURS[name].meaning}
    return data.assign({name: (("setting", "trial", "robot"), found, about)})


def _made(data: xr.Dataset, name: str, rows: slice) -> Floats:
    """The number of each robot that a measure's trials have theirs of, (setting, trial, robot), of some settings."""
    values = data[MADE_OF.get(name, (name,))[0]].transpose("setting", "trial", "robot").values[rows]
    some = _known(values)
    if name == "decided":  # of -1, which is no option, it is known that there is none
        return np.where(np.isnan(values), np.nan, values >= 0)
    if name == "done":  # infinite: never
        return np.where(np.isnan(values), np.nan, np.isfinite(values))
    if name == "decided_right":
        right = data["right_option"].isel(setting=rows).transpose("setting", "trial").values[:, :, np.newaxis]
        known_right = np.where(np.isnan(right), np.nan, 1.0)
        return np.where(np.isnan(some), np.nan, some == right) * known_right
    if name in ("final_error", "done_error", "right_side"):
        held = truth(data.isel(setting=rows))[:, :, np.newaxis]
        return _side(some, held) if name == "right_side" else np.abs(some - held)
    return some


def _side(estimates: Floats, truth: Floats) -> Floats:
    """Whether estimates and truth lie on the same side of one half, where an estimate on it is wrong; NaN for a truth
    on it."""
    same = (estimates - 0.5) * (truth - 0.5) > 0
    return np.where(np.isnan(estimates) | (truth == 0.5), np.nan, same)


def _known(values: NDArray[Any]) -> Floats:
    """Numbers as float64, NaN where whole ones say that they are missing."""
    return np.where(values < 0, np.nan, values) if values.dtype.kind == "i" else np.asarray(values, np.float64)


def truth(data: xr.Dataset) -> Floats:
    """The fill ratio that estimates are held against, (setting, trial): see `truth` in docs/study-file.md."""
    nominal = np.broadcast_to(data["fill_ratio"].values[:, np.newaxis], (data.sizes["setting"], data.sizes["trial"]))
    if data.attrs.get("truth") != "floor":
        return np.asarray(nominal, np.float64)
    own = data["true_fill_ratio"].transpose("setting", "trial").values
    return np.where(np.isnan(own), nominal, own)
