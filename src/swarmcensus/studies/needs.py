"""Where a study does not give a brain what its file says that it needs (`brains/requirements.py`), in sentences."""

import functools
import warnings
from collections.abc import Iterable, Iterator

import numpy as np

from swarmcensus.brains import Brain, names_in
from swarmcensus.studies.settings import Setting
from swarmcensus.support.formatting import counted
from swarmcensus.support.plugins import is_unread
from swarmcensus.worlds import Accuracy, Body, Chance, Floor, Ground, Topology

MOST_ROBOTS = 10_000  # of networks whose neighbours are counted
TRIALS, PLACES, NEAR = 3, 1 << 15, 0.08  # of which floors are looked at; metres between readings that `sure` compares
# found in worlds where `sure` was measured (benchmarks/sure.py): robots for each density of an arena that is small; how
# much quarters of the arena differ there, and how far from one half their shares of black are where one is a patch; how
# much they differ in others, also for each correlation of near tiles; and that correlation where no robot stops
FEW, COARSE, PLAIN, FINE, LASTING, ALIKE = 2.0, 0.025, 0.45, 0.0006, 0.05, 0.3


def warn_of_needs(settings: Iterable[Setting], bins: int) -> None:
    """Warn of brains that are used outside their range, for the line that called the caller."""
    for sentence in unmet_needs(settings, bins):
        warnings.warn(sentence, stacklevel=3)


def unmet_needs(settings: Iterable[Setting], bins: int) -> list[str]:
    """A line for each honest brain that is used outside its range; `bins` are those of the study's question."""
    found: dict[str, dict[str, str]] = {}
    worlds = dict.fromkeys(
        (brain, s.rounds, s.topology, s.robots, s.accuracy, _floor(brain, s), "round" if s.body is None else "tick")
        for s in settings
        for brain in (s.brain, *(m.brain for m in s.members if m.honest and isinstance(m.brain, Brain)))
        if brain.needs
    )
    for brain, rounds, topology, robots, accuracy, floor, unit in sorted(worlds, key=lambda world: world[1]):
        there = found.setdefault(brain.name, {})
        unmet = *_unmet_in_time(brain, rounds, unit), *_unmet_in_swarm(brain, topology, robots)
        for key, sentence in (*unmet, *_unmet_by_floor(brain, accuracy, floor, bins)):
            there.setdefault(key, sentence + _parameters(brain, key))
    return [f"{name} {'. It '.join(needs.values())}" for name, needs in found.items() if needs]


def _floor(brain: Brain, setting: Setting) -> tuple[float, str]:
    """The fill ratio; 0, in the middle of no step, if each trial draws its own. And a floor that hides its changes."""
    floor, body, f, hides = setting.floor, setting.body, setting.fill_ratio, False
    if brain.needs.get("even") and body and floor and setting.density and not is_unread(floor.kind):
        hides = _hides(floor, body, setting.side, f, setting.robots <= FEW * setting.density)
    return 0.0 if setting.spread else f, str(floor) if hides else ""


@functools.lru_cache(maxsize=256)
def _hides(floor: Floor, body: Body, side: float, fill_ratio: float, small: bool) -> bool:
    """Whether large parts of a floor differ in their shares of black, and robots may not notice.

    In a `small` arena all robots may stay in one patch. In others, parts may differ where tiles near each other are
    hardly correlated, as in dithered shades. Both by numbers relative to the variance of colours, averaged over trials.
    """
    found = []
    for trial in range(TRIALS):
        chance = Chance(np.zeros(2, np.uint64), trial)
        ground = Ground(floor, body, side, np.array([fill_ratio]), chance.key, trial, PLACES)
        half, random = ground.across // 2, chance.generator()
        x, y = first = random.uniform(-half, half, (2, PLACES))
        second = first + random.normal(0.0, NEAR / body.tile, first.shape)
        tiles = np.clip(np.floor([first, second]), -half, half - 1).astype(np.int32)
        black = ground.colours(tiles.transpose(0, 2, 1))
        share = np.histogram2d(x, y, 4, weights=black[0])[0] / np.histogram2d(x, y, 4)[0]
        quarters = np.lib.stride_tricks.sliding_window_view(share, (2, 2)).mean(axis=(2, 3))
        found.append((quarters.var(), np.cov(black)[0, 1], np.abs(quarters - 0.5).max()))
    apart, alike, plain = np.mean(found, axis=0)
    variance = fill_ratio * (1.0 - fill_ratio)
    fine = alike < ALIKE * variance and apart > max(FINE * variance, LASTING * alike)
    return bool(apart > COARSE * variance and plain > PLAIN if small else fine)


def _unmet_in_time(brain: Brain, rounds: int, unit: str) -> Iterator[tuple[str, str]]:
    """The needs that so many rounds or ticks do not meet, each with a sentence."""
    has = f"this study has {rounds:,}"
    if rounds <= (silent := brain.needs.get("silent", -1.0)):
        yield "silent", f"says nothing before {unit} {int(silent) + 1:,}; {has}"
    if rounds < (least := brain.needs.get("rounds", 0.0)):
        yield "rounds", f"needs {counted(round(least), unit)}; {has}"
    if rounds != (length := round(brain.needs.get("length", rounds))):
        yield "length", f"is made for an answer after {unit} {length:,}; {has}"


def _unmet_in_swarm(brain: Brain, topology: Topology, robots: int) -> Iterator[tuple[str, str]]:
    """The needs that a swarm of this size and network does not meet."""
    if robots < (least := brain.needs.get("robots", 0.0)):
        yield "robots", f"needs {counted(round(least), 'robot')}; this study has {robots:,}"
    least, mutual = brain.needs.get("neighbours", 0.0), brain.needs.get("mutual", 0.0)
    if not (least or mutual) or topology.moves or robots > MOST_ROBOTS:
        return
    there, both_ways = (robots - 1.0, True) if topology.is_full else _neighbours(topology, robots)
    if mutual and not both_ways:
        yield "mutual", f"needs robots that hear each other; some links of {topology.title} go one way only"
    if there < least:
        yield "neighbours", f"needs {least:g} neighbours; most robots of {topology.title} have {there:g} or fewer"


@functools.lru_cache(maxsize=64)
def _neighbours(topology: Topology, robots: int) -> tuple[float, bool]:
    """How many robots most robots hear, and whether all links go both ways; once for all settings of a network."""
    links = topology.links(robots, 0, 0, 1, lossless=True, sums=False)
    to, back = links.receivers * robots + links.senders, links.senders * robots + links.receivers
    return float(np.median(np.bincount(links.receivers, minlength=robots))), np.array_equal(np.sort(to), np.sort(back))


def _unmet_by_floor(brain: Brain, accuracy: Accuracy, floor: tuple[float, str], bins: int) -> Iterator[tuple[str, str]]:
    """The needs that sensors, the floor and the question about it do not meet."""
    fill_ratio, hidden = floor
    biased = f"so an accuracy of {accuracy} biases its estimates"
    exact = accuracy.drift is None and all(d.is_number and d.numbers[0] == 1.0 for d in accuracy.distributions)
    if brain.needs.get("equal_sensors") and accuracy.white is not None and accuracy.white != accuracy.black:
        yield "equal_sensors", f"takes b and w to be equal, {biased}"
    elif brain.needs.get("perfect_sensors") and not exact:
        yield "perfect_sensors", f"takes readings for the truth, {biased}"
    if brain.needs.get("binary") and bins != 2:
        yield "binary", f"answers whether f is above one half; this study asks for one of {bins:,} bins"
    if hidden:
        yield "even", f"may stop too early, or give wrong intervals, where its robots miss changes of {hidden}"
    steps = brain.needs.get("steps", 0.0)
    place = fill_ratio * steps - 0.5
    if abs(place - round(place)) <= 1e-9:
        middles = f"chooses among the middles of {round(steps)} steps"
        yield "steps", f"{middles}, and f = {fill_ratio:g} is one: it errs less than at other f"


def _parameters(brain: Brain, key: str) -> str:
    """The parameters that a need depends on, and their values, in brackets."""
    expression = brain.contents.needs.get(key)
    names = names_in(expression) if expression else []
    return f" ({', '.join(f'{name} = {brain.parameters[name]:g}' for name in names)})" if names else ""
