"""Statistics of one setting, each of the sample and then of every resample.

A setting is a contender, which is a study and the coordinates that select its settings, in a world, which is the other
coordinates. An event that did not happen within a trial counts as if in the last round, so that times are lower bounds.
"""

from typing import NamedTuple

import numpy as np

from swarmcensus.evaluation.paper.evidence import LATE, Evidence, Missing, Where
from swarmcensus.results import setting_of
from swarmcensus.simulation import senders_heard
from swarmcensus.support.intervals import Floats, medians

QUORUM = 0.8  # share of a swarm; our choice


class Contender(NamedTuple):
    """A study and the coordinates that select its settings; if `local`, estimates are those of robots by themselves."""

    name: str
    study: str
    where: Where
    local: bool = False

    def within(self, world: Where) -> tuple[str, Where]:
        """The study, and all coordinates of the contender's setting in a world."""
        return self.study, {**world, **self.where}


def convergence(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The median K, in observations."""
    study, where = contender.within(world)
    if contender.local:
        return evidence.median(study, "local_convergence_step", where)
    rounds = evidence.median(study, "convergence_round", where)
    return rounds * evidence.number(study, "observations_per_round", where)


def rounds(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The median K, in rounds."""
    study, where = contender.within(world)
    return convergence(evidence, contender, world) / evidence.number(study, "observations_per_round", where)


def error(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The median error at K."""
    study, where = contender.within(world)
    return evidence.median(study, "local_convergence_error" if contender.local else "convergence_error", where)


def end_of(evidence: Evidence, contender: Contender, world: Where) -> float:
    """When a run counts as over, in observations: what settles later may not have settled."""
    study, where = contender.within(world)
    return LATE * evidence.number(study, "rounds", where) * evidence.number(study, "observations_per_round", where)


def unsettled(evidence: Evidence, contender: Contender, world: Where) -> bool:
    """Whether the median robot settles in the last tenth of the run or not at all."""
    return bool(convergence(evidence, contender, world)[0] > end_of(evidence, contender, world))


def right_share(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The mean share of robots in the right bin, over the checkpoints."""
    study, where = contender.within(world)
    return evidence.mean(evidence.values(study, "correct", where).mean(axis=1))


def wrong_share(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The mean share of robots in a wrong bin, over the checkpoints."""
    return 1 - right_share(evidence, contender, world)


def spread(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The largest difference of two final estimates in any trial; exact."""
    study, where = contender.within(world)
    return np.array([np.ptp(evidence.values(study, "final_estimate", where), axis=1).max()])


def without_neighbours(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of ticks in which a robot that moves hears nobody."""
    study, where = contender.within(world)
    data = evidence.setting(study, where)
    made_by, setting = setting_of(evidence.datasets[study], int(data["setting"]))
    heard = (senders_heard(setting, made_by.seed, int(trial)) for trial in data["trial"].values)
    return evidence.mean(np.array([(trial == 0).mean() for trial in heard]))


def consensus_time(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The median round of a first consensus, right or wrong."""
    study, where = contender.within(world)
    rounds = np.minimum(evidence.values(study, "consensus_round", where), evidence.number(study, "rounds", where))
    return medians(rounds[:, np.newaxis], evidence.counts)


def decision_time(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The mean round of a robot's first decision."""
    study, where = contender.within(world)
    rounds = np.minimum(evidence.values(study, "decision_round", where), evidence.number(study, "rounds", where))
    return evidence.mean(rounds.mean(axis=1))


def consensus_right(evidence: Evidence, contender: Contender, world: Where) -> Floats:
    """The share of trials with a right first consensus, among those that have a right option."""
    study, where = contender.within(world)
    consensus, option = _whole(evidence, study, "consensus", where), evidence.column(study, "right_option", where)
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
    study, where = contender.within(world)
    data = evidence.setting(study, where)
    floors = data.attrs.get("truth") == "floor"
    truth = evidence.values(study, "true_fill_ratio", where) if floors else np.full(evidence.trials, data.fill_ratio)
    estimates = evidence.values(study, "final_estimate", where)
    return evidence.mean(np.abs(estimates - truth[:, np.newaxis]).mean(axis=1))


def _whole(evidence: Evidence, study: str, variable: str, where: Where) -> Floats:
    """A variable of one setting. Raises Missing if trials were not run."""
    values = evidence.column(study, variable, where)
    if np.isnan(values).any():  # a trial that was never run; -1 means no option
        raise Missing(f"{study}: trials with {where}")
    return values


def _decisions(evidence: Evidence, contender: Contender, world: Where) -> tuple[Floats, Floats]:
    """Decisions at the end (trial, robot), and the right option (trial, 1), NaN if there is none."""
    study, where = contender.within(world)
    option = evidence.column(study, "right_option", where)
    return _whole(evidence, study, "decision", where), option[:, np.newaxis]
