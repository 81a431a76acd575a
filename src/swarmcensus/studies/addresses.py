"""Addresses of a setting's random numbers, and its fingerprint.

An address contains only what its random numbers depend on. So two settings that differ only in brain or topology have
the same tiles and readings, trial by trial, and a setting's numbers do not depend on its place in a grid.
"""

import dataclasses
import hashlib
from typing import get_args

import numpy as np

from swarmcensus.brains import PLAIN
from swarmcensus.engine import address
from swarmcensus.studies.keys import Draws, Key
from swarmcensus.studies.settings import KEYS, Setting, set_apart
from swarmcensus.worlds import Accuracy, Body, Floor, Misjudgement, Topology

FIRST = (  # fields of a setting that are part of every fingerprint, in this order
    "topology", "robots", "accuracy", "assumed_accuracy", "fill_ratio", "link_success", "rounds",
    "observations_per_round", "density", "body", "faults", "floor",
)  # fmt: skip
FIELDS = {field.name for field in dataclasses.fields(Setting)}
DRAWN = {draws: [key for key in KEYS.values() if draws in key.draws] for draws in get_args(Draws)}
NAMES = {"link_success": "success"}  # of keys in addresses, where they differ
NO_KEYS = np.zeros(0, np.uint64)


def fingerprint(setting: Setting, seed: int) -> str:
    """A hash of the brain's name and all that a trial's numbers depend on: equal settings share it."""
    content: list[object] = [setting.brain.name, setting.brain.sha256]
    content += [_whole(setting, field) for field in FIRST]
    content += [[member.content for member in setting.members]] if setting.members else []
    content += [[*setting.brain.parameters.items()]] if setting.brain.parameters else []
    content += [str(one) for one in (setting.change, setting.spread) if one]
    for key in set_apart(setting):
        if key.field in FIELDS:
            content += [key.name, getattr(setting, key.field)]
    content += ["numbers", *setting.brain.numbers] if setting.brain.numbers != PLAIN else []
    content += [editions] if (editions := _editions(setting)) else []
    return hashlib.blake2b(repr((seed, tuple(content))).encode(), digest_size=16).hexdigest()


def _whole(setting: Setting, field: str) -> object:
    """A value of a setting as text, with all its content."""
    value = getattr(setting, field)
    if field == "assumed_accuracy" and value is None:
        return ""
    if isinstance(value, Topology):
        return value.content
    if isinstance(value, Accuracy | Misjudgement):
        return str(value)
    if isinstance(value, Floor):
        return [value.name, value.content]
    if isinstance(value, tuple):
        return [fault.content for fault in value]
    return value.model_dump() if isinstance(value, Body) else value


def _editions(setting: Setting) -> list[str]:
    """Hashes of the files of other packages that it uses."""
    theirs = (part for m in setting.members for part in (m.accuracy, m.assumed_accuracy))
    parts = (setting.topology, setting.accuracy, setting.assumed_accuracy, setting.floor, setting.spread, *theirs)
    return [part.edition for part in parts if part is not None and part.edition]


def _content(setting: Setting, draws: Draws) -> dict[str, object]:
    """The content of an address: the keys that declare that these random numbers depend on them."""
    found = {NAMES.get(key.name, key.name): _begun(setting, key) for key in DRAWN[draws]}
    return {name: value for name, value in found.items() if value is not None}


def _begun(setting: Setting, key: Key) -> object:
    """The value of a key at the beginning, without change or drift. None if addresses do not contain it."""
    value = getattr(setting, key.field)
    if (key.is_new and value == key.default) or value == Floor():
        return None
    if key.name == "fill_ratio":
        return str(setting.spread) if setting.spread else float(setting.course[0])
    if isinstance(value, Accuracy):
        return str(value.start)
    return value.content if isinstance(value, Topology | Floor) else value


def readings_key(setting: Setting, seed: int, purpose: str = "readings") -> np.ndarray:
    """The address of sensor readings."""
    return address(seed, purpose, **_content(setting, "readings"))


def in_trial(setting: Setting, seed: int, trial: int) -> Setting:
    """A setting as it is in one trial: with the fill ratio that is drawn for it, if any is."""
    if setting.spread is None:
        return setting
    key = address(seed, "fill ratio", fill_ratio=str(setting.spread))
    return dataclasses.replace(setting, fill_ratio=float(setting.spread.draw(key, trial, 1, 1)[0, 0]), spread=None)


def losses_key(setting: Setting, seed: int) -> np.ndarray:
    """The address of message losses."""
    return address(seed, "losses", **_content(setting, "losses"))


def draw_keys(setting: Setting, seed: int, alone: bool = False) -> np.ndarray:
    """The addresses of random numbers for brains, in their functions and in messages; empty if none asks for any.

    All brains share them. With `alone` all networks do too: settings that differ only in the network share their
    local estimates.
    """
    if not any(brain.uses.luck for brain in setting.brains):
        return NO_KEYS
    content = _content(setting, "luck alone" if alone else "luck")
    return np.concatenate([address(seed, purpose, **content) for purpose in ("luck", "luck of messages")])


def floor_key(setting: Setting, seed: int) -> np.ndarray:
    """The address of the floor's tiles."""
    assert setting.body is not None
    return address(seed, "floor", tile=setting.body.tile, **_content(setting, "floor"))


def walk_key(setting: Setting, seed: int) -> np.ndarray:
    """The address of trajectories: where robots start and how they walk."""
    return address(seed, "walk", **_walk(setting))


def _walk(setting: Setting) -> dict[str, object]:
    assert setting.body is not None
    return {**_content(setting, "walk"), "body": setting.body.model_dump(exclude={"message_delay"})}


def walk_group(setting: Setting) -> str:
    """Settings of one group share their trajectories, trial by trial. A brain that steers shares with none."""
    if setting.steers:
        return fingerprint(setting, 0)
    members, faults = setting.members, enumerate(setting.faults)
    speeds = [(m.robots, m.speed) for m in members] if any(m.speed is not None for m in members) else []
    lame = [(n, f.at, f.until, f.robots) for n, f in faults if "moving" in f.stop]
    return repr((_walk(setting), setting.rounds, lame, *speeds))


def streams(setting: Setting, seed: int) -> dict[str, object]:
    """What chance decides in trials of a setting, and what that depends on.

    Two settings share, trial by trial, the random numbers of which these contents are equal.
    """
    robots = setting.robots
    found: dict[str, object] = {"readings": readings_key(setting, seed).tolist()}
    if setting.body is not None:
        found |= {"trajectories": walk_key(setting, seed).tolist(), "floors": floor_key(setting, seed).tolist()}
    elif setting.topology.varies:
        found["networks"] = (seed, setting.topology.content, robots)
    for what, of in (("accuracies", setting.accuracy.start), ("assumed accuracies", setting.assumed_accuracy)):
        if of is not None and not all(distribution.is_number for distribution in of.distributions):
            found[what] = (seed, str(of), robots)
    found |= {"lost messages": losses_key(setting, seed).tolist()} if setting.link_success < 1.0 else {}
    if setting.missing_links:
        found["missing links"] = (seed, setting.topology.content, robots)
    found |= {"which robots differ": (seed, robots)} if setting.members else {}
    found |= {"faults": (seed, len(setting.faults), robots)} if setting.faults else {}
    draws = draw_keys(setting, seed)
    return found | ({"random numbers of brains": draws.tolist()} if draws.size else {})
