"""docs/paper.md has the numbers of `swarmcensus reproduce`, as it prints them, and the engine still gives them.

Where a change was meant to alter numbers, run `swarmcensus reproduce` and `swarmcensus reproduce --trials 120`, copy
their claims.json to docs/paper-claims.json and docs/paper-claims-120.json, and mend the page as these tests say.
"""

import json
import re

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.evaluation.paper import report
from swarmcensus.evaluation.paper.evaluations import PAPER
from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, MARGIN, MUCH, NO, PARTLY, check
from swarmcensus.support.files import shipped_study
from tests.support.claims import counts, measured, worst
from tests.support.pages import OUR_C_LIBRARY
from tests.support.places import DOCS

TEXT = (DOCS / "paper.md").read_text(encoding="utf-8")
FOUND, MORE = (
    {claim["id"]: claim for claim in json.loads((DOCS / name).read_text(encoding="utf-8"))["claims"]}
    for name in ("paper-claims.json", "paper-claims-120.json")
)


def in_bold(verdict):
    return verdict if verdict == HOLDS else f"**{verdict}**"


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
        assert about["margins"] == {"ordering": MARGIN, "much": MUCH} == {"ordering": 0.05, "much": 1.25}
        for claim in PAPER.claims:
            texts = ("title", "sentence", "section", "statistic", "explanation")
            assert all(found[claim.id][key] in (getattr(claim, key), "") for key in texts)
            assert found[claim.id]["threshold"] == claim.needed.words


def test_claims_are_whole_sentences():
    for claim in PAPER.claims:
        assert re.fullmatch(r"[A-Z].*\.", claim.sentence)


def test_the_tables_are_what_the_command_prints():
    fixed, moving, _ = tables()
    found = {c["title"]: [measured(worst(c)), c["threshold"], counts(c), in_bold(c["verdict"])] for c in FOUND.values()}
    assert {title: cells[1:] for title, cells in (fixed | moving).items()} == found
    assert {title for title in found if title.startswith("Moving")} == set(moving)


def test_table_of_more_trials_lists_claims_that_do_not_hold_everywhere():
    *_, more = tables()
    found = {
        c["title"]: [
            measured(worst(c)), counts(c), in_bold(c["verdict"]),
            "; ".join(each["setting"] for each in c["settings"] if each["verdict"] == NO) or "none",
        ]
        for c in MORE.values()
        if not c["verdict"] == FOUND[c["id"]]["verdict"] == HOLDS
    }  # fmt: skip
    assert more == found


def test_verdicts_are_counted():
    verdicts = [claim["verdict"] for claim in FOUND.values()]
    holds, part, fails = (verdicts.count(verdict) for verdict in (HOLDS, PARTLY, FAILS))
    assert holds + part + fails == len(FOUND)
    assert f"Of {len(FOUND)} claims {holds} hold, {part} hold in part, and {fails} do not hold" in " ".join(
        TEXT.split()
    )


def test_explanations_are_quoted_word_for_word():
    quoted = " ".join(re.sub(r"^> ?", "", TEXT, flags=re.MULTILINE).split())
    assert all(claim["explanation"] in quoted for claim in FOUND.values())


def test_numbers_in_the_prose():
    prose = " ".join(line for line in TEXT.splitlines() if line[:1] not in ("|", ">", "!"))
    prose = re.sub(r"\]\([^)]*\)|\*?\b[fbw]\*? (= \*w\* )?= \*?[\d.]+(, [\d.]+)*", "", prose)
    settings = [setting for each in (FOUND, MORE) for claim in each.values() for setting in claim["settings"]]
    intervals = re.findall(r"-?[\d.]+ \[[^]]*\]", prose)
    assert intervals
    assert set(intervals) <= {measured(setting) for setting in settings}
    rest = re.sub(r"-?[\d.]+ \[[^]]*\]", "", prose)
    behind = " ".join(setting["made_of"] for setting in settings)
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


@pytest.fixture(scope="module")
def claims_again(moving, topologies):
    """What is said now of the claims that these settings suffice for."""
    data = {"topologies": topologies, "moving": moving}
    outcomes = check(data, [claim for claim in PAPER.claims if claim.studies])
    about = json.loads(report.as_json(outcomes, data, PAPER.source))
    return {claim["id"]: claim for claim in about["claims"] if claim["settings"]}


@pytest.mark.long
def test_the_engine_gives_the_numbers_of_the_page(claims_again):
    found = claims_again
    fixed = {"low-error-055", "ring-like-tree", "low-error-095", "blacker-first", "consensus"}
    assert set(found) == fixed | {"few-unheard-moving"}
    for name in sorted(found):
        if name in fixed or OUR_C_LIBRARY:
            assert found[name]["settings"] == FOUND[name]["settings"]


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
