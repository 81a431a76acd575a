"""What theory expects of a setting: a robot alone, its neighbourhood, mixed sums, the whole swarm.

Sensors and graphs are those of the trials, drawn again from the study in the results; no brain is run. If a closed form
does not hold, a sentence says why.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus import theory
from swarmcensus.engine.constants import LISTED
from swarmcensus.results import NETWORKS, setting_of
from swarmcensus.simulation import Connections, connections, sampling
from swarmcensus.studies import Setting, Study
from swarmcensus.summaries import done_trials
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.support.options import wrong_option
from swarmcensus.support.plugins import is_unread
from swarmcensus.theory import from_links
from swarmcensus.worlds import Accuracy, Floor, Misjudgement, reachable

Origin = tuple[Study, Setting]
EVERY = ALONE, NEAR, MIXED, SWARM = "alone", "neighbourhood", "mixed", "swarm"
MOST_ROBOTS = 1000  # of the largest network of which the mixing is computed
MOST_WORK = 1e9  # operations of decompositions: the number of graphs times the cube of the number of robots
PROGRAM = "is a program, which is not run here, and therefore unknown"
MOST_SAMPLED = 100  # sensors, or variances, that represent all of a study


class Line(NamedTuple):
    """What theory expects of estimates at each time (time,), over robots and trials."""

    median_error: Floats
    low: Floats  # the quartiles of estimates
    high: Floats
    sd: Floats
    bias: Floats
    right: Floats
    variance: Floats  # the mean over robots and trials


class Expectation(NamedTuple):
    """The lines of theory by name, why others are absent, and what they were computed from."""

    lines: dict[str, Line]
    absent: dict[str, str]
    setting: Setting
    stationary: float  # variance of mixed sums at the last time if all readings were fully mixed; NaN if unknown
    floor: float  # variance of the floor's own share of black about f
    connections: Connections  # whether the networks are connected
    beliefs: float  # the error that wrong beliefs about sensors add; NaN if robots know theirs


def expect(
    data: xr.Dataset, number: int, times: Sequence[int], names: Sequence[str] = (), origin: Origin | None = None,
    graphs_of: int | None = None,
) -> Expectation:  # fmt: skip
    """What theory expects of a setting after these rounds, or ticks: the lines of these names, or all.

    `origin` is the study and the setting, if they are known. Graphs are those of the first `graphs_of` trials, or of as
    many as `MOST_WORK` allows. Raises InputError.
    """
    study, setting = origin or setting_of(data, number, run=False)
    trials = data["trial"].values[done_trials(data.sel(setting=[number]))[0]]
    if not trials.size:
        raise wrong_option("setting", number, "none of its trials has been run")
    (b, w), absent = sensors(study, setting, trials)
    if "done_round" in data and np.isfinite(data["done_round"].sel(setting=number).values).any():
        absent = dict.fromkeys(EVERY, "some robots are done before the end and stop observing")
    wanted = [name for name in names or EVERY if name not in absent]
    floor = float(floor_variance(data, setting, np.array(np.inf)))
    known = np.array([data[name].sel(setting=number, trial=trials) for name in NETWORKS if name in data])
    is_known = known.size > 0 and bool(np.isfinite(known).all())
    connected = connections(setting, study.seed, trials.size, known=known if is_known else None)
    f, bins = setting.fill_ratio, int(data.attrs["bins"])
    readings = np.array(times, np.float64) * setting.observations_per_round
    lines: dict[str, Line] = {}
    graphs: list[Floats] = []
    stationary = np.nan
    if ALONE in wanted:
        lines[ALONE] = _alone(readings, f, b, w, bins)
    if SWARM in wanted:
        bound = theory.swarm_bound(readings, f, b, w)
        if setting.body is not None:  # robots see tiles repeatedly; best is to see all tiles equally often
            of_floor = floor_variance(data, setting, readings * setting.robots)
            bound = _sensing(readings, f, b, w) + of_floor[:, np.newaxis]
        lines[SWARM] = normal_line(bound, f, bins)
    if NEAR in wanted or MIXED in wanted:
        graphs = mixing_of(setting, study.seed, trials[:graphs_of])
    if NEAR in wanted:
        near = [theory.neighbourhood_bound(m, readings, f, b[k], w[k]) for k, m in enumerate(graphs)]
        lines[NEAR] = normal_line(np.concatenate(near, axis=1), f, bins)
    if MIXED in wanted:
        lines[MIXED], stationary = _mixed(setting, times, graphs, b, w, bins)
    beliefs = sampling.belief_error(setting, study.seed, int(trials[0]), trials.size) if b.size else np.nan
    return Expectation(lines, absent, setting, stationary, floor, connected, beliefs)


def sensors(study: Study, setting: Setting, trials: NDArray[np.intp]) -> tuple[list[Floats], dict[str, str]]:
    """The b and w of robots in these trials, (trial, robot), and why theory has no value for some lines, by line."""
    beliefs: list[Accuracy | Misjudgement | None] = [setting.accuracy, setting.assumed_accuracy]
    beliefs += [belief for member in setting.members for belief in (member.accuracy, member.assumed_accuracy)]
    if any(is_unread(one.kind) for belief in beliefs if belief for one in belief.distributions):
        return [np.zeros((0, 0))] * 2, dict.fromkeys(EVERY, f"the sensors' spread {PROGRAM}")
    first, count = int(trials[0]), int(trials[-1] - trials[0] + 1)
    drawn = [values[trials - first] for values in sampling.accuracies(setting, study.seed, first, count)]
    absent = _reasons(setting, all(map(np.array_equal, drawn[:2], drawn[2:])))
    return [np.broadcast_to(values, (trials.size, setting.robots)) for values in drawn[:2]], absent


def _reasons(setting: Setting, knows: bool) -> dict[str, str]:
    """Why theory has no value for some lines of a setting, by line; `knows` tells whether robots know their sensors."""
    moves, accuracy = setting.body is not None, setting.accuracy
    sensors_of = [accuracy, *(member.accuracy for member in setting.members)]
    reasons: dict[str, str] = {}
    for names, why, holds in (  # of several reasons for a line the first is given
        (EVERY, "the floor changes while robots observe", setting.change is not None),
        (EVERY, "each trial draws its own fill ratio", setting.spread is not None),
        (EVERY, "sensors drift while robots observe", any(one is not None and one.drift for one in sensors_of)),
        (EVERY, "some robots lie", setting.honest < setting.robots),
        (EVERY, "parts of robots fail", bool(setting.faults)),
        (EVERY, "b + w = 1: readings say nothing of the floor", accuracy.is_blind and not setting.members),
        ((ALONE,), "robots are wrong about their sensors", not knows),
        ((ALONE,), "robots that move see tiles again, so that readings are not independent", moves),
        ((NEAR, MIXED), "robots that move hear others all the time", moves),
        ((NEAR, MIXED), f"the network {PROGRAM}", is_unread(setting.topology.named)),
        ((MIXED,), "messages are lost", setting.link_success < 1.0 and not setting.brain.is_oracle),
        ((MIXED,), "messages are late", setting.message_delay > 0 and not moves),
        ((MIXED,), "robots are wrong about their sensors", not knows),
        ((NEAR, MIXED), f"there are more than {MOST_ROBOTS:,} robots", setting.robots > MOST_ROBOTS),
    ):
        if holds:
            reasons = dict.fromkeys(names, why) | reasons
    return {name: reasons[name] for name in EVERY if name in reasons}


def floor_variance(data: xr.Dataset, setting: Setting, readings: Floats) -> Floats:
    """The least variance that a floor of independent tiles leaves after so many readings of the whole swarm.

    It is reached if all tiles are seen equally often, or each reading is of another tile. It is 0, which is a bound
    too, for other floors, and on fixed networks, where each reading is of a new tile, as the sensors' bound assumes.
    """
    if setting.body is None or setting.floor not in (None, Floor()):
        return np.zeros(readings.shape)
    body = setting.body
    arm = float(np.hypot(*body.sensor))
    tiles = reachable(setting.arena_side / 2.0, body.radius, arm, body.tile).shape[1]
    truth: theory.Truth = "floor" if data.attrs["truth"] == "floor" else "nominal"
    return theory.tiles_variance(np.maximum(1.0 / readings, 1.0 / tiles), setting.fill_ratio, tiles, truth=truth)


def normal_line(variance: Floats, f: float, bins: int) -> Line:
    """The line of normal estimates about f with these variances (time, robots of all trials)."""
    mean = variance.mean(axis=1)
    sampled = np.sort(variance, axis=1)[:, _evenly_spaced(variance.shape[1])]
    right = np.array([theory.normal_right_share(variances, f, bins).mean() for variances in sampled])
    half = theory.normal_median_error(sampled, f)
    low, high = np.maximum(f - half, 0.0), np.minimum(f + half, 1.0)
    return Line(half, low, high, np.sqrt(mean), np.zeros(len(mean)), right, mean)


def _alone(readings: Floats, f: float, b: Floats, w: Floats, bins: int) -> Line:
    pairs = np.stack([b.ravel(), w.ravel()], axis=1)
    same = (pairs == pairs[0]).all()
    pairs = pairs[:1] if same else pairs[np.lexsort(pairs.T[::-1])][_evenly_spaced(len(pairs))]  # in proportion
    rows = []
    for t in readings.astype(int).tolist():
        law = theory.mixed_law([theory.local_law(t, f, *pair) for pair in pairs.tolist()])
        middle, half = theory.error_law(law, f).quantile(0.5), (law.quantile(0.25), law.quantile(0.75))
        right = theory.right_share(law, f, bins)
        rows.append((middle, *half, law.variance**0.5, law.mean - f, right, law.variance))
    return Line(*np.array(rows).T)


def _mixed(
    setting: Setting, times: Sequence[int], graphs: list[Floats], b: Floats, w: Floats, bins: int
) -> tuple[Line, float]:
    """The line of mixed sums, and their stationary variance."""
    f, looks = setting.fill_ratio, setting.observations_per_round
    variances, late, law = [], [], np.zeros(0)
    for k, matrix in enumerate(graphs):
        variances.append(theory.mixed_sums(matrix, times, looks, f, b[k], w[k]).variance)
        # decompositions take the longest, and trials often share one graph
        if k == 0 or matrix is not graphs[k - 1]:
            try:
                law = theory.stationary_law(matrix)
            except InputError:  # the graph is not connected
                law = np.full(setting.robots, np.nan)
        weights = law * (b[k] + w[k] - 1.0) ** 2
        variance = theory.reading_variance(f, b[k], w[k])
        known = weights != 0.0
        late.append((weights[known] ** 2 @ variance[known]) / weights.sum() ** 2 / (looks * times[-1]))
    line = normal_line(np.concatenate(variances, axis=1), f, bins)
    return line, float(np.mean(late))


def mixing_of(setting: Setting, seed: int, trials: NDArray[np.intp]) -> list[Floats]:
    """The mixing matrices of the first trials, as many as `MOST_WORK` allows; one if all trials have the same."""
    robots, accuracy = setting.robots, setting.accuracy
    same_graph, are_numbers = not setting.graphs_vary, all(one.is_number for one in accuracy.distributions)
    alike = same_graph and are_numbers and not setting.members
    # sensors that differ need all trials, even on one graph
    chosen = trials[:1] if alike else trials[: max(1, int(MOST_WORK / robots**3))]
    matrices: list[Floats] = []
    for trial in chosen.tolist():
        links = sampling.links(setting, seed, trial, 1)
        everyone = np.full((robots, robots), 1.0 / robots)
        matrix = from_links(robots, links.receivers, links.senders) if links.mode == LISTED else everyone
        matrices.append(matrices[0] if same_graph and matrices else matrix)
    return matrices


def _sensing(readings: Floats, f: float, b: Floats, w: Floats) -> Floats:
    """The variance that sensors leave if all readings are pooled, weighted by information: (time, trial)."""
    slope = b + w - 1.0
    errs = f * b * (1.0 - b) + (1.0 - f) * w * (1.0 - w)
    with np.errstate(divide="ignore"):
        information = np.where(np.abs(slope) < 1e-12, 0.0, slope**2 / errs)
        return np.asarray(1.0 / np.multiply.outer(readings, information.sum(axis=1)))


def _evenly_spaced(count: int) -> NDArray[np.intp]:
    """At most `MOST_SAMPLED` of `count` places, evenly spaced."""
    sampled = min(count, MOST_SAMPLED)
    return ((np.arange(sampled) + 0.5) * count / sampled).astype(np.intp)
