"""Published results on consensus on a number and on filters, by the same rules as in `claims`."""

from functools import partial

import numpy as np

from swarmcensus.paper import rival_explanations as explained
from swarmcensus.paper import rival_measures as measures
from swarmcensus.paper.evidence import ABOVE_ONE, ALIKE, BELOW_ONE, Claim

SHAN = "Shan and Mostaghim 2024, abstract"
LEBLANC = "LeBlanc, Zhang, Koutsoukos and Sundaram 2013, as generally known, not checked"
BELIEFS = ("beliefs", {"brain": "belief-sharing", "every": 10.0})
LINEAR = [("beliefs", {"brain": "linear-consensus", "phase": phase}) for phase in (10.0, 450.0)]
FILLS = [{"fill_ratio": f} for f in (0.55, 0.6, 0.75)]
NETWORKS = ("full", "circulant_graph(offsets=[1, 2, 3])")
TRIMMED, PLAIN = ("liars", {"brain": "w-msr"}), ("liars", {"brain": "linear-consensus"})
SENSORS = [{"accuracy": a, "fill_ratio": f} for a in ("0.7", "U(0.525,0.975)") for f in (0.35, 0.55)]


CLAIMS: tuple[Claim, ...] = (
    Claim(
        id="beliefs-closer",
        title="Belief sharing errs less than linear consensus",
        sentence="Distributed Bayesian belief sharing beats linear consensus in error.",
        section=SHAN,
        statistic="mean final error, belief sharing / linear consensus with phases of 1 s and 45 s, for each f",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(measures.ratios, of=measures.final_error, first=BELIEFS, others=LINEAR, worlds=FILLS),
        studies=("beliefs",),
        explanation=explained.soon_settled,
    ),
    Claim(
        id="beliefs-sooner",
        title="Belief sharing settles before linear consensus",
        sentence="Distributed Bayesian belief sharing beats linear consensus in time.",
        section=SHAN,
        statistic="median K, belief sharing / linear consensus with phases of 1 s and 45 s, for each f",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(measures.ratios, of=measures.settling_time, first=BELIEFS, others=LINEAR, worlds=FILLS),
        studies=("beliefs",),
    ),
    Claim(
        id="trimming-bears",
        title="W-MSR errs less than linear consensus among liars",
        sentence="Robots that drop the F largest and the F smallest values bear up to F liars, and others do not.",
        section=LEBLANC,
        statistic="mean final error, W-MSR with F = 2 / linear consensus, for one and two liars and each network",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(
            measures.ratios,
            of=measures.final_error,
            first=TRIMMED,
            others=[PLAIN],
            worlds=[{"topology": t, "liars": n} for t in NETWORKS for n in (1, 2)],
        ),
        studies=("liars",),
    ),
    Claim(
        id="trimming-unmoved",
        title="W-MSR stays among what honest robots hold",
        sentence="Where a network is robust enough, up to F liars do not move robots out of what honest ones hold.",
        section=LEBLANC,
        statistic="mean final error of W-MSR with F = 2, for one and two liars and each network; honest robots hold "
        "shares of a hundred readings, whose standard deviation is 0.043",
        threshold="below 0.043",
        right=(-np.inf, 0.043),
        measure=partial(
            measures.numbers,
            of=measures.final_error,
            contenders=[TRIMMED],
            worlds=[{"topology": t, "liars": n} for t in NETWORKS for n in (1, 2)],
        ),
        studies=("liars",),
    ),
    Claim(
        id="trimming-no-more",
        title="W-MSR does not bear more than F liars that all hear",
        sentence="The promise of W-MSR ends at F liars beside a robot.",
        section=LEBLANC,
        statistic="mean final error of W-MSR with F = 2 on the full network, with three liars / with two",
        threshold="above 1",
        right=ABOVE_ONE,
        measure=partial(
            measures.growths,
            of=measures.final_error,
            contenders=[TRIMMED],
            worlds=[({"topology": "full", "liars": 2}, {"topology": "full", "liars": 3})],
        ),
        studies=("liars",),
    ),
    Claim(
        id="filter-pools",
        title="The information filter pools all readings of a full network",
        sentence="Where everybody hears every reading once, the information filter is as one robot that makes all of "
        "them.",
        section="Rao, Durrant-Whyte and Sheen 1993, as generally known, not checked",
        statistic="mean final error, information filter / all readings pooled, on the full network, for each f and "
        "accuracy",
        threshold="within 0.8 to 1.25",
        right=ALIKE,
        measure=partial(
            measures.ratios,
            of=measures.final_error,
            first=("filters", {"brain": "information-filter"}),
            others=[("filters", {"brain": "oracle"})],
            worlds=[{"topology": "full", **world} for world in SENSORS],
        ),
        studies=("filters",),
    ),
    Claim(
        id="innovations-losses",
        title="Consensus + innovations gains where most messages are lost",
        sentence="Consensus with innovations works on networks that are connected on average alone.",
        section="Kar and Moura 2013, as generally known, not checked",
        statistic="mean final error, consensus + innovations / a robot alone, on a ring where one message in five gets "
        "through, for each f and accuracy",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(
            measures.ratios,
            of=measures.final_error,
            first=("filters", {"brain": "consensus-innovations"}),
            others=[("filters", {"brain": "alone"})],
            worlds=[{"topology": "ring", **world} for world in SENSORS],
        ),
        studies=("filters",),
    ),
)
