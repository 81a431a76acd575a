"""Addresses of a setting's random numbers, and its fingerprint.

An address contains only what its random numbers depend on. So two settings that differ only in brain or topology have
the same tiles and readings, trial by trial, and a setting's numbers do not depend on its place in a grid.
"""

import hashlib

import numpy as np

from swarmcensus.brains.packing import PLAIN
from swarmcensus.engine.addresses import address
from swarmcensus.studies.settings import Setting
from swarmcensus.worlds.patterns import Floor

NO_KEYS = np.zeros(0, np.uint64)


def fingerprint(setting: Setting, seed: int) -> str:
    """A hash of the brain's name and all that a trial's numbers depend on: equal settings share it."""
    content: tuple[object, ...] = (
        setting.brain.name,
        setting.brain.sha256,
        setting.topology.content,
        setting.robots,
        str(setting.accuracy),
        "" if setting.assumed_accuracy is None else str(setting.assumed_accuracy),
        setting.fill_ratio,
        setting.link_success,
        setting.rounds,
        setting.observations_per_round,
        setting.density,
        setting.body and setting.body.model_dump(),
        [fault.content for fault in setting.faults],
        setting.floor and [str(setting.floor), setting.floor.content],
    )
    if setting.members:
        content = (*content, [member.content for member in setting.members])
    if setting.brain.parameters:
        content = (*content, [*setting.brain.parameters.items()])
    if setting.change:
        content = (*content, str(setting.change))
    if setting.delay:
        content = (*content, "message_delay", setting.delay)
    if setting.brain.numbers != PLAIN:
        content = (*content, "numbers", *setting.brain.numbers)
    if editions := _editions(setting):
        content = (*content, editions)
    return hashlib.blake2b(repr((seed, content)).encode(), digest_size=16).hexdigest()


def _editions(setting: Setting) -> list[str]:
    """Hashes of the files of other packages that it uses."""
    theirs = (part for m in setting.members for part in (m.accuracy, m.assumed_accuracy))
    parts = (setting.topology, setting.accuracy, setting.assumed_accuracy, setting.floor, *theirs)
    return [part.edition for part in parts if part is not None and part.edition]


def readings_key(setting: Setting, seed: int, purpose: str = "readings") -> np.ndarray:
    """The address of sensor readings. A change or drift is no part of it: only how the world begins is."""
    return address(
        seed,
        purpose,
        robots=setting.robots,
        accuracy=str(setting.accuracy.start),
        fill_ratio=float(setting.course[0]),
        observations_per_round=setting.observations_per_round,
        **_where(setting),
    )


def losses_key(setting: Setting, seed: int) -> np.ndarray:
    """The address of message losses."""
    return address(
        seed,
        "losses",
        topology=setting.topology.content,
        robots=setting.robots,
        success=setting.link_success,
        **_where(setting),
    )


def luck_keys(setting: Setting, seed: int, alone: bool = False) -> np.ndarray:
    """The addresses of random numbers for brains, in their functions and in messages; empty if none asks for any.

    All brains share them. With `alone` all networks do too: settings that differ only in the network share their
    local estimates.
    """
    if not any(brain.uses.luck for brain in setting.brains):
        return NO_KEYS
    network = {} if alone else {"topology": setting.topology.content}
    content = {"robots": setting.robots, **network, **_where(setting)}
    return np.concatenate([address(seed, purpose, **content) for purpose in ("luck", "luck of messages")])


def _where(setting: Setting) -> dict[str, object]:
    return {} if setting.density is None else {"density": setting.density}


def floor_key(setting: Setting, seed: int) -> np.ndarray:
    """The address of the floor's tiles. A change is no part of it: only how the floor begins is."""
    assert setting.body is not None
    return address(
        seed,
        "floor",
        robots=setting.robots,
        density=setting.density,
        tile=setting.body.tile,
        fill_ratio=float(setting.course[0]),
        **({} if setting.floor in (None, Floor()) else {"floor": setting.floor.content}),
    )


def walk_key(setting: Setting, seed: int) -> np.ndarray:
    """The address of trajectories: where robots start and how they walk."""
    return address(seed, "walk", **_walk(setting))


def _walk(setting: Setting) -> dict[str, object]:
    """What the random numbers of trajectories depend on."""
    assert setting.body is not None
    body = setting.body.model_dump(exclude={"message_delay"})
    return {"robots": setting.robots, "density": setting.density, "body": body}


def walk_group(setting: Setting) -> str:
    """Settings of one group share their trajectories, trial by trial. Where a brain steers, it shares with none."""
    if setting.steers:
        return fingerprint(setting, 0)
    members, faults = setting.members, enumerate(setting.faults)
    speeds = [(m.robots, m.speed) for m in members] if any(m.speed is not None for m in members) else []
    lame = [(n, f.at, f.until, f.robots) for n, f in faults if "moving" in f.stop]
    return repr((_walk(setting), setting.rounds, lame, *speeds))
