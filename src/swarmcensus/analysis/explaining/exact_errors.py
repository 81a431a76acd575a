"""The expected squared error of a setting's estimates, trial by trial, for brains with exact theory.

It is known for `alone`, for `commons`, which mixes running sums, and for `minimalistic` if nobody is heard. For commons
it includes the prior, and that estimates are cut to [0, 1]: by a binomial law if all sensors are equal and all robots
hold the same sums, or hear nobody. Otherwise theory counts as exact where cutting changes less than `MOST_CUT`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus import brains, theory
from swarmcensus.analysis.explaining.expectations import ALONE, MIXED, mixing_of, sensors
from swarmcensus.studies import Setting, Study
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats

MOST_CUT = 1e-3  # share of the mean squared error
BRAINS = {"alone": ALONE, "minimalistic": ALONE, "commons": MIXED}  # the line of theory for each brain
MOST_POOLED = 1_000_000  # readings of a swarm up to which all counts of black readings are summed over


class ExactErrors(NamedTuple):
    """The expected (x - f)^2 of each robot after the last round, (trial, robot); or why it is not known."""

    squared: Floats
    why: str = ""


def exact_errors(study: Study, setting: Setting, trials: NDArray[np.intp]) -> ExactErrors:
    """The expected squared errors of a study's setting, given the sensors and graphs of these trials.

    Raises InputError.
    """
    name = setting.brain.name
    hears_nobody = setting.robots == 1 or setting.link_success == 0.0
    if name not in BRAINS:
        return _unknown(f"no closed form is known for {name}")
    if setting.brain.sha256 != brains.load(name).sha256:
        return _unknown(f"{name} is not the one that ships")
    (b, w), absent = sensors(study, setting, trials)
    line = ALONE if hears_nobody else BRAINS[name]
    if line in absent:
        return _unknown(absent[line])
    if any(brain.sha256 != setting.brain.sha256 for brain in setting.brains):
        return _unknown("robots have several brains")
    if name == "minimalistic" and not hears_nobody:
        return _unknown("no closed form is known for minimalistic's use of messages")
    if line == ALONE:
        return ExactErrors(_pooled_readings(setting, b, w, 1, prior=name == "commons"))
    graphs = mixing_of(setting, study.seed, trials)
    readings = setting.rounds * setting.observations_per_round * setting.robots
    pooled = b.min() == b.max() and w.min() == w.max() and np.ptp(graphs[0]) == 0.0
    if pooled and readings <= MOST_POOLED:
        return ExactErrors(_pooled_readings(setting, b, w, setting.robots, prior=True))
    if 1 < len(graphs) < trials.size:
        return _unknown(f"graphs of {counted(setting.robots, 'robot')} are too large to decompose one for each trial")
    return _mixed(setting, graphs, b, w)


def prior_pull(evidence: Floats) -> Floats:
    """How far commons' prior pulls s / v to 1/2: p / (v + p), p = min(1/4, 1 / (16 v)); v is the `evidence`."""
    with np.errstate(divide="ignore"):
        weight = np.minimum(0.25, 0.0625 / evidence)
    return np.asarray(weight / (evidence + weight))


def _unknown(why: str) -> ExactErrors:
    return ExactErrors(np.zeros((0, 0)), why)


def _pooled_readings(setting: Setting, b: Floats, w: Floats, robots_pooled: int, prior: bool) -> Floats:
    """Squared errors (trial, robot) of robots that hold the readings of `robots_pooled` robots with equal sensors."""
    readings = setting.rounds * setting.observations_per_round
    pull = prior_pull((b + w - 1.0) ** 2 * readings) if prior else np.zeros(())
    return theory.local_squared_error(readings * robots_pooled, setting.fill_ratio, b, w, pull)


def _mixed(setting: Setting, graphs: list[Floats], b: Floats, w: Floats) -> ExactErrors:
    """Squared errors of sums that are mixed on these graphs, one for each trial or one for all."""
    same = len(graphs) == 1 and (b == b[0]).all() and (w == w[0]).all()
    rounds, looks, f = setting.rounds, setting.observations_per_round, setting.fill_ratio
    squared, cut = [], 0.0
    used = [graphs[min(k, len(graphs) - 1)] for k in range(1 if same else len(b))]
    for k, graph in enumerate(used):
        sums = theory.mixed_sums(graph, rounds, looks, f, b[k], w[k])
        if not np.isfinite(sums.variance).all():
            return _unknown("some robots know only of sensors with b + w = 1")
        pull = prior_pull(sums.evidence)
        squared.append(theory.pulled_squared_error(sums.variance, f, pull))
        cut += float(theory.cut_off(sums.variance, f, pull).mean())
    share = cut / max(float(np.mean(squared)) * len(squared), np.finfo(float).tiny)
    if share > MOST_CUT:
        return _unknown(f"cutting estimates to [0, 1] takes {100.0 * share:.2g} % off the squared error")
    return ExactErrors(np.broadcast_to(squared, b.shape))
