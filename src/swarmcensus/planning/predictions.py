"""What theory says before anything is simulated: how long a swarm needs at best, at worst, and if it mixes its sums.

An estimate from E independent readings has the variance of a reading over E, as far as the floor has tiles enough; a
robot alone has as many readings as it made, one that knows all those of the swarm. Where estimates are normal, their
share in the region of right ones grows with E, and the least E that is enough is found by bisection.
"""

import functools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmcensus import theory
from swarmcensus.planning.mission import Mission
from swarmcensus.studies.fields import LARGEST
from swarmcensus.theory.matrices import from_links, spectrum_of
from swarmcensus.theory.mixing import variance_factors
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.patterns import Floor
from swarmcensus.worlds.sensors import Accuracy

SENSORS = 1001  # that stand for all of a spread
MOST_MIXED = 400  # robots of a network whose mixing is computed: a second
POINTS = 80  # of time at which mixing is looked at
MOST_READINGS = 1e15
APART = 3  # candidates from one fill ratio to the next at which liars are looked at
REFERENCE = 100  # robots: whose area stands for others where it follows from their density


class Start(NamedTuple):
    """What theory says is enough, of a robot alone, of sums that are mixed, of all readings together: in rounds."""

    alone: float
    mixed: float
    pooled: float

    def minutes(self, mission: Mission) -> "Start":
        """The same in minutes."""
        return Start(*(rounds * mission.round_minutes for rounds in self))


@functools.lru_cache(maxsize=64)
def _reading(accuracy: object, fill_ratio: float) -> float:
    """The variance of a corrected reading, of unequal sensors that of one which tells as much as they do on average."""
    b, w = accuracy.draw(0, "planning", 0, 1, SENSORS)  # type: ignore[attr-defined]
    told = float(theory.information(fill_ratio, b, w).mean())
    return 1.0 / told if told > 0.0 else math.inf


def tiles_of(mission: Mission) -> float:
    """How many tiles sensors can get over: those of the square in which a robot's centre is, and an arm around it."""
    side = mission.side
    if side is None:
        return math.inf
    arm, inner = math.hypot(*mission.body.sensor), max(side - 2.0 * mission.body.radius, 0.0)
    within = inner**2 + 4.0 * inner * arm + math.pi * arm**2
    return max(1.0, min(within, side**2) / mission.body.tile**2)


def variance(mission: Mission, fill_ratio: float, readings: float) -> float:
    """The variance of an estimate from so many readings anywhere on the floor, about what it is held against."""
    f, tiles = fill_ratio, tiles_of(mission)
    whole = _reading(mission.accuracy, f)
    floor = mission.area.floor[0] if mission.area.floor else Floor()
    if math.isinf(tiles):
        return whole / readings
    ordered = floor != Floor()  # such floors have exactly so many black tiles
    left = theory.tiles_variance(
        theory.even_concentration(readings, round(tiles)),
        f,
        round(tiles),
        drawn="exactly" if ordered else "one by one",
        truth="floor" if mission.on_floor else "nominal",
    )
    return max(whole - f * (1.0 - f), 0.0) / readings + float(left)


def readings_needed(mission: Mission, fill_ratio: float) -> float:
    """The least number of readings that are enough; infinite where none is."""
    goal = mission.goal

    def enough(readings: float) -> bool:
        return goal.normal_share(math.sqrt(variance(mission, fill_ratio, readings)), fill_ratio) >= goal.confidence

    if not enough(MOST_READINGS):
        return math.inf
    low, high = 1.0, MOST_READINGS
    if enough(low):
        return low
    while high / low > 1.0 + 1e-6:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def limit_of(mission: Mission, fill_ratio: float) -> float:
    """The standard deviation that no number of readings gets below: that of the floor's own share of black."""
    return math.sqrt(variance(mission, fill_ratio, MOST_READINGS))


def worst(mission: Mission) -> list[float]:
    """The fill ratio that takes most readings, and both ends of the range, each once."""
    every = mission.goal.candidates(*mission.known.fill_ratio)
    first = float(max(every, key=lambda f: (readings_needed(mission, float(f)), limit_of(mission, float(f)))))
    return list(dict.fromkeys([first, float(every[0]), float(every[-1])]))


def between(mission: Mission) -> list[float]:
    """Other fill ratios of the range that are looked at: theory knows nothing of liars, who may do most harm inside."""
    if not mission.known.lying:
        return []
    every = mission.goal.candidates(*mission.known.fill_ratio)[::APART].tolist()
    return [f for f in every if f not in worst(mission)]


def hardest(mission: Mission) -> Mission:
    """The mission with that one of its accuracies which takes most readings in the first of its worlds."""

    def readings(accuracy: Accuracy) -> float:
        known = mission.known.model_copy(update={"accuracy": [accuracy]})
        world = mission.model_copy(update={"known": known}).worlds[0].sized(REFERENCE)
        return readings_needed(world, worst(world)[0])

    accuracy = max(mission.known.accuracy, key=readings)
    return mission.model_copy(update={"known": mission.known.model_copy(update={"accuracy": [accuracy]})})


def start_of(mission: Mission, robots: int, readings: float) -> Start:
    """How many rounds so many robots need for so many readings' worth, each, were those that lie or fail not there."""
    working = robots - mission.lying(robots) - mission.failing(robots)
    alone, pooled = readings / mission.looks, readings / mission.looks / working
    alone, pooled = max(1.0, alone), max(1.0, pooled)
    if working == 1 or not math.isfinite(readings) or mission.known.link_success == 0.0:
        return Start(alone, alone, pooled)
    times = np.unique(np.geomspace(pooled, min(alone, LARGEST), POINTS).round())
    factors = _factors(mission, working, robots, times)
    if factors is None:
        return Start(alone, math.sqrt(alone * pooled), pooled)
    enough = np.flatnonzero(mission.looks / factors >= readings)
    return Start(alone, float(times[enough[0]]) if enough.size else alone, pooled)


def _factors(mission: Mission, working: int, robots: int, times: np.ndarray) -> np.ndarray | None:
    """The mean factor of the network after these rounds; None where it is not known."""
    if mission.moves:
        assert mission.side is not None
        rate = meeting_rate(working, mission.side, mission.body)
        return meeting_factors(working, rate, times)
    topology = mission.free.topology[0]
    if topology.name == "full" or robots > MOST_MIXED or working < robots:
        return 1.0 / (working * times) if topology.name == "full" else None
    links = topology.links(robots, mission.seed, 0, 1, lossless=False, sums=False)
    matrix = from_links(robots, links.receivers, links.senders)
    if spectrum_of(matrix) is None:
        return None
    return np.asarray(variance_factors(matrix, [int(t) for t in times]).mean(axis=1))


def meeting_rate(robots: int, side: float, body: Body) -> float:
    """How many others a robot meets in a tick, in a square of this side in metres."""
    run = body.straight_mean
    moving = run / (run + max(body.turn_most / 2.0, 1.0))  # turns on the spot take the rest of the time
    speed = moving * body.speed * body.tick
    return 2.0 * body.radio_range * (robots - 1) / side**2 * 4.0 / math.pi * speed


def meeting_factors(robots: int, rate: float, ticks: ArrayLike) -> NDArray[np.float64]:
    """The factor of the network after so many ticks, of the shape of `ticks`: 1/t of a robot alone, 1/(N t) of one that
    knows all."""
    t = np.asarray(ticks, np.float64)
    if robots == 1 or rate <= 0.0:
        return 1.0 / t
    a = rate * robots / (2.0 * (robots - 1))
    return np.asarray(1.0 / (robots * t) + (1.0 - 1.0 / robots) * -np.expm1(-a * t) / (a * t**2))
