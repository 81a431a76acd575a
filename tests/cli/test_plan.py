"""The command `plan`: what it prints and writes, and one sentence for each wish that cannot be."""

import os
import re
import tomllib
from pathlib import Path

import pytest

from swarmcensus import brains
from swarmcensus.cli.commands import main

WORLD = '[world]\ntopology = "ring"\nfill_ratio = 0.55\n'
SWARM = '[swarm]\nrobots = 10\naccuracy = 0.8\nbrain = ["commons", "minimalistic"]\n'
RING = SWARM + WORLD + "[wanted]\nerror = 0.05\n"
YARD = {"side": 3, "accuracy": 0.8, "error": 0.05, "robots": 5}


def keys(*given, **usual):
    """--set for each of these keys, and for the usual ones that are not among them."""
    names = {one.partition("=")[0] for one in given}
    every = [*given, *(f"{name}={value}" for name, value in usual.items() if name not in names)]
    return [word for one in every for word in ("--set", one)]


@pytest.fixture(autouse=True)
def mission(here):
    (here / "m.toml").write_text("trials = 40\n" + RING)


def test_plan_prints_and_writes(accepted):
    words = ["plan", "m.toml", "--out", "p.toml", "--plot", "p.svg", *keys("robots={choose=[5, 20]}")]
    printed = accepted(*words)
    assert "95 % of robots within 0.05 of the truth" in printed.out
    assert printed.out.count("\ncommons  ") == printed.out.count("\nminimalistic  ") == 5
    assert printed.out.count("\ncommons needs ") == printed.out.count("\nminimalistic needs ") == 2  # 5 and 20 robots
    assert all(f" {column}: " in printed.out.replace("\n", " ") for column in ("all", "mixed", "alone"))
    assert re.search(r"^p.toml: .*\np.svg: ", printed.out, re.MULTILINE)
    assert "swarmcensus run p.toml" in printed.out + printed.err
    assert tomllib.loads(Path("p.toml").read_text())["swarm"]["robots"] in (5, 7, 10, 14, 20)
    assert "<svg" in Path("p.svg").read_text()[:500]
    assert "reached" in accepted("run", "p.toml", "--trials", "6").out


@pytest.mark.long
def test_keys_replace_what_the_file_says(accepted):
    changed = keys("right=majority", "brain=voter", "minutes=9")
    Path("m.toml").write_text(Path("m.toml").read_text().replace("error = 0.05", ""))
    out = accepted("plan", "m.toml", *changed).out
    for said in ("in the right half", "whether these are enough; wanted: ", "voter "):
        assert said in out
    assert "commons" not in out
    usual = YARD | {"side": 1, "trials": 40}
    body = keys("body={speed=0.2}", "fill_ratio={worst=[0.5, 0.6]}", **usual)
    assert "fill_ratio 0.5 to 0.6, body {speed = 0.2}, side 1, accuracy 0.8, truth floor" in accepted("plan", *body).out
    single = keys("precision=single", "world.message=ratio16", "fill_ratio=0.6", **usual)
    assert "precision single" in accepted("plan", *single).out


TWO_PARTS = 'topology={name = "two", edges = [[0, 1], [2, 3], [3, 4]]}'
ONE_WAY = 'topology={name = "relay", edges = [[0, 1], [1, 2]], directed = true}'
STAR = 'topology={name = "star", edges = [[0, 1], [0, 2]]}'
GRID = 'topology={networkx="grid_2d_graph", m=3, n=3}'
NO_PAIRS = 'topology={networkx="gnp_random_graph", p=0.0}'
GOAL = {"accuracy": 0.9, "error": 0.1, "fill_ratio": 0.5, "brain": "commons", "trials": 40, "minutes": 1}
LIARS = "members=[{robots = %s, brain = %s, honest = false}]"


@pytest.mark.parametrize(("change", "said"), [
    (("[world]", "[world"), "study file m.toml: not TOML"),
    (("error = 0.05", ""), "wanted: should have an error"),
    (("error = 0.05", 'error = 0.05\nright = "majority"'), "and not both"),
    ((RING[RING.index("[wanted]") :], "[other]\nerror = 0.1\n"), "unknown key other"),
    ((WORLD, "world = 3\n"), "unknown key swarm.world"),
])  # fmt: skip
def test_faults_of_files(change, said, here, refused):
    (here / "m.toml").write_text(RING.replace(*change))
    assert said in refused("plan", "m.toml", "--out", "p.toml")


OF_A_FILE = [
    (["accuracy=0.5"], "cannot be reached, because an accuracy of 0.5 says the same of black and white"),
    (['accuracy={black = 0.5, white = "U(0.5, 0.5)"}'], "not even 1e+15 readings are enough"),
    (["minutes={choose=[0.02, 0.04]}"], "cannot be reached, because in 0.0333 min only "),
    (["minutes=inf"], "wanted.minutes = inf"),
    (["robots=50", "accuracy=0.51", "error=0.0002"], "would take over an hour of a core: wish for less; theory "),
    (["robots={choose=[20, 5]}"], "swarm.robots = {choose = [20, 5]}: should have two numbers, the lower one first"),
    (["robots={choose=[20]}"], "should have two numbers, the lower one first"),
    (["robots={worst=[20, 30]}"], "swarm.robots = {worst = [20, 30]}: should be {choose = ...}"),
    (["link_success={worst=[0.5, 1]}"], "{worst = ...} goes with swarm.accuracy, world.fill_ratio"),
    ([TWO_PARTS, "robots=5"], "'two' of 5 robots is not connected: it has 2 parts"),
    ([ONE_WAY, "robots=3"], "'relay' of 3 robots is not connected: it has 3 parts"),
    (["side=3"], "world.side"),
    (["fill_ratio={worst=[0.5, 1.5]}"], "world.fill_ratio[1] = 1.5"),
    (["brain=voter"], "swarm.brain = voter"),
    (["trials=20"], "trials = 20: a plan needs a whole number from 40"),
    (["fill_ratio={from=0.8, to=0.2, at=9}"], "a plan is for a floor that stays"),
    ([LIARS % (0.1, '{worst = ["minimalistic"]}'), "brain=minimalistic"], "members[0].brain = minimalistic"),
    ([LIARS % (0.1, '["random", "shouter"]')], "or of brains {worst = [...]} in place of a list"),
    (["case=[{robots=7}]"], "case: a plan has no cases"),
    (["faults=[{at=3, robots=1, do='kill'}]"], "faults[0].do"),
    ([LIARS % (0.3, '"shouter"'), "brain=commons"], "at f = 0.55 among liars (shouter), not 95 %"),
]
OF_A_YARD = [
    (["side=-4"], "world.side = -4: should be greater than 0"),
    (["side=1e9"], "tiles"), (["side=0.1"], "side"), (["robots=500"], "500 robots"),
    (["side=1", "error=0.004", "truth=nominal"], "have a share of black of their own"),
    (["density=5"], "world.density and world.side both say how large"),
    (["right=10", "fill_ratio={worst=[0.2,0.4]}", "error=0.1"], "not both"),
]  # fmt: skip
OF_A_GOAL = [([STAR, "robots=2"], "topology"), ([NO_PAIRS], "is not connected: it has ")]
OF_A_GOAL += [([one], "say how many robots there are") for one in (STAR, "topology=pairs.csv", GRID)]
FAULTS = [(["m.toml"], {}, *row) for row in OF_A_FILE] + [([], YARD, *row) for row in OF_A_YARD]


@pytest.mark.parametrize(("file", "usual", "values", "said"), FAULTS + [([], GOAL, *row) for row in OF_A_GOAL])
def test_faults_of_keys_write_nothing(file, usual, values, said, here, refused):
    (here / "pairs.csv").write_text("i,j\n0,1\n1,2\n2,3\n")
    assert said in refused("plan", *file, *keys(*values, **usual), "--out", "p.toml")


@pytest.mark.parametrize(("words", "said"), [
    (["--out", "m.toml"], "cannot write m.toml: it is an input"),
    (["--out", "p.json"], "p.json"),
    (["--out", "other/p.toml", *keys("brain=mine.py")], "paths in it are relative to its folder"),
])  # fmt: skip
def test_faults_of_files_to_write(words, said, here, refused):
    (here / "mine.py").write_text(brains.load("minimalistic").source)
    assert said in refused("plan", "m.toml", *words)


def test_a_mission_says_what_it_lacks(refused):
    given = {"side": 5, "robots": 20, "accuracy": 0.7, "error": 0.02}
    for lacks, said in (
        ("accuracy", "swarm.accuracy is missing"), ("error", "wanted: should have an error"),
        ("side", "need a swarm density, such as 1, or the side"),
        ("robots", "swarm.robots or wanted.minutes should be given"),
    ):  # fmt: skip
        assert said in refused("plan", *keys(**{key: value for key, value in given.items() if key != lacks}))


@pytest.mark.long
def test_theory_says_what_it_leaves_out(accepted):
    liars = LIARS % (0.1, '"shouter"')
    for values, said in (
        (["link_success=0.5"], "knew all readings at once, and no message were lost; mixed: "),
        (["link_success=0.5", liars], "at once, and nobody lied, and no message were lost; mixed: "),
    ):
        assert said in " ".join(accepted("plan", "m.toml", *keys("minutes=1", "brain=steadfast", *values)).out.split())


@pytest.mark.long
def test_a_density_replaces_the_side_of_a_file(accepted):
    swarm = '[swarm]\nrobots = 4\naccuracy = {worst = [0.85, 0.9]}\nbrain = "commons"\n'
    Path("yard.toml").write_text(f"trials = 40\n{swarm}[world]\nside = 3\n[wanted]\nerror = 0.1\nminutes = 0.5\n")
    out = " ".join(accepted("plan", "yard.toml", *keys("density=[3, 6]", LIARS % (0.25, '"shouter"'))).out.split())
    for said in ("accuracy 0.85, the worst of 0.85, 0.9", "brain density robots side, m minutes",
                 "commons 3.0 4 1.43 0.500", "commons 6.0 4 1.01 0.500", "at once, and nobody lied"):  # fmt: skip
        assert said in out


def test_ctrl_c_ends_it_in_a_sentence_and_writes_nothing(monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("swarmcensus.search.planning.planning.shortest", interrupted)
    assert main(["plan", "m.toml", "--out", "p.toml"]) == 130
    assert capsys.readouterr().err.splitlines()[-1] == "swarmcensus: stopped"
    assert sorted(os.listdir()) == ["m.toml"]


def test_run_refuses_what_a_plan_finds_and_a_time_that_is_not_its_own(refused):
    whole = Path("m.toml").read_text()
    for change, said in (
        (("robots = 10", "robots = {choose = [5, 9]}"), "swarmcensus plan m.toml finds a value between these"),
        (("accuracy = 0.8", "accuracy = {worst = [0.7, 0.8]}"), "swarmcensus plan m.toml finds the worst of these"),
        (("error = 0.05", "error = 0.05\nminutes = 3"), "wanted.minutes = 3: that is 180 rounds, and a trial has"),
        (("error = 0.05", "margin = 0.05"), "should have an error, such as 0.02, or right"),
    ):
        Path("m.toml").write_text(whole.replace(*change))
        assert said in refused("run", "m.toml")
