"""One setting's measurements compared with theory, and what limits its precision."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.analysis.explaining.expectations import MIXED, SWARM, Expectation, Line, expect
from swarmcensus.results import check_held, robots_in
from swarmcensus.summaries import done_trials, measures
from swarmcensus.support import bootstrap
from swarmcensus.support.answers import Answer
from swarmcensus.support.formatting import counted, fixed
from swarmcensus.support.intervals import Estimate, estimate
from swarmcensus.support.options import wrong_option
from swarmcensus.support.printed_tables import ASKED, REST, Column, Table, with_ends

Interval = tuple[float, float, float]  # a value and the ends of its 95 % interval; NaN with fewer than 6 trials
NONE: Interval = (np.nan, np.nan, np.nan)
LEAST = "the smallest error of any unbiased estimate from"
LINES = {  # of theory, in the order of the table: what it calls them, and what they are
    "alone": ("a robot alone", "exact, for a robot that hears nobody"),
    "neighbourhood": ("its neighbourhood", f"{LEAST} the readings of a robot and its neighbours"),
    "mixed": ("mixed sums", "running sums of evidence, mixed and divided on the same network"),
    "swarm": ("the whole swarm", f"{LEAST} all readings"),
}
MEANINGS = {"error": "the median of |x - f|", "sd": "the standard deviation of x", "bias": "the mean of x - f"}
NEGLIGIBLE = 1e-12  # a squared error of this size is due to rounding or to a prior
MOST_CHECKPOINTS = 6  # shown in the table


@dataclass(repr=False)
class Explanation(Answer):
    """A setting's measurements, what theory expects, and the parts of the error.

    `terms` are the parts of the mean squared error after the last round. "sensors" is what all readings of the swarm
    leave, "floor" is how far a finite floor's share of black is from f, "time" is what mixed sums lose because readings
    have not reached all robots yet, and "mixing" is the rest: readings that count unequally, or that the brain does not
    pass on. The rest is "unconnected" if some networks are not connected.
    """

    setting: int
    what: str  # the setting in a line
    trials: int
    unit: str  # of time: "rounds", or "ticks" for robots that move
    rounds: int
    checkpoints: list[int]
    convergence_round: Interval  # the median K over robots and trials
    median_error: Interval  # of |x - f| after the last round
    sd: float  # of the final estimates, over robots and trials
    bias: float  # the mean of the final estimates minus f
    squared_error: Interval  # the mean of (x - f)^2
    right: list[Interval]  # the share of right robots at each checkpoint
    theory: dict[str, Line]  # at the checkpoints, and after the last round
    absent: dict[str, str]  # why theory has no value for a line
    efficiency: Interval  # the bound of the swarm divided by the mean squared error
    terms: dict[str, float]
    limit: str  # the largest term, in words
    title: str = ""

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """All that is known."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """What limits the setting most, what its error consists of, K, and what theory has no line for."""
        said, total, error = [], sum(self.terms.values()), f"mean squared error: {self.squared_error[0]:.3g}"
        if self.terms and total < NEGLIGIBLE:
            said = [f"nothing limits it: {error} is due to rounding or a prior"]
        elif self.terms:
            parts = ", ".join(f"{name} {100 * part / total:.0f} %" for name, part in self.terms.items())
            efficiency = f"{self.efficiency[0]:.3g}{ends_text(self.efficiency, '{:.3g}'.format, ' ')}"
            said = [
                f"What limits it most is {self.limit}", f"{error}, made of {parts}",
                f"efficiency: {efficiency}, the bound of the whole swarm over the mean squared error",
            ]  # fmt: skip
        said.append(f"K: {fixed(self.convergence_round[0])} {self.unit}{ends_text(self.convergence_round, fixed, ' ')}")
        for why in dict.fromkeys(self.absent.values()):
            names = [LINES[name][0] for name, reason in self.absent.items() if reason == why]
            missing = "no line of theory" if len(names) == len(LINES) else f"no line for {', '.join(names)}"
            said.append(f"{missing}: {why}")
        return said

    @property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """A row for what was measured, and one for each line of theory; `right_K` is the share at round K."""
        parts = [*self._parts()]
        measured = with_ends({"line": "measured"} | {name: value for name, value, *_ in parts})
        return [measured] + [
            {"line": name} | {part: float(getattr(line, of)[at]) for part, _, of, at in parts}
            for name, line in self.theory.items()
        ]

    def _parts(self) -> Iterator[tuple[str, Interval | float, str, int]]:
        """The entries of a row: name and measured value, and the field of a line that has theory's, and the place."""
        yield from (("error", self.median_error, "median_error", -1), ("sd", self.sd, "sd", -1))
        yield "bias", self.bias, "bias", -1
        for place, k in enumerate(self.checkpoints):
            yield f"right_{k}", self.right[place], "right", place

    def tables(self, limit: int) -> list[Table]:
        """One table, with the interval below what was measured, and no more checkpoints than a reader compares."""
        lines = {LINES[name]: self.theory[name] for name in LINES if name in self.theory}
        known, last = math.isfinite(self.median_error[1]), len(self.checkpoints) - 1
        # evenly spaced backwards from the last one, which says most
        few = min(last, MOST_CHECKPOINTS - 1)
        places = [last - round(k * last / few) for k in range(few, -1, -1)] if few > 0 else [0]
        names = ["measured", *["[95 %]"] * known, *(name for name, _ in lines)]
        columns = [Column("", names, number=False, name="line")]
        for name, measured, of, at in self._parts():
            if of == "right" and at not in places:
                continue
            form, head = _number, name
            if of == "right":
                form, head = _percent, f"{'right % ' * (at == places[0])}at {self.checkpoints[at]:,}"
            value, ends = (measured[0], ends_text(measured, form)) if isinstance(measured, tuple) else (measured, "")
            cells = [form(value), *[ends] * known, *(form(float(getattr(line, of)[at])) for line in lines.values())]
            rank = REST if of == "right" and at not in (places[0], last) else ASKED
            columns.append(Column(head, cells, rank=rank, name=name, meaning=MEANINGS.get(name, "")))
        notes = [f"error, sd, bias: after {self.rounds:,} {self.unit}", *(f"{name}: {means}" for name, means in lines)]
        return [Table(columns, notes=lambda _: notes).first(limit)]


def _number(value: float) -> str:
    return f"{round(value, 4) + 0.0:.4f}"  # no -0.0000


def _percent(value: float) -> str:
    return f"{100.0 * value:.1f}"


def ends_text(interval: Interval, form: Callable[[float], str], before: str = "") -> str:
    """The ends of an interval, behind `before`; empty if they are not known."""
    return f"{before}[{form(interval[1])}, {form(interval[2])}]" if math.isfinite(interval[1]) else ""


def explain(data: xr.Dataset, setting: int) -> Explanation:
    """Compare a setting's measurements with theory; the result also has the efficiency, and what limits it in words.

    `setting` is a value of its coordinate. The lines of theory are "alone" (the exact distribution for a robot that
    hears nobody), "neighbourhood" (the bound for the readings of a robot and those that it hears), "mixed" (sums that
    are mixed and divided on the same network) and "swarm" (the bound for all readings), each at the checkpoints and
    after the last round. Raises InputError.
    """
    check_held(data, setting=setting)
    selected = data.sel(setting=[setting])
    ran = done_trials(selected)[0]
    if not ran.any():
        raise wrong_option("setting", setting, "none of its trials has been run")
    rounds = int(selected["rounds"].values[0])
    reached = selected["checkpoint"].values <= rounds
    checkpoints = selected["checkpoint"].values[reached].tolist()
    expectation = expect(data, setting, [*checkpoints, rounds])
    errors = errors_of(selected)
    squared = mean_of(np.square(errors).mean(axis=1))
    rounds_of_convergence = selected["convergence_round"].values[0][ran][:, : errors.shape[1]].astype(np.float64)
    correct = selected["correct"].transpose("setting", "checkpoint", "trial").values[0][reached][:, ran]
    terms = terms_of(expectation, squared[0])
    # an interval may reach beyond what K can be
    k, low, high = estimate(rounds_of_convergence, "median")
    what, trials = f"{expectation.setting.brain.name}: {expectation.setting}", int(ran.sum())
    return Explanation(
        setting, what, trials, "rounds" if expectation.setting.body is None else "ticks", rounds, checkpoints,
        convergence_round=(k, max(low, 0.0), min(high, float(rounds))),
        median_error=_interval(estimate(np.abs(errors), "median")), sd=float(errors.std()), bias=float(errors.mean()),
        squared_error=squared, theory=expectation.lines, absent=expectation.absent, terms=terms,
        right=[_interval(estimate(share[:, np.newaxis], "mean", share=True)) for share in correct],
        efficiency=efficiency_of(expectation, squared), limit=_limit_text(expectation, terms),
        title=f"setting {setting}: {what}; {counted(trials, 'trial')}",
    )  # fmt: skip


def _interval(of: Estimate) -> Interval:
    """An estimate as a plain tuple, which JSON has as a list."""
    return of.value, of.low, of.high


def errors_of(selected: xr.Dataset) -> NDArray[np.float64]:
    """The errors x - f of one setting after the last round, (trial, robot), in the trials that ran."""
    ran, robots = done_trials(selected)[0], int(robots_in(selected).values[0])
    final = selected["final_estimate"].transpose("setting", "trial", "robot").values[0][ran][:, :robots]
    return np.asarray(final - measures.truth(selected)[0][ran][:, np.newaxis], np.float64)


def mean_of(by_trial: NDArray[np.float64]) -> Interval:
    """The mean over trials of a number that is never negative, and its bootstrap interval, cut at 0."""
    low, high = bootstrap.intervals(by_trial[np.newaxis], "mean")
    return float(by_trial.mean()), max(float(low[0]), 0.0), float(high[0])


def efficiency_of(expectation: Expectation, squared: Interval) -> Interval:
    """The bound of the whole swarm divided by the mean squared error; NaN if theory has no bound."""
    if SWARM not in expectation.lines:
        return NONE
    bound = float(expectation.lines[SWARM].variance[-1])
    value, high, low = (bound / part if part > 0.0 else np.inf if part == 0.0 else np.nan for part in squared)
    return value, low, high


def terms_of(expectation: Expectation, squared: float) -> dict[str, float]:
    """The parts of the mean squared error, in the order in which they are subtracted; empty if theory has no bound."""
    if SWARM not in expectation.lines:
        return {}
    floor = expectation.floor
    terms = {"sensors": float(expectation.lines[SWARM].variance[-1]) - floor}
    if expectation.setting.body is not None:
        terms["floor"] = floor
    if MIXED in expectation.lines and np.isfinite(expectation.stationary):
        late = max(float(expectation.lines[MIXED].variance[-1]) - expectation.stationary, 0.0)
        terms["time"] = min(late, max(squared - sum(terms.values()), 0.0))  # a brain may mix faster than the sums
    rest = "unconnected" if expectation.connections.apart else "mixing"
    return terms | {rest: max(squared - sum(terms.values()), 0.0)}


def _limit_text(expectation: Expectation, terms: dict[str, float]) -> str:
    """A sentence on the largest part of the error, and what would reduce it."""
    if not terms:
        return ""
    largest = max(terms, key=lambda name: terms[name])
    return {
        "sensors": "the sensors: the largest part of the error would remain if all readings of the swarm were pooled. "
        "Better sensors, more readings or more robots would help.",
        "floor": "the floor: its own share of black differs from f. A larger floor would help, or comparing estimates "
        'with the floor itself (truth = "floor").',
        "time": "time: readings have not reached all robots yet. More rounds, more links or a brain that mixes faster "
        "would help.",
        "unconnected": f"the network: {expectation.connections}. Readings of one component do not reach all others. "
        "More links would help.",
        "mixing": "mixing: estimates use less than all readings of the swarm. A brain that passes on more"
        + f"{'' if expectation.setting.brain.never_speaks else ', or a network in which all robots count equally,'}"
        " would help.",
    }[largest]
