"""Published results on rules for opinions, by the same rules as in `claims`."""

from functools import partial

import numpy as np

from swarmcensus.paper import rival_explanations as explained
from swarmcensus.paper import rival_measures as measures
from swarmcensus.paper.evidence import ABOVE_ONE, BELOW_ONE, BELOW_ZERO, Claim
from swarmcensus.paper.rival_measures import Contender

VALENTINI = "Valentini, Brambilla, Hamann and Dorigo 2016, as generally known, not checked"
ZAKIR = "Zakir, Dorigo and Reina 2022, abstract"
CROSSCOMBE = "Crosscombe, Lawry, Hauert and Homer 2017, abstract"
ABOVE_ZERO, HALF_OR_MORE, LESS_THAN_HALF = (0.0, np.inf), (0.5, np.inf), (-np.inf, 0.5)
LITTLE = 0.05  # of accuracy
NEVER = "a trial without one counts as its last round"

EASY, HARD = {"fill_ratio": 0.66, "floor": "tiles"}, {"fill_ratio": 0.55, "floor": "tiles"}
PIECE = {"fill_ratio": 0.66, "floor": "half"}
VOTER, MAJORITY, DIRECT = (("opinions", {"brain": b}) for b in ("voter", "majority", "direct-comparison"))
SWITCHING, CROSSING = (
    [("switching", {"brain": brain, "miscommunication": noise}) for noise in (0.0, 0.15)]
    for brain in ("direct-switching", "cross-inhibition")
)
EVEN, ASYMMETRIC = [{"fill_ratio": 0.5}], [{"fill_ratio": 0.6}, {"fill_ratio": 0.8}]
THREE: Contender = ("three-valued", {})
BOOLEAN: Contender = ("boolean", {})
BINS = [{"fill_ratio": 0.25, "liars": 0}, {"fill_ratio": 0.55, "liars": 0}]

CLAIMS: tuple[Claim, ...] = (
    Claim(
        id="majority-sooner",
        title="The majority rule agrees before the voter",
        sentence="Majority decisions (DMMD) are faster than those of the weighted voter (DMVD).",
        section=VALENTINI,
        statistic=f"median time to a consensus, majority / voter, for each floor; {NEVER}",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(
            measures.ratios, of=measures.consensus_time, first=MAJORITY, others=[VOTER], worlds=[EASY, HARD]
        ),
        studies=("opinions",),
    ),
    Claim(
        id="voter-more-accurate",
        title="The voter is right more often than the majority rule",
        sentence="The weighted voter (DMVD) is slower, and more accurate.",
        section=VALENTINI,
        statistic="share of trials whose consensus is right, voter less majority, for each floor",
        threshold="above 0",
        right=ABOVE_ZERO,
        measure=partial(
            measures.differences, of=measures.consensus_right, first=VOTER, others=[MAJORITY], worlds=[EASY, HARD]
        ),
        studies=("opinions",),
    ),
    Claim(
        id="direct-sooner",
        title="Direct comparison agrees first where it is easy",
        sentence="Direct comparison is fast.",
        section=VALENTINI,
        statistic=f"median time to a consensus, direct comparison / other rule, at f = 0.66; {NEVER}",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(
            measures.ratios, of=measures.consensus_time, first=DIRECT, others=[VOTER, MAJORITY], worlds=[EASY]
        ),
        studies=("opinions",),
    ),
    Claim(
        id="direct-less-accurate",
        title="Direct comparison is right less often where it is hard",
        sentence="Direct comparison is less accurate than the others where both colours are nearly even.",
        section=VALENTINI,
        statistic="share of trials whose consensus is right, direct comparison less other rule, at f = 0.55",
        threshold="below 0",
        right=BELOW_ZERO,
        measure=partial(
            measures.differences, of=measures.consensus_right, first=DIRECT, others=[VOTER, MAJORITY], worlds=[HARD]
        ),
        studies=("opinions",),
        explanation=explained.quality_helps,
    ),
    Claim(
        id="pattern-matters",
        title="The floor's pattern matters as much as its share of black",
        sentence="How hard a floor is depends on its pattern as much as on its share of black.",
        section="Bartashevich and Mostaghim 2019, as generally known, not checked",
        statistic="how many times as long a consensus takes with black in one piece, over how many times as long it "
        f"takes at 0.55 in place of 0.66, for each rule; {NEVER}",
        threshold="above 0.8",
        right=(0.8, np.inf),
        measure=partial(
            measures.pattern_against_share,
            contenders=[VOTER, MAJORITY, DIRECT],
            patterned=PIECE,
            plain=EASY,
            harder=HARD,
        ),
        studies=("opinions",),
        explanation=explained.patterns,
    ),
    Claim(
        id="cross-inhibition-breaks",
        title="Cross-inhibition breaks the deadlock at f = 0.5",
        sentence="Robots with cross-inhibition come to a consensus where both colours are alike.",
        section=ZAKIR,
        statistic="share of trials that end with four in five robots of one colour, at f = 0.5, without and with "
        "miscommunication",
        threshold="above one half",
        right=HALF_OR_MORE,
        measure=partial(measures.numbers, of=measures.quorums, contenders=CROSSING, worlds=EVEN),
        studies=("switching",),
        explanation=explained.wrong_messages,
    ),
    Claim(
        id="switching-deadlock",
        title="Direct switching stays in the deadlock at f = 0.5",
        sentence="Robots that switch directly come to no consensus where both colours are alike.",
        section=ZAKIR,
        statistic="share of trials that end with four in five robots of one colour, at f = 0.5, without and with "
        "miscommunication",
        threshold="below one half",
        right=LESS_THAN_HALF,
        measure=partial(measures.numbers, of=measures.quorums, contenders=SWITCHING, worlds=EVEN),
        studies=("switching",),
        explanation=explained.wrong_messages,
    ),
    Claim(
        id="switching-asymmetric",
        title="Direct switching agrees where one colour prevails",
        sentence="Robots that switch directly come to a consensus in asymmetric environments.",
        section=ZAKIR,
        statistic="share of trials that end with four in five robots of one colour, for each f, without and with "
        "miscommunication",
        threshold="above one half",
        right=HALF_OR_MORE,
        measure=partial(measures.numbers, of=measures.quorums, contenders=SWITCHING, worlds=ASYMMETRIC),
        studies=("switching",),
        explanation=explained.wrong_messages,
    ),
    Claim(
        id="three-as-accurate",
        title="Three-valued opinions are as accurate as Boolean ones",
        sentence="A third truth value costs no accuracy.",
        section=CROSSCOMBE,
        statistic="share of robots decided for the right bin at the end, three-valued less Boolean, for each f",
        threshold="within -0.05 to 0.05",
        right=(-LITTLE, LITTLE),
        measure=partial(measures.differences, of=measures.right_robots, first=THREE, others=[BOOLEAN], worlds=BINS),
        studies=("three-valued", "boolean"),
        explanation=explained.neighbouring_bins,
    ),
    Claim(
        id="three-slower",
        title="Three-valued opinions are slower than Boolean ones",
        sentence="With a third truth value robots take longer to agree.",
        section=CROSSCOMBE,
        statistic=f"median time to a consensus, three-valued / Boolean, for each f; {NEVER}",
        threshold="above 1",
        right=ABOVE_ONE,
        measure=partial(measures.ratios, of=measures.consensus_time, first=THREE, others=[BOOLEAN], worlds=BINS),
        studies=("three-valued", "boolean"),
        explanation=explained.early_robots,
    ),
    Claim(
        id="three-robust",
        title="Three-valued opinions suffer less from malfunction",
        sentence="With a third truth value swarms are more robust to malfunction.",
        section=CROSSCOMBE,
        statistic="share of robots decided for the right bin that a tenth of malfunctioning ones costs, Boolean less "
        "three-valued, for each f",
        threshold="above 0",
        right=ABOVE_ZERO,
        measure=partial(
            measures.spared, first=THREE, second=BOOLEAN, worlds=[{"fill_ratio": f} for f in (0.25, 0.55)], liars=5
        ),
        studies=("three-valued", "boolean"),
    ),
)
