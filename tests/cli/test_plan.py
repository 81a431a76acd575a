"""The command `plan`: what it prints and writes, and one sentence for each wish that cannot be."""

import json
import os
from pathlib import Path

import pytest
from rich.console import Console

from swarmcensus.cli.commands import main

KNOWN = "[known]\naccuracy = 0.8\nfill_ratio = 0.55\n"
RING = KNOWN + "[wanted]\nhalf_width = 0.05\n[free]\nrobots = 10\n"
RING += 'topology = "ring"\n'
YARD = ["plan", "--side", "3", "--accuracy", "0.8", "--half-width", "0.05", "--robots", "5"]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("m.toml").write_text("trials = 40\n" + RING)
    return tmp_path


def test_plan_prints_and_writes(here, capsys):
    assert main(["plan", "m.toml", "--out", "p.json", "--plot", "p.svg", "--robots", "5:20"]) == 0
    told = capsys.readouterr()
    assert "95 % of robots within 0.05 of the truth" in told.out
    assert told.out.count("\ncommons ") == told.out.count("\nminimalistic ") == 5
    assert all(f" {column} = " in told.out.replace("\n", " ") for column in ("all", "mixed", "alone"))
    assert "p.json, p.svg: " in told.err
    rows = json.loads(Path("p.json").read_text())["rows"]
    assert {row["robots"] for row in rows} == {5, 7, 10, 14, 20}
    assert {row["trials"] for row in rows} == {40}
    assert "<svg" in Path("p.svg").read_text()[:500]


@pytest.mark.long
def test_options_replace_what_the_file_says(here, capsys):
    assert main(["plan", "m.toml", "--right", "majority", "--brain", "voter", "--minutes", "9"]) == 0
    out = capsys.readouterr().out
    assert "in the right half" in out
    assert "whether these are enough;" in out
    assert "voter " in out
    assert "commons" not in out
    assert main([*YARD, "--side", "1", "--body", "speed=0.2", "--trials", "40", "--fill-ratio", ".5:.6"]) == 0
    assert "1 m x 1 m, accuracy 0.8, f from 0.5 to 0.6; the truth is the floor's own share" in capsys.readouterr().out
    numbers = ["--precision", "single", "--message", "ratio16"]
    assert main([*YARD, "--side", "1", "--trials", "40", "--fill-ratio", ".6", *numbers]) == 0
    assert "f = 0.6, single precision, messages in ratio16; the truth" in capsys.readouterr().out


TWO_PARTS = '{name = "two", edges = [[0, 1], [2, 3], [3, 4]]}'
EVERYWHERE = [f"--topology={name}" for name in ("ring", "full", "line", "scale-free", "{networkx = 'cycle_graph'}")]
MUTE = """'''It speaks of nothing that a liar knows.'''
MEMORY = {"t": 0.0}
MESSAGE = ("t",)
def observe(me, blacks, looks):
    me.t += looks
def broadcast(me):
    return (me.t,)
def receive(me, message):
    pass
def fuse(me):
    pass
def estimate(me):
    return 0.5
"""
ONE_WAY = '{name = "relay", edges = [[0, 1], [1, 2]], directed = true}'


@pytest.mark.long(only=["change42-options42-at f = 0.55 among 30 % of liars (shouter), not 95 %"])
@pytest.mark.parametrize(
    ("change", "options", "said"),
    [
        (("robots = 10", "robot = 10"), [], "m.toml: unknown key free.robot: did you mean 'robots'?"),
        (("accuracy = 0.8", ""), [], "known.accuracy is missing"),
        (("[known]", "[known"), [], "mission file m.toml: not TOML"),
        ((), ["--accuracy", "0.5"], "cannot be reached, because an accuracy of 0.5 says the same of black and white"),
        ((), ["--minutes", "0.02:0.04"], "cannot be reached, because in 0.0333 min only "),
        ((), ["--minutes", "0.001"], "free.minutes = 0.001"),
        ((), ["--robots", "20:5"], "free.robots = [20, 5]"),
        ((), ["--robots", "0"], "free.robots = 0"),
        ((), ["--robots", "2.5"], "free.robots = 2.5"),
        ((), ["--robots", "many"], "--robots many"),
        ((), ["--density", "2:20"], "--density 2"),
        ((), ["--density", "1,5"], "--density 1,5"),
        ((), ["--topology", TWO_PARTS, "--robots", "5"], "topology 'two' of 5 robots is not connected: it has 2 parts"),
        ((), ["--topology", ONE_WAY, "--robots", "3"], "topology 'relay' of 3 robots is not connected: it has 3 parts"),
        ((), ["--side", "3"], "area.side"),
        ((), ["--truth", "floor"], 'wanted.truth = "floor"'),
        ((), ["--margin", "0.1"], "wanted.margin = 0.1"),
        ((), ["--right", "10", "--fill-ratio", "0.2:0.4"], "because f may be 0.2, on the edge between two bins"),
        ((), ["--right", "most"], 'wanted.right = "most"'),
        ((), ["--right", "majority", "--margin", "0.2"], "wanted.margin = 0.2"),
        ((), ["--fill-ratio", "0.5:1.5"], "known.fill_ratio[1] = 1.5"),
        ((), ["--brain", "voter"], "free.brain = 'voter'"),
        ((), ["--brain", "comons"], "did you mean 'commons'?"),
        ((), ["--confidence", "95"], "wanted.confidence = 95"),
        ((), ["--failing", "1"], "known.failing = 1"),
        (("half_width = 0.05", ""), [], "wanted: should have a half_width"),
        (("half_width = 0.05", 'half_width = 0.05\nright = "majority"'), [], "and not both"),
        (("robots = 10", ""), [], "free: should have robots, or minutes, or both"),
        ((), ["--out", "p.nc"], "--out p.nc"),
        ((), ["--out", "m.toml"], "cannot write m.toml: it is an input"),
        ((), ["--plot", "p.gif"], "--plot p.gif"),
        ((), ["--body", "speed"], "--body speed"),
        ((), ["--body", "speed=fast"], "--body speed=fast"),
        ((), ["--lie", "shouter"], "known.lie"),
        ((), ["--lying", "0.5", "--failing", "0.5"], "leave no robot that works and is honest"),
        ((), ["--lying", "1"], "known.lying = 1"),
        ((), ["--lying", "-0.1"], "known.lying = -0.1"),
        ((), ["--lying", "0.1", "--robots", "1"], "known.lying = 0.1"),
        ((), ["--lying", "0.1", "--lie", "shoutr"], "did you mean 'shouter'?"),
        ((), ["--lying", "0.1", "--lie", "commons"], "known.lie = 'commons'"),
        ((), ["--lying", "0.1", "--lie", "random", "--lie", "random"], "known.lie: random is there twice"),
        ((), ["--lying", "0.1", "--brain", "mute.py"], "known.lie = 'shouter'"),
        ((), ["--lying", "0.3", "--brain", "commons"], "at f = 0.55 among 30 % of liars (shouter), not 95 %"),
        ((), ["--density", "5"], "free.density"),
        ((), ["--topology", "ring", "--topology", "moving"], "or leave it to a swarm density (free.density)"),
        ((), ["--topology", "ring", "--topology", TWO_PARTS], "topology 'two' of 10 robots is not connected"),
        ((), ["--topology", "ring", "--topology", "ring"], "free.topology: ring is there twice"),
        ((), ["--brain", "commons", "--brain", "commons"], "free.brain: commons is there twice"),
        ((), ["--accuracy", "0.4:0.6"], "known.accuracy"),
        ((), ["--accuracy", "0.8", "--accuracy", "0.8"], "known.accuracy: 0.8 is there twice"),
        ((), ["--accuracy", "nan"], "known.accuracy = nan"),
        ((), ["--accuracy", '{black = 0.5, white = "U(0.5, 0.5)"}'], "not even 1e+15 readings are enough"),
        ((), ["--half-width", "1e-9"], "not even 1e+15 readings are enough with an accuracy of 0.8"),
        ((), ["--half-width", "nan"], "wanted.half_width = nan"),
        ((), ["--robots", "2000000000"], "free.robots = 2000000000"),
        ((), ["--robots", "1:2:3"], "--robots 1"),
        ((), ["--minutes", "1e9"], "free.minutes = 1e+09"),
        ((), ["--minutes", "inf"], "free.minutes = inf"),
        ((), ["--plot", "p.png", *EVERYWHERE], "would be 10 lines, and a figure has at most 8"),
        (("[known]", "known = 3\n[other]"), [], "unknown key other"),
        (("[known]", "body = 3\n[known]"), [], "body = 3: should be a table"),
        ((KNOWN, "known = 3\n"), ["--accuracy", "0.7"], "mission file m.toml: known = 3: should be a table"),
        (("[known]", "body = 3\n[known]"), ["--body", "speed=1"], "mission file m.toml: body = 3: should be a table"),
    ],
)
def test_mistakes_write_nothing(change, options, said, here, capsys):
    if change:
        assert change[0] in RING
        Path("m.toml").write_text("trials = 40\n" + RING.replace(*change))
    Path("mute.py").write_text(MUTE)
    out = [] if "--out" in options else ["--out", "p.json"]
    assert main(["plan", "m.toml", *options, *out]) == 2
    *progress, error = capsys.readouterr().err.splitlines()
    assert error.startswith("swarmcensus")
    assert said in error
    assert "Traceback" not in error
    assert not any(line.startswith("swarmcensus") for line in progress)
    assert sorted(os.listdir()) == ["m.toml", "mute.py"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--side", "-3"], "area.side = -3"),
        (["--area", "-4"], "area.area = -4"),
        (["--area", "9"], "area.side"),
        (["--side", "nan"], "area.side = nan"),
        (["--side", "1e9"], "the area is 1e+11 tiles wide: 1,073,741,824 is the most"),
        (["--density", "-3"], "free.density = -3"),
        (["--density", "100"], "free.density = 100"),
        (["--density", "x"], "--density x: should be a number"),
        (["--density", "40", "--robots", "1"], "at a density of 40 fewer than 3 robots have no room to move"),
        (["--density", "5", "--side", "3"], "free.density"),
        (
            ["--density", "9", "--half-width", "0.004", "--truth", "nominal"],
            "0.925 m x 0.925 m, 47 % of floors with f = 0.5",
        ),
        (["--side", "0.1"], "robots = 5"),
        (["--robots", "500"], "free.robots = 500"),
        (["--round-seconds", "2"], "free.round_seconds"),
        (["--side", "1", "--half-width", "0.004", "--truth", "nominal"], "have a share of black of their own"),
    ],
)
def test_areas_that_cannot_be_are_told_too(options, said, here, capsys):
    alone = options[0] == "--density" or options == ["--area", "-4"]
    given = [YARD[0], *YARD[3:]] if alone else YARD
    assert main([*given, *options]) == 2
    assert said in capsys.readouterr().err
    assert sorted(os.listdir()) == ["m.toml"]


STAR = '{name = "star", edges = [[0, 1], [0, 2]]}'
NO_PAIRS = "swarmcensus: mission: the goal cannot be reached, because free.topology 'gnp_random_graph(p=0.0)' of "


@pytest.mark.long(but_every=4)
@pytest.mark.parametrize(
    ("topology", "options", "said"),
    [
        (STAR, [], "free.topology"),
        ("pairs.csv", [], "free.topology"),
        (STAR, ["--robots", "2"], "free.topology"),
        ('{networkx="watts_strogatz_graph", k=4, p=0.1}', [], "free.topology"),
        ('{networkx="grid_2d_graph", m=3, n=3}', [], "500 robots can be made, because networkx.grid_2d_graph gives 9"),
        ('{networkx="random_regular_graph", d=3}', [], "125 robots can be made, because networkx.random_regular"),
        ('{networkx="random_regular_graph", d=3}', ["--robots", "4:99"], "free.topology"),
        ('{networkx="gnp_random_graph", p=0.0}', [], NO_PAIRS + "500 robots is not connected: it has 500 parts"),
    ],
)  # fmt: skip
def test_networks_of_impossible_sizes(topology, options, said, here, capsys):
    Path("pairs.csv").write_text("i,j\n0,1\n1,2\n2,3\n")
    commands = [
        "--accuracy",
        "0.9",
        "--half-width",
        "0.1",
        "--fill-ratio",
        "0.5",
        "--brain",
        "commons",
        "--trials",
        "40",
    ]
    assert main(["plan", *commands, "--minutes", "1", "--topology", topology, *options]) == 2
    *_, error = capsys.readouterr().err.splitlines()
    assert error.startswith("swarmcensus")
    assert said in error
    assert "free.topology" in error


@pytest.mark.long
def test_theory_says_what_it_leaves_out(here, capsys):
    for options, said in (
        (["--link-success", "0.5"], "theory, in minutes, as if no message were lost: "),
        (["--lying", "0.1", "--link-success", "0.5"], "as if nobody lied and no message were lost: "),
    ):
        assert main(["plan", "m.toml", "--minutes", "1", "--brain", "steadfast", *options]) == 0
        assert said in " ".join(capsys.readouterr().out.split())


def test_a_narrow_terminal_has_no_columns_of_theory(here, monkeypatch, capsys):
    monkeypatch.setattr("swarmcensus.support.terminal.console", lambda **_: Console(width=80))
    assert main(["plan", "m.toml", "--minutes", "5"]) == 0
    out = capsys.readouterr().out
    assert "left out, as they do not fit into 80 columns: theory: all, mixed, alone;" in " ".join(out.split())
    assert "theory, in minutes" not in out
    assert "enough" in out
    assert max(map(len, out.splitlines())) <= 80


def test_a_mission_that_is_not_there(here, capsys):
    assert main(["plan", "none.toml"]) == 2
    assert capsys.readouterr().err == "swarmcensus: mission file none.toml: cannot be read: No such file or directory\n"


@pytest.mark.parametrize(
    ("content", "said"),
    [(b"", "known.accuracy is missing"), (b"\x00\xff\x01", "cannot be read as text"), (None, "Is a directory")],
)
def test_a_file_that_is_no_mission(content, said, here, capsys):
    if content is not None:
        Path("other.toml").write_bytes(content)
    assert main(["plan", "other.toml" if content is not None else "."]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert said in line


@pytest.mark.long
def test_a_density_replaces_the_side_of_a_file(here, capsys):
    commands = "[known]\naccuracy = 0.9\n[wanted]\nhalf_width = 0.1\n[free]\nrobots = 4\n"
    Path("yard.toml").write_text("[area]\nside = 3\n" + commands)
    options = ["--minutes", "0.5", "--trials", "40", "--brain", "commons", "--lying", "0.1", "--accuracy", "0.85:0.9"]
    assert main(["plan", "yard.toml", "--density", "3", "--density", "6", *options]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "density 3, 6, accuracy 0.85, the worst of 0.85, 0.9, f from 0 to 1, 10 % lie (shouter); the truth" in out
    assert "brain density robots side, m minutes" in out
    assert "commons 3 4 1.43 0.500" in out
    assert "commons 6 4 1.01 0.500" in out
    assert "theory, in minutes, as if nobody lied" in out


def test_ctrl_c_ends_it_in_a_sentence_and_writes_nothing(here, monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("swarmcensus.search.planning.planning.shortest", interrupted)
    assert main(["plan", "m.toml", "--out", "p.json"]) == 130
    assert capsys.readouterr().err == "swarmcensus: stopped\n"
    assert sorted(os.listdir()) == ["m.toml"]
