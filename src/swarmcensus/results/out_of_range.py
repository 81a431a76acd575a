"""Cautions about brains that a study used outside their range, or asked what they do not answer."""

import contextlib
from collections.abc import Collection

import xarray as xr

from swarmcensus.results import measures
from swarmcensus.results.source_study import RELIVED, origins_of
from swarmcensus.studies import Setting, unmet_needs
from swarmcensus.support.errors import InputError

BINARY = 2


def cautions_of_needs(data: xr.Dataset, compared: Collection[str] = ()) -> list[str]:
    """What brains of these results lacked, a sentence each; `compared` names the measures that are compared.

    Brains are not run. Nothing is said of recordings of robots, and of results without their study.
    """
    settings: dict[int, Setting] = {}
    if RELIVED not in data.attrs:
        with contextlib.suppress(InputError):
            settings = {n: setting for n, (_, setting) in origins_of(data, data["setting"].values).items()}
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
