"""What was published and is run again: the paper's own evaluation, and what the rivals' papers say of each other."""

from dataclasses import dataclass

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.paper import claims, rival_claims
from swarmcensus.paper.evidence import Claim
from swarmcensus.paper.figures import FIGURES, PaperFigure


@dataclass(frozen=True)
class Evaluation:
    """Figures and claims, and what the page says of them; `name` is that of the folder of studies too."""

    name: str
    title: str
    lead: str
    source: str
    about: str
    symbols: str
    spoken_of: str  # which settings claims speak of
    figures: tuple[PaperFigure, ...]
    claims: tuple[Claim, ...]
    section: str  # what stands before a claim's section
    quoted: bool  # whether sentences are quoted word for word

    @property
    def parts(self) -> tuple[str, ...]:
        """What can be asked for by itself."""
        return (*(figure.name for figure in self.figures), "claims")


def evaluation(name: str) -> Evaluation:
    """The evaluation of a name. Raises InputError."""
    if name not in EVALUATIONS:
        known = ", ".join(EVALUATIONS)
        raise InputError(f"there is no {name!r} to reproduce: {did_you_mean(name, EVALUATIONS)}known are {known}")
    return EVALUATIONS[name]


PAPER = Evaluation(
    name="paper",
    title="The paper, run again",
    lead="What a paper says about swarms of robots with lying sensors, simulated afresh, drawn, and checked sentence "
    "by sentence.",
    source="Chin, Khaluf and Pinciroli, “Minimalistic Collective Perception with Imperfect Sensors”",
    about="its evaluation on fixed communication networks (Sec. IV-B) and with robots that move (Sec. IV-C)",
    symbols="N robots estimate f, the share of the floor that is black; b and w are how often their sensors are right "
    "about black and about white. On a fixed network they live C communication rounds, with R observations in each; "
    "robots that move observe and talk once a tick, ten times a second, and their density is D = N π r² / L² in a "
    "square of side L, with radios that reach r. An estimate has converged at K (round or tick) when it stays within "
    "0.01 of what it was there; its error is |x(K) - f|.",
    spoken_of="100 robots on a fixed network, or 25 that move, unless it says otherwise",
    figures=FIGURES,
    claims=claims.CLAIMS,
    section="Sec. ",
    quoted=True,
)
RIVALS = Evaluation(
    name="rivals",
    title="The rivals, run again",
    lead="What papers say about other algorithms for collective perception, simulated afresh and checked.",
    source="Published results on rivals of the minimalistic brain",
    about="orderings and effects as abstracts and reviews tell them, here in our words, on small studies of our own",
    symbols="f is the share of the floor that is black; b and w are how often sensors are right about black and about "
    "white. A robot that decides is for black or for white; a trial ends in a consensus when all honest robots have "
    "decided for the same.",
    spoken_of="those of the studies named rivals, whose files say how many robots live how long",
    figures=(),
    claims=rival_claims.CLAIMS,
    section="",
    quoted=False,
)
EVALUATIONS = {one.name: one for one in (PAPER, RIVALS)}
