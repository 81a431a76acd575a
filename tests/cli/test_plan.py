"""The command `plan`: what it prints and writes, and one sentence for each wish that cannot be."""

import json
import os
import re
from pathlib import Path

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.cli.commands.plan import brain_with_parameters, tables_of
from tests.support.options import with_usual

KNOWN = "[known]\naccuracy = 0.8\nfill_ratio = 0.55\n"
RING = KNOWN + "[wanted]\nhalf_width = 0.05\n[free]\nrobots = 10\n"
RING += 'topology = "ring"\n'
YARD = ["plan", "--side", "3", "--accuracy", "0.8", "--half-width", "0.05", "--robots", "5"]


@pytest.fixture(autouse=True)
def mission(here):
    (here / "m.toml").write_text("trials = 40\n" + RING)


def test_plan_prints_and_writes(capsys):
    assert main(["plan", "m.toml", "--out", "p.json", "--plot", "p.svg", "--robots", "5:20"]) == 0
    printed = capsys.readouterr()
    assert "95 % of robots within 0.05 of the truth" in printed.out
    assert printed.out.count("\ncommons  ") == printed.out.count("\nminimalistic  ") == 5
    assert printed.out.count("\ncommons needs ") == printed.out.count("\nminimalistic needs ") == 2  # 5 and 20 robots
    assert all(f" {column}: " in printed.out.replace("\n", " ") for column in ("all", "mixed", "alone"))
    assert re.search(r"^p.json: .*\np.svg: ", printed.out, re.MULTILINE)
    rows = json.loads(Path("p.json").read_text())["rows"]
    assert {row["robots"] for row in rows} == {5, 7, 10, 14, 20}
    assert {row["trials"] for row in rows} == {40}
    assert "<svg" in Path("p.svg").read_text()[:500]


@pytest.mark.long
def test_options_replace_what_the_file_says(capsys):
    assert main(["plan", "m.toml", "--right", "majority", "--brain", "voter", "--minutes", "9"]) == 0
    out = capsys.readouterr().out
    assert "in the right half" in out
    assert "whether these are enough; wanted: " in out
    assert "voter " in out
    assert "commons" not in out
    assert (
        main(["plan", "--side", "1", *YARD[3:], "--body", "speed=0.2", "--trials", "40", "--fill-ratio", ".5:.6"]) == 0
    )
    assert "1 m x 1 m, accuracy 0.8, f from 0.5 to 0.6; the truth is the floor's own share" in capsys.readouterr().out
    numbers = ["--precision", "single", "--message", "ratio16"]
    assert main(["plan", "--side", "1", *YARD[3:], "--trials", "40", "--fill-ratio", ".6", *numbers]) == 0
    assert "f = 0.6, single precision, messages in ratio16; the truth" in capsys.readouterr().out


TWO_PARTS = '{name = "two", edges = [[0, 1], [2, 3], [3, 4]]}'
EVERYWHERE = [f"--topology={name}" for name in ("ring", "full", "line", "scale-free", "{networkx = 'cycle_graph'}")]
ONE_WAY = '{name = "relay", edges = [[0, 1], [1, 2]], directed = true}'


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("robots = 10", "robot = 10"), "m.toml: unknown key free.robot: did you mean 'robots'?"),
        (("accuracy = 0.8", ""), "known.accuracy is missing"),
        (("[known]", "[known"), "mission file m.toml: not TOML"),
        (("half_width = 0.05", ""), "wanted: should have a half_width"),
        (("half_width = 0.05", 'half_width = 0.05\nright = "majority"'), "and not both"),
        (("[known]", "known = 3\n[other]"), "unknown key other"),
        (("[known]", "body = 3\n[known]"), "body = 3: should be a table"),
        ((KNOWN, "known = 3\n"), "mission file m.toml: known = 3: should be a table"),
    ],
)
def test_faults_of_mission_files(change, said, here, refused):
    assert change[0] in RING
    (here / "m.toml").write_text(RING.replace(*change))
    assert said in refused("plan", "m.toml", "--out", "p.json")


@pytest.mark.long(only=["at f = 0.55 among 30 % of liars (shouter), not 95 %"])
@pytest.mark.parametrize(
    ("options", "said"),
    [
        pytest.param(options, said, id=said) for options, said in [
            (["--accuracy", "0.5"], "cannot be reached, because an accuracy of 0.5 says the same of black and white"),
            (["--accuracy", "0.8", "--accuracy", "0.8"], "known.accuracy: 0.8 is there twice"),
            (["--accuracy", '{black = 0.5, white = "U(0.5, 0.5)"}'], "not even 1e+15 readings are enough"),
            (["--minutes", "0.02:0.04"], "cannot be reached, because in 0.0333 min only "),
            (["--minutes", "inf"], "free.minutes = inf"),
            (["--robots", "20:5"], "free.robots = [20, 5]"),
            (["--robots", "2.5"], "free.robots = 2.5"),
            (["--robots", "1:2:3"], "--robots 1"),
            (["--density", "5"], "free.density"),
            (["--topology", TWO_PARTS, "--robots", "5"], "'two' of 5 robots is not connected: it has 2 parts"),
            (["--topology", ONE_WAY, "--robots", "3"], "'relay' of 3 robots is not connected: it has 3 parts"),
            (["--topology", "ring", "--topology", "moving"], "or leave it to a swarm density (free.density)"),
            (["--side", "3"], "area.side"),
            (["--truth", "floor"], 'wanted.truth = "floor"'),
            (["--right", "10", "--fill-ratio", "0.2:0.4"], "because f may be 0.2, on the edge between two bins"),
            (["--fill-ratio", "0.5:1.5"], "known.fill_ratio[1] = 1.5"),
            (["--brain", "voter"], "free.brain = voter"),
            (["--out", "m.toml"], "cannot write m.toml: it is an input"),
            (["--plot", "p.png", *EVERYWHERE], "would be 10 lines, and a figure has at most 8"),
            (["--body", "speed=fast"], "--body speed=fast"),
            (["--lie", "shouter"], "known.lie"),
            (["--lying", "0.5", "--failing", "0.5"], "leave no robot that works and is honest"),
            (["--lying", "0.1", "--robots", "1"], "known.lying = 0.1"),
            (["--lying", "0.1", "--lie", "commons"], "known.lie = commons"),
            (["--lying", "0.1", "--lie", "random", "--lie", "random"], "known.lie: random is there twice"),
            (["--lying", "0.3", "--brain", "commons"], "at f = 0.55 among 30 % of liars (shouter), not 95 %"),
        ]
    ],
)  # fmt: skip
def test_faults_of_options_write_nothing(options, said, refused):
    assert said in refused("plan", "m.toml", *options, *([] if "--out" in options else ["--out", "p.json"]))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--area -4", "--area -4"),
        ("--side 3 --area 9", "area.side"),
        ("--side 1e9", "the area is 1e+11 tiles wide: 1,073,741,824 is the most"),
        ("--side 0.1", "--robots 5"),
        ("--side 3 --robots 500", "--robots 500"),
        ("--side 3 --round-seconds 2", "free.round_seconds"),
        ("--side 1 --half-width 0.004 --truth nominal", "have a share of black of their own"),
        ("--density 40 --robots 1", "at a density of 40 fewer than 3 robots have no room to move"),
        ("--density 5 --side 3", "free.density"),
        ("--density 9 --half-width 0.004 --truth nominal", "0.925 m x 0.925 m, 47 % of floors with f = 0.5"),
    ],
)
def test_areas_that_cannot_be_are_refused(options, said, refused):
    assert said in refused("plan", *with_usual(options.split(), YARD[3:]))


STAR = '{name = "star", edges = [[0, 1], [0, 2]]}'


GOAL = "--accuracy 0.9 --half-width 0.1 --fill-ratio 0.5 --brain commons --trials 40 --minutes 1 --topology"


@pytest.mark.long(but=["star", "grid"])
@pytest.mark.parametrize(
    ("topology", "options", "said"),
    [
        pytest.param(STAR, "", "free.topology", id="star"),
        pytest.param("pairs.csv", "", "free.topology", id="file"),
        pytest.param(STAR, "--robots 2", "free.topology", id="too few"),
        pytest.param('{networkx="grid_2d_graph", m=3, n=3}', "", "networkx.grid_2d_graph gives 9", id="grid"),
        pytest.param('{networkx="random_regular_graph", d=3}', "", "125 robots can be made, because", id="odd"),
        pytest.param('{networkx="gnp_random_graph", p=0.0}', "", "is not connected: it has 500 parts", id="no pairs"),
    ],
)
def test_networks_of_impossible_sizes(topology, options, said, here, refused):
    (here / "pairs.csv").write_text("i,j\n0,1\n1,2\n2,3\n")
    error = refused("plan", *GOAL.split(), topology, *options.split())
    assert said in error
    assert "free.topology" in error


@pytest.mark.long
def test_theory_says_what_it_leaves_out(capsys):
    for options, said in (
        (["--link-success", "0.5"], "knew all readings at once, and no message were lost; mixed: "),
        (["--lying", "0.1", "--link-success", "0.5"], "at once, and nobody lied, and no message were lost; mixed: "),
    ):
        assert main(["plan", "m.toml", "--minutes", "1", "--brain", "steadfast", *options]) == 0
        assert said in " ".join(capsys.readouterr().out.split())


def test_a_brain_keeps_the_values_of_the_mission_file_or_has_those_that_are_given():
    tables = {"free": {"brain": ["commons", {"file": "mine.py", "gain": [0.5, 1]}]}}
    for text, brains in (
        ("mine.py", [{"file": "mine.py", "gain": [0.5, 1]}]),
        ("mine.py gain=2 w=(1, 0.5)", [{"file": "mine.py", "gain": 2.0, "w": (1.0, 0.5)}]),
        ("commons", ["commons"]),
    ):
        keys = {"brain": [brain_with_parameters(text)], "body": (), "trials": None, "seed": None}
        assert tables_of(keys, tables)["free"]["brain"] == brains


def test_plan_takes_the_name_of_a_brain_that_it_prints(capsys):
    assert main(["plan", "m.toml", "--minutes", "0.2", "--brain", "steadfast z=2.5"]) == 0
    assert "\nsteadfast z=2.5 " in capsys.readouterr().out


@pytest.mark.long
def test_a_density_replaces_the_side_of_a_file(capsys):
    tables = "[known]\naccuracy = 0.9\n[wanted]\nhalf_width = 0.1\n[free]\nrobots = 4\n"
    Path("yard.toml").write_text("[area]\nside = 3\n" + tables)
    options = ["--minutes", "0.5", "--trials", "40", "--brain", "commons", "--lying", "0.1", "--accuracy", "0.85:0.9"]
    assert main(["plan", "yard.toml", "--density", "3", "--density", "6", *options]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "density 3, 6, accuracy 0.85, the worst of 0.85, 0.9, f from 0 to 1, 10 % lie (shouter); the truth" in out
    assert "brain density robots side, m minutes" in out
    assert "commons 3 4 1.43 0.500" in out
    assert "commons 6 4 1.01 0.500" in out
    assert "at once, and nobody lied" in out


def test_ctrl_c_ends_it_in_a_sentence_and_writes_nothing(monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("swarmcensus.search.planning.planning.shortest", interrupted)
    assert main(["plan", "m.toml", "--out", "p.json"]) == 130
    assert capsys.readouterr().err.splitlines()[-1] == "swarmcensus: stopped"
    assert sorted(os.listdir()) == ["m.toml"]
