"""What theory expects of a setting of some results: a robot alone, its neighbourhood, mixed sums, the whole swarm.

Sensors and graphs are those that the trials drew, found again from the study in the results; no brain is run. Where a
closed form does not hold, there is a sentence that says why.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus import theory
from swarmcensus.basics.errors import InputError
from swarmcensus.engine.constants import LISTED
from swarmcensus.results.source_study import setting_of
from swarmcensus.results.summaries import done
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study
from swarmcensus.theory.late_mixing import fits
from swarmcensus.theory.matrices import from_links
from swarmcensus.worlds.ground import reachable
from swarmcensus.worlds.patterns import Floor

Floats = NDArray[np.float64]
Origin = tuple[Study, Setting]
ALONE, NEAR, MIXED, SWARM = "alone", "neighbourhood", "mixed", "swarm"
MOST_ROBOTS = 1000  # of a network whose mixing is computed
WORK = 1e9  # of decompositions: the cube of the robots, times graphs
SOME = 100  # sensors, or variances, that stand for all of a study's


class Line(NamedTuple):
    """What theory expects at each time, each (time,): of robots' estimates, over robots and trials."""

    median_error: Floats
    low: Floats  # the middle half of estimates lies from here
    high: Floats
    sd: Floats
    bias: Floats
    right: Floats
    variance: Floats  # the mean one


class Expectation(NamedTuple):
    """Lines by their names, why others are absent, and what they were computed from."""

    times: list[int]
    lines: dict[str, Line]
    absent: dict[str, str]
    setting: Setting
    stationary: float  # variance of mixed sums at the last time, were all news round; NaN where that is not known
    relaxation: float  # rounds, the longest of the graphs; NaN likewise, and where messages are late
    graphs: int  # that were looked at
    floor: float  # variance that the floor's own share of black has about f


def expect(
    data: xr.Dataset,
    number: int,
    times: Sequence[int],
    names: Sequence[str] = (),
    origin: Origin | None = None,
    graphs_of: int | None = None,
) -> Expectation:
    """What theory says of a setting after these rounds, or ticks; of some lines only, or of all.

    `origin` is its study and itself, where they are found already. Graphs are looked at of the first `graphs_of`
    trials, or of as many as time allows. Raises InputError.
    """
    study, found = origin or setting_of(data, number, run=False)
    trials = data["trial"].values[done(data.sel(setting=[number]))[0]]
    if not trials.size:
        raise InputError(f"setting {number}: none of its trials has been run")
    first, count = int(trials[0]), int(trials[-1] - trials[0] + 1)
    drawn = [one[trials - first] for one in found.accuracies(study.seed, first, count)]
    absent = reasons(found, all(map(np.array_equal, drawn[:2], drawn[2:])))
    if _stop(data.sel(setting=[number])):
        absent = dict.fromkeys((ALONE, NEAR, MIXED, SWARM), "some robots are done before the end, and look no more")
    wanted = [name for name in names or (ALONE, NEAR, MIXED, SWARM) if name not in absent]
    floor = float(floor_variance(data, found, np.array(np.inf)))
    out = Expectation(list(times), {}, absent, found, np.nan, np.nan, 0, floor)
    if not wanted:
        return out
    b, w = (np.broadcast_to(one, (trials.size, found.robots)) for one in drawn[:2])
    f, bins = found.fill_ratio, int(data.attrs["bins"])
    readings = np.array(times, np.float64) * found.observations_per_round
    if ALONE in wanted:
        out.lines[ALONE] = _alone(readings, f, b, w, bins)
    if SWARM in wanted:
        bound = theory.swarm_bound(readings, f, b, w)
        if found.body is not None:  # tiles are seen again: at best all of them, and all as often
            bound = _sensing(readings, f, b, w) + floor_variance(data, found, readings * found.robots)[:, np.newaxis]
        out.lines[SWARM] = normal_line(bound, f, bins)
    if NEAR in wanted or MIXED in wanted:
        graphs = mixing_of(found, study.seed, trials[:graphs_of])
        if NEAR in wanted:
            near = [theory.neighbourhood_bound(m, readings, f, b[k], w[k]) for k, m in enumerate(graphs)]
            out.lines[NEAR] = normal_line(np.concatenate(near, axis=1), f, bins)
        if MIXED in wanted:
            out = _mixed(out, graphs, b, w, bins)
        out = out._replace(graphs=len(graphs))
    return out


def _stop(one: xr.Dataset) -> bool:
    return "done_round" in one and bool(np.isfinite(one["done_round"].values).any())


def reasons(found: Setting, knows: bool) -> dict[str, str]:
    """Why theory says nothing of some lines of a setting, by their names; whether its robots know their sensors."""
    for why, holds in (
        ("the floor changes while robots look", found.change is not None),
        ("sensors drift while robots look", found.accuracy.drift is not None or any(map(_drifts, found.members))),
        ("some robots lie", found.honest < found.robots),
        ("parts of robots fail", bool(found.faults)),
        ("b + w = 1: readings say nothing of the floor", found.accuracy.is_blind and not found.members),
    ):
        if holds:
            return dict.fromkeys((ALONE, NEAR, MIXED, SWARM), why)
    out: dict[str, str] = {}
    moves = found.body is not None
    for name, why, holds in (
        (ALONE, "robots are wrong about their sensors", not knows),
        (ALONE, "robots that move see tiles again, so that readings are not independent", moves),
        (NEAR, "robots that move hear others all the time", moves),
        (NEAR, f"there are more than {MOST_ROBOTS:,} robots", found.robots > MOST_ROBOTS),
        (MIXED, "robots that move hear others all the time", moves),
        (MIXED, "messages are lost", found.link_success < 1.0 and not found.brain.is_oracle),
        (MIXED, "messages are late, in too large a network", not moves and not _fits(found)),
        (MIXED, "robots are wrong about their sensors", not knows),
        (MIXED, f"there are more than {MOST_ROBOTS:,} robots", found.robots > MOST_ROBOTS),
    ):
        if holds:
            out.setdefault(name, why)
    return out


def floor_variance(data: xr.Dataset, found: Setting, readings: Floats) -> Floats:
    """What a floor leaves at least after so many readings of the whole swarm, of tiles that are drawn one by one.

    At best all tiles have been seen as often, or as many as there are readings. 0 on fixed networks, where each reading
    has a tile of its own, which the sensors' bound counts, and of other floors: a bound too.
    """
    if found.body is None or found.floor not in (None, Floor()):
        return np.zeros(readings.shape)
    body = found.body
    arm = float(np.hypot(*body.sensor))
    tiles = reachable(found.arena_side / 2.0, body.radius, arm, body.tile).shape[1]
    truth: theory.Truth = "floor" if data.attrs["truth"] == "floor" else "nominal"
    return theory.tiles_variance(np.maximum(1.0 / readings, 1.0 / tiles), found.fill_ratio, tiles, truth=truth)


def normal_line(variance: Floats, f: float, bins: int) -> Line:
    """Of estimates that are normal about f with variances (time, robot of any trial)."""
    mean = variance.mean(axis=1)
    some = np.sort(variance, axis=1)[:, _some(variance.shape[1])]
    right = np.array([theory.normal_right_share(one, f, bins).mean() for one in some])
    half = theory.normal_median_error(some, f)
    return Line(
        half, np.maximum(f - half, 0.0), np.minimum(f + half, 1.0), np.sqrt(mean), np.zeros(len(mean)), right, mean
    )


def _alone(readings: Floats, f: float, b: Floats, w: Floats, bins: int) -> Line:
    pairs = np.stack([b.ravel(), w.ravel()], axis=1)
    alike = (pairs == pairs[0]).all()
    pairs = pairs[:1] if alike else pairs[np.lexsort(pairs.T[::-1])][_some(len(pairs))]  # as often as they are there
    rows = []
    for t in readings.astype(int).tolist():
        law = theory.mixed_law([theory.local_law(t, f, *pair) for pair in pairs.tolist()])
        middle, half = theory.error_law(law, f).quantile(0.5), (law.quantile(0.25), law.quantile(0.75))
        right = theory.right_share(law, f, bins)
        rows.append((middle, *half, law.variance**0.5, law.mean - f, right, law.variance))
    return Line(*np.array(rows).T)


def _mixed(out: Expectation, graphs: list[Floats], b: Floats, w: Floats, bins: int) -> Expectation:
    found = out.setting
    variances, late, slow = [], [], []
    looks, f = found.observations_per_round, found.fill_ratio
    law, relaxation = np.zeros(0), np.nan
    for k, matrix in enumerate(graphs):
        variances.append(theory.mixing_variance(matrix, out.times, looks, f, b[k], w[k], found.message_delay))
        if k == 0 or matrix is not graphs[k - 1]:
            try:
                law, relaxation = theory.stationary_law(matrix), theory.relaxation_time(matrix)
            except InputError:  # it falls apart
                law, relaxation = np.full(found.robots, np.nan), np.nan
        slow.append(np.nan if found.message_delay else relaxation)
        weights = law * (b[k] + w[k] - 1.0) ** 2
        variance = theory.reading_variance(f, b[k], w[k])
        known = weights != 0.0
        late.append((weights[known] ** 2 @ variance[known]) / weights.sum() ** 2 / (looks * out.times[-1]))
    out.lines[MIXED] = normal_line(np.concatenate(variances, axis=1), f, bins)
    return out._replace(stationary=float(np.mean(late)), relaxation=float(np.max(slow)))


def mixing_of(found: Setting, seed: int, trials: NDArray[np.intp]) -> list[Floats]:
    """The mixing matrices of the first trials, as many as may be decomposed; one where all trials have the same."""
    same = not found.topology.varies or found.brain.is_oracle
    most = max(1, int(WORK / (found.robots**3 if not found.message_delay else found.robots**2 * found.rounds * 10)))
    alike = found.accuracy.black.is_number and not found.members
    kept = trials[:1] if same and alike and (found.accuracy.white or found.accuracy.black).is_number else trials[:most]
    matrices: list[Floats] = []
    for trial in kept.tolist():
        links = found.links(seed, trial, 1)
        everyone = np.full((found.robots, found.robots), 1.0 / found.robots)
        one = from_links(found.robots, links.receivers, links.senders) if links.mode == LISTED else everyone
        matrices.append(matrices[0] if same and matrices else one)
    return matrices


def _fits(found: Setting) -> bool:
    return not found.message_delay or fits(found.robots, found.message_delay)


def _sensing(readings: Floats, f: float, b: Floats, w: Floats) -> Floats:
    """What sensors leave of all readings pooled, each weighed by how sure it is: (time, trial)."""
    slope = b + w - 1.0
    errs = f * b * (1.0 - b) + (1.0 - f) * w * (1.0 - w)
    with np.errstate(divide="ignore"):
        told = np.where(np.abs(slope) < 1e-12, 0.0, slope**2 / errs)
        return np.asarray(1.0 / np.multiply.outer(readings, told.sum(axis=1)))


def _some(count: int) -> NDArray[np.intp]:
    """Places evenly spread over so many, the middles of equal parts."""
    few = min(count, SOME)
    return ((np.arange(few) + 0.5) * count / few).astype(np.intp)


def _drifts(member: object) -> bool:
    accuracy = getattr(member, "accuracy", None)
    return accuracy is not None and accuracy.drift is not None
