"""A study's keys mean the same in every command, and wrong ones are refused in the same sentence."""

import json
from pathlib import Path

import pytest

from swarmcensus.cli.commands import main

STUDY = """trials = 40
swarm = {robots = 6, accuracy = 0.8, brain = "commons"}
world = {topology = "ring", fill_ratio = 0.55, message = "float32"}
schedule = {rounds = 20, observations_per_round = 1}
wanted = {error = 0.2}
groups = {all = "robots > 0"}
"""
COMMANDS = {
    "run": "run s.toml", "plan": "plan s.toml", "watch": "watch s.toml --no-browser",
    "swarm": "swarm s.toml --out logs",
    "tune": "tune p.toml --parameter z=2:3 --budget 13", "leaderboard": "leaderboard --study s.toml",
    "deploy": "deploy commons out --target argos --study s.toml",
    "infer": "infer o.csv --study s.toml",
}  # fmt: skip
WRONG = {  # what is asked, and what is said of it
    "fil_ratio=0.3": "unknown key fil_ratio: did you mean 'fill_ratio'?",
    "robots=0": "swarm.robots = 0: should be greater than or equal to 1",
    "accuracy=1.5": "swarm.accuracy = 1.5: ",
    "accuracy={black=0.8}": "swarm.accuracy = {black = 0.8}: ",
    "topology=rnig": "did you mean 'ring'?",
    "fill_ratio=[0.5": "[0.5: not a value of TOML",
    "message_delay=3": "message_delay may be world.message_delay or world.body.message_delay: say which",
    "density=2": "world.density",
    'members=[{robots=2, brain="nobody"}]': "members[0].brain",
    'faults=[{at=5, robots=1, stop="singing"}]': "faults[0].stop",
    'topology={name="ring", label="moving"}': "this label is the name of another topology or floor",
    "wanted={eror=0.1}": "unknown key wanted.eror: did you mean 'error'?",
    "link_success=nan": "world.link_success = nan: ",
}


@pytest.fixture
def files(here):
    (here / "s.toml").write_text(STUDY)
    (here / "p.toml").write_text(STUDY.replace('"commons"', '{file = "steadfast", z = 2.5}'))
    (here / "o.csv").write_text("1,0,1\n0,0,1\n")


@pytest.mark.parametrize("value", WRONG)
@pytest.mark.parametrize("command", COMMANDS)
def test_wrong_keys_and_values_are_refused_alike(command, value, files, refused):
    before = sorted(Path().rglob("*"))
    said = refused(*COMMANDS[command].split(), "--set", value)
    assert WRONG[value] in said
    assert sorted(Path().rglob("*")) == before


def test_a_group_that_selects_nothing_is_refused_before_anything_runs(files, refused):
    said = refused("leaderboard", "--study", "s.toml", "--set", "groups.x='nosuch == 3'", "--out", "board")
    assert "groups.x = 'nosuch == 3': no coordinate 'nosuch'" in said
    assert not Path("board").exists()


@pytest.mark.interpreted
def test_merged_studies_that_want_different_things_say_so(files, capsys, refused):
    for name, values in (("a", ["error=0.1"]), ("b", ["right=10", "robots=7"])):
        words = [word for value in (*values, "trials=2") for word in ("--set", value)]
        assert main(["run", "s.toml", *words, "--out", f"{name}.nc", "-q"]) == 0
    assert main(["merge", "a.nc", "b.nc", "--out", "c.nc"]) == 0
    capsys.readouterr()
    assert main(["show", "c.nc"]) == 0
    assert "the studies want different things (error = 0.1; right = 10)" in capsys.readouterr().out
    assert "merged studies want different things" in refused(
        "compare", "c.nc", "--factor", "robots", "--metric", "reached"
    )


def test_infer_takes_brain_accuracy_and_rounds_from_a_study(files, capsys):
    words = ["infer", "o.csv", "--json", "--out", "t.csv", "--plot", "t.svg"]
    assert main([*words, "--study", "s.toml", "--set", "accuracy={black=0.9, white=0.7}"]) == 0
    of_study = json.loads(capsys.readouterr().out)["rows"]
    plain = ["--accuracy", "{black=0.9, white=0.7}", "--brain", "commons", "--observations-per-round", "1"]
    assert main([*words, *plain]) == 0
    assert json.loads(capsys.readouterr().out)["rows"] == of_study


def test_deploy_takes_other_values_of_a_study(files, capsys):
    moving = ["--set", "topology=moving", "--set", "density=1", "--set", "schedule={ticks=99}"]
    command = COMMANDS["deploy"].split()
    assert main([*command, *moving, "--set", "robots=7", "--set", "message=float16"]) == 0
    text = Path("out", "commons.argos").read_text()
    assert 'quantity="7"' in text
