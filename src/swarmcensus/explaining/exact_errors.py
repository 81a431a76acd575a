"""Where theory is exact: the squared error that a setting's estimates are expected to have, trial by trial.

Three brains are linear in what robots read, or say it as it is, so that theirs is known: `alone`; `commons`, which
mixes running sums; and `minimalistic` where nobody is heard. Of commons the prior is counted in. That its estimate is
cut to [0, 1] can be counted in where all sensors are equal and all robots hold the same sums, or hear nobody; elsewhere
theory counts as exact from the round on in which cutting takes less than `CUT` off the squared error.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmcensus import brains, theory
from swarmcensus.basics.formatting import counted
from swarmcensus.explaining.expectations import ALONE, MIXED, mixing_of, reasons
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study

Floats = NDArray[np.float64]
CUT = 1e-3  # of the mean squared error
BRAINS = {"alone": ALONE, "minimalistic": ALONE, "commons": MIXED}  # theory's lines for them
MOST_POOLED = 1_000_000  # readings of a swarm whose counts are listed


class Exact(NamedTuple):
    """The mean of (x - f)^2 expected of each robot after the last round, (trial, robot); or why there is none."""

    squared: Floats
    why: str = ""


def exact(study: Study, found: Setting, trials: NDArray[np.intp]) -> Exact:
    """What the squared errors of a study's setting are expected to be, given the sensors and graphs of these trials.

    Raises InputError.
    """
    name = found.brain.name
    deaf = found.robots == 1 or found.link_success == 0.0
    if name not in BRAINS:
        return _none(f"no closed form is known of {name}")
    if found.brain.sha256 != brains.load(name).sha256:
        return _none(f"{name} is not the one that ships")
    first, count = int(trials[0]), int(trials[-1] - trials[0] + 1)
    drawn = [one[trials - first] for one in found.accuracies(study.seed, first, count)]
    absent = reasons(found, all(map(np.array_equal, drawn[:2], drawn[2:])))
    line = ALONE if deaf else BRAINS[name]
    if line in absent:
        return _none(absent[line])
    if any(brain.sha256 != found.brain.sha256 for brain in found.crew):
        return _none("robots have several brains")
    if name == "minimalistic" and not deaf:
        return _none("of what minimalistic makes of what it hears no closed form is known")
    b, w = (np.broadcast_to(one, (trials.size, found.robots)) for one in drawn[:2])
    if line == ALONE:
        return Exact(_listed(found, b, w, 1, prior=name == "commons"))
    graphs = mixing_of(found, study.seed, trials)
    looks = found.rounds * found.observations_per_round * found.robots
    pooled = b.min() == b.max() and w.min() == w.max() and np.ptp(graphs[0]) == 0.0 and not found.message_delay
    if pooled and looks <= MOST_POOLED:
        return Exact(_listed(found, b, w, found.robots, prior=True))
    if 1 < len(graphs) < trials.size:
        return _none(f"graphs of {counted(found.robots, 'robot')} are too large to decompose one a trial")
    return _mixed(found, graphs, b, w)


def prior_pull(evidence: Floats) -> Floats:
    """How far commons' prior draws s / v with this v to 1/2: p / (v + p), p = min(1/4, 1 / (16 v))."""
    with np.errstate(divide="ignore"):
        weight = np.minimum(0.25, 0.0625 / evidence)
    return np.asarray(weight / (evidence + weight))


def _none(why: str) -> Exact:
    return Exact(np.zeros((0, 0)), why)


def _listed(found: Setting, b: Floats, w: Floats, together: int, prior: bool) -> Floats:
    """Of robots that hold the readings of so many with sensors like theirs, (trial, robot)."""
    looks = found.rounds * found.observations_per_round
    pull = prior_pull((b + w - 1.0) ** 2 * looks) if prior else np.zeros(())
    return theory.local_squared_error(looks * together, found.fill_ratio, b, w, pull)


def _mixed(found: Setting, graphs: list[Floats], b: Floats, w: Floats) -> Exact:
    """Of sums that are mixed on these graphs, one a trial or one for all."""
    alike = len(graphs) == 1 and (b == b[0]).all() and (w == w[0]).all()
    squared, cut = [], 0.0
    for k in range(1 if alike else len(b)):
        sums = theory.mixed_sums(
            graphs[min(k, len(graphs) - 1)], found.rounds, found.observations_per_round, found.fill_ratio, b[k], w[k],
            found.message_delay,
        )  # fmt: skip
        if not np.isfinite(sums.variance).all():
            return _none("some robots know only of sensors with b + w = 1")
        pull = prior_pull(sums.evidence)
        squared.append(theory.pulled_squared_error(sums.variance, found.fill_ratio, pull))
        cut += float(theory.cut_off(sums.variance, found.fill_ratio, pull).mean())
    share = cut / max(float(np.mean(squared)) * len(squared), np.finfo(float).tiny)
    if share > CUT:
        return _none(f"too early: cutting estimates to [0, 1] takes {100.0 * share:.2g} % off the squared error")
    return Exact(np.broadcast_to(squared, b.shape))
