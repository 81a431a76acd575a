"""Errors have a file, a key and a value for programs."""

import pytest

import swarmcensus as sc
from swarmcensus.cli.app import execute
from swarmcensus.support.errors import InputError, StudyError
from tests.support.small import SMALL


def test_error_of_a_file_keeps_inner_fields():
    inner = InputError.at("rounds", 0, "should be above 0")
    error = StudyError.within("study file ring.toml", inner)
    assert str(error) == "study file ring.toml: rounds = 0: should be above 0"
    assert (error.file, error.key, error.value) == ("ring.toml", "rounds", 0)
    assert StudyError.within("study", "not TOML").file is None


@pytest.mark.parametrize(("value", "text"), [("mean", "'mean'"), (7, "7")])
def test_error_of_a_named_thing(value, text):
    error = InputError.named("metric", value, "it has changed, did you mean 'median'?")
    assert str(error).startswith(f"metric {text}: it has changed")
    assert (error.key, error.value, error.hint) == ("metric", value, "median")


@pytest.mark.parametrize(
    ("command", "file", "key", "value"),
    [
        (["export", "small.nc", "--out", "x.xls"], None, "out", "x.xls"),
        (["merge", "none.nc", "small.nc", "--out", "x.nc"], "none.nc", None, None),
        (["plot", "small.nc", "--kind", "curves", "--trial", "99"], None, "trial", 99),
        (["plot", "small.nc", "--kind", "lnes"], None, "kind", "lnes"),
        (["plot", "small.nc", "--kind", "lines", "--x", "eror"], None, "x", "eror"),
        (["run", "small.toml", "--share", "9/9"], None, "share", "9/9"),
        (["run", "broken.toml"], "broken.toml", "world.message_delay", 100),
        (["verify", "small.nc", "--sample", "2"], None, "sample", 2.0),
        (["watch", "--set", "robots=many"], None, "swarm.robots", "many"),
    ],
)
def test_fields_of_wrong_commands(command, file, key, value, small_file, here):
    (here / "small.nc").write_bytes(small_file.read_bytes())
    (here / "small.toml").write_text(SMALL)
    (here / "broken.toml").write_text(SMALL.replace("world = {", "world = {message_delay = 100, "))
    with pytest.raises(sc.InputError) as caught:
        execute(command)
    error = caught.value
    assert (error.file, error.key, str(error.value)) == (file, key, str(value))
