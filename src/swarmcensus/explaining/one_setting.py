"""A setting's measured figures beside theory's, and what limits it."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.explaining.expectations import MIXED, SWARM, Expectation, Line, expect
from swarmcensus.results import measures
from swarmcensus.results.store import load
from swarmcensus.results.summaries import done
from swarmcensus.results.values import robots_in
from swarmcensus.statistics import bootstrap
from swarmcensus.statistics.intervals import estimate

Interval = tuple[float, float, float]  # a value and the ends of its 95 % interval over trials; NaN of fewer than 6
NONE: Interval = (np.nan, np.nan, np.nan)


class Explanation(NamedTuple):
    """What was measured of a setting, what theory expects, and what is between them.

    `terms` are the parts of the mean squared error after the last round: "sensors" what the readings of the whole swarm
    leave, "floor" how far the black share of a finite floor is from f, "time" what mixed sums lose while news is under
    way, and "mixing" what else was measured: news that counts unevenly, or that the brain does not pass on.
    """

    setting: int
    what: str  # the setting in a line
    trials: int
    unit: str  # of rounds
    rounds: int
    checkpoints: list[int]
    convergence_round: Interval  # the median K over robots and trials
    median_error: Interval  # of |x - f| after the last round
    sd: float  # of estimates then, over robots and trials
    bias: float  # their mean, less f
    squared_error: Interval  # the mean of (x - f)^2
    right: list[Interval]  # the share of right robots at each checkpoint
    theory: dict[str, Line]  # at the checkpoints, and after the last round
    absent: dict[str, str]  # why theory says nothing of a line
    efficiency: Interval  # the bound of the swarm over the mean squared error
    terms: dict[str, float]
    relaxation: float  # of the network, in rounds
    limit: str  # the largest term, in words


def explain(results: xr.Dataset | str | Path, setting: int) -> Explanation:
    """A setting's measured figures beside theory's, with the efficiency, and in words what limits it.

    `results` is a dataset or a results file, `setting` a number of its coordinate. Theory's lines are "alone" (the
    exact law of a robot that hears nobody), "neighbourhood" (the bound of what a robot and those that it hears have
    seen), "mixed" (sums that are mixed and divided on the same network) and "swarm" (the bound of all readings), each
    at the checkpoints and after the last round. Raises InputError.
    """
    data = load(results) if isinstance(results, str | Path) else results
    if setting not in data["setting"].values:
        known = data["setting"].values
        raise InputError(f"setting {setting}: these results hold setting {known.min()} to {known.max()}")
    one = data.sel(setting=[setting])
    ran = done(one)[0]
    if not ran.any():
        raise InputError(f"setting {setting}: none of its trials has been run")
    rounds, robots = int(one["rounds"].values[0]), int(robots_in(one).values[0])
    reached = one["checkpoint"].values <= rounds
    checkpoints = one["checkpoint"].values[reached].tolist()
    found = expect(data, setting, [*checkpoints, rounds])
    off = errors_of(one, ran, robots)
    squared = mean_of(np.square(off).mean(axis=1))
    when = one["convergence_round"].values[0][ran][:, :robots].astype(np.float64)
    correct = one["correct"].transpose("setting", "checkpoint", "trial").values[0][reached][:, ran]
    terms = terms_of(found, squared[0])
    k, low, high = estimate(when, "median")
    return Explanation(
        setting=setting,
        what=f"{found.setting.brain.name}: {found.setting}",
        trials=int(ran.sum()),
        unit="rounds" if found.setting.body is None else "ticks",
        rounds=rounds,
        checkpoints=checkpoints,
        convergence_round=(k, max(low, 0.0), min(high, float(rounds))),
        median_error=estimate(np.abs(off), "median"),
        sd=float(off.std()),
        bias=float(off.mean()),
        squared_error=squared,
        right=[estimate(share[:, np.newaxis], "mean", share=True) for share in correct],
        theory=found.lines,
        absent=found.absent,
        efficiency=efficiency_of(found, squared),
        terms=terms,
        relaxation=found.relaxation,
        limit=_words(found, terms),
    )


def errors_of(one: xr.Dataset, ran: NDArray[np.bool_], robots: int) -> NDArray[np.float64]:
    """x - f after the last round, (trial, robot), of the trials that ran."""
    final = one["final_estimate"].transpose("setting", "trial", "robot").values[0][ran][:, :robots]
    return np.asarray(final - measures.truth(one)[0][ran][:, np.newaxis], np.float64)


def mean_of(by_trial: NDArray[np.float64]) -> Interval:
    """The mean over trials, and its interval by bootstrap over them, which is not below 0 for what cannot be."""
    low, high = bootstrap.intervals(by_trial[np.newaxis], "mean")
    return float(by_trial.mean()), max(float(low[0]), 0.0), float(high[0])


def efficiency_of(found: Expectation, squared: Interval) -> Interval:
    """The bound of the whole swarm over the mean squared error; NaN where theory has no bound."""
    if SWARM not in found.lines:
        return NONE
    bound = float(found.lines[SWARM].variance[-1])
    value, high, low = (bound / part if part > 0.0 else np.inf if part == 0.0 else np.nan for part in squared)
    return value, low, high


def terms_of(found: Expectation, squared: float) -> dict[str, float]:
    """The parts of the mean squared error, in the order in which they come off; none where theory has no bound."""
    if SWARM not in found.lines:
        return {}
    floor = found.floor
    terms = {"sensors": float(found.lines[SWARM].variance[-1]) - floor}
    if found.setting.body is not None:
        terms["floor"] = floor
    if MIXED in found.lines and np.isfinite(found.stationary):
        late = max(float(found.lines[MIXED].variance[-1]) - found.stationary, 0.0)
        terms["time"] = min(late, max(squared - sum(terms.values()), 0.0))  # a brain may be faster than mixed sums
    return terms | {"mixing": max(squared - sum(terms.values()), 0.0)}


def _words(found: Expectation, terms: dict[str, float]) -> str:
    """What the largest part of the error comes from, and what would help."""
    if not terms:
        return ""
    largest = max(terms, key=lambda name: terms[name])
    relaxed = f", and the network relaxes in {found.relaxation:,.0f} rounds" if found.relaxation > 0.0 else ""
    return {
        "sensors": "the sensors: even all readings of the swarm together leave as much. Better sensors, more readings "
        "or more robots would help.",
        "floor": "the floor: its own share of black is as far from f. A larger floor would help, or holding estimates "
        'against the floor itself (truth = "floor").',
        "time": f"time: news is still under way{relaxed}. More rounds, more links or a brain that mixes faster would "
        "help.",
        "mixing": "mixing: estimates hold less than what the swarm has seen. A brain that passes on more, or a network "
        "in which all count alike, would help.",
    }[largest]
