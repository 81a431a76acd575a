"""The leaderboard: fixed worlds for all; scores by hand; what it keeps, and what it refuses."""

import json
import math
import re

import numpy as np
import pytest
import xarray as xr
from scipy.stats import rankdata

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.evaluation import ranking
from swarmcensus.evaluation.ranking import leaderboard
from swarmcensus.studies.coordinates import coordinates_of
from swarmcensus.summaries.labels import groups_in
from swarmcensus.summaries.selecting import where
from swarmcensus.support.toml_text import to_toml
from tests.support.places import ROOT

SMALL = """
name = "leaderboard"
seed = 4
trials = 6
swarm = {brain = ["minimalistic", "legacy"], robots = 20, accuracy = [0.55, 0.9]}
world = {topology = ["ring", "moving"], side = 2.0, fill_ratio = [0.47, 0.9]}
schedule = {rounds = 30, observations_per_round = 1, ticks = 40}
measure = {bins = 2}
[[members]]
robots = [0, 0.1, 0.3]
brain = "always-black"
honest = false
[[case]]
accuracy = 0.9
link_success = 0.5
[groups]
honest = "liars == 0"
networks = "liars == 0 and link_success == 1 and topology == 'ring'"
moving = "liars == 0 and link_success == 1 and topology == 'moving'"
liars = "liars > 0"
"10 % liars" = "liars == 2"
"""


def honest():
    """The same of one brain and without liars."""
    before, _, after = SMALL.replace(', "legacy"', "").partition("[[members]]")
    after = after[after.index("[[case]]") : after.index("liars = ")].replace('"liars == 0"', '"robots == 20"')
    return before + after.replace("liars == 0 and ", "")


@pytest.fixture
def small(here, monkeypatch):
    (here / "leaderboard.toml").write_text(SMALL)
    monkeypatch.setattr(ranking, "shipped_study", lambda name: here / name)
    mine = brains.load("minimalistic").source
    (here / "mine.py").write_text(mine + "\n# a copy\n")
    return here


@pytest.mark.long
def test_leaderboard_worlds_are_complete():
    study = sc.Study.load(ROOT / "studies" / "leaderboard.toml")
    assert {brain.name for brain in study.brains} >= set(brains.shipped())
    settings, also = study.settings(), {"liars": 0, "fill_ratio_change": ""}
    worlds = [also | coordinates_of(one) for one in settings if one.brain == settings[0].brain]
    columns = {name: ("setting", [world[name] for world in worlds]) for name in worlds[0] if name in worlds[-1]}
    data = xr.Dataset(coords=columns, attrs={"study": study.text})
    sizes = {name: where(data, name).sizes["setting"] for name in groups_in(data)}
    assert min(sizes.values()) >= 2
    assert [sizes[name] for name in ("honest", "liars", "change")] == [22, 44, 2]
    assert len({one.accuracy for one in settings}) == 4
    assert {one.body is None for one in settings} == {True, False}
    assert {(one.robots - one.honest) / one.robots for one in settings} == {0.0, 0.1, 0.3}


def hold(found, data, opinions):
    """Every number of a ranking, worked out once more."""
    final, truth = data["final_estimate"].values, data["fill_ratio"].values
    medians, sides, tails = (np.empty(final.shape[:2]) for _ in range(3))
    for s, t in np.ndindex(final.shape[:2]):
        some = final[s, t]
        medians[s, t] = np.median(np.abs(some - truth[s]))
        tails[s, t] = sorted(np.abs(some - truth[s]))[math.ceil(0.9 * len(some)) - 1]
        sides[s, t] = np.mean([(x > 0.5) == (truth[s] > 0.5) and x != 0.5 for x in some])
    of, still = data["brain"].values, data["topology"].values == "ring"
    plain, rows = data["link_success"].values == 1.0, {row["brain"]: row for row in found.rows}
    for name, row in rows.items():
        for kind, some in (("networks", plain & still), ("moving", plain & ~still)):
            chosen = some & (of == name)
            error = np.nan if name in opinions else np.mean(np.median(medians[chosen], axis=1))
            assert row[f"final_error: {kind}"] == pytest.approx(error, abs=1e-12, nan_ok=True)
            assert row[f"right_side: {kind}"] == pytest.approx(np.mean(sides[chosen]), abs=1e-12)
        tail = np.nan if name in opinions else np.mean(np.median(tails[of == name], axis=1))
        assert row["error_90"] == pytest.approx(tail, abs=1e-12, nan_ok=True)
        assert row["right_side"] == pytest.approx(np.mean(sides[of == name]), abs=1e-12)
    ranked = [name for name in rows if name not in opinions]
    numbers = np.stack([medians[of == name] for name in ranked]).round(14)  # the same but for rounding: a tie
    ranks = rankdata(numbers, axis=0).mean(axis=(1, 2))
    assert [rows[name]["rank"] for name in ranked] == pytest.approx(ranks, abs=1e-9)
    assert all(np.isnan(rows[name]["rank"]) for name in opinions)


def test_scores_of_numbers_that_are_known(small):
    """One brain's, half as wrong, half as wrong again, and rounded to an opinion."""
    (small / "leaderboard.toml").write_text(honest())
    data = leaderboard(["mine.py"], "out").data
    data = data.isel(setting=np.flatnonzero(data["brain"].values == "minimalistic"))
    x, truth = data["final_estimate"], data["fill_ratio"]
    made = {"minimalistic": x, "wrong.py": truth + 1.5 * (x - truth), "right.py": truth + 0.5 * (x - truth),
            "votes.py": (x > 0.5) + 0.0 * x}  # fmt: skip
    parts = [
        data.assign(final_estimate=found.transpose(*x.dims)).assign_coords(brain=("setting", [name] * truth.size))
        for name, found in made.items()
    ]
    known = xr.concat(parts, "setting", data_vars="minimal").assign_coords(setting=np.arange(4 * truth.size))
    (small / "votes.py").write_text(brains.load("voter").source)
    both = [brains.load("minimalistic"), brains.load("votes.py")]
    found = ranking.ranking(known, "honest", ["networks", "moving"], both)
    hold(found, known, ["votes.py"])
    table = found.frame
    assert table["place"].isna().tolist() == [False] * 3 + [True]  # an opinion has no error, and no place
    assert table["brain"].tolist() == ["right.py", "minimalistic", "wrong.py", "votes.py"]
    assert re.findall(r"^[123] +(\S+)", repr(found), re.MULTILINE) == table["brain"].tolist()[:3]
    assert found.sentences == ["right.py is number 1 of 3"]


@pytest.mark.long
def test_only_changed_brains_are_run_again(small, capsys):
    first = leaderboard(["mine.py"], "out")
    times = {path: path.stat().st_mtime_ns for path in (small / "out" / "data").iterdir()}
    said = []
    again = leaderboard(["mine.py"], "out", say=said.append)
    assert again.rows == first.rows
    assert {path.resolve() for path in first.files} == {path.resolve() for path in again.files} == {*times}
    assert {path: path.stat().st_mtime_ns for path in times} == times
    assert sum("found" in line for line in said) == 2
    (small / "mine.py").write_text(brains.load("voter").source)
    said.clear()
    leaderboard(["mine.py"], "out", say=said.append)
    assert {path.name for path, when in times.items() if path.stat().st_mtime_ns != when} == {"mine.nc"}


@pytest.mark.long
def test_who_is_ranked_is_said(small, accepted):
    """An oracle is a bound; a brain that talks to nobody is one that can be had."""
    toml = small / "leaderboard.toml"
    toml.write_text(SMALL.replace('"legacy"', '"alone", "oracle"'))
    shown = " ".join(accepted("leaderboard", "--out", "out", "--trials", "2").out.split())
    assert "not ranked, as references that no robot can run: oracle" in shown
    places = {row["brain"]: row["place"] for row in leaderboard(out="out", set={"trials": 2}).rows}
    assert places["oracle"] is None
    assert places["alone"] in (1, 2)


def test_leaderboard_command_shows_ranks_and_losses(small, accepted, benchmark):
    """Of two brains that are one and of no liars, so that the machine compiles little."""
    (small / "leaderboard.toml").write_text(honest())
    command = ["leaderboard", "mine.py", "--out", "out", "--trials", "3"]
    shown = accepted(*command).out
    assert shown.splitlines()[-2:] == ["out/data/mine.nc", "out/data/shipped.nc"]
    assert re.search(r"^mine.py is number [12] of 2(; it loses most in '(networks|moving)')?$", shown, re.MULTILINE)
    found = json.loads(accepted(*command, "--json").out, parse_constant=pytest.fail)
    rows = [line.split() for line in shown.splitlines()]
    rows = rows[next(k for k, words in enumerate(rows) if "brain" in words) :]
    # as the pages of docs/ take them over
    pages = benchmark("pages")
    read = pages.values_of(pages.answers_of("out", ["mine.py"], ["honest"], set={"trials": 3}))
    for row in found["rows"]:
        assert read[row["brain"], "error: rank (honest)"] == f"{row['rank']:.1f}"
        assert read[row["brain"], "error: networks"] == f"{row['final_error: networks']:.4f}"
        words = next(words for words in rows if row["brain"] in words[:2])
        assert words[:2] == [str(row["place"]), row["brain"]]
        assert words[2:4] == [f"{row[name]:.4f}" for name in ("final_error", "error_90")]


@pytest.mark.parametrize(("arguments", "said"), [
    (["nobody.py"], "nobody.py"),
    (["shipped.py"], "rename the file"),
    (["mine.py", "a/mine.py"], "another brain mine: rename"),
    (["bad.py"], "MESSAGE is missing"),
    (["legacy"], "another brain legacy: rename"),
    (["mine.py", "--group", "honst"], "did you mean 'honest'? there are honest, "),
])  # fmt: skip
def test_what_is_wrong_is_said_before_anything_runs(small, refused, arguments, said):
    (small / "bad.py").write_text('MEMORY = {"x": 0.5}\n')
    (small / "a").mkdir()
    for name in ("shipped.py", "a/mine.py"):
        (small / name).write_text(brains.load("legacy").source)
    assert said in refused("leaderboard", *arguments, "--out", "out")


def test_another_study_with_groups_is_a_leaderboard(here, accepted, refused):
    tables = {"trials": 4, "swarm": {"robots": 5, "accuracy": 0.8, "brain": ["commons", "alone"]},
              "world": {"topology": ["ring", "full"], "fill_ratio": 0.7}, "schedule": {"rounds": 20}}  # fmt: skip
    groups = {"all": "robots == 5", "rings": 'topology == "ring"', "full": 'topology == "full"'}
    (here / "own.toml").write_text(to_toml(tables))
    assert "it needs [groups]" in refused("leaderboard", "--study", "own.toml")
    alone = tables | {"groups": groups, "swarm": tables["swarm"] | {"brain": "commons"}}
    (here / "own.toml").write_text(to_toml(alone))
    assert "it has one brain: name files of others" in refused("leaderboard", "--study", "own.toml")
    (here / "own.toml").write_text(to_toml(tables | {"groups": groups}))
    found = json.loads(accepted("leaderboard", "--study", "own.toml", "--set", "fill_ratio=0.9", "--json").out)
    assert (found["group"], found["kinds"], found["worlds"]) == ("all", ["rings", "full"], 2)
    assert [row["brain"] for row in found["rows"]] == ["commons", "alone"]


@pytest.mark.long
def test_each_group_ranks_its_own_worlds_and_a_brain_once(small, refused, accepted):
    for group, worlds in (("honest", 12), ("liars", 24)):
        words = ["leaderboard", "mine.py", "./mine.py", "--out", "out", "--trials", "2", "--group", group, "--json"]
        shown = json.loads(accepted(*words).out)
        assert (shown["group"], shown["worlds"]) == (group, worlds)
        assert sorted(row["brain"] for row in shown["rows"]) == ["legacy", "mine.py", "minimalistic"]
        assert ("final_error: 10 % liars" in shown["rows"][0]) == (group == "liars")
    moving = ["leaderboard", "--out", "out", "--trials", "2", "--group", "moving", "--json", "--limit", "1"]
    shown = json.loads(accepted(*moving).out)
    assert (shown["group"], shown["worlds"], len(shown["rows"])) == ("moving", 4, 1)
    assert "there are honest, networks, moving, liars" in refused("leaderboard", "--out", "out", "--group", "change")


def test_a_group_of_a_study_selects_settings_by_its_name():
    tables = {"swarm": {"robots": [5, 6, 7], "brain": "minimalistic", "accuracy": 0.8}, "schedule": {"rounds": 5},
              "world": {"topology": "ring", "fill_ratio": 0.6}, "groups": {"few": "robots < 7"}}  # fmt: skip
    data = sc.run(sc.Study(trials=1, **tables), progress=False)
    assert where(data, "few")["robots"].values.tolist() == [5, 6]
    tables["groups"]["few"] = "robots == 5"
    again = sc.run(sc.Study(trials=1, **tables), progress=False)
    assert again.final_estimate.equals(data.final_estimate)
    assert groups_in(again) == {"few": "robots == 5"}
