"""All that chance decides for some trials of a setting before they run: accuracies, failures, links, keys of draws."""

from typing import NamedTuple, Self

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.engine.layout import Links, Radio, Sensors
from swarmcensus.simulation import sampling
from swarmcensus.studies import addresses
from swarmcensus.studies.settings import Setting

NO_GROUPS = np.zeros((0, 0), np.int64)
ALL_HONEST = np.zeros((0, 0), np.bool_)
NO_SPEEDS = np.zeros((0, 0))
NO_KEY = np.zeros(2, np.uint64)  # where nothing is drawn


class Inputs(NamedTuple):
    """The inputs of trials first to first + trials - 1."""

    first: int
    sensors: Sensors
    beliefs: tuple[np.ndarray, np.ndarray]  # assumed b and w, (trial, robot or 1)
    radio: Radio
    links: Links | None  # who hears whom; None where robots move
    stops: np.ndarray  # (trial, part, robot): when parts of robots fail, see `engine.failures`
    luck: np.ndarray  # two keys; empty where no brain uses luck
    walk: np.ndarray  # key of the random walk
    speeds: np.ndarray  # (trial, robot): metres that a robot goes in a tick; no rows on fixed networks
    group: np.ndarray  # (trial, robot): which of the setting's brains; no rows where there is only one
    honest: np.ndarray  # (trial, robot): whom metrics count; no rows where they count all

    def of(self, k: int) -> Self:
        """The inputs of the k-th of these trials alone, as a batch of one."""
        one = slice(k, k + 1)
        sensors, links = self.sensors, self.links
        if links is not None and links.starts.size > 2:
            links = links._replace(starts=links.starts[k : k + 2])
        return self._replace(
            first=self.first + k,
            sensors=sensors._replace(b=sensors.b[one], w=sensors.w[one], drift=sensors.drift[one]),
            beliefs=(self.beliefs[0][one], self.beliefs[1][one]), links=links, stops=self.stops[one],
            speeds=self.speeds[one], group=self.group[one], honest=self.honest[one],
        )  # fmt: skip

    @property
    def first_beliefs(self) -> tuple[np.ndarray, np.ndarray]:
        """The accuracies that robots assume in the first trial."""
        return self.beliefs[0][0], self.beliefs[1][0]


def inputs_of(setting: Setting, seed: int, first: int, trials: int = 1, *, order: bool = False) -> Inputs:
    """Prepare trials; `order` if single readings are needed. Raises InputError if no graph can be made."""
    moves = setting.body is not None
    try:
        links = None if moves else sampling.links(setting, seed, first, trials)
    except ValueError as error:
        raise InputError(f"trials {first} to {first + trials - 1} of {setting}: {error}") from error
    b, w, assumed_b, assumed_w = sampling.accuracies(setting, seed, first, trials)
    beliefs = (assumed_b, assumed_w)
    if setting.precision == "single":
        beliefs = (assumed_b.astype(np.float32).astype(np.float64), assumed_w.astype(np.float32).astype(np.float64))
    drift, readings = sampling.drifts(setting, seed, first, trials, b), addresses.readings_key(setting, seed)
    orders = addresses.readings_key(setting, seed, "order") if order else NO_KEY
    sensors = Sensors(b, w, drift, setting.course, setting.observations_per_round, readings, orders)
    losses = addresses.losses_key(setting, seed) if setting.loss_threshold else NO_KEY
    group, honest = _groups_of(setting, seed, first, trials)
    return Inputs(
        first=first,
        sensors=sensors,
        beliefs=beliefs,
        radio=Radio(losses, setting.loss_threshold, setting.message_delay, moves and setting.brain.is_oracle),
        links=links,
        stops=np.stack([sampling.stops(setting, seed, first + t) for t in range(trials)]),
        luck=addresses.luck_keys(setting, seed, alone=order),
        walk=addresses.walk_key(setting, seed) if moves else NO_KEY,
        speeds=np.stack([sampling.speeds(setting, seed, first + t) for t in range(trials)]) if moves else NO_SPEEDS,
        group=group,
        honest=honest,
    )


def _groups_of(setting: Setting, seed: int, first: int, trials: int) -> tuple[np.ndarray, np.ndarray]:
    group, honest = NO_GROUPS, ALL_HONEST
    if not setting.members:
        return group, honest
    groups, brains = sampling.groups(setting, seed, first, trials), setting.brains
    if len(brains) > 1:
        group = np.array(
            [0, *(brains.index(m.brain_in(setting.brain).with_numbers(setting.brain.numbers)) for m in setting.members)]
        )[groups]
    if setting.honest < setting.robots:
        honest = np.array([True, *(m.honest for m in setting.members)])[groups]
    return group, honest
