"""A setting's robots as the engine's loops take them, with room for their states, messages and decisions."""

import functools
from collections.abc import Container, Mapping
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.engine import Inputs, States, Swarm, Tally, compiler, runs_of
from swarmcensus.engine.constants import HELPERS, LISTED, PAIRS, VERDICTS
from swarmcensus.simulation.intervals import ENDS
from swarmcensus.studies import Setting
from swarmcensus.support.bins import bin_of

NO_WORDS = np.zeros(0, np.uint64)
ALL_HONEST = np.zeros(0, np.bool_)
MEASURING = HELPERS[:7]  # what all trials on fixed networks call
DECIDED, IS_DONE = "decided", "is_done"  # of a trace, besides a brain's own fields


def swarm_of(setting: Setting, given: Inputs, use: str) -> Swarm:
    """The swarm of some trials. Raises NotCompiled."""
    fails, loses, luck = given.stops.size > 0, bool(given.radio.threshold), given.draws.size > 0
    # the addresses of what of the engine is called on a fixed network
    helpers = _helpers(setting.brains, use, given.links.mode, fails, loses, luck)
    is_mixed = given.group.size > 0
    made = swarm(setting.brains, given.group[0], use) if is_mixed else _uniform(setting.brain, setting.robots, use)
    honest, blanks = given.honest[0] if given.honest.size else ALL_HONEST, made.blanks.copy()
    for name, value in foreknowledge(setting, alone=use == "alone").items():
        compiler.array_layout(setting.brain).records(blanks)[name] = value
    return made._replace(blanks=blanks, draws=given.draws, honest=honest, helpers=helpers)


@functools.lru_cache(maxsize=256)
def _uniform(brain: Brain, robots: int, use: str) -> Swarm:
    """A swarm of robots with one brain; its arrays are only read. Raises NotCompiled."""
    return swarm((brain,), np.zeros(robots, np.int64), use)


@functools.lru_cache(maxsize=256)
def _helpers(brains: tuple[Brain, ...], use: str, mode: int, fails: bool, loses: bool, luck: bool) -> np.ndarray:
    silent = any(compiler.array_layout(brain, len(brains) > 1).is_signalled for brain in brains)
    judged = any(brain.decides or brain.ends for brain in brains)
    is_called = {
        "go_alone": use == "alone",
        "hear_pairs": mode == PAIRS,
        "hear_singly": mode == LISTED and (silent or fails or loses),
        "fail_sensors": fails,
        "count_signals": silent,
        "draw_words": luck,
        "fill_words": luck,
        "note_clipped": any(brain.parts for brain in brains),
    }
    is_called |= dict.fromkeys(("ask_intervals", "note_intervals"), any(brain.has_interval for brain in brains))
    is_called |= dict.fromkeys(("forget", "judge_block", "agree"), judged)
    return np.asarray(compiler.compile_helpers({*MEASURING, *(name for name, yes in is_called.items() if yes)}))


def foreknowledge(setting: Setting, *, alone: bool = False) -> dict[str, float]:
    """The initial values of an oracle's fields: what it knows of the schedule beforehand. Empty for other brains.

    It knows when the fill ratio changes, not from what to what, and how the swarm's accuracy drifts. `alone` is for
    robots that end a round after each reading.
    """
    brain, drift, change = setting.brain, setting.accuracy.drift, setting.change
    if not brain.is_oracle or (drift is None and change is None):
        return {}
    schedule = {"fuses": float(setting.observations_per_round if alone else 1)}
    if change is not None:
        schedule |= {"change": float(setting.course[2]), "until": float(setting.course[3])}
    if drift is not None:
        schedule |= dict(zip(("drift", "least", "most"), drift.numbers, strict=True))
    return {name: value for name, value in schedule.items() if name in brain.memory}


def swarm(brains: tuple[Brain, ...], group: np.ndarray, use: str, draws: np.ndarray = NO_WORDS) -> Swarm:
    """A swarm in which robot i has the brain brains[group[i]]; `draws` are keys. Raises NotCompiled."""
    mixed = len(brains) > 1
    layouts = [compiler.array_layout(brain, mixed) for brain in brains]
    sizes = np.array([layout.record.itemsize for layout in layouts])
    blanks = np.zeros((len(brains), sizes.max()), np.uint8)
    for row, layout in zip(blanks, layouts, strict=True):
        row[: layout.blank.size] = layout.blank
    runs, of_block = runs_of(group)
    return Swarm(
        functions=np.stack([compiler.compile_brain(brain, use, mixed=mixed) for brain in brains]),
        bases=group.size * (np.cumsum(sizes) - sizes),
        sizes=sizes,
        clipped=np.array([layout.clipped for layout in layouts]),
        blanks=blanks,
        runs=runs,
        of_block=of_block,
        additive=not mixed and bool(brains[0].sums),
        is_signalled=layouts[0].is_signalled,
        jams=any(brain.jams for brain in brains),
        draws=draws if any(brain.uses.luck for brain in brains) else NO_WORDS,
        honest=ALL_HONEST,
        helpers=NO_WORDS,
    )


def states_of(setting: Setting, swarm: Swarm, rounds: int, rows: np.ndarray) -> States:
    """Room for states and their messages of so many rounds; `rows` (round, robot) is room for estimates."""
    size = compiler.array_layout(setting.brain, swarm.sizes.size > 1).message_bytes
    messages = rounds * setting.robots
    return States(
        np.empty((setting.robots, swarm.sizes.sum()), np.uint8),
        np.zeros((messages, size), np.uint8),
        np.zeros(messages if swarm.is_signalled else 0, np.uint8),
        rows,
    )


def tally_of(setting: Setting, trials: int, local: bool = False) -> Tally:
    """Counts of zero, and room for decisions, if any brain of the setting decides or ends; no `local` estimate does."""
    judged = not local and any(brain.decides or brain.ends for brain in setting.brains)
    verdicts = np.empty((trials, setting.robots if judged else 0, VERDICTS))
    return Tally(np.zeros((trials, 3, setting.robots), np.int64), verdicts, np.empty((trials, 2)))


def consensus_of(setting: Setting, agreed: np.ndarray, truth: float) -> np.ndarray:
    """Which option all robots agreed on, when, whether it is right, and which is (trial, 4); NaN if none decides."""
    options = [brain.options for brain in setting.brains if brain.decides]  # all the same
    if not options:
        return np.full((len(agreed), 4), np.nan)
    right = right_option(truth, options[0])
    is_right = np.full(len(agreed), np.nan) if np.isnan(right) else (agreed[:, 0] == right).astype(np.float64)
    return np.column_stack([agreed, is_right, np.full(len(agreed), right)])


def right_option(truth: float, options: int) -> float:
    """The right option: the k-th of n for fill ratios in [k/n, (k + 1)/n), and the last one for 1.

    NaN for two options, white and black, at 0.5: neither is right.
    """
    return np.nan if options == 2 and truth == 0.5 else float(bin_of(truth, options))


def fields_of(
    brains: tuple[Brain, ...], swarm: Swarm, history: np.ndarray, estimates: np.ndarray
) -> dict[str, np.ndarray]:
    """What a trace shows of states (round, robot, byte): fields of MEMORY, decisions, whether done, intervals.

    In a mixed swarm a field is NaN for robots whose brain has no such field, or only a shorter vector.
    """
    robots = estimates.shape[1]
    fields: dict[str, np.ndarray] = {}
    flat = history.reshape(len(history), -1)
    for group, brain in enumerate(brains):
        base, size = swarm.bases[group], swarm.sizes[group]
        rows = np.ascontiguousarray(flat[:, base : base + robots * size]).reshape(len(flat), robots, size)
        states = compiler.array_layout(brain).records(rows)
        own = np.zeros(robots, np.bool_)
        for _, first, last in (run for run in swarm.runs.tolist() if run[0] == group):
            own[first:last] = True
        for name in brain.memory:
            fields[name] = states[name] if len(brains) == 1 else _with(fields.get(name), states[name], own)
    if any(brain.decides or brain.ends for brain in brains):
        decisions = np.empty((*estimates.shape, 2))
        compiler.compile_world("kernel").decided(swarm, history, estimates, decisions)
        fields |= {free(DECIDED, fields): decisions[..., 0]} if any(brain.decides for brain in brains) else {}
        fields |= {free(IS_DONE, fields): decisions[..., 1]} if any(brain.ends for brain in brains) else {}
    if any(brain.has_interval for brain in brains):
        bounds = np.full((len(estimates), 2, robots), np.nan)
        compiler.compile_world("kernel").bounded(swarm, history, bounds)
        fields |= {free(name, fields): bounds[:, end] for end, name in enumerate(ENDS)}
    return fields


def _with(known: np.ndarray | None, values: np.ndarray, own: np.ndarray) -> np.ndarray:
    """A field with the values of the robots `own` added: numbers, or vectors as long as the longest."""
    parts = [values] if known is None else [known, values]
    longest = max(part.shape[2] if part.ndim == 3 else 0 for part in parts)
    if not longest:
        return np.where(own, values, np.nan if known is None else known)
    out = np.full((*values.shape[:2], longest), np.nan)
    for part, where in zip(parts[::-1], (own, ~own), strict=False):
        wide = part if part.ndim == 3 else part[..., np.newaxis]
        out[:, where, : wide.shape[2]] = wide[:, where]
    return out


def ended(brains: tuple[Brain, ...], fields: Mapping[Any, Any]) -> np.ndarray:
    """Which robots make no reading because they are done (round, robot), after states of earlier rounds.

    Some of the brains end.
    """
    done = fields[free(IS_DONE, {name for brain in brains for name in brain.memory})]
    return np.asarray(done[:-1] == 1.0)


def free(name: str, taken: Container[Any]) -> str:
    """The name, with underscores behind it until it is not taken."""
    while name in taken:
        name += "_"
    return name
