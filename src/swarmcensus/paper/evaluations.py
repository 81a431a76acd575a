"""The evaluations that `reproduce` runs: the paper's own, and published results on rivals."""

from dataclasses import dataclass

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.paper import bayesian_claims, claims, number_claims, opinion_claims
from swarmcensus.paper.evidence import Claim
from swarmcensus.paper.figures import FIGURES, PaperFigure

RIVAL_CLAIMS: tuple[Claim, ...] = (*opinion_claims.CLAIMS, *bayesian_claims.CLAIMS, *number_claims.CLAIMS)


@dataclass(frozen=True)
class Evaluation:
    """Figures, claims and the texts of their page. `name` is also the folder of the studies."""

    name: str
    title: str
    lead: str
    source: str
    about: str
    symbols: str
    settings: str  # the settings that claims are about
    figures: tuple[PaperFigure, ...]
    claims: tuple[Claim, ...]
    section: str  # printed before the section of a claim
    quoted: bool  # whether sentences are quoted word for word

    @property
    def parts(self) -> tuple[str, ...]:
        """The names that --only takes."""
        return (*(figure.name for figure in self.figures), "claims")


def evaluation(name: str) -> Evaluation:
    """The evaluation with this name. Raises InputError."""
    if name not in EVALUATIONS:
        known = ", ".join(EVALUATIONS)
        raise InputError(f"there is no {name!r} to reproduce: {did_you_mean(name, EVALUATIONS)}known are {known}")
    return EVALUATIONS[name]


PAPER = Evaluation(
    name="paper",
    title="The paper, run again",
    lead="The results of a paper on swarms of robots with lying sensors, simulated again, drawn, and checked sentence "
    "by sentence.",
    source="Chin, Khaluf and Pinciroli, “Minimalistic Collective Perception with Imperfect Sensors”",
    about="its evaluation on fixed communication networks (Sec. IV-B) and with robots that move (Sec. IV-C)",
    symbols="N robots estimate f, the share of the floor that is black; b and w are the probabilities that a sensor "
    "reads black and white rightly. On a fixed network there are C communication rounds with R observations each. "
    "Robots that move observe and communicate once a tick, ten times a second, and their density is D = N π r² / L² "
    "in a square of side L, with radio range r. An estimate has converged at K (round or tick) if it then stays "
    "within 0.01 of its value there; its error is |x(K) - f|.",
    settings="100 robots on a fixed network, or 25 that move, unless it says otherwise",
    figures=FIGURES,
    claims=claims.CLAIMS,
    section="Sec. ",
    quoted=True,
)
RIVALS = Evaluation(
    name="rivals",
    title="The rivals, run again",
    lead="Published results on other algorithms for collective perception, simulated again and checked.",
    source="Published results on rivals of the minimalistic brain",
    about="orderings and effects stated in abstracts and reviews, in our words, checked on small studies of our own",
    symbols="f is the share of the floor that is black; b and w are the probabilities that a sensor reads black and "
    "white rightly. A robot that decides chooses black or white; a trial reaches a consensus when all honest robots "
    "have made the same choice.",
    settings="those of the studies in the folder rivals, whose files give numbers of robots and rounds",
    figures=(),
    claims=RIVAL_CLAIMS,
    section="",
    quoted=False,
)
EVALUATIONS = {each.name: each for each in (PAPER, RIVALS)}
