"""Published results on Bayesian robots that decide, by the same rules as in `claims`."""

from functools import partial

import numpy as np

from swarmcensus.paper import rival_explanations as explained
from swarmcensus.paper import rival_measures as measures
from swarmcensus.paper.evidence import BELOW_ONE, Claim
from swarmcensus.paper.rival_measures import Contender

EBERT = "Ebert, Gauci, Mallmann-Trenn and Nagpal 2020, abstract"
SOFT = "arXiv 2404.08390, abstract"
ABOVE_ZERO, HALF_OR_MORE, LESS_THAN_HALF = (0.0, np.inf), (0.5, np.inf), (-np.inf, 0.5)
LITTLE = 0.05  # of accuracy
BOT = {"feedback": 0.0, "prior": 10.0, "threshold": 0.95, "every": 200.0}
BOTS = [{"fill_ratio": 0.55}, {"fill_ratio": 0.6}]
SOFT_WORLDS = [{"fill_ratio": 0.52}, {"fill_ratio": 0.55}]
CHANGES = [{"fill_ratio": f} for f in (0.1, 0.3, 0.4, 0.45)]


def bot(**other: float) -> Contender:
    """Bayes Bots with these parameters in place of the usual ones."""
    return "bayes-bots", BOT | other


def soft(feedback: float) -> Contender:
    """Those of the study of soft feedback."""
    return "soft-feedback", {"feedback": feedback}


CLAIMS: tuple[Claim, ...] = (
    Claim(
        id="bots-rare-looks",
        title="Bayes Bots: rare looks make decisions right more often",
        sentence="Fewer, less correlated observations improve accuracy.",
        section=EBERT,
        statistic="share of decided robots that are right, a look in 20 s less one a second, for each f",
        threshold="above 0",
        right=ABOVE_ZERO,
        measure=partial(
            measures.differences, of=measures.right_deciders, first=bot(), others=[bot(every=10.0)], worlds=BOTS
        ),
        studies=("bayes-bots",),
    ),
    Claim(
        id="bots-bold-sooner",
        title="Bayes Bots: a low threshold and a weak prior are fast",
        sentence="A well-chosen prior and threshold make decisions faster.",
        section=EBERT,
        statistic="mean time of a first decision, threshold 0.95 and prior 10 / threshold 0.99 or prior 40, for each "
        "f; who never decides counts as the last round",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(
            measures.ratios,
            of=measures.decision_time,
            first=bot(),
            others=[bot(threshold=0.99), bot(prior=40.0)],
            worlds=BOTS,
        ),
        studies=("bayes-bots",),
    ),
    Claim(
        id="bots-bold-accurate",
        title="Bayes Bots: a low threshold and a weak prior cost little",
        sentence="The speed that prior and threshold buy costs little accuracy.",
        section=EBERT,
        statistic="share of decided robots that are right, threshold 0.95 and prior 10 less threshold 0.99 or prior "
        "40, for each f",
        threshold="above -0.05",
        right=(-LITTLE, np.inf),
        measure=partial(
            measures.differences,
            of=measures.right_deciders,
            first=bot(),
            others=[bot(threshold=0.99), bot(prior=40.0)],
            worlds=BOTS,
        ),
        studies=("bayes-bots",),
        explanation=explained.little_evidence,
    ),
    Claim(
        id="bots-feedback-sooner",
        title="Bayes Bots: positive feedback is fast",
        sentence="Positive feedback makes decisions faster.",
        section=EBERT,
        statistic="mean time of a first decision, with feedback / without, for each f; who never decides counts as "
        "the last round",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(
            measures.ratios, of=measures.decision_time, first=bot(feedback=1.0), others=[bot()], worlds=BOTS
        ),
        studies=("bayes-bots",),
    ),
    Claim(
        id="bots-feedback-accurate",
        title="Bayes Bots: positive feedback is accurate",
        sentence="Positive feedback makes decisions more accurate.",
        section=EBERT,
        statistic="share of decided robots that are right, with feedback less without, for each f",
        threshold="above 0",
        right=ABOVE_ZERO,
        measure=partial(
            measures.differences, of=measures.right_deciders, first=bot(feedback=1.0), others=[bot()], worlds=BOTS
        ),
        studies=("bayes-bots",),
    ),
    Claim(
        id="soft-sooner",
        title="Soft feedback decides sooner",
        sentence="Soft feedback brings the mean decision forward.",
        section=SOFT,
        statistic="mean time of a first decision, soft feedback / none, for each f; who never decides counts as the "
        "last round",
        threshold="below 1",
        right=BELOW_ONE,
        measure=partial(
            measures.ratios, of=measures.decision_time, first=soft(2.0), others=[soft(0.0)], worlds=SOFT_WORLDS
        ),
        studies=("soft-feedback",),
    ),
    Claim(
        id="soft-a-fifth",
        title="Soft feedback saves a fifth of the time where it is hard",
        sentence="Decisions come up to 20.52 % sooner.",
        section=SOFT,
        statistic="mean time of a first decision, soft feedback / none, at f = 0.52; who never decides counts as the "
        "last round",
        threshold="below 0.7948",
        right=(-np.inf, 0.7948),
        measure=partial(
            measures.ratios, of=measures.decision_time, first=soft(2.0), others=[soft(0.0)], worlds=SOFT_WORLDS[:1]
        ),
        studies=("soft-feedback",),
    ),
    Claim(
        id="soft-accurate",
        title="Soft feedback costs little accuracy",
        sentence="The gain in time costs 0.78 % of accuracy.",
        section=SOFT,
        statistic="share of robots decided for the right colour at the end, soft feedback less none, for each f; the "
        "margin is ours",
        threshold="above -0.05",
        right=(-LITTLE, np.inf),
        measure=partial(
            measures.differences, of=measures.right_robots, first=soft(2.0), others=[soft(0.0)], worlds=SOFT_WORLDS
        ),
        studies=("soft-feedback",),
    ),
    Claim(
        id="change-followed",
        title="Robots that give up decisions follow a floor that changes",
        sentence="Who goes back on a decision that it believes in no more comes to be right after a change, where "
        "Bayes Bots do not.",
        section="Pfister and Hamann 2022, what the method is for, not checked as a result",
        statistic="share of robots decided for the right colour 200 looks after the change, such robots less Bayes "
        "Bots, for each change",
        threshold="above 0",
        right=ABOVE_ZERO,
        measure=partial(
            measures.differences,
            of=measures.right_robots,
            first=("changing", {"brain": "changing-floor"}),
            others=[("changing", {"brain": "bayes-bots"})],
            worlds=CHANGES,
        ),
        studies=("changing",),
    ),
)
