"""What is said of a name that is not known, and what programs read of an error."""

import shutil

import pytest

import swarmcensus as sc
from swarmcensus.cli.app import execute
from swarmcensus.results import schema
from swarmcensus.support.errors import InputError, StudyError
from swarmcensus.support.hints import did_you_mean
from tests.support.small import SMALL

KNOWN = [*schema.TEXTS, *schema.NUMBERS, "setting"]


@pytest.mark.parametrize(("written", "meant"), [
    ("accuraccy", "accuracy"), ("N", "robots"), ("f", "fill_ratio"), ("fill", "fill_ratio"), ("C", "rounds"),
    ("topologies", "topology"), ("brains", "brain"), ("R", "observations_per_round"), ("D", "density"),
    ("Fill Ratio", "fill_ratio"), ("obs", "observations_per_round"), ("ROBOTS", "robots"), ("graph", "topology"),
])  # fmt: skip
def test_similar_and_other_names_get_a_hint(written, meant):
    assert did_you_mean(written, KNOWN) == f"did you mean {meant!r}? "


@pytest.mark.parametrize("strange", ["x", "", "--", "xyzzy", "loss", "noise", "members"])
def test_a_name_that_is_like_none_gets_no_hint(strange):
    assert did_you_mean(strange, [*KNOWN, "memory"]) == ""


@pytest.mark.parametrize(("change", "meant"), [
    (("seed ", "rng "), "seed"), (("robots ", "n "), "robots"), (('"ring"', '"scalefree"'), "scale-free"),
    (("swarm = {", 'swarm = {brain = "minimalist", '), "minimalistic"),
    (("measure = {", 'measure = {truth = "flor", '), "floor"),
    (("trials", 'faults = [{at = 1, robots = 1, stop = ["talking", "sense"]}]\ntrials'), "sensing"),
    (("trials", "faults = [{start = 1, robots = 1, stop = 'moving'}]\ntrials"), "at"),
    (('"ring"', '{networkx = "watts_strogatz", k = 2, p = 0.1}'), "watts_strogatz_graph"),
    (('"ring"', '{networks = "watts_strogatz_graph", k = 2}'), "networkx"),
    (('"ring"', '{name = "star", edges = [[0, 1]], direct = true}'), "directed"),
    (("swarm = {", 'swarm = {brain = {files = "minimalistic"}, '), "file"),
    (("swarm = {", "swarm = {assumed_accuracy = {eror = 0.1}, "), "error"),
    (("world = {", "world = {floor = {x = 1, cluster = 0.2}, "), "clusters"),
    (('accuracy = [0.675, "U(0.525, 0.975)"]', "accuracy = {blak = 0.6, white = 0.9}"), "black"),
    (("trials = 4", 'trials = {until = "convergence_eror median +- 0.1"}'), "convergence_error"),
    (("trials = 4", 'trials = {until = "convergence_error medain +- 0.1"}'), "median"),
])  # fmt: skip
def test_study_files(change, meant):
    assert change[0] in SMALL
    with pytest.raises(sc.InputError) as error:
        sc.run(sc.Study.parse(SMALL.replace(*change)))
    assert error.value.hint == meant


@pytest.mark.parametrize("number", ["²", "1" * 5000, "1e3", "-1", "0x3", ""])
def test_numbers_of_options_are_plain(number, capsys):
    with pytest.raises(sc.InputError, match="should be a whole number from 1") as error:
        execute(["run", "x.toml", f"--trials={number}"])
    assert error.value.key == "trials"


@pytest.mark.parametrize(("command", "meant"), [
    ("shwo x.nc", "show"), ("summary x.nc", "show"), ("run x.toml --rng 3", "--seed"),
    ("run x.toml --threads=3", "--jobs"), ("replay small.nc --setting 1 --trail 0", "--trial"),
    ("new example/comare", "example/compare"), ("reproduce rivls", "rivals"), ("reproduce --only fig22", "fig2"),
    ("show small.nc --sort finl", "final error"), ("show smal.nc", "small.nc"), ("run smll.toml", "small.toml"),
    ("plot small.nc --kind lnes", "lines"), ("plot small.nc --kind lines --x robots --y eror", "convergence_error"),
    ("plot small.nc --option scle=linear", "scale"), ("explain small.nc --where robot==5", "robots"),
    ("brains --show shoter", "shouter"),
    ("plan --set robots=9 --set topology=ring --set accuracy=0.8 --set right=majorty", "majority"),
    ("list topology", "topologies"), ("doctor --completion bsh", "bash"), ("show rest.nc", None),
])  # fmt: skip
def test_commands_suggest_what_was_meant(command, meant, small_file, here):
    shutil.copy(small_file, "small.nc")
    for name in ("small.toml", "rest.toml"):
        (here / name).write_text(SMALL)
    with pytest.raises(sc.InputError) as error:
        execute(command.split())
    assert error.value.hint == meant


# ---- errors have a file, a key and a value for programs
def test_error_of_a_file_keeps_inner_fields():
    error = StudyError.within("study file ring.toml", InputError.at("rounds", 0, "should be above 0"))
    assert str(error) == "study file ring.toml: rounds = 0: should be above 0"
    assert (error.file, error.key, error.value) == ("ring.toml", "rounds", 0)
    assert StudyError.within("study", "not TOML").file is None


@pytest.mark.parametrize(("value", "text"), [("mean", "'mean'"), (7, "7")])
def test_error_of_a_named_thing(value, text):
    error = InputError.named("metric", value, "it has changed, did you mean 'median'?")
    assert str(error).startswith(f"metric {text}: it has changed")
    assert (error.key, error.value, error.hint) == ("metric", value, "median")


@pytest.mark.parametrize(("command", "file", "key", "value"), [
    (["export", "small.nc", "--out", "x.xls"], None, "out", "x.xls"),
    (["merge", "none.nc", "small.nc", "--out", "x.nc"], "none.nc", None, None),
    (["plot", "small.nc", "--kind", "curves", "--trial", "99"], None, "trial", 99),
    (["plot", "small.nc", "--kind", "lnes"], None, "kind", "lnes"),
    (["plot", "small.nc", "--kind", "lines", "--x", "eror"], None, "x", "eror"),
    (["run", "small.toml", "--share", "9/9"], None, "share", "9/9"),
    (["run", "broken.toml"], "broken.toml", "world.message_delay", 100),
    (["verify", "small.nc", "--sample", "2"], None, "sample", 2.0),
    (["watch", "--set", "robots=many"], None, "swarm.robots", "many"),
])  # fmt: skip
def test_fields_of_wrong_commands(command, file, key, value, small_file, here):
    (here / "small.nc").write_bytes(small_file.read_bytes())
    (here / "small.toml").write_text(SMALL)
    (here / "broken.toml").write_text(SMALL.replace("world = {", "world = {message_delay = 100, "))
    with pytest.raises(sc.InputError) as caught:
        execute(command)
    assert (caught.value.file, caught.value.key, str(caught.value.value)) == (file, key, str(value))
