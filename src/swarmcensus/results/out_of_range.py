"""Cautions about brains that a study used outside their range, or asked what they do not answer."""

from collections.abc import Collection, Mapping

import xarray as xr

from swarmcensus.results import measures
from swarmcensus.results.source_study import RELIVED, origins_of
from swarmcensus.studies import Setting, Study, unmet_needs
from swarmcensus.support.errors import InputError

BINARY = 2


Origins = Mapping[int, tuple[Study, Setting]]


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

    Nothing is said of recordings of robots, and of results without their study. `origins` are those of the results, if
    they are known.
    """
    origins = known_origins(data) if origins is None else origins
    settings = {} if RELIVED in data.attrs else {number: setting for number, (_, setting) in origins.items()}
    cautions = unmet_needs(settings.values(), BINARY)  # what else is asked, the measures say
    if not measures.lacks(data, "messages_sent"):
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
