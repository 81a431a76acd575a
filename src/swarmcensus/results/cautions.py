"""Warnings about settings with results that are easily misread."""

from __future__ import annotations

import warnings

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import measures
from swarmcensus.support.bins import on_edges
from swarmcensus.support.bootstrap import centres
from swarmcensus.worlds import read_change

LEAST = 0.05  # share of a setting's robots from which a warning is given
MOST_NAMED = 8  # settings
TOGETHER = "robots begin with one estimate and stay together, be it right or wrong"
EARLY = 0.5  # share of the rounds up to which a median K is early
FAR = 3.0  # deltas from each other, or from the truth, that are far


def settled_at_start(data: xr.Dataset) -> NDArray[np.float64]:
    """The share of robots with convergence 0 over all trials, (setting,); NaN without a trial.

    The estimates of such a robot never left its first belief by delta or more. Often this is because the fill ratio is
    0.5, where brains begin.
    """
    when = data["convergence_round"].transpose("setting", "trial", "robot").values
    known = (when >= 0).sum(axis=(1, 2))
    share: NDArray[np.float64] = np.where(known, (when == 0).sum(axis=(1, 2)) / np.maximum(known, 1), np.nan)
    return share


def settled_far_off(data: xr.Dataset, *, opinions: bool = False) -> NDArray[np.bool_]:
    """Settings in which robots settle early, but far from each other or from the truth, (setting,).

    Errors fall with the root of the number of readings. So robots that are within delta of all their later estimates
    after half of the rounds are about delta off in the end: of brains that do right, 90 % of the robots are within 1.6
    delta. What is more than 3 delta has another reason, such as a bias, liars, or robots that hear too little. Settings
    whose robots decide are left out, as their estimates may be opinions, unless `opinions` are wanted too.
    """
    apart = ("final_disagreement", "error_90")
    if {"delta", "truth"} - {*data.attrs} or any(measures.lacks(data, name) for name in ("convergence_round", *apart)):
        return np.zeros(data.sizes["setting"], np.bool_)
    late, *far = (centres(measures.numbers(data, name), "median") for name in ("convergence_round", *apart))
    decides = (
        data["decision"].notnull().any(("trial", "robot")).values if "decision" in data and not opinions else False
    )
    early = (late > 0) & (late <= EARLY * data["rounds"].values)
    return np.asarray(early & (np.maximum(*far) > FAR * float(data.attrs["delta"])) & ~np.asarray(decides))


def cautions_of_settling(data: xr.Dataset) -> list[str]:
    """A sentence on the settings in which K misleads, if there are any."""
    found = settled_far_off(data)
    if not found.any():
        return []
    one = data.isel(setting=found)
    up_to = " up to" * (one.sizes["setting"] > 1)
    ends = [f"{name}{up_to} {_highest(one, name):.2g}" for name in ("final_disagreement", "error_90")]
    return [
        f"{_settings(one)} ({', '.join(dict.fromkeys(one['brain'].values.tolist()))}): K is early and misleads, since "
        f"robots end far from each other or from the true fill ratio ({', '.join(ends)}; delta = "
        f"{data.attrs['delta']:g}): look at agreement_round and error_90"
    ]


def _highest(data: xr.Dataset, name: str) -> float:
    return float(np.nanmax(centres(measures.numbers(data, name), "median")))


def _settings(data: xr.Dataset) -> str:
    """The settings of a dataset, by number."""
    numbers = data["setting"].values
    named = ", ".join(map(str, numbers[:MOST_NAMED])) + (", ..." if numbers.size > MOST_NAMED else "")
    return f"setting{'s' if numbers.size > 1 else ''} {named}"


def warn_of(data: xr.Dataset) -> None:
    """Give all cautions about these results as warnings, for the line that called the caller."""
    for caution in cautions_of(data):
        warnings.warn(caution, stacklevel=3)


def warn_of_course(data: xr.Dataset) -> None:
    """Give those that only trials can tell."""
    for caution in [*cautions_of_start(data), *cautions_of_settling(data)]:
        warnings.warn(caution, stacklevel=3)


def cautions_of(data: xr.Dataset) -> list[str]:
    """A sentence on each reason to misread these results."""
    return [*cautions_of_edges(data), *cautions_of_start(data), *cautions_of_settling(data), *_of_clipped(data)]


def cautions_of_start(data: xr.Dataset) -> list[str]:
    """A sentence on the settings in which 5 % of the robots or more converged before their first observation."""
    shares = settled_at_start(data)
    found = np.flatnonzero(shares >= LEAST)
    if not found.size:
        return []
    highest = f"{'up to ' if found.size > 1 else ''}{100 * shares[found].max():.0f} %"
    delta = f" = {data.attrs['delta']:g}" if "delta" in data.attrs else ""
    return [
        f"{_settings(data.isel(setting=found))}: {highest} of the robots have K = 0: their estimates never "
        f"left what they believed before any observation by delta{delta} or more. There, K does not "
        f"tell how fast robots learn: {_remedy(data.isel(setting=found))}"
    ]


def _remedy(data: xr.Dataset) -> str:
    """What would let robots that never left their first belief learn."""
    if (data["accuracy"].values.astype(str) == "0.5").all():
        return "readings of accuracy 0.5 say nothing of the floor: choose another accuracy"
    return "choose another fill ratio, or a smaller delta under [measure]"


def cautions_of_edges(*parts: xr.Dataset) -> list[str]:
    """A sentence on fill ratios on the edge between two bins, if there are any: estimates just below count as wrong."""
    nominal = [data for data in parts if data.attrs.get("truth") == "nominal"]  # else each trial has its own true one
    if not nominal:
        return []
    bins = int(nominal[0].attrs["bins"])
    texts = {text for data in nominal if "fill_ratio_change" in data for text in data["fill_ratio_change"].values}
    changes = map(read_change, texts)
    values = np.unique(
        [f for data in nominal for f in data["fill_ratio"].values] + [one.first for one in changes if one]
    )
    found = [f"{value:g}" for value in values[on_edges(values, bins)]]
    if not found:
        return []
    named = ", ".join(found[:MOST_NAMED]) + (", ..." if len(found) > MOST_NAMED else "")
    return [
        f"fill ratio {named} {'lies' if len(found) == 1 else 'lie'} on the edge between two of the {bins} bins: about "
        "half of good estimates are in the wrong one. Choose another number of bins under [measure], or another fill "
        "ratio"
    ]


def warn_of_edges(data: xr.Dataset, stacklevel: int = 2) -> None:
    """Warn about fill ratios on the edge between two bins."""
    for caution in cautions_of_edges(data):
        warnings.warn(caution, stacklevel=stacklevel)


def _of_clipped(data: xr.Dataset) -> list[str]:
    """A sentence on settings with messages that their format could not hold."""
    if "messages_clipped" not in data:
        return []
    clipped, sent = (data[name].mean(("trial", "robot")).values for name in ("messages_clipped", "messages_sent"))
    if not (clipped > 0.0).any():
        return []
    most = 100.0 * np.nanmax(clipped / np.maximum(sent, 1.0))
    return [
        f"{_settings(data.isel(setting=clipped > 0.0))}: a number was too large for the message format and was sent as "
        f"the largest, in up to {most:.3g} % of the messages (messages_clipped)"
    ]
