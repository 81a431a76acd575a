"""docs/paper.md has the numbers of `swarmcensus reproduce`, as it prints them, and the engine still gives them.

Where a change was meant to alter numbers, run `swarmcensus reproduce` and `swarmcensus reproduce --trials 120`, write
the table again by `python benchmarks/claims.py paper`, and mend the page as these tests say.
"""

import json
import re

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.evaluation.paper import report
from swarmcensus.evaluation.paper.evaluations import PAPER
from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, MARGIN, MUCH, PARTLY, check
from swarmcensus.support.files import shipped_study
from tests.support.pages import OUR_C_LIBRARY, cells_of
from tests.support.places import DOCS

TEXT = (DOCS / "paper.md").read_text(encoding="utf-8")
CLAIMS = TEXT.partition("## Choices")[0]
FOUND = {row["claim"]: row for row in cells_of("paper-claims")}
KNOWN = {claim.title: claim for claim in PAPER.claims}


def test_the_table_has_every_claim():
    assert set(FOUND) == set(KNOWN)
    assert (MARGIN, MUCH) == (0.05, 1.25)
    for title, claim in KNOWN.items():
        assert FOUND[title]["needed"] == claim.needed.words
        assert FOUND[title]["statistic"] == claim.statistic.replace(";", ",")


def test_claims_are_whole_sentences():
    for claim in PAPER.claims:
        assert re.fullmatch(r"[A-Z].*\.", claim.sentence)


def test_the_page_shows_claims_that_do_not_hold_everywhere():
    shown = re.findall(r"^\| ([^|]*) \| [-\d.]+ \| [-\d.]+ \|", CLAIMS, re.MULTILINE)
    assert shown == [title for title, row in FOUND.items() if row["verdict"] != HOLDS]


def test_verdicts_are_counted():
    verdicts = [row["verdict"] for row in FOUND.values()]
    holds, part, fails = (verdicts.count(verdict) for verdict in (HOLDS, PARTLY, FAILS))
    assert f"Of {len(FOUND)} claims {holds} hold, {part} hold in part, and {fails} do not hold" in " ".join(
        TEXT.split()
    )


def test_explanations_are_those_of_the_claims():
    said = " ".join(TEXT.replace("*", "").split())
    told = [claim.explanation for claim in PAPER.claims if FOUND[claim.title]["verdict"] != HOLDS]
    assert any(told)
    assert all(explanation in said for explanation in told)


def test_numbers_in_the_prose():
    prose = " ".join(line for line in CLAIMS.splitlines() if line.strip()[:1] not in ("|", ">", "!"))
    prose = re.sub(r"\]\([^)]*\)|\*?\b[fbw]\*? (= \*w\* )?= \*?[\d.]+(, [\d.]+)*", "", prose)
    intervals = re.findall(r"(-?[\d.]+) \[([^][]*), ([^][]*)\]", prose)
    assert intervals
    assert set(intervals) <= {(row["value"], row["low"], row["high"]) for row in FOUND.values()}
    rest = re.sub(r"-?[\d.]+ \[[^][]*\]", "", prose)
    behind = " ".join(row["against it"] for row in FOUND.values())
    defined = {"0.95", "1.05", "0.05", "0.8", "1.25", "5 %", "95 %", "0.525"}  # margins, the interval's level, a sensor
    assert set(re.findall(r"\d+\.\d+|\d+ %", rest)) <= defined | set(re.findall(r"\d+\.\d+|\d+ %", behind))


def again(name, *changes):
    """A few settings of a study of the paper, with all their trials, as the engine runs them now."""
    text = (shipped_study("paper") / f"{name}.toml").read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    return sc.run(sc.Study.parse(text))


@pytest.fixture(scope="module")
def moving():
    return again("moving", ("[1, 10]", "1"), ("0.575, 0.625, 0.675, 0.725, 0.775, 0.825, 0.875, ", ""))


@pytest.fixture(scope="module")
def topologies():
    return again("topologies", ("[10, 100]", "100"), ('"line", ', ""))


@pytest.mark.long
def test_the_engine_gives_the_numbers_of_the_table(moving, topologies, benchmark):
    """Those claims that these settings suffice for."""
    data = {"topologies": topologies, "moving": moving}
    outcomes = check(data, [claim for claim in PAPER.claims if claim.studies])
    about = json.loads(report.as_json(outcomes, data, PAPER.source))
    found = {claim["id"]: claim for claim in about["claims"] if claim["settings"]}
    fixed = {"low-error-055", "ring-like-tree", "low-error-095", "blacker-first", "consensus"}
    assert set(found) == fixed | {"few-unheard-moving"}
    for row in benchmark("claims").rows([found[name] for name in found if name in fixed or OUR_C_LIBRARY]):
        assert row.items() <= FOUND[row["claim"]].items()


@pytest.mark.long
def test_fully_connected_robots_err_least_in_the_end(topologies):
    """As the page says of f = 0.95, where their errors at K are not the least."""
    black = topologies.isel(setting=(topologies.fill_ratio == 0.95).values)
    errors = abs(black.final_estimate - 0.95).median(["trial", "robot"])
    full, ring, tree = (errors.values[black.topology == name] for name in ("full", "ring", "scale-free"))
    assert (full < np.minimum(ring, tree)).all()


@pytest.mark.long
@pytest.mark.skipif(not OUR_C_LIBRARY, reason="a walk goes another way where a sine differs in its last bit")
def test_settings_of_one_walk_are_correlated(moving):
    of = {a: (moving.accuracy == a).values & (moving.fill_ratio == 0.55).values for a in ("0.925", "0.975")}
    one, other = (moving.final_estimate.values[k][0][:, :25].mean(axis=1) for k in of.values())
    page = " ".join((DOCS / "moving-robots.md").read_text(encoding="utf-8").split())
    assert f"are correlated by {np.corrcoef(one, other)[0, 1]:.2f} at *D* = 1" in page
