"""Claims as claims.json has them, in the words of pages."""

from swarmcensus.evaluation.paper import report
from swarmcensus.evaluation.paper.evidence import NEITHER, NO, YES, Detail


def detail(found):
    """A setting of a claim."""
    return Detail(found["setting"], found["value"], found["interval"], found["verdict"], found["made_of"])


def measured(found):
    """The value of a setting and its interval."""
    return " ".join(report.measured(detail(found))).strip()


def worst(claim):
    """The setting that supports a claim least."""
    return next(each for each in claim["settings"] if each["setting"] == claim["setting"])


def counts(claim):
    """How many settings say yes, no and neither, and how many are left out."""
    said = [setting["verdict"] for setting in claim["settings"]]
    numbers = [*(said.count(each) for each in (YES, NO, NEITHER)), len(claim["left_out"])]
    return ", ".join(map(str, numbers))
