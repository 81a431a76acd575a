"""A setting's robots as the engine's loops take them, with room for what is counted of them and what they decide."""

import functools
from collections.abc import Container, Mapping
from typing import Any

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.brains import Brain
from swarmcensus.engine import compiler
from swarmcensus.engine.constants import VERDICTS, WRONG
from swarmcensus.engine.swarms import Swarm, runs_of
from swarmcensus.simulation.inputs import Inputs
from swarmcensus.simulation.intervals import ENDS
from swarmcensus.studies.settings import Setting

NO_LUCK = np.zeros(0, np.uint64)
ALL_HONEST = np.zeros(0, np.bool_)
DECIDED, IS_DONE = "decided", "is_done"  # of a trace, beside a brain's own fields


def swarm_of(setting: Setting, given: Inputs, use: str) -> Swarm:
    """The swarm of some trials. Raises NotCompiled."""
    if not setting.members:
        found = alike(setting.brain, setting.robots, use)
        return found._replace(luck=given.luck) if given.luck.size else found
    group = given.group[0] if given.group.size else np.zeros(setting.robots, np.int64)
    honest = given.honest[0] if given.honest.size else ALL_HONEST
    return swarm(setting.crew, group, use, given.luck, honest)


@functools.lru_cache(maxsize=256)
def alike(brain: Brain, robots: int, use: str) -> Swarm:
    """A swarm of robots that have one brain, without luck: nothing alters it. Raises NotCompiled."""
    return swarm((brain,), np.zeros(robots, np.int64), use)


def swarm(
    brains: tuple[Brain, ...],
    group: np.ndarray,
    use: str,
    luck: np.ndarray = NO_LUCK,
    honest: np.ndarray = ALL_HONEST,
) -> Swarm:
    """A swarm in which robot i has the brain brains[group[i]]; `luck` are keys. Raises NotCompiled."""
    mixed = len(brains) > 1
    fields = np.array([compiler.width(brain) for brain in brains])
    blanks = np.zeros((len(brains), fields.max()))
    for row, brain in zip(blanks, brains, strict=True):
        row[: compiler.width(brain)] = compiler.blank(brain)
    runs, of_block = runs_of(group)
    return Swarm(
        minds=np.stack([compiler.compile_brain(brain, use, mixed=mixed) for brain in brains]),
        bases=group.size * (np.cumsum(fields) - fields),
        fields=fields,
        named=np.array([brain.uses.name for brain in brains]),
        blanks=blanks,
        runs=runs,
        of_block=of_block,
        additive=not mixed and bool(brains[0].sums),
        flag=compiler.flag_of(brains[0], mixed),
        jams=any(brain.jams for brain in brains),
        luck=luck if any(brain.uses.luck for brain in brains) else NO_LUCK,
        honest=honest,
    )


def outbox_of(made: Swarm, setting: Setting, rounds: int) -> np.ndarray:
    """Room for what the robots of a setting say in so many rounds."""
    return compiler.outbox(setting.brain, rounds * setting.robots, made.fields.size > 1)


def verdicts_of(setting: Setting, trials: int, robots: int) -> tuple[np.ndarray, np.ndarray]:
    """Room for what robots decide (trial, robot, what), none where none does, and for what all agree on (trial, 2)."""
    judged = any(brain.decides or brain.ends for brain in setting.crew)
    return np.empty((trials, robots if judged else 0, VERDICTS)), np.empty((trials, 2))


def check_verdicts(setting: Setting, given: Inputs, verdicts: np.ndarray) -> None:
    """Raise InputError where a brain decided for what is no option."""
    wrong = np.argwhere(verdicts[..., WRONG] != -1.0) if verdicts.size else ()
    for trial, robot in wrong[:1]:
        brain = setting.crew[given.group[trial, robot]] if given.group.size else setting.brain
        raise InputError(
            f"brain {brain.name!r} fails in trial {given.first + trial} of {setting}: decide gives "
            f"{verdicts[trial, robot, WRONG]:g}: -1 (undecided) or an option from 0 to {brain.options - 1} is right"
        )


def consensus_of(setting: Setting, agreed: np.ndarray, truth: float) -> np.ndarray:
    """What all robots agreed on, when, whether it is right, and what is (trial, 4); all NaN where no brain decides."""
    options = [brain.options for brain in setting.crew if brain.decides]  # all the same
    if not options:
        return np.full((len(agreed), 4), np.nan)
    right = right_option(truth, options[0])
    is_right = np.full(len(agreed), np.nan) if np.isnan(right) else (agreed[:, 0] == right).astype(np.float64)
    return np.column_stack([agreed, is_right, np.full(len(agreed), right)])


def right_option(truth: float, options: int) -> float:
    """Which of so many options is right: the k-th of n for fill ratios in [k/n, (k + 1)/n), the last one for 1 too.

    Of white and black neither is at 0.5: NaN.
    """
    if options == 2 and truth == 0.5:
        return np.nan
    edges = np.arange(options + 1) / options
    return float(min(int(np.searchsorted(edges, truth, side="right")) - 1, options - 1))


def fields_of(
    brains: tuple[Brain, ...], made: Swarm, history: np.ndarray, estimates: np.ndarray
) -> dict[str, np.ndarray]:
    """What a trace shows of minds (round, robot, number): MEMORY's fields, and of brains that decide what and when.

    In a mixed swarm a field is NaN of robots whose brain has none of its name, or a shorter vector.
    """
    robots = estimates.shape[1]
    fields: dict[str, np.ndarray] = {}
    flat = history.reshape(len(history), -1)
    for group, brain in enumerate(brains):
        base, size = made.bases[group], made.fields[group]
        rows = np.ascontiguousarray(flat[:, base : base + robots * size]).reshape(len(flat), robots, size)
        minds = compiler.records(brain, rows)
        own = np.zeros(robots, np.bool_)
        for _, first, last in (run for run in made.runs.tolist() if run[0] == group):
            own[first:last] = True
        for name in brain.memory:
            fields[name] = minds[name] if len(brains) == 1 else _with(fields.get(name), minds[name], own)
    if any(brain.decides or brain.ends for brain in brains):
        told = np.empty((*estimates.shape, 2))
        compiler.compile_world("kernel").decided(*made, history, estimates, told)
        fields |= {free(DECIDED, fields): told[..., 0]} if any(brain.decides for brain in brains) else {}
        fields |= {free(IS_DONE, fields): told[..., 1]} if any(brain.ends for brain in brains) else {}
    if any(brain.has_interval for brain in brains):
        bounds = np.full((len(estimates), 2, robots), np.nan)
        compiler.compile_world("kernel").bounded(*made, history, bounds)
        fields |= {free(name, fields): bounds[:, end] for end, name in enumerate(ENDS)}
    return fields


def _with(known: np.ndarray | None, values: np.ndarray, own: np.ndarray) -> np.ndarray:
    """A field of some robots, `own`, beside what is known of the others': numbers, or vectors as long as any."""
    parts = [values] if known is None else [known, values]
    longest = max(part.shape[2] if part.ndim == 3 else 0 for part in parts)
    if not longest:
        return np.where(own, values, np.nan if known is None else known)
    out = np.full((*values.shape[:2], longest), np.nan)
    for part, where in zip(parts[::-1], (own, ~own), strict=False):
        wide = part if part.ndim == 3 else part[..., np.newaxis]
        out[:, where, : wide.shape[2]] = wide[:, where]
    return out


def ended(brains: tuple[Brain, ...], fields: Mapping[str, np.ndarray]) -> np.ndarray:
    """Who makes no reading in each round but the first row's, being done before it (round, robot)."""
    said = fields.get(free(IS_DONE, {name for brain in brains for name in brain.memory}))
    return np.zeros((0, 0), np.bool_) if said is None else said[:-1] == 1.0


def free(name: str, taken: Container[Any]) -> str:
    """A name that no field of a brain has."""
    while name in taken:
        name += "_"
    return name
