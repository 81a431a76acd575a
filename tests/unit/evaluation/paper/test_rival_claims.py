"""What was published about rivals: rules on made-up data, and the page has the numbers of `reproduce rivals`.

Where a change was meant to alter numbers, run that, write the table again by `python benchmarks/claims.py rivals`, and
mend the page as these tests say.
"""

import json
import math
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.evaluation.paper import measures, quantities, report
from swarmcensus.evaluation.paper.evaluations import RIVALS
from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, PARTLY, Contender, Evidence, Missing, check, outcome
from swarmcensus.studies.coordinates import coordinates_of
from swarmcensus.support.files import shipped_study
from tests.support.pages import OUR_C_LIBRARY, cells_of
from tests.support.places import DOCS

FOUND = {row["claim"]: row for row in cells_of("rivals-claims")}
KNOWN = {claim.id: claim for claim in RIVALS.claims}
STUDIES = {path.stem: path for path in shipped_study("rivals/claims").glob("*.toml")}
TRIALS = 30
QUICK = ("changing", "filters", "liars")  # seconds, on networks: the same on all machines


# ---- what claims are
def test_claims_have_names_and_studies():
    assert len(KNOWN) == len(RIVALS.claims) == len({claim.title for claim in RIVALS.claims})
    assert {study for claim in RIVALS.claims for study in claim.studies} == set(STUDIES)
    assert all(claim.studies and claim.sentence.endswith(".") for claim in RIVALS.claims)
    assert all("abstract" in claim.section or "not checked" in claim.section for claim in RIVALS.claims)


@pytest.mark.parametrize("path", STUDIES.values(), ids=STUDIES)
def test_names_and_trials_of_claim_studies(path):
    study = sc.Study.load(path)
    assert study.name == path.stem
    assert study.trials >= TRIALS
    assert study.settings()


@cache
def settings_of(study):
    """The coordinates of a study's settings."""
    return [{"liars": 0} | coordinates_of(setting) for setting in sc.Study.load(STUDIES[study]).settings()]


@pytest.mark.parametrize("claim", RIVALS.claims, ids=KNOWN)
def test_all_settings_that_a_claim_asks_for_are_in_its_studies(claim, monkeypatch):
    asked = []
    with_numbers(monkeypatch, lambda study, where: asked.append((study, where)) or 1.0)
    outcome(replaced(claim), blank())
    assert asked
    for study, where in asked:
        assert study in claim.studies
        assert sum(where.items() <= one.items() for one in settings_of(study)) == 1, (study, where)


# ---- the rules, on numbers that are made up
def blank():
    """Evidence without data: numbers are made up where they are asked for."""
    return Evidence({}, trials=TRIALS)


def with_numbers(monkeypatch, number):
    """In place of every statistic, `number(study, where)` with a little noise by trial."""

    def made_up(evidence, contender, world):
        noise = np.random.default_rng(1).normal(0, 0.001, TRIALS)
        return evidence.mean(number(*contender.within(world)) * (1 + noise))

    for name in ("consensus_time", "right_robots"):  # which measures ask for by name
        monkeypatch.setattr(measures, name, made_up)
    monkeypatch.setattr(quantities, "made_up", made_up, raising=False)


def replaced(claim):
    """The claim with what `with_numbers` made up for the statistics that it names itself."""
    made_up = [
        partial(old.func, **(old.keywords | {"of": [quantities.made_up]})) if "of" in old.keywords else old
        for old in claim.measures
    ]
    return replace(claim, measures=tuple(made_up))


def is_first(claim, study, where):
    """Whether a claim means this setting as the one that others are held against."""
    keywords = claim.measures[0].keywords
    if "first" in keywords:
        return any(study == one.study and one.where.items() <= where.items() for one in keywords["first"])
    return keywords.get("patterned", keywords.get("after", {})).items() <= where.items()


@pytest.mark.parametrize("claim", [c for c in RIVALS.claims if c.id != "three-robust"], ids=lambda claim: claim.id)
def test_every_claim_can_hold_and_can_fail(claim, monkeypatch):
    """The first of its settings has one number and the others another."""
    verdicts = set()
    for first, other in ((0.9, 0.3), (0.3, 0.9), (0.6, 0.6), (0.01, 0.01)):
        numbers = {True: first, False: other}
        with_numbers(monkeypatch, lambda *where, numbers=numbers: numbers[is_first(claim, *where)])
        verdicts.add(outcome(replaced(claim), blank()).verdict)
    assert {HOLDS, FAILS} <= verdicts


@pytest.mark.parametrize(("three", "boolean", "said"), [(0.1, 0.3, HOLDS), (0.3, 0.1, FAILS)])
def test_who_loses_less_to_malfunction_is_the_more_robust(three, boolean, said, monkeypatch):
    lost = {"three-valued": three, "boolean": boolean}
    with_numbers(monkeypatch, lambda study, where: 0.9 - (where["liars"] > 0) * lost[study])
    assert outcome(KNOWN["three-robust"], blank()).verdict == said


# ---- statistics, by hand
def made_up():
    """A setting of three trials and four robots; in the third trial no option is right."""
    never, robots = math.inf, ("setting", "trial", "robot")
    given = {"robots": 4, "rounds": 10, "observations_per_round": 1, "fill_ratio": 0.6}
    return xr.Dataset(
        {
            "decision": (robots, [[[1.0, 1, 1, 0], [0, 0, -1, -1], [1, 1, 1, 1]]]),
            "decision_round": (robots, [[[1.0, 2, 3, 4], [1, 1, never, never], [2, 2, 2, 2]]]),
            "convergence_round": (robots, [[[1, 2, 3, 4], [5, 6, 7, 8], [9, 9, 9, 9]]]),
            "final_estimate": (robots, [[[0.5, 0.7, 0.6, 0.6], [0.2, 0.2, 0.2, 0.2], [1.0, 1, 1, 1]]]),
            "consensus": (("setting", "trial"), [[1.0, -1.0, 1.0]]),
            "consensus_round": (("setting", "trial"), [[4.0, never, 6.0]]),
            "right_option": (("setting", "trial"), [[1.0, 1.0, np.nan]]),
            "true_fill_ratio": (("setting", "trial"), [[0.6, 0.4, 0.5]]),
        },
        {name: ("setting", [value]) for name, value in given.items()},
        {"truth": "floor"},
    )


def by_hand(name, data=None, resamples=400):
    evidence = Evidence({"made-up": made_up() if data is None else data}, resamples)
    return getattr(quantities, name)(evidence, Contender("", "made-up", {}), {"fill_ratio": 0.6})


@pytest.mark.parametrize(("name", "value"), [
    ("consensus_time", 6.0),  # of 4, 10 and 6
    ("decision_time", (2.5 + 5.5 + 2.0) / 3), ("convergence", 6.5), ("final_error", (0.05 + 0.2 + 0.5) / 3),
    ("consensus_right", 1 / 2), ("wrong_consensus", 1 / 2), ("right_robots", 3 / 8), ("wrong_robots", 5 / 8),
    ("right_deciders", 3 / 6), ("wrong_deciders", 3 / 6), ("quorums", 1 / 3),
])  # fmt: skip
def test_statistics_are_what_they_are_by_hand(name, value):
    found = by_hand(name)
    assert found[0] == pytest.approx(value, abs=1e-12)
    assert np.nanstd(found[1:]) > 0


def test_trials_that_were_never_run_are_missing():
    statistics = {"decision": "quorums", "consensus": "consensus_right", "consensus_round": "consensus_time"}
    for name, statistic in statistics.items():
        data = made_up()
        data[name][0, 2] = np.nan
        with pytest.raises(Missing):
            by_hand(statistic, data)


# ---- the page
def test_the_table_has_every_claim():
    assert set(FOUND) == {claim.title for claim in RIVALS.claims}
    for claim in RIVALS.claims:
        row = FOUND[claim.title]
        about = (claim.needed.words, claim.statistic.replace(";", ","), claim.section)
        assert (row["needed"], row["statistic"], row["source"]) == about


def test_the_page_has_what_the_command_prints():
    text = (DOCS / "rivals-claims.md").read_text(encoding="utf-8")
    verdicts = [row["verdict"] for row in FOUND.values()]
    holds, part, fails = (verdicts.count(verdict) for verdict in (HOLDS, PARTLY, FAILS))
    assert holds + part + fails == len(FOUND)
    assert f"Of {len(FOUND)} claims {holds} hold, {part} hold in part, and {fails} do not." in " ".join(text.split())


@pytest.mark.long
def test_the_engine_still_gives_the_numbers_of_the_table(benchmark):
    data = {name: sc.run(sc.Study.load(STUDIES[name])) for name in QUICK}
    quick = [claim for claim in RIVALS.claims if set(claim.studies) <= set(QUICK)]
    assert len(quick) >= 5
    found = json.loads(report.as_json(check(data, quick), data, RIVALS.source))["claims"]
    for row in benchmark("claims").rows(found):
        stored = FOUND[row["claim"]]
        if OUR_C_LIBRARY:
            assert row.items() <= stored.items()
        else:
            assert row["verdict"] == stored["verdict"]
            assert float(row["value"]) == pytest.approx(float(stored["value"]), rel=0.1, abs=0.01)
