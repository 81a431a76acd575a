"""Statistics of one setting, each of the sample and then of every resample.

A setting is a contender, which is a study and the coordinates that select its settings, in a world, which is the other
coordinates. An event that did not happen within a trial counts as if in the last round, so that times are lower bounds.
"""

import numpy as np

from swarmcensus.evaluation.paper.evidence import LATE, Contender, Evidence, Where
from swarmcensus.results import setting_of
from swarmcensus.simulation import senders_heard
from swarmcensus.support.intervals import Floats, medians

QUORUM = 0.8  # share of a swarm; our choice


def convergence(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The median K, in observations."""
    if contender.local:
        return evidence.median(contender, world, "local_convergence_step")
    rounds = evidence.median(contender, world, "convergence_round")
    return rounds * evidence.number(contender, world, "observations_per_round")


def rounds(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The median K, in rounds."""
    return convergence(evidence, contender, world) / evidence.number(contender, world, "observations_per_round")


def error(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The median error at K."""
    return evidence.median(contender, world, "local_" * contender.local + "convergence_error")


def end_of(evidence: Evidence, contender: Contender, world: Where) -> float:
    """When a run counts as over, in observations: what settles later may not have settled."""
    rounds, per_round = (evidence.number(contender, world, name) for name in ("rounds", "observations_per_round"))
    return LATE * rounds * per_round


def unsettled(evidence: Evidence, contender: Contender, world: Where) -> bool:
    """Whether the median robot settles in the last tenth of the run or not at all."""
    return bool(convergence(evidence, contender, world)[0] > end_of(evidence, contender, world))


def right_share(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The mean share of robots in the right bin, over the checkpoints."""
    return evidence.mean(evidence.values(contender, world, "correct").mean(axis=1))


def wrong_share(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The mean share of robots in a wrong bin, over the checkpoints."""
    return 1 - right_share(evidence, contender, world)


def spread(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The largest difference of two final estimates in any trial; exact."""
    return np.array([np.ptp(evidence.values(contender, world, "final_estimate"), axis=1).max()])


def without_neighbours(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of ticks in which a robot that moves hears nobody."""
    data, place = evidence.find(contender, world)
    study, setting = setting_of(data, int(data["setting"].values[place]))
    heard = (senders_heard(setting, study.seed, trial) for trial in data["trial"].values[: evidence.trials].tolist())
    return evidence.mean(np.array([(trial == 0).mean() for trial in heard]))


def consensus_time(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The median round of a first consensus, right or wrong."""
    return medians(_within_run(evidence, contender, world, "consensus_round")[:, np.newaxis], evidence.counts)


def decision_time(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The mean round of a robot's first decision."""
    return evidence.mean(_within_run(evidence, contender, world, "decision_round").mean(axis=1))


def consensus_right(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of trials with a right first consensus, among those that have a right option."""
    option = evidence.column(contender, world, "right_option")
    consensus = evidence.values(contender, world, "consensus", least=-1)
    return evidence.share(consensus == option, ~np.isnan(option))


def wrong_consensus(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of trials with a wrong first consensus or none, among those that have a right option."""
    return 1 - consensus_right(evidence, contender, world)


def right_robots(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of all robots that have decided for the right option at the end."""
    decisions, option = _decisions(evidence, contender, world)
    return evidence.share((decisions == option).sum(axis=1), np.isfinite(option[:, 0]) * decisions.shape[1])


def wrong_robots(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of all robots that have not decided for the right option at the end."""
    return 1 - right_robots(evidence, contender, world)


def right_deciders(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of robots that have decided for the right option, among those that have decided at the end."""
    decisions, option = _decisions(evidence, contender, world)
    return evidence.share((decisions == option).sum(axis=1), np.isfinite(option[:, 0]) * (decisions >= 0).sum(axis=1))


def wrong_deciders(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of robots that have decided for a wrong option, among those that have decided at the end."""
    return 1 - right_deciders(evidence, contender, world)


def quorums(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of trials that end with QUORUM of the robots for one colour."""
    decisions, _ = _decisions(evidence, contender, world)
    most = np.maximum((decisions == 0).mean(axis=1), (decisions == 1).mean(axis=1))
    return evidence.share(most >= QUORUM, np.ones(len(decisions)))


def final_error(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The mean error of final estimates, from the floor's own fill ratio where the study's `truth` is "floor"."""
    estimates = evidence.values(contender, world, "final_estimate")
    truth = np.full(len(estimates), evidence.number(contender, world, "fill_ratio"))
    if evidence.find(contender, world)[0].attrs.get("truth") == "floor":
        truth = evidence.values(contender, world, "true_fill_ratio")
    return evidence.mean(np.abs(estimates - truth[:, np.newaxis]).mean(axis=1))


def _within_run(evidence: Evidence, contender: Contender, world: Where, variable: str) -> Floats:
    """Rounds of events; those that never happen count as if in the last round."""
    return np.minimum(evidence.values(contender, world, variable), evidence.number(contender, world, "rounds"))


def _decisions(evidence: Evidence, contender: Contender, world: Where) -> tuple[Floats, Floats]:
    """Decisions at the end (trial, robot), and the right option (trial, 1), NaN if there is none."""
    option = evidence.column(contender, world, "right_option")
    return evidence.values(contender, world, "decision", least=-1), option[:, np.newaxis]
