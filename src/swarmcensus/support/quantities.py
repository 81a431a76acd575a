"""Everything that is measured, each declared once: what a run stores, and what is derived from that.

A new quantity is one entry of `ALL`. Files, summaries, comparisons and figures take its dimensions, unit, labels,
direction and bounds from there.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from swarmcensus.support.bootstrap import Statistic
from swarmcensus.support.intervals import Floats

PER_ROBOT = ("setting", "trial", "robot")
PER_TRIAL = ("setting", "trial")
PER_SETTING = ("setting",)
PER_CHECKPOINT = ("setting", "checkpoint", "trial")
ESTIMATES = ("setting", "checkpoint", "trial", "robot")
SEARCHED = "search"  # the attribute of logs of searches that names the measure
BEST = "best_"  # before its name, the best number so far
TRUTH = "truth"  # an input of derived quantities: the fill ratio that estimates are compared with
GOAL = "wanted"  # another one: the error or the number of bins that a study wants, NaN for robots that do not count
OPTIONS = (-1.0, inf)  # bounds of an option's number; -1 is none


@dataclass(frozen=True)
class Quantity:
    """Something that is measured, with what every reader needs to know of it.

    `group` says which runs store it ("always", "messages" and "setting": all runs; other groups: with which kind of
    brain or key of a study); "derived" is stored by none: `derive` computes it from the arrays of `inputs`, robot
    by robot. `statistic` is what is taken over robots and over trials; `over_robots` makes one number a trial of an
    array (..., robot) in another way. `share` is whether it is a share, which is printed in percent. `low` is whether
    less is better; None is not compared. `summary` is whether `swarmcensus show --json` and `sc.summary` have it.
    """

    name: str
    meaning: str  # the attribute `long_name` of the file
    group: str = "derived"
    dims: tuple[str, ...] = PER_ROBOT
    unit: str = "1"
    kind: Any = np.float64
    label: str = ""  # the head of its column in tables; by default the name in words
    shown: bool = False  # whether the table of `show` has it
    axis: str = ""  # on axes of figures; by default the name in words
    low: bool | None = None
    statistic: Statistic = "median"
    share: bool = False
    bounds: tuple[float, float] = (0.0, inf)
    within_rounds: bool = False  # no larger than the number of rounds
    never: bool = False  # infinite means that the event never happens
    summary: bool = False
    decimals: int | None = None  # of a value without an interval, in the table of `show`
    compared: str = ""  # what a comparison's legend says; by default the meaning
    inputs: tuple[str, ...] = ()
    derive: Callable[..., Floats] | None = None  # by default the input itself
    over_robots: Callable[[Floats], Floats] | None = None  # by default `statistic`
    factor: str = ""  # a quantity of settings by which that is multiplied

    @property
    def title(self) -> str:
        """The head of its column in tables, without the sign of percent."""
        return self.label or self.name.replace("_", " ")


def _error(estimates: Floats, truth: Floats) -> Floats:
    return np.abs(estimates - truth)


def _right_side(estimates: Floats, truth: Floats) -> Floats:
    """Whether both are on the same side of one half. An estimate of one half is wrong; NaN for a truth of one half."""
    same = (estimates - 0.5) * (truth - 0.5) > 0
    return np.where(np.isnan(estimates) | (truth == 0.5), np.nan, same)


def as_wanted(estimates: Floats, truth: Floats, goal: Floats) -> Floats:
    """Whether estimates are within the error of the truth, or of 2 bins or more in the same one; NaN without a goal."""
    wanted = np.nanmax(goal, initial=0.0)
    if wanted < 1.0:
        right = np.abs(estimates - truth) <= wanted
    else:
        edges = np.arange(1, wanted) / wanted
        right = np.searchsorted(edges, estimates, side="right") == np.searchsorted(edges, truth, side="right")
    return np.where(np.isnan(estimates) | np.isnan(truth) | np.isnan(goal), np.nan, right)


def _share_of_known(right: Floats) -> Floats:
    """The share of robots (..., robot) that are right, of those that count; NaN if none does."""
    known = ~np.isnan(right)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(known, right, 0.0).sum(axis=-1) / known.sum(axis=-1))


def _decided_right(decision: Floats, right_option: Floats) -> Floats:
    known = np.where(np.isnan(right_option), np.nan, 1.0)
    return np.where(np.isnan(decision), np.nan, decision == right_option) * known


def _on_right(when: Floats, right: Floats) -> Floats:
    """When all agreed; infinite for a wrong option, which is not fast, and NaN if no option is right."""
    return np.where(np.isnan(right), np.nan, np.where(right == 1, when, np.inf))


def nine_of_ten(errors: Floats) -> Floats:
    """The smallest of a trial's errors (..., robot) that nine of ten robots keep; NaN if any error is NaN."""
    return np.asarray(np.quantile(errors, 0.9, axis=-1, method="inverted_cdf"))


def half_width(estimates: Floats) -> Floats:
    """Half the width of the middle 90 % of estimates (..., robot): from their 5 % to their 95 % quantile."""
    low, high = np.quantile(estimates, [0.05, 0.95], axis=-1)
    return np.asarray((high - low) / 2.0)


ALL = (
    Quantity(
        "convergence_round", "K, the convergence of the informed estimate", "always", unit="rounds", kind=np.int32,
        label="K", shown=True, axis="convergence $K$", low=True, within_rounds=True, summary=True, decimals=0,
        compared="round of convergence, in which a robot settles (agreement_round: in which robots agree)",
    ),
    Quantity(
        "convergence_error", "|x^K - f|, the informed estimate's error at convergence", "always",
        label="error at K", shown=True, axis=r"error $|x^K - f\,|$", low=True, summary=True, decimals=4,
        compared="|x - f| at K",
    ),
    Quantity(
        "final_estimate", "the informed estimate after the last round", "always",
        axis="final estimate $x$", bounds=(-inf, inf),
    ),
    Quantity(
        "final_error", "|x - f| after the last round", inputs=("final_estimate", TRUTH), derive=_error,
        shown=True, axis=r"final error $|x - f\,|$", low=True, summary=True, decimals=4,
    ),
    Quantity(
        "error_90", "the smallest |x - f| after the last round that nine of ten robots keep", dims=PER_TRIAL,
        inputs=("final_estimate", TRUTH), derive=_error, over_robots=nine_of_ten,
        shown=True, axis=r"final error $|x - f\,|$ of nine in ten robots", low=True, summary=True, decimals=4,
    ),
    Quantity(
        "worst_error", "|x - f| of the worst robot after the last round", dims=PER_TRIAL,
        inputs=("final_estimate", TRUTH), derive=_error, over_robots=lambda errors: errors.max(axis=-1),
        axis=r"worst final error $|x - f\,|$", low=True, summary=True, decimals=4,
    ),
    Quantity(
        "final_disagreement", "half the width of the middle 90 % of estimates after the last round", dims=PER_TRIAL,
        inputs=("final_estimate",), over_robots=half_width, low=True, summary=True, decimals=4,
    ),
    Quantity(
        "agreement_round", "first round from which on the disagreement stays within delta; infinite: never",
        "agreement", PER_TRIAL, "rounds", shown=True, never=True, low=True, summary=True, decimals=0,
        compared="first round from which on robots stay within delta of each other",
    ),
    Quantity("disagreement", "half the width of the middle 90 % of estimates", "agreement", PER_CHECKPOINT),
    Quantity(
        "correct", "fraction of robots in the correct bin", "always", PER_CHECKPOINT,
        label="right", shown=True, axis="share of right robots", low=False, statistic="mean", share=True,
        decimals=1, compared="robots in the correct bin at the last checkpoint",
    ),
    Quantity(
        "right_side", "last estimates on f's side of one half", inputs=("final_estimate", TRUTH), derive=_right_side,
        low=False, statistic="mean", share=True,
    ),
    Quantity(
        "reached", "last estimates as the study wants them", dims=PER_TRIAL, inputs=("final_estimate", TRUTH, GOAL),
        derive=as_wanted, over_robots=_share_of_known, label="reached",
        shown=True, low=False, statistic="mean", share=True, summary=True, decimals=1,
        compared="robots with a last estimate as the study wants it",
    ),
    Quantity("true_fill_ratio", "black share of the floor that robots can reach", "always", PER_TRIAL),
    Quantity(
        "components", "connected components of the trial's network", "networks", PER_TRIAL, statistic="mean",
        summary=True,
    ),
    Quantity("mean_degree", "robots that a robot hears", "networks", PER_TRIAL, statistic="mean", summary=True),
    Quantity(
        "connected", "networks that are connected", dims=PER_TRIAL, inputs=("components",),
        derive=lambda parts: np.where(np.isnan(parts), np.nan, parts == 1),
        statistic="mean", share=True, summary=True,
    ),
    Quantity("drawn_fill_ratio", "the fill ratio of a trial", "drawn", PER_TRIAL, statistic="mean", summary=True),
    Quantity(
        "local_convergence_step", "convergence of the local estimate", "local", unit="observations", kind=np.int32,
        label="local K", axis="local convergence $K$", low=True, summary=True,
    ),
    Quantity(
        "local_convergence_error", "the local estimate's error at convergence", "local",
        label="local error at K", axis=r"local error $|\hat{x}^K - f\,|$", low=True, summary=True,
        compared="|x - f| of the local estimate at its K",
    ),
    Quantity(
        "messages_sent", "rounds, or ticks, in which the robot broadcast", "messages", unit="messages",
        label="messages", axis="messages sent by a robot", low=True, statistic="mean", summary=True,
        compared="messages sent by a robot",
    ),
    Quantity(
        "messages_heard", "messages that reached the robot", "messages", unit="messages",
        label="heard", low=True, statistic="mean", summary=True, compared="messages heard by a robot",
    ),
    Quantity(
        "messages_clipped", "messages with a number that the format cannot hold", "formats", unit="messages",
        label="clipped", low=True, statistic="mean",
    ),
    Quantity(
        "memory_bytes", "what a robot remembers, 4 a number", "setting", PER_SETTING, "bytes", np.int64,
        label="memory", axis="memory of a robot (bytes)",
    ),
    Quantity(
        "message_bytes", "what one message takes, 4 a number", "setting", PER_SETTING, "bytes", np.int64,
        label="message", axis="bytes of a message",
    ),
    Quantity("anonymous", "1 where no brain knows its robot's name", "setting", PER_SETTING, "", np.int64),
    Quantity("honest", "those that are measured", "honest", PER_SETTING, "robots", np.int64),
    Quantity(
        "fingerprint", "the address of all that a setting's numbers depend on", "setting", PER_SETTING, "", object,
    ),
    Quantity("half_width", "half the interval that the rule looks at", "rule", PER_SETTING, "", label="+-"),
    Quantity(
        "bytes_sent", "bytes sent by a robot", unit="bytes", inputs=("messages_sent",), factor="message_bytes",
        axis="bytes sent by a robot", label="bytes", low=True, statistic="mean", summary=True,
    ),
    Quantity("decision", "the option decided for at the end; -1: none", "decisions", bounds=OPTIONS),
    Quantity(
        "decided", "robots that decided", inputs=("decision",),
        derive=lambda decision: np.where(np.isnan(decision), np.nan, decision >= 0),
        low=False, statistic="mean", share=True, summary=True,
    ),
    Quantity(
        "decided_right", "robots that decided for the right option", inputs=("decision", "right_option"),
        derive=_decided_right, low=False, statistic="mean", share=True, summary=True,
    ),
    Quantity(
        "decision_round", "the first decision; infinite: never", "decisions", unit="rounds", never=True,
        low=True, summary=True, compared="round of a robot's first decision",
    ),
    Quantity(
        "decision_change", "the last change of the decision; infinite: never decided", "decisions", unit="rounds",
        never=True, label="last change", low=True, compared="round of a robot's last change of its decision",
    ),
    Quantity(
        "consensus", "the first option that all robots agreed on; -1: none", "decisions", PER_TRIAL, bounds=OPTIONS,
    ),
    Quantity(
        "consensus_round", "the first round after which they did; infinite: never", "decisions", PER_TRIAL, "rounds",
        never=True, summary=True,
    ),
    Quantity(
        "right_consensus_round", "round of a consensus on the right option", dims=PER_TRIAL, unit="rounds", never=True,
        inputs=("consensus_round", "consensus_right"), derive=_on_right, label="right consensus", low=True,
        summary=True,
    ),
    Quantity(
        "consensus_right", "1 if that option is right, 0 if not, or if there is none", "decisions", PER_TRIAL,
        label="exit", low=False, statistic="mean", share=True, summary=True,
        compared="trials whose consensus is on the right option",
    ),
    Quantity("right_option", "the option that is right; missing where none is", "decisions", PER_TRIAL, bounds=OPTIONS),
    Quantity(
        "done_round", "the first after which the robot was done; infinite: never", "endings", unit="rounds",
        never=True, label="done", low=True, summary=True, compared="round in which a robot is done",
    ),
    Quantity(
        "done", "robots that are done", inputs=("done_round",),
        derive=lambda done_round: np.where(np.isnan(done_round), np.nan, np.isfinite(done_round)),
        low=False, statistic="mean", share=True, summary=True,
    ),
    Quantity("done_estimate", "the estimate then", "endings", bounds=(-inf, inf)),
    Quantity(
        "done_error", "|x - f| of the estimate that a robot is done with", inputs=("done_estimate", TRUTH),
        derive=_error, label="error when done", low=True,
    ),
    Quantity(
        "coverage", "fraction of robots whose interval holds the fill ratio", "intervals", PER_CHECKPOINT,
        shown=True, axis="share of intervals that hold $f$", statistic="mean", share=True, bounds=(0.0, 1.0),
        decimals=1,
    ),
    Quantity(
        "interval_width", "mean width of the robots' intervals", "intervals", PER_CHECKPOINT,
        shown=True, axis="width of the intervals", low=True, bounds=(0.0, 1.0), decimals=4,
        compared="mean width of the robots' intervals at the last checkpoint",
    ),
    Quantity("estimates", "the informed estimate at the checkpoints", "estimates", ESTIMATES, bounds=(-inf, inf)),
)  # fmt: skip
QUANTITIES = {quantity.name: quantity for quantity in ALL}


def stored(group: str) -> dict[str, Quantity]:
    """The quantities that runs of a group store."""
    return {quantity.name: quantity for quantity in ALL if quantity.group == group}
