"""The cost of a wrong belief about one's own sensor: the bias that remains, in closed form and as simulated."""

import re
from typing import NamedTuple

import numpy as np
import xarray as xr

from swarmcensus.results import robots_in
from swarmcensus.summaries import require
from swarmcensus.support import intervals
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.theory import asymptote
from swarmcensus.worlds import Accuracy, Misjudgement, parse_accuracy, parse_assumed

EQ_4 = {"minimalistic", "leaver", "legacy"}  # brains with the local estimate of the paper's Eq. 4


class Cost(NamedTuple):
    """One setting: the accuracy of its robots' sensors, what they believe, and the error of their final estimates.

    `error` is the believed minus the true accuracy, None if it is drawn for each robot. `median` is the median of
    |x - f| over robots and trials, `low` and `high` are its 95 % bootstrap interval over trials. All are NaN without a
    finished trial, the interval also with fewer than 6. `predicted` is |asymptote - f|, NaN if robots differ or their
    brain does not use Eq. 4.
    """

    accuracy: str
    belief: str
    error: float | None
    fill_ratio: float
    median: float
    low: float
    high: float
    predicted: float


def costs(results: xr.Dataset) -> list[Cost]:
    """The cost of each setting's belief, in the order of the settings.

    Raises InputError if a variable is missing, if all robots know their sensors, or if a belief is off by different
    amounts for black and for white.
    """
    require(results, "accuracy", "assumed_accuracy", "fill_ratio", "final_estimate", "robots", "brain")
    if "fill_ratio_spread" in results.coords:
        why = "each trial of some settings draws its own f, and the cost of a belief is that at one f"
        raise InputError(why, key="fill_ratio")
    if (results["assumed_accuracy"].values == results["accuracy"].values).all():
        raise InputError(
            "all robots of these results know their sensors: set assumed_accuracy under [swarm], "
            "such as [{error = -0.05}, {error = 0}, {error = 0.05}], and run again",
            key="assumed_accuracy",
        )
    return costs_of(results)


def costs_of(results: xr.Dataset) -> list[Cost]:
    """The cost of each setting's belief, also if all robots know their sensors."""
    return [_cost(results.isel(setting=k)) for k in range(results.sizes["setting"])]


def _cost(selected: xr.Dataset) -> Cost:
    accuracy, belief = str(selected["accuracy"].item()), str(selected["assumed_accuracy"].item())
    f = float(selected["fill_ratio"])
    true, assumed = map(_read, (accuracy, belief))
    assert isinstance(true, Accuracy)
    error = _error(true, assumed, accuracy, belief)
    predicted = median = low = high = np.nan
    if error is not None and _fixed(true) and selected["brain"].item() in EQ_4:
        predicted = float(np.abs(goes_to(true, error, f) - f))
    final = selected["final_estimate"].transpose("trial", "robot").values[:, : int(robots_in(selected))]
    errors = np.abs(final[np.isfinite(final).all(axis=1)] - f)
    if len(errors):
        median, low, high = intervals.interval(intervals.medians(errors, intervals.resample(len(errors))))
    if len(errors) < intervals.FEWEST:
        low = high = np.nan
    return Cost(accuracy, belief, error, f, median, low, high, predicted)


def _read(text: str) -> Accuracy | Misjudgement:
    """An accuracy or belief; one from a file of the user's is read as some spread, as no file is run here."""
    plain = re.sub(r"(?<![^=])[^=]*\.py\([^()]*\)", "U(0.0,1.0)", text)
    return accuracy_of(text if plain == text else plain.partition(" drift=")[0])


def accuracy_of(text: str) -> Accuracy | Misjudgement:
    """An accuracy or belief from its canonical text, as stored in a dataset."""
    return parse_assumed(text) if "error=" in text else parse_accuracy(text)


def _sides(accuracy: Accuracy) -> tuple[float, float]:
    return accuracy.black.numbers[0], (accuracy.white or accuracy.black).numbers[0]


def _fixed(accuracy: Accuracy) -> bool:
    """Whether an accuracy is the same for all robots and rounds."""
    return accuracy.drift is None and accuracy.black.is_number and (accuracy.white or accuracy.black).is_number


def _error(true: Accuracy, assumed: Accuracy | Misjudgement, accuracy: str, belief: str) -> float | None:
    if isinstance(assumed, Misjudgement):
        return assumed.error.numbers[0] if assumed.error.is_number else None
    if not (_fixed(assumed) and _fixed(true)):
        return None
    # rounded, as 0.9 - 0.85 and 0.8 - 0.75 differ in the last bits
    black, white = (round(a - t, 9) for a, t in zip(_sides(assumed), _sides(true), strict=True))
    if black != white:
        raise InputError(
            f"assumed_accuracy {belief} is off from the accuracy {accuracy} by {black:g} for black and {white:g} for "
            "white: this figure shows one error for both, as {error = ...} gives; select others",
            key="assumed_accuracy",
            value=belief,
        )
    return black


def goes_to(true: Accuracy, error: float | Floats, f: float) -> Floats:
    """The `asymptote` of robots that believe the truth plus `error`, for black and for white."""
    b, w = _sides(true)
    return asymptote(b, w, np.clip(b + error, 0.0, 1.0), np.clip(w + error, 0.0, 1.0), f)
