"""All that chance decides for some trials of a setting before they run: accuracies, failures, links, keys of draws."""

import numpy as np

from swarmcensus.engine import NO_LINKS, Inputs, Reception, Sensors
from swarmcensus.simulation import sampling
from swarmcensus.studies import Setting, addresses
from swarmcensus.support.errors import InputError

NO_GROUPS = np.zeros((0, 0), np.int64)
ALL_HONEST = np.zeros((0, 0), np.bool_)
NO_SPEEDS = np.zeros((0, 0))
NO_KEY = np.zeros(2, np.uint64)  # where nothing is drawn


def inputs_of(setting: Setting, seed: int, first: int, trials: int = 1, *, order: bool = False) -> Inputs:
    """Prepare trials; `order` if single readings are needed. Raises InputError if no graph can be made.

    Where each trial draws its fill ratio, one trial is prepared at a time.
    """
    setting = addresses.in_trial(setting, seed, first)
    moves = setting.body is not None
    try:
        links = NO_LINKS if moves else sampling.links(setting, seed, first, trials)
    except ValueError as error:
        raise InputError.of(None, error, where=f"trials {first} to {first + trials - 1} of {setting}") from error
    b, w, assumed_b, assumed_w = sampling.accuracies(setting, seed, first, trials)
    beliefs = (assumed_b, assumed_w)
    if setting.precision == "single":
        beliefs = (assumed_b.astype(np.float32).astype(np.float64), assumed_w.astype(np.float32).astype(np.float64))
    drift, readings = sampling.drifts(setting, seed, first, trials, b), addresses.readings_key(setting, seed)
    orders = addresses.readings_key(setting, seed, "order") if order else NO_KEY
    sensors = Sensors(b, w, drift, setting.course, setting.observations_per_round, readings, orders)
    losses = addresses.losses_key(setting, seed) if setting.loss_threshold else NO_KEY
    group, honest = NO_GROUPS, ALL_HONEST
    groups = sampling.groups(setting, seed, first, trials) if setting.members else group
    if len(setting.brains) > 1:
        of_members = (member.brain_in(setting.brain) for member in setting.members)
        numbers = [setting.brains.index(brain.with_numbers(setting.brain.numbers)) for brain in of_members]
        group = np.array([0, *numbers])[groups]
    if setting.honest < setting.robots:
        honest = np.array([True, *(member.honest for member in setting.members)])[groups]
    return Inputs(
        first=first,
        sensors=sensors,
        beliefs=beliefs,
        radio=Reception(losses, setting.loss_threshold, setting.message_delay, moves and setting.brain.is_oracle),
        links=links,
        stops=np.stack([sampling.stops(setting, seed, first + t) for t in range(trials)]),
        draws=addresses.draw_keys(setting, seed, alone=order),
        walk=addresses.walk_key(setting, seed) if moves else NO_KEY,
        speeds=np.stack([sampling.speeds(setting, seed, first + t) for t in range(trials)]) if moves else NO_SPEEDS,
        group=group,
        honest=honest,
    )
