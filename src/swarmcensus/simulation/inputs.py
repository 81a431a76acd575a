"""What chance gives some trials of a setting, looked up once: from here on no setting is asked for random numbers."""

from dataclasses import replace
from typing import NamedTuple, Self

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.studies.settings import Setting
from swarmcensus.worlds.networks import Links

NO_GROUPS = np.zeros((0, 0), np.int64)
ALL_HONEST = np.zeros((0, 0), np.bool_)
NO_PACES = np.zeros((0, 0))
NO_KEY = np.zeros(2, np.uint64)  # of draws that are not made


class Inputs(NamedTuple):
    """Of trials first to first + trials - 1; accuracies are (trial, robot), or (trial, 1) where robots are alike."""

    first: int
    sensors: tuple[np.ndarray, np.ndarray]  # true b and w, of the first round
    drift: np.ndarray  # (trial, 3, robot or 1): how those drift, see `engine.changes`; no robots where they stay
    beliefs: tuple[np.ndarray, np.ndarray]  # assumed b and w
    stops: np.ndarray  # (trial, part, robot): when parts of robots fail
    readings: np.ndarray  # addresses of random numbers, each a key of two words
    order: np.ndarray  # of single readings within a round
    losses: np.ndarray
    loss_threshold: np.uint64  # a message gets through where a uniform uint64 is below it; 0 stands for always
    luck: np.ndarray  # of brains that ask for it, two keys; empty where none does
    walk: np.ndarray  # of robots that move
    paces: np.ndarray  # (trial, robot): how far they go in a tick, in metres; no rows on fixed networks
    links: Links | None  # who hears whom; None where robots move
    group: np.ndarray  # (trial, robot): which of the setting's brains; no rows where there is one
    honest: np.ndarray  # (trial, robot): whom metrics count; no rows where they count all

    def of(self, k: int) -> Self:
        """Those of the k-th of these trials alone."""
        one = slice(k, k + 1)
        links = self.links
        if links is not None and links.starts.size > 2:
            links = replace(links, starts=links.starts[k : k + 2])
        b, w, assumed_b, assumed_w = (a[one] for a in (*self.sensors, *self.beliefs))
        return self._replace(
            first=self.first + k, sensors=(b, w), drift=self.drift[one], beliefs=(assumed_b, assumed_w),
            stops=self.stops[one], links=links, group=self.group[one], honest=self.honest[one], paces=self.paces[one],
        )  # fmt: skip


def inputs_of(setting: Setting, seed: int, first: int, trials: int = 1, *, order: bool = False) -> Inputs:
    """Prepare trials; `order` where single readings are asked for. Raises InputError where no graph can be made."""
    moves = setting.body is not None
    try:
        links = None if moves else setting.links(seed, first, trials)
    except ValueError as error:
        raise InputError(f"trials {first} to {first + trials - 1} of {setting}: {error}") from error
    b, w, assumed_b, assumed_w = setting.accuracies(seed, first, trials)
    group, honest = _who(setting, seed, first, trials)
    return Inputs(
        first=first,
        sensors=(b, w),
        drift=setting.drifts(seed, first, trials, b),
        beliefs=(assumed_b, assumed_w),
        stops=np.stack([setting.stops(seed, first + t) for t in range(trials)]),
        readings=setting.readings_key(seed),
        order=setting.readings_key(seed, "order") if order else NO_KEY,
        losses=setting.losses_key(seed) if setting.loss_threshold else NO_KEY,
        loss_threshold=setting.loss_threshold,
        luck=setting.luck_keys(seed, alone=order),
        walk=setting.walk_key(seed) if moves else NO_KEY,
        paces=np.stack([setting.paces(seed, first + t) for t in range(trials)]) if moves else NO_PACES,
        links=links,
        group=group,
        honest=honest,
    )


def _who(setting: Setting, seed: int, first: int, trials: int) -> tuple[np.ndarray, np.ndarray]:
    group, honest = NO_GROUPS, ALL_HONEST
    if not setting.members:
        return group, honest
    who, crew = setting.who(seed, first, trials), setting.crew
    if len(crew) > 1:
        group = np.array([0, *(crew.index(m.brain_in(setting.brain)) for m in setting.members)])[who]
    if setting.honest < setting.robots:
        honest = np.array([True, *(m.honest for m in setting.members)])[who]
    return group, honest
