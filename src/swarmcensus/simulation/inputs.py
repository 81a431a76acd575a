"""All that chance decides for some trials of a setting before they run: accuracies, failures, links, keys of draws."""

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.engine.layout import NO_LINKS, Inputs, Radio, Sensors
from swarmcensus.studies.settings import Setting

NO_GROUPS = np.zeros((0, 0), np.int64)
ALL_HONEST = np.zeros((0, 0), np.bool_)
NO_SPEEDS = np.zeros((0, 0))
NO_KEY = np.zeros(2, np.uint64)  # where nothing is drawn


def inputs_of(setting: Setting, seed: int, first: int, trials: int = 1, *, order: bool = False) -> Inputs:
    """Prepare trials; `order` if single readings are needed. Raises InputError if no graph can be made."""
    moves = setting.body is not None
    try:
        links = NO_LINKS if moves else setting.links(seed, first, trials)
    except ValueError as error:
        raise InputError(f"trials {first} to {first + trials - 1} of {setting}: {error}") from error
    b, w, assumed_b, assumed_w = setting.accuracies(seed, first, trials)
    beliefs = (assumed_b, assumed_w)
    if setting.precision == "single":
        beliefs = (assumed_b.astype(np.float32).astype(np.float64), assumed_w.astype(np.float32).astype(np.float64))
    drift, readings = setting.drifts(seed, first, trials, b), setting.readings_key(seed)
    orders = setting.readings_key(seed, "order") if order else NO_KEY
    sensors = Sensors(b, w, drift, setting.course, setting.observations_per_round, readings, orders)
    losses = setting.losses_key(seed) if setting.loss_threshold else NO_KEY
    group, honest = _groups_of(setting, seed, first, trials)
    return Inputs(
        first=first,
        sensors=sensors,
        beliefs=beliefs,
        radio=Radio(losses, setting.loss_threshold, setting.message_delay, moves and setting.brain.is_oracle),
        links=links,
        stops=np.stack([setting.stops(seed, first + t) for t in range(trials)]),
        luck=setting.luck_keys(seed, alone=order),
        walk=setting.walk_key(seed) if moves else NO_KEY,
        speeds=np.stack([setting.speeds(seed, first + t) for t in range(trials)]) if moves else NO_SPEEDS,
        group=group,
        honest=honest,
    )


def _groups_of(setting: Setting, seed: int, first: int, trials: int) -> tuple[np.ndarray, np.ndarray]:
    group, honest = NO_GROUPS, ALL_HONEST
    if not setting.members:
        return group, honest
    groups, brains = setting.groups(seed, first, trials), setting.brains
    if len(brains) > 1:
        group = np.array(
            [0, *(brains.index(m.brain_in(setting.brain).with_numbers(setting.brain.numbers)) for m in setting.members)]
        )[groups]
    if setting.honest < setting.robots:
        honest = np.array([True, *(m.honest for m in setting.members)])[groups]
    return group, honest
