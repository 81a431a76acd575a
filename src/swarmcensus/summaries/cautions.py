"""What misleads in results: settings that are easily misread, and brains that a study used outside their range."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from operator import itemgetter
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import failed_in, origins_of
from swarmcensus.studies import Measure, Setting, Study, unmet_needs
from swarmcensus.summaries import measures
from swarmcensus.summaries.never_learnt import never_learnt
from swarmcensus.support.bins import on_edges
from swarmcensus.support.bootstrap import centres
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.toml_text import to_toml
from swarmcensus.worlds import read_change

LEAST = 0.05  # share of a setting's robots from which a warning is given
MOST_NAMED = 8  # settings, brains, or trials
MOST_LINES = 40  # on failed trials
SETTING = itemgetter("setting")
BINARY = 2  # bins of those who decide between two options
AGREED_AT_START = "robots begin with one estimate and stay together, be it right or wrong"
EARLY = 0.5  # share of the rounds up to which a median K is early
FAR = 3.0  # deltas from each other, or from the truth, that are far

Origins = Mapping[int, tuple[Study, Setting]]


def settled_at_start(data: xr.Dataset) -> NDArray[np.float64]:
    """The share of robots with convergence 0 over all trials, (setting,); NaN without a trial.

    The estimates of such a robot never left its first belief by delta or more. Often this is because the fill ratio is
    0.5, where brains begin.
    """
    when = data.variables["convergence_round"].transpose("setting", "trial", "robot").values
    known = (when >= 0).sum(axis=(1, 2))
    return np.asarray(np.where(known, (when == 0).sum(axis=(1, 2)) / np.maximum(known, 1), np.nan))


def settled_far_off(data: xr.Dataset, *, opinions: bool = False) -> NDArray[np.bool_]:
    """Settings in which robots settle early, but far from each other or from the truth, (setting,).

    Errors fall with the root of the number of readings. So robots that are within delta of all their later estimates
    after half of the rounds are about delta off in the end: of brains that do right, 90 % of the robots are within 1.6
    delta. What is more than 3 delta has another reason, such as a bias, liars, or robots that hear too little. Settings
    whose robots decide are left out, as their estimates may be opinions, unless `opinions` are wanted too.
    """
    names = ("convergence_round", "final_disagreement", "error_90")
    if {"delta", "truth"} - {*data.attrs} or any(measures.missing_inputs(data, name) for name in names):
        return np.zeros(data.sizes["setting"], np.bool_)
    found = (centres(measures.numbers(data, name), "median") for name in names)
    misleads = ((late := next(found)) > 0) & (late <= EARLY * data["rounds"].values)
    if "decision" in data and not opinions:
        misleads &= data["decision"].isnull().all(("trial", "robot")).values
    return np.asarray(misleads & (misleads.any() and np.maximum(*found) > FAR * float(data.attrs["delta"])))


def cautions_of_settling(data: xr.Dataset) -> list[str]:
    """A sentence on the settings in which K misleads, if there are any."""
    if not (found := settled_far_off(data)).any():
        return []
    one = data.isel(setting=found)
    highest = {n: np.nanmax(centres(measures.numbers(one, n), "median")) for n in ("final_disagreement", "error_90")}
    ends = [f"{name} up to {value:.2g}" for name, value in highest.items()]
    return [
        f"{_settings(one)} ({', '.join(dict.fromkeys(one['brain'].values.tolist()))}): K is early and misleads, since "
        f"robots end far from each other or from the true fill ratio ({', '.join(ends)}; delta = "
        f"{data.attrs['delta']:g}): look at agreement_round and error_90"
    ]


def _settings(data: xr.Dataset) -> str:
    """The settings of a dataset, by number."""
    numbers = data["setting"].values.tolist()
    return f"setting{'s' if len(numbers) > 1 else ''} {_first(numbers)}"


def _first(names: Iterable[object]) -> str:
    """The first of these, each once."""
    several = [str(name) for name in dict.fromkeys(names)]
    return ", ".join(several[:MOST_NAMED]) + ", ..." * (len(several) > MOST_NAMED)


def cautions_of_trials(data: xr.Dataset) -> list[str]:
    """The cautions that only trials can tell."""
    return cautions_of_start(data) + cautions_of_settling(data)


def cautions_of(data: xr.Dataset, compared: Collection[str] | None = None, origins: Origins | None = None) -> list[str]:
    """A sentence on each reason to misread these results.

    They are for a table of settings, or for a comparison by the measures `compared`. `origins` are those of the
    results, if they are known.
    """
    wants = [" ".join(to_toml(one).splitlines()) for one in measures.wants_of(data)]
    differ = [f"the studies want different things ({'; '.join(wants)}), so nothing is reached"] * (len(wants) > 1)
    if compared is None:
        return differ + cautions_of_edges(data) + cautions_of_trials(data) + _of_clipped(data)
    cautions = [*differ, *cautions_of_needs(data, compared, origins)]
    if failed := len(failed_trials(data)):
        cautions.append(f"{counted(failed, 'trial')} failed and cannot be compared")
    lacking = [variable for name in measures.COSTS for variable in measures.missing_inputs(data, name)]
    if absent := dict.fromkeys(lacking + [name for name in measures.SIZES if name not in data]):
        cautions.append(f"these results do not say what brains cost: they have no {', no '.join(absent)}")
    named = data["brain"].values[data["anonymous"].values == 0].tolist() if "anonymous" in data else []
    if named:
        cautions.append(f"not anonymous, as robots' names are used: {_named(named)}")
    if "correct" in compared:
        cautions += cautions_of_edges(data)
    if "convergence_round" in compared:
        cautions += cautions_of_settling(data)
    return cautions


def failed_trials(data: xr.Dataset) -> list[dict[str, Any]]:
    """The failed trials of these settings, each with `setting`, `trial` and `why`."""
    there = set(data["setting"].values.tolist())
    return [one for one in failed_in(data) if one["setting"] in there]


def failures(data: xr.Dataset) -> list[str]:
    """A line for each of the first settings with failed trials."""
    lines = []
    for number, group in itertools.groupby(sorted(failed_trials(data), key=SETTING), SETTING):
        failed = [*group]
        lines.append(f"setting {number}, trial {_first(failure['trial'] for failure in failed)}: {failed[0]['why']}")
    more = len(lines) - MOST_LINES
    return lines[:MOST_LINES] + [f"and trials of {counted(more, 'more setting')}"] * (more > 0)


def cautions_of_start(data: xr.Dataset) -> list[str]:
    """A sentence on the settings in which 5 % of the robots or more converged before their first observation."""
    shares = settled_at_start(data)
    if not (found := np.flatnonzero(shares >= LEAST)).size:
        return []
    delta = f" = {data.attrs['delta']:g}" if "delta" in data.attrs else ""
    return [
        f"{_settings(data.isel(setting=found))}: up to {100 * shares[found].max():.0f} % of the robots have K = 0: "
        f"their estimates never left what they believed before any observation by delta{delta} or more. There, K does "
        "not tell how fast robots learn: choose another fill ratio or accuracy, or a smaller delta under [measure]"
    ]


def cautions_of_edges(*parts: xr.Dataset) -> list[str]:
    """A sentence on fill ratios on the edge between two bins, if there are any: estimates just below count as wrong."""
    nominal = [data for data in parts if data.attrs.get("truth") == "nominal"]  # else each trial has its own true one
    if not nominal:
        return []
    bins = int(nominal[0].attrs["bins"])
    texts = {text for data in nominal if "fill_ratio_change" in data for text in data["fill_ratio_change"].values}
    drawn = [data["fill_ratio_spread"].values != "" if "fill_ratio_spread" in data else False for data in nominal]
    fixed = [np.where(so, np.nan, data["fill_ratio"].values) for so, data in zip(drawn, nominal, strict=True)]
    return _of_edges(np.concatenate([*fixed, [one.first for one in map(read_change, texts) if one]]), bins)


def cautions_of_fill_ratios(settings: Sequence[Setting], measure: Measure) -> list[str]:
    """The same before anything has run."""
    values = [one.fill_ratio for one in settings if not one.spread] + [s.change.first for s in settings if s.change]
    return _of_edges(np.array(values), measure.bins) if measure.truth == "nominal" else []


def _of_edges(values: NDArray[np.float64], bins: int) -> list[str]:
    known = np.unique(values)
    found = [f"{value:g}" for value in known[on_edges(known, bins)]]
    return bool(found) * [
        f"fill ratios on the edge between two of the {bins} bins, {_first(found)}: about half of good estimates are in "
        "the wrong one. Choose another number of bins under [measure], or another fill ratio"
    ]


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


def known_origins(data: xr.Dataset) -> Origins:
    """The study and setting of each number, without running any brain; none if the results do not tell them."""
    if not {"study", "merged"} & data.attrs.keys() or "fingerprint" not in data:
        return {}
    try:
        return origins_of(data, data["setting"].values)
    except InputError:
        return {}


def cautions_of_needs(data: xr.Dataset, compared: Collection[str] = (), origins: Origins | None = None) -> list[str]:
    """What brains of these results lacked, a sentence each; `compared` names the measures that are compared.

    Nothing is said of results without their study. `origins` are those of the results, if
    they are known.
    """
    origins = known_origins(data) if origins is None else origins
    settings = {number: setting for number, (_, setting) in origins.items()}
    cautions = unmet_needs(settings.values(), BINARY)  # what else is asked, the measures say
    if not measures.missing_inputs(data, "messages_sent"):
        silent = data["setting"].values[(measures.numbers(data, "messages_sent") == 0).any(axis=1)].tolist()
        mute = [settings[n].brain.label for n in silent if n in settings and not settings[n].brain.never_speaks]
        if mute:
            cautions.append(f"{_named(mute)} sent nothing in all trials or some, so robots were alone there")
    asked = [name for name in compared if "error" in name or (name == "correct" and data.attrs["bins"] != BINARY)]
    binary = [setting.brain.label for setting in settings.values() if setting.brain.needs.get("binary")]
    if asked and binary:
        which = "on which side of one half f is"
        cautions.append(f"{_named(binary)}: the answer is {which}, so right_side measures it, not {', '.join(asked)}")
    return cautions


def _named(labels: list[str]) -> str:
    return ", ".join(dict.fromkeys(labels))


def caution_of_learning(parts: Sequence[xr.Dataset], what: str) -> str:
    """A sentence on the settings whose robots never learnt, and `what` is made of them; empty if there are none."""
    brains = [name for part in parts for name in part["brain"].values[never_learnt(part)].tolist()]
    if not brains:
        return ""
    return f"{_first(brains)}: in {counted(len(brains), 'setting')} half of the robots never learnt (K = 0): {what}"
