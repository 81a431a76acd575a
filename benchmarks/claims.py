"""Tables of what `swarmcensus reproduce` says of claims: python benchmarks/claims.py QUESTION.

A row is a claim, with the setting that supports it least. Claims that do not hold everywhere come first.
"""

import json
from pathlib import Path

import harness
import numpy as np

from swarmcensus.evaluation.paper import report
from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, NEITHER, NO, PARTLY, UNDECIDED, UNMEASURED, YES, Detail

HEADS = ("claim", "value", "low", "high", "needed", "yes", "no", "neither", "left out", "verdict")
MORE = ("setting", "against it", "statistic")
ORDER = (FAILS, PARTLY, UNDECIDED, UNMEASURED, HOLDS)


def rows(claims):
    """Claims as claims.json has them, each as its row by the titles of columns."""
    found = [_row(claim) for claim in claims]
    return sorted(found, key=lambda row: ORDER.index(row["verdict"]))


def _row(claim):
    """One claim: values are rounded as the command prints them, and the same in all trials has no interval."""
    settings = claim["settings"]
    worst = next(each for each in settings if each["setting"] == claim["setting"])
    middle, *ends = (np.nan if x is None else x for x in (worst["value"], *(worst["interval"] or ())))  # of few trials
    detail = Detail(worst["setting"], middle, tuple(ends) or None, worst["verdict"], worst["made_of"])
    value, interval = report.value_and_interval(detail)
    low, _, high = interval.strip("[]").partition(", ")
    said = [each["verdict"] for each in settings]
    against = [_against(each) for each in settings if each["verdict"] == NO]
    texts = (claim["threshold"], *(str(said.count(each)) for each in (YES, NO, NEITHER)), str(len(claim["left_out"])))
    cells = (claim["title"], value, low, high, *texts, claim["verdict"], worst["setting"])
    more = [text.replace(";", ",") for text in (" / ".join(against), claim["statistic"])]
    return dict(zip(HEADS + MORE, (*cells, *more), strict=True))


def _against(setting):
    """A setting against a claim, and the two numbers that are compared."""
    return setting["setting"] + (f": {setting['made_of']}" if setting["made_of"] else "")


def claims_in(folder):
    """The claims of a folder that `reproduce` wrote."""
    return json.loads((Path(folder) / "claims.json").read_text(encoding="utf-8"))["claims"]


def write(name, found):
    """Write rows to a file of benchmarks/tables."""
    harness.write_csv(name, found[0], [row.values() for row in found])


@harness.question(unasked=False)
def paper(folder, more):
    """Claims of the paper: FOLDER is of `swarmcensus reproduce`, MORE of the same with `--trials 120`."""
    again = {row["claim"]: row for row in rows(claims_in(more))}
    found = rows(claims_in(folder))
    for row in found:
        of = again[row["claim"]]
        row |= {f"{head} (120 trials)": of[head] for head in (*HEADS[1:4], *HEADS[5:], "against it")}
    write("paper-claims", found)


@harness.question(unasked=False)
def rivals(folder):
    """Claims that were published about rivals: FOLDER is of `swarmcensus reproduce rivals`."""
    sources = {claim["title"]: claim["section"] for claim in claims_in(folder)}
    write("rivals-claims", [row | {"source": sources[row["claim"]]} for row in rows(claims_in(folder))])


if __name__ == "__main__":
    harness.answer(globals())
