"""What is said of a name that is not known."""

import re
import shutil

import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import execute, main
from swarmcensus.results import structure
from swarmcensus.results.selecting import where
from swarmcensus.support.hints import OTHER_WORDS, did_you_mean
from tests.support.small import SMALL

KNOWN = [*structure.TEXTS, *structure.NUMBERS, "setting"]


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("accuraccy", "accuracy"), ("N", "robots"), ("f", "fill_ratio"), ("fill", "fill_ratio"), ("C", "rounds"),
        ("topologies", "topology"), ("brains", "brain"), ("R", "observations_per_round"), ("D", "density"),
        ("Fill Ratio", "fill_ratio"), ("obs", "observations_per_round"),
        ("ROBOTS", "robots"), ("looks", "observations_per_round"),
    ],
)  # fmt: skip
def test_names_that_are_like_one_or_mean_one(written, meant):
    assert did_you_mean(written, KNOWN) == f"did you mean {meant!r}? "


@pytest.mark.parametrize("strange", ["x", "", "--", "xyzzy", "loss", "noise"])
def test_a_name_that_is_like_none_gets_no_hint(strange):
    assert did_you_mean(strange, KNOWN) == ""


def test_other_words_name_one_thing_each_where_they_meet():
    """Rounds and ticks stand in one table, and go with other topologies: either may be meant."""
    words = [word for name, others in OTHER_WORDS.items() if name != "ticks" for word in others]
    assert len(words) == len(set(words))
    assert did_you_mean("rng", ["trials", "seed"]) == "did you mean 'seed'? "


@pytest.mark.parametrize(
    ("change", "meant"),
    [
        (("seed ", "rng "), "seed"), (("robots ", "n "), "robots"), (("accuracy ", "sensors "), "accuracy"),
        (('"ring"', '"rng"'), "ring"), (('"ring"', '"scalefree"'), "scale-free"),
        (("[swarm]", '[swarm]\nbrain = "minimalist"'), "minimalistic"),
        (("[measure]", '[measure]\ntruth = "flor"'), "floor"),
        (("[measure]", '[[faults]]\nat = 1\nrobots = 1\nstop = "talk"\n[measure]'), "talking"),
        (("[measure]", '[[faults]]\nat = 1\nrobots = 1\nstop = ["talking", "sense"]\n[measure]'), "sensing"),
        (("[measure]", "[[faults]]\nstart = 1\nrobots = 1\nstop = 'moving'\n[measure]"), "at"),
        (('"ring"', '{networkx = "watts_strogatz", k = 2, p = 0.1}'), "watts_strogatz_graph"),
        (('"ring"', '{networks = "watts_strogatz_graph", k = 2}'), "networkx"),
        (('"ring"', '{name = "star", edge = [[0, 1]]}'), "edges"), (('"ring"', '{fiel = "links.csv"}'), "file"),
        (('"ring"', '{name = "star", edges = [[0, 1]], direct = true}'), "directed"),
        (("[swarm]", '[swarm]\nbrain = {files = "minimalistic"}'), "file"),
        (("[swarm]", "[swarm]\nassumed_accuracy = {eror = 0.1}"), "error"),
        (("[world]", "[world]\nfloor = {x = 1, cluster = 0.2}"), "clusters"),
    ],
)  # fmt: skip
def test_study_files(change, meant):
    with pytest.raises(sc.InputError, match=re.escape(f"did you mean '{meant}'?")) as error:
        sc.run(sc.Study.parse(SMALL.replace(*change)))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("floor", "meant"),
    [('"cluster"', "clusters"), ("{stripe = 0.5}", "stripes"), ('{image = "a.png", mode = "dithered"}', "dither")],
)
def test_floors(floor, meant):
    text = f"trials = 1\nswarm = {{robots = 2, accuracy = 0.7}}\nschedule = {{ticks = 5}}\n[world]\nfloor = {floor}\n"
    with pytest.raises(sc.InputError, match=re.escape(f"did you mean '{meant}'?")):
        sc.Study.parse(f'{text}topology = "moving"\ndensity = 1\nfill_ratio = 0.5\n')


def test_where(small_results):
    with pytest.raises(sc.InputError, match="no coordinate 'topologies': did you mean 'topology'"):
        where(small_results, 'topologies == "ring"')
    says = "no setting is so: did you mean 'ring'? topology is full, ring, line, scale-free"
    with pytest.raises(sc.InputError, match=re.escape(says)):
        where(small_results, 'robots == 5 and topology == "rng"')
    with pytest.raises(sc.InputError, match=r"no setting is so: robots is 5, 12$"):
        where(small_results, "7 == robots")
    with pytest.raises(sc.InputError, match=r"no setting is so$"):
        where(small_results, "robots > 12")


@pytest.mark.parametrize(
    ("command", "meant"),
    [
        (["shwo", "x.nc"], "show"), (["summary", "x.nc"], "show"),
        (["export", "x.nc", "--format", "cvs"], "csv"), (["run", "x.toml", "--rng", "3"], "--seed"),
        (["run", "x.toml", "--threads=3"], "--jobs"), (["plot", "x.nc", "--wehre", "a"], "--where"),
    ],
)  # fmt: skip
def test_commands_and_options(command, meant, capsys):
    assert main(command) == 2
    said = capsys.readouterr().err
    assert f"did you mean '{meant}'?" in said
    assert said.startswith(
        f"swarmcensus {command[0]}: " if command[0] in ("run", "plot", "export") else "swarmcensus: "
    )
    assert said.count("\n") == 1


@pytest.mark.parametrize("number", ["²", "1" * 5000, "1e3", "-1", "0x3", ""])
def test_numbers_of_options_are_plain(number, capsys):
    with pytest.raises(sc.InputError, match="should be a whole number from 1") as error:
        execute(["run", "x.toml", f"--trials={number}"])
    assert error.value.key == "trials"


def test_parts_of_the_paper(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["reproduce", "--only", "fig22"]) == 2
    assert "did you mean 'fig2'?" in capsys.readouterr().err


def test_python_names_what_was_meant():
    with pytest.raises(AttributeError) as error:
        sc.sumary  # noqa: B018
    assert (error.value.name, error.value.obj) == ("sumary", sc)  # what a traceback makes its own hint from


@pytest.mark.parametrize(
    ("change", "meant"),
    [
        (('accuracy = [0.675, "U(0.525, 0.975)"]', "accuracy = {blak = 0.6, white = 0.9}"), "black"),
        (("trials = 4", 'trials = {until = "convergence_eror median +- 0.1"}'), "convergence_error"),
        (("trials = 4", 'trials = {until = "convergence_error medain +- 0.1"}'), "median"),
        (("trials = 4", 'trials = {util = "convergence_error median +- 0.1"}'), "until"),
    ],
)
def test_what_a_table_or_a_rule_may_say(change, meant):
    assert change[0] in SMALL
    with pytest.raises(sc.InputError, match=re.escape(f"did you mean '{meant}'?")):
        sc.Study.parse(SMALL.replace(*change))


@pytest.mark.parametrize(
    ("command", "meant"),
    [
        (["studies", "comare"], "example/compare"),
        (["studies", "toplogies"], "paper/topologies"),
        (["reproduce", "rivls"], "rivals"),
        (["show", "small.nc", "--sort", "eror"], "error"),
        (["show", "small.nc", "--sort", "finl"], "final error"),
        (["plot", "small.nc", "--kind", "lnes"], "lines"),
        (["plot", "small.nc", "--kind", "lines", "--x", "robots", "--y", "eror"], "final_error"),
        (["plot", "small.nc", "--set", "scle=linear"], "scale"),
        (["explain", "small.nc", "--where", "robot == 5"], "robots"),
        (["brains", "--show", "comons"], "commons"),
        (["brains", "--show", "shoter"], "shouter"),
        (["leaderboard", "comons"], "commons"),
        (["plan", "--robots", "9", "--topology", "ring", "--accuracy", "0.8", "--right", "majorty"], "majority"),
        (["show", "smal.nc"], "small.nc"),
        (["run", "smll.toml"], "small.toml"),
        (["list", "topology"], "topologies"),
        (["completion", "bsh"], "bash"),
        (["replay", "small.nc", "--setting", "1", "--trail", "0"], "--trial"),
        (["doctor", "--jsn"], "--json"),
    ],
)  # fmt: skip
def test_commands_suggest_what_was_meant(command, meant, small_file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(small_file, "small.nc")
    (tmp_path / "small.toml").write_text(SMALL)
    with pytest.raises(sc.InputError) as error:
        execute(command)
    assert error.value.hint == meant


def test_a_file_that_is_like_none_beside_it_gets_no_hint(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other.nc").touch()
    (tmp_path / "rest.toml").touch()
    assert main(["show", "rest.nc"]) == 2
    assert capsys.readouterr().err == "swarmcensus: results file rest.nc: there is no such file\n"
