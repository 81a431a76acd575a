"""The paper's claims as checks on measured data: those of Secs. III-D and IV-B.

Chin, Khaluf and Pinciroli, "Minimalistic Collective Perception with Imperfect Sensors". "Alike" means that a
ratio lies within 0.8 to 1.25 with its whole interval, the usual margin of equivalence studies. The claims of
Sec. IV-C on robots that move are in `moving_claims`.
"""

from collections.abc import Iterable, Mapping
from functools import partial

import numpy as np
import xarray as xr

from swarmcensus.paper import explanations, measures, moving_claims
from swarmcensus.paper.evidence import (
    ABOVE_ONE,
    ALIKE,
    BELOW_ONE,
    BELOW_ZERO,
    Claim,
    Evidence,
    Outcome,
    common_trials,
    outcome,
)

TOPOLOGY, FREQUENCY, CONSENSUS = (
    f"IV-B, {name}" for name in ("Topology effects", "Communication frequency effects", "Consensus speed")
)


def check(datasets: Mapping[str, xr.Dataset], claims: Iterable[Claim] | None = None) -> list[Outcome]:
    """Check claims, by default all, on datasets by the name of their study.

    A claim is "not measured" if settings are missing or some of their trials were not run. Of its studies, only the
    trials that all of them have count.
    """
    claims = CLAIMS if claims is None else tuple(claims)
    sizes = [common_trials(datasets, claim.studies) for claim in claims]
    evidence = {trials: Evidence(datasets, trials=trials) for trials in set(sizes)}
    return [outcome(claim, evidence[trials]) for claim, trials in zip(claims, sizes, strict=True)]


CLAIMS: tuple[Claim, ...] = (
    Claim(
        id="low-error-055",
        title="Ring and scale-free: small errors (f = 0.55)",
        sentence="the estimate errors remain fairly close and low, with median error values of < 0.05",
        section=TOPOLOGY,
        statistic="median error over robots and trials, for each accuracy",
        threshold="below 0.05",
        right=(-np.inf, 0.05),
        measure=partial(measures.low_errors, fill=0.55),
        studies=("topologies",),
    ),
    Claim(
        id="low-error-095",
        title="Ring and scale-free: small errors (f = 0.95)",
        sentence="median estimate errors remain < 0.05 for all sensor accuracies",
        section=TOPOLOGY,
        statistic="median error over robots and trials, for each accuracy",
        threshold="below 0.05",
        right=(-np.inf, 0.05),
        measure=partial(measures.low_errors, fill=0.95),
        studies=("topologies",),
    ),
    Claim(
        id="full-agrees",
        title="Fully connected robots hold one and the same estimate",
        sentence="fully connected robots reach the same informed estimate",
        section=TOPOLOGY,
        statistic="largest difference between two robots' final estimates in any trial; exact; N = 10 and 100",
        threshold="below 1e-9 (rounding)",
        right=(-np.inf, 1e-9),
        measure=measures.full_agrees,
        studies=("topologies",),
    ),
    Claim(
        id="full-first",
        title="Fully connected robots converge first",
        sentence="fully connected robots produce highly accurate estimates significantly quicker than robots in "
        "less connected networks",
        section=TOPOLOGY,
        statistic="median K, fully connected / other topology, for each accuracy and f",
        threshold="below 1",
        right=BELOW_ONE,
        measure=measures.full_first,
        studies=("topologies",),
    ),
    Claim(
        id="ring-like-line",
        title="Ring and line are alike",
        sentence="the ring and line topologies yield similar results",
        section=TOPOLOGY,
        statistic="median K and median error, line / ring, for each accuracy and f",
        threshold="within 0.8 to 1.25",
        right=ALIKE,
        measure=measures.ring_like_line,
        studies=("topologies",),
    ),
    Claim(
        id="informed-first",
        title="Informed estimates converge before local ones",
        sentence="Robots converge onto an informed estimate much quicker than a local estimate",
        section=TOPOLOGY,
        statistic="median K in observations, informed / local, for each topology and accuracy at f = 0.55",
        threshold="below 1",
        right=BELOW_ONE,
        measure=measures.informed_first,
        studies=("topologies", "local"),
    ),
    Claim(
        id="helps-poor",
        title="Communication helps most where sensors are poor",
        sentence="with improved accuracies particularly for low-quality sensors",
        section=TOPOLOGY,
        statistic="median local error less median informed error: its mean over the five accuracies below 0.75 "
        "less its mean over the five above, for each topology at f = 0.55",
        threshold="above 0",
        right=(0.0, np.inf),
        measure=measures.helps_poor,
        studies=("topologies", "local"),
    ),
    Claim(
        id="grows",
        title="Performance grows with accuracy",
        sentence="performance improves with sensor accuracy across all topologies",
        section=TOPOLOGY,
        statistic="Kendall's rank correlation of b = w with median K and with median error, for each topology and f",
        threshold="below 0",
        right=BELOW_ZERO,
        measure=measures.grows,
        studies=("topologies",),
        note=measures.steps_back,
    ),
    Claim(
        id="mixed-055",
        title="A heterogeneous swarm is like b = w = 0.75 (f = 0.55)",
        sentence="The similarity in performance between the heterogeneous robots and the b = w = 0.75 homogeneous "
        "robots is reasonable",
        section=TOPOLOGY,
        statistic="median K and median error, heterogeneous / geometric mean of b = w = 0.725 and 0.775, which "
        "stands for 0.75, for each topology",
        threshold="within 0.8 to 1.25",
        right=ALIKE,
        measure=partial(measures.mixed_like_middle, fill=0.55),
        studies=("topologies",),
        explanation=explanations.mixed(0.55),
    ),
    Claim(
        id="mixed-095",
        title="A heterogeneous swarm is like b = w = 0.75 (f = 0.95)",
        sentence="Similar trends are observed for f = 0.95",
        section=TOPOLOGY,
        statistic="median K and median error, heterogeneous / geometric mean of b = w = 0.725 and 0.775, which "
        "stands for 0.75, for each topology",
        threshold="within 0.8 to 1.25",
        right=ALIKE,
        measure=partial(measures.mixed_like_middle, fill=0.95),
        studies=("topologies",),
        explanation=explanations.mixed(0.95),
    ),
    Claim(
        id="blacker-first-sparse",
        title="f = 0.95 converges before f = 0.55: ring, line, scale-free",
        sentence="A slight leftward shift in results when comparing f = 0.95 to f = 0.55 suggests that the former "
        "may be faster to estimate",
        section=TOPOLOGY,
        statistic="median K, f = 0.95 / f = 0.55, for each topology and accuracy",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(measures.blacker_first, topologies=measures.SPARSE),
        studies=("topologies",),
    ),
    Claim(
        id="blacker-first-full",
        title="f = 0.95 converges before f = 0.55: fully connected",
        sentence="A slight leftward shift in results when comparing f = 0.95 to f = 0.55 suggests that the former "
        "may be faster to estimate",
        section=TOPOLOGY,
        statistic="median K, f = 0.95 / f = 0.55, for each accuracy; the paper shows no figure of this topology "
        "at f = 0.95",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(measures.blacker_first, topologies=("full",)),
        studies=("topologies",),
        explanation=explanations.blacker_full,
    ),
    Claim(
        id="same-observations",
        title="R = 1 and R = 10 are alike after 10,000 observations",
        sentence="no noticeable gain in the higher rate of information exchange (C = 1,000 vs. C = 10,000) "
        "between robots when a fixed amount of T = C · R = 10,000 observations have been made",
        section=FREQUENCY,
        statistic="median K in observations and median error, R = 1 / R = 10, scale-free, for each accuracy and f",
        threshold="within 0.8 to 1.25",
        right=ALIKE,
        measure=measures.same_observations,
        studies=("topologies", "same-observations"),
    ),
    Claim(
        id="same-rounds",
        title="R = 1 is slower than R = 10 in 1,000 rounds",
        sentence="when a communication limit of C = 1,000 is imposed, our results indicate that premature "
        "communication slows estimate convergence",
        section=FREQUENCY,
        statistic="median K in rounds, R = 1 / R = 10, scale-free, for each accuracy and f",
        threshold="above 1",
        right=ABOVE_ONE,
        measure=measures.same_rounds,
        studies=("topologies", "same-rounds"),
    ),
    Claim(
        id="consensus",
        title="Scale-free: all robots are right by round 1,000 from 0.675 on",
        sentence="it eventually achieves consensus with robots of sensor accuracies ≥ 0.675 by 1,000 "
        "communication rounds",
        section=CONSENSUS,
        statistic="share of trials in which all 100 robots choose the right bin at round 1,000, for each b = w "
        "from 0.675 on and f; Wilson's interval",
        threshold="1, in 30 trials or more",
        right=(1.0, np.inf),
        measure=measures.consensus,
        studies=("topologies",),
    ),
    Claim(
        id="sooner-right",
        title="Ring and line are right before scale-free",
        sentence="For robots in the ring and line networks, accurate collective decision is similarly achieved, "
        "often faster than the scale-free network case",
        section=CONSENSUS,
        statistic="share of wrong robots less that on scale-free: its mean over the checkpoints and b = w from "
        "0.675 on, for each f",
        threshold="below 0",
        right=BELOW_ZERO,
        measure=measures.sooner_right,
        studies=("topologies",),
    ),
    *moving_claims.CLAIMS,
    Claim(
        id="minimal",
        title="Memory, message and computation grow with neither N nor time",
        sentence="The on-board memory and computational requirements are also constant (O(1))",
        section="III-D",
        statistic="growth from 10 to 1,000 robots and from 10 to 1,000,000 observations of the numbers kept and "
        "sent, and of the most lines that CPython runs for an observation, a message or a fusion; exact. A robot "
        "with more neighbours handles more messages, each at the same cost",
        threshold="0",
        right=BELOW_ZERO,
        measure=measures.minimal,
    ),
)
