"""docs/rivals.md shows every shipped brain as benchmarks/tables/brains.csv has it, and all deviations of its file."""

import json
import re
import runpy

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains import adversary
from swarmcensus.evaluation.paper import report
from swarmcensus.evaluation.paper.evaluations import PAPER
from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, MARGIN, MUCH, PARTLY, check
from swarmcensus.studies.study import Study
from swarmcensus.support.files import shipped_study
from tests.support.pages import OUR_C_LIBRARY, cells_of
from tests.support.places import DOCS, ROOT

PAGE = DOCS / "rivals.md"
HOOK = runpy.run_path(str(PAGE.parents[1] / "docs_hooks" / "brain_files.py"))


def built(page):
    """A page of docs/ as the site has it, with what its brain files say."""
    text = (PAGE.parent / page).read_text(encoding="utf-8")
    return HOOK["on_page_markdown"](text, page=None, config=None, files=None)


def told(brain):
    """What a brain estimates, what it decides for, and what it costs, as the table's row says it."""
    options = "black or white" if brain.options == 2 else f"one of {brain.options}"
    costs = {"memory": str(brain.memory_bytes), "message": str(brain.message_bytes)}
    estimates = "an opinion" if brain.is_opinion else "a number"
    return {"estimates": estimates, "decides for": options if brain.decides else ""} | costs


def test_the_table_has_every_shipped_brain_as_it_is():
    found = {row["brain"]: row for row in cells_of("brains")}
    assert set(found) == set(brains.shipped())
    for name, row in found.items():
        assert told(brains.load(name)).items() <= row.items(), name


@pytest.mark.parametrize("name", brains.shipped())
def test_the_page_has_deviations_and_parameters_of_every_brain(name):
    brain, shown = brains.load(name), built("rivals.md")
    deviations = brain.functions.__doc__.partition("Deviations")[2]
    assert all(line in shown for line in deviations.strip().splitlines())
    assert all(f'"{parameter}"' in shown for parameter in brain.parameters)
    assert f"library/{name.replace('-', '_')}.py)" in shown


def test_a_page_shows_a_file_below_the_paragraph_that_links_it():
    shown = built("rivals.md").partition("library/oracle.py)\n\n")[2]
    assert shown.startswith('??? quote "alone.py"\n\n    A robot alone')


@pytest.mark.long
@pytest.mark.parametrize("question", ["consensus", "opinions", "unknown", "strobel", "beliefs"])
def test_tables_are_what_the_benchmark_measures(question, benchmark, monkeypatch):
    rivals, written = benchmark("rivals"), []
    monkeypatch.setattr(rivals.harness, "write_csv", lambda *table: written.append(table))
    getattr(rivals, question)(write=True)
    [(name, heads, rows)] = written
    for row, stored in zip(rows, cells_of(name), strict=True):
        row = dict(zip(heads, map(str, row), strict=True))
        if OUR_C_LIBRARY:
            assert row == stored
        else:
            assert list(row) == list(stored)


def test_the_first_page_counts_them_rightly():
    first = (PAGE.parents[1] / "README.md").read_text(encoding="utf-8").lower()
    words = {9: "nine", 10: "ten", 33: "thirty-three"}
    assert f"{words[len(brains.shipped())]} brains ship" in first
    assert f"{words[len(adversary.PLUGINS.shipped)]} adversaries" in first


def test_the_arena_of_liars_is_the_published_experiment():
    """Liars say 0 of a colour that covers 0.75; 10,000 ticks of 1 s and 10 cm are 217 phases, three of them silent."""
    study = Study.load(ROOT / "studies" / "rivals" / "strobel-2020.toml")
    for setting in study.settings():
        assert (setting.fill_ratio, setting.rounds) == (0.75, 10_000)
        body = setting.body
        assert (body.tick, body.speed, body.tile, body.radio_range) == (1, 0.1, 0.1, 0.5)
        assert (body.straight_mean, body.turn_most) == (40, 4)
        given = setting.brain.parameters
        assert (setting.rounds // given["phase"], given["silent"], given["debiased"]) == (217, 3, 0)
    assert [adversary.name for adversary in study.adversaries] == ["always-white"]


# ---- docs/paper.md has the numbers of `swarmcensus reproduce`, as it prints them, and the engine still gives them
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


def test_the_page_shows_claims_that_do_not_hold_everywhere():
    shown = re.findall(r"^\| ([^|]*) \| [-\d.]+ \| [-\d.]+ \|", CLAIMS, re.MULTILINE)
    assert shown == [title for title, row in FOUND.items() if row["verdict"] != HOLDS]


def test_verdicts_are_counted():
    verdicts = [row["verdict"] for row in FOUND.values()]
    holds, part, fails = (verdicts.count(verdict) for verdict in (HOLDS, PARTLY, FAILS))
    said = f"Of {len(FOUND)} claims {holds} hold, {part} hold in part, and {fails} do not hold"
    assert said in " ".join(TEXT.split())


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
