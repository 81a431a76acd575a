"""Predictions of theory: how long a robot alone, a swarm that mixes its sums, and a swarm at best need for the goal.

An estimate from E independent readings has the variance of a reading divided by E, if the floor has enough tiles. A
robot alone has its own readings; a robot that knows everything has those of the swarm. If estimates are normal, the
share of right ones grows with E, and bisection finds the least E that is enough.
"""

import functools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmcensus import theory
from swarmcensus.search.planning.mission import Mission
from swarmcensus.studies import LARGEST
from swarmcensus.theory import from_links, spectrum_of, variance_factors
from swarmcensus.worlds import Accuracy, Body, Floor

SAMPLED_SENSORS = 1001  # sensors that represent a spread of accuracies
MOST_MIXED = 400  # robots of the largest network of which the mixing is computed, which takes a second
POINTS = 80  # times at which mixing is computed
MOST_READINGS = 1e15
INNER_STEP = 3  # every third candidate is an inner fill ratio
REFERENCE = 100  # robots of the swarm with the area that represents others, if it follows from a density


class Prediction(NamedTuple):
    """The rounds that a robot alone, a swarm that mixes its sums, and a swarm that pools all readings need."""

    alone: float
    mixed: float
    pooled: float

    def minutes(self, mission: Mission) -> "Prediction":
        """The prediction in minutes."""
        return Prediction(*(rounds * mission.round_minutes for rounds in self))


def predict(mission: Mission, robots: int, readings: float) -> Prediction:
    """How many rounds robots need for estimates as good as from so many readings, without those that lie or fail."""
    working = robots - mission.lying(robots) - mission.failing(robots)
    per_round = mission.setting.observations_per_round
    alone, pooled = max(1.0, readings / per_round), max(1.0, readings / per_round / working)
    if working == 1 or not math.isfinite(readings) or mission.setting.link_success == 0.0:
        return Prediction(alone, alone, pooled)
    times = np.unique(np.geomspace(pooled, min(alone, LARGEST), POINTS).round())
    factors = _factors(mission, working, robots, times)
    if factors is None:
        return Prediction(alone, math.sqrt(alone * pooled), pooled)
    enough = np.flatnonzero(per_round / factors >= readings)
    return Prediction(alone, float(times[enough[0]]) if enough.size else alone, pooled)


def _factors(mission: Mission, working: int, robots: int, times: np.ndarray) -> np.ndarray | None:
    """The network's mean variance factor after these rounds; None if it is not known."""
    if mission.moves:
        assert mission.side is not None
        rate = meeting_rate(working, mission.side, mission.body)
        return meeting_factors(working, rate, times)
    topology = mission.setting.topology
    if topology.name == "full" or robots > MOST_MIXED or working < robots:
        return 1.0 / (working * times) if topology.name == "full" else None
    links = topology.links(robots, mission.study.seed, 0, 1, lossless=False, sums=False)
    matrix = from_links(robots, links.receivers, links.senders)
    if spectrum_of(matrix) is None:
        return None
    return np.asarray(variance_factors(matrix, [int(t) for t in times]).mean(axis=1))


def meeting_rate(robots: int, side: float, body: Body) -> float:
    """How many other robots a robot meets in a tick, in a square of this side in metres."""
    run = body.straight_mean
    moving = run / (run + max(body.turn_most / 2.0, 1.0))  # the share of time that is not spent turning on the spot
    speed = moving * body.speed * body.tick
    return 2.0 * body.radio_range * (robots - 1) / side**2 * 4.0 / math.pi * speed


def meeting_factors(robots: int, rate: float, ticks: ArrayLike) -> NDArray[np.float64]:
    """The variance factor of a moving swarm after these ticks: 1/t for a robot alone, 1/(N t) if all is known.

    Returns an array of the shape of `ticks`.
    """
    t = np.asarray(ticks, np.float64)
    if robots == 1 or rate <= 0.0:
        return 1.0 / t
    a = rate * robots / (2.0 * (robots - 1))
    return np.asarray(1.0 / (robots * t) + (1.0 - 1.0 / robots) * -np.expm1(-a * t) / (a * t**2))


def readings_needed(mission: Mission, fill_ratio: float) -> float:
    """The least number of readings that is enough; infinite if none is."""
    goal, wanted = mission.goal, mission.wanted.probability

    def enough(readings: float) -> bool:
        return goal.normal_share(math.sqrt(variance(mission, fill_ratio, readings)), fill_ratio) >= wanted

    if not enough(MOST_READINGS):
        return math.inf
    low, high = 1.0, MOST_READINGS
    if enough(low):
        return low
    while high / low > 1.0 + 1e-6:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def least_deviation(mission: Mission, fill_ratio: float) -> float:
    """The least standard deviation for any number of readings, that of the floor's own share of black."""
    return math.sqrt(variance(mission, fill_ratio, MOST_READINGS))


def variance(mission: Mission, fill_ratio: float, readings: float) -> float:
    """The variance about the truth of an estimate from so many readings anywhere on the floor."""
    f, tiles = fill_ratio, tiles_of(mission)
    of_reading = _reading(mission.accuracy, f)
    if math.isinf(tiles):
        return of_reading / readings
    ordered = mission.setting.floor not in (None, Floor())  # such floors have an exact number of black tiles
    of_floor = theory.tiles_variance(
        theory.even_concentration(readings, round(tiles)), f, round(tiles),
        drawn="exactly" if ordered else "one by one", truth="floor" if mission.on_floor else "nominal",
    )  # fmt: skip
    return max(of_reading - f * (1.0 - f), 0.0) / readings + float(of_floor)


def tiles_of(mission: Mission) -> float:
    """How many tiles sensors can reach: those in the square of robots' centres, widened by the sensor's distance."""
    side = mission.side
    if side is None:
        return math.inf
    arm, inner = math.hypot(*mission.body.sensor), max(side - 2.0 * mission.body.radius, 0.0)
    within = inner**2 + 4.0 * inner * arm + math.pi * arm**2
    return max(1.0, min(within, side**2) / mission.body.tile**2)


@functools.lru_cache(maxsize=64)
def _reading(accuracy: object, fill_ratio: float) -> float:
    """The variance of a corrected reading; for unequal sensors, of a sensor with their mean information."""
    b, w = accuracy.draw(0, "planning", 0, 1, SAMPLED_SENSORS)  # type: ignore[attr-defined]
    information = float(theory.information(fill_ratio, b, w).mean())
    return 1.0 / information if information > 0.0 else math.inf


def worst_fill_ratios(mission: Mission) -> list[float]:
    """The fill ratio that needs most readings, and both ends of the range, each once."""
    candidates: list[float] = mission.goal.candidates(*mission.fill_ratios).tolist()
    hardest = max(candidates, key=lambda f: (readings_needed(mission, f), least_deviation(mission, f)))
    return list(dict.fromkeys([hardest, candidates[0], candidates[-1]]))


def inner_fill_ratios(mission: Mission) -> list[float]:
    """Other fill ratios of the range, examined if robots lie: theory cannot tell where liars do most harm."""
    if not mission.has_liars:
        return []
    candidates = mission.goal.candidates(*mission.fill_ratios)[::INNER_STEP].tolist()
    return [f for f in candidates if f not in worst_fill_ratios(mission)]


def with_worst_accuracy(missions: Sequence[Mission]) -> list[Mission]:
    """The missions with that of their accuracies first which needs most readings in the first world."""

    def readings(accuracy: Accuracy) -> float:
        world = replace(missions[0].sized(REFERENCE), accuracies=(accuracy,))
        return readings_needed(world, worst_fill_ratios(world)[0])

    worst = max(missions[0].accuracies, key=readings)
    several = len(missions[0].accuracies) > 1
    return [replace(one, accuracies=(worst, *one.accuracies)) if several else one for one in missions]
