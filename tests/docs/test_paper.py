"""docs/paper.md has the numbers of `swarmcensus reproduce`, as it prints them, and the engine still gives them.

Where a change was meant to alter numbers, run `swarmcensus reproduce` and `swarmcensus reproduce --trials 120`, copy
their claims.json to docs/paper-claims.json and docs/paper-claims-120.json, and mend the page as these tests say.
"""

import json
import re
from collections import Counter

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.evaluation.paper import report
from swarmcensus.evaluation.paper.evaluations import PAPER
from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, NO, OPEN, YES, Detail, check
from swarmcensus.evaluation.paper.measures import NUMBERS
from swarmcensus.support.files import shipped_study
from tests.support.pages import OUR_C_LIBRARY
from tests.support.places import DOCS

TEXT = (DOCS / "paper.md").read_text(encoding="utf-8")
VERDICTS = {HOLDS: "holds", FAILS: "**does not hold**"}
FOUND, MORE = (
    {claim["id"]: claim for claim in json.loads((DOCS / name).read_text(encoding="utf-8"))["claims"]}
    for name in ("paper-claims.json", "paper-claims-120.json")
)


def detail(found):
    interval = found["interval"] and tuple(found["interval"])
    return Detail(found["setting"], found["value"], interval, found["verdict"])


def worst(claim):
    return next(each for each in claim["settings"] if each["setting"] == claim["setting"])


def measured(found):
    return " ".join(report.measured(detail(found))).strip()


def counts(claim):
    said = Counter(setting["verdict"] for setting in claim["settings"])
    return ", ".join(str(said[verdict]) for verdict in (YES, NO, OPEN))


def verdict(claim):
    return VERDICTS.get(claim["verdict"], "open")


def settings(claim, said):
    return "; ".join(each["setting"] for each in claim["settings"] if each["verdict"] == said) or "none"


def tables():
    """The page's tables of claims, each as cells by title."""
    for text in TEXT.split("| the paper says ")[1:]:
        lines = text.partition("\n\n")[0].splitlines()[2:]
        cells = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines]
        yield {title: rest for title, *rest in cells}


def test_claim_files_are_complete():
    for found, name, trials in ((FOUND, "paper-claims.json", 30), (MORE, "paper-claims-120.json", 120)):
        about = json.loads((DOCS / name).read_text(encoding="utf-8"))
        assert list(found) == [claim.id for claim in PAPER.claims]
        assert {(each["seed"], each["trials"]) for each in about["studies"].values()} == {(2023, trials)}
        for claim in PAPER.claims:
            texts = ("title", "sentence", "section", "statistic", "threshold")
            assert all(found[claim.id][key] == getattr(claim, key) for key in texts)


def test_the_tables_are_what_the_command_prints():
    fixed, moving, _ = tables()
    found = {c["title"]: [measured(worst(c)), c["threshold"], counts(c), verdict(c)] for c in FOUND.values()}
    assert {title: cells[1:] for title, cells in (fixed | moving).items()} == found
    assert {title for title in found if title.startswith("Moving")} == set(moving)


def test_table_of_more_trials_lists_claims_that_do_not_hold():
    *_, more = tables()
    found = {
        c["title"]: [measured(worst(c)), counts(c), verdict(c), settings(c, NO), settings(c, OPEN)]
        for c in MORE.values()
        if not c["verdict"] == FOUND[c["id"]]["verdict"] == HOLDS
    }
    assert more == found


def test_verdicts_are_counted():
    kinds = Counter(verdict(claim) for claim in FOUND.values())
    summary = " ".join(TEXT.split())
    assert (
        f"Of {len(FOUND)} claims {kinds['holds']} hold, {kinds[VERDICTS[FAILS]]} do not, and {kinds['open']} cannot "
        "be told from 30 trials"
    ) in summary


def test_explanations_are_quoted_word_for_word():
    quoted = " ".join(re.sub(r"^> ?", "", TEXT, flags=re.MULTILINE).split())
    for claim in FOUND.values():
        assert claim["explanation"] in quoted
    for name in ("grows-moving", "impaired-moving", "mixed-sooner-moving", "like-tree-moving"):
        assert FOUND[name]["note"] in quoted


def test_numbers_in_the_prose():
    prose = " ".join(line for line in TEXT.splitlines() if line[:1] not in ("|", ">", "!"))
    prose = re.sub(r"\]\([^)]*\)|U\(0\.525, 0\.975\)|\*?\b[fbw]\*? (= \*w\* )?= \*?[\d.]+(, [\d.]+)*", "", prose)
    found = {measured(s) for each in (FOUND, MORE) for c in each.values() for s in c["settings"]}
    intervals = re.findall(r"-?[\d.]+ \[[^]]*\]", prose)
    assert intervals
    assert set(intervals) <= found
    rest = re.sub(r"-?[\d.]+ \[[^]]*\]", "", prose)
    defined = {"0.8", "1.25", "0.05", "95 %", "0.75"}  # margins, a threshold, the interval's level, a mean of U
    assert set(re.findall(r"\d+\.\d+|\d+ %", rest)) <= {*NUMBERS, "0.55", "0.95"} | defined


def again(name, *changes):
    """A few settings of a study of the paper, with all their trials, as the engine runs them now."""
    text = (shipped_study("paper") / f"{name}.toml").read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    return sc.run(sc.Study.parse(text))


@pytest.fixture(scope="module")
def moving():
    return again("moving", ("[1, 10]", "1"), ("0.525, 0.575, 0.625, 0.675, 0.725, 0.775, 0.825, 0.875, ", ""))


@pytest.fixture(scope="module")
def claims_again(moving):
    """What is said now of the claims that these settings suffice for."""
    topologies = again("topologies", ("[10, 100]", "100"), (', "ring", "line", "scale-free"', ""))
    data = {"topologies": topologies, "moving": moving}
    outcomes = check(data, [claim for claim in PAPER.claims if claim.studies])
    about = json.loads(report.as_json(outcomes, data, PAPER.source))
    return {claim["id"]: claim for claim in about["claims"] if claim["settings"]}


@pytest.mark.long
def test_the_engine_gives_the_numbers_of_the_page(claims_again):
    found = claims_again
    assert set(found) == {"blacker-first-full", "mixed-consensus-moving"}
    for name in sorted(found):
        if "moving" not in name or OUR_C_LIBRARY:
            assert found[name]["settings"] == FOUND[name]["settings"]


@pytest.mark.long
@pytest.mark.skipif(not OUR_C_LIBRARY, reason="a walk goes another way where a sine differs in its last bit")
def test_settings_of_one_walk_are_correlated(moving):
    of = {a: (moving.accuracy == a).values & (moving.fill_ratio == 0.55).values for a in ("0.925", "0.975")}
    one, other = (moving.final_estimate.values[k][0][:, :25].mean(axis=1) for k in of.values())
    page = " ".join((DOCS / "moving-robots.md").read_text(encoding="utf-8").split())
    assert f"are correlated by {np.corrcoef(one, other)[0, 1]:.2f} at *D* = 1" in page
