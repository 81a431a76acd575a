"""The paper's claims about robots that move, Sec. IV-C, by the same rules as in `claims`."""

from functools import partial

import numpy as np

from swarmcensus.paper import explanations, moving_measures
from swarmcensus.paper.evidence import ALIKE, BELOW_ONE, BELOW_ZERO, Claim
from swarmcensus.paper.measures import ERROR, K

DENSITY, CONSENSUS = (f"IV-C, {name}" for name in ("Swarm density effects", "Consensus speed"))
BLACKER = "both estimation accuracy and convergence speed are better for f = 0.95 than for f = 0.55"

CLAIMS: tuple[Claim, ...] = (
    Claim(
        id="denser-first",
        title="Moving: D = 10 converges before D = 1",
        sentence="mostly in increasing the speed of estimate convergence",
        section=DENSITY,
        statistic="median K, D = 10 / D = 1, for each accuracy and f",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(moving_measures.denser, name=K),
        studies=("moving",),
        explanation=explanations.denser_first,
    ),
    Claim(
        id="denser-alike",
        title="Moving: density hardly matters but for speed",
        sentence="Density has a small influence on performance",
        section=DENSITY,
        statistic="median error, D = 10 / D = 1, for each accuracy and f",
        threshold="within 0.8 to 1.25",
        right=ALIKE,
        measure=partial(moving_measures.denser, name=ERROR),
        studies=("moving",),
        explanation=explanations.denser_alike,
    ),
    Claim(
        id="blacker-first-moving",
        title="Moving: f = 0.95 converges before f = 0.55",
        sentence=BLACKER,
        section=DENSITY,
        statistic="median K, f = 0.95 / f = 0.55, for each density and accuracy",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(moving_measures.blacker_better, name=K),
        studies=("moving",),
    ),
    Claim(
        id="blacker-closer-moving",
        title="Moving: f = 0.95 is estimated better than f = 0.55",
        sentence=BLACKER,
        section=DENSITY,
        statistic="median error, f = 0.95 / f = 0.55, for each density and accuracy",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(moving_measures.blacker_better, name=ERROR),
        studies=("moving",),
    ),
    Claim(
        id="grows-moving",
        title="Moving: performance grows with accuracy",
        sentence="Estimation performance increases with sensor accuracies for both homogeneous and heterogeneous "
        "robots",
        section=DENSITY,
        statistic="Kendall's rank correlation of b = w with median K and with median error, for each density and f; "
        "of heterogeneous swarms there is only one",
        threshold="below 0",
        right=BELOW_ZERO,
        measure=moving_measures.grows,
        studies=("moving",),
        note=moving_measures.steps_back,
    ),
    Claim(
        id="impaired-moving",
        title="Moving: b = w = 0.625 still estimates well",
        sentence="a severely impaired sensor (b = w = 0.625) still shows good estimation accuracy at the expense of "
        "convergence speed",
        section=DENSITY,
        statistic="median error of b = w = 0.625, for each density and f; the threshold is what the paper calls low "
        "of fixed networks",
        threshold="below 0.05",
        right=(-np.inf, 0.05),
        measure=moving_measures.impaired,
        studies=("moving",),
        note=moving_measures.expense,
    ),
    Claim(
        id="consensus-moving",
        title="Moving: all robots are right by tick 10,000 from 0.675 on",
        sentence="for homogeneous swarms, the correct decision is eventually made by every robot with sensor "
        "accuracies ≥ 0.675",
        section=CONSENSUS,
        statistic="share of trials in which all 25 robots choose the right bin at tick 10,000 (17 minutes), at D = 1, "
        "for each b = w from 0.675 on and f; Wilson's interval",
        threshold="1, in 30 trials or more",
        right=(1.0, np.inf),
        measure=moving_measures.consensus,
        studies=("moving",),
    ),
    Claim(
        id="mixed-consensus-moving",
        title="Moving: all of a heterogeneous swarm are right by tick 10,000",
        sentence="the heterogeneous swarm achieves that in a shorter time-frame",
        section=CONSENSUS,
        statistic="share of trials in which all 25 robots choose the right bin at tick 10,000, at D = 1, for each f; "
        "Wilson's interval",
        threshold="1, in 30 trials or more",
        right=(1.0, np.inf),
        measure=moving_measures.mixed_consensus,
        studies=("moving",),
        explanation=explanations.mixed_consensus,
    ),
    Claim(
        id="mixed-sooner-moving",
        title="Moving: a heterogeneous swarm is right before some of the worst",
        sentence="the heterogeneous swarm achieves that in a shorter time-frame when compared to some of the worst "
        "sensor accuracies b = w ≤ 0.675",
        section=CONSENSUS,
        statistic="share of wrong robots in the heterogeneous swarm less that in the worst of b = w = 0.525 to "
        "0.675: its mean over the checkpoints, at D = 1, for each f",
        threshold="below 0",
        right=BELOW_ZERO,
        measure=moving_measures.mixed_sooner,
        studies=("moving",),
        note=moving_measures.overtaken,
    ),
    Claim(
        id="like-tree-moving",
        title="Moving: decisions are like those of the scale-free network",
        sentence="show results similar to the case where robots were connected by a scale-free topology",
        section=CONSENSUS,
        statistic="share of right robots, 25 moving at D = 1 / 100 on the scale-free network at R = 10, after as many "
        "observations: means over the checkpoints, from 100 to 10,000 observations, for each accuracy and f",
        threshold="within 0.8 to 1.25",
        right=ALIKE,
        measure=moving_measures.like_tree,
        studies=("moving", "topologies", "same-observations"),
        note=moving_measures.settled_like_tree,
    ),
)
