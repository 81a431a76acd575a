"""The command `tune`: what it writes, what it says where it cannot, and that a killed one goes on."""

import csv
import json
import os
import tomllib
from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.search.tuning.training import Training
from swarmcensus.support.owners import Owner
from tests.support.options import with_usual
from tests.support.tunable import SOURCE, text_of

TUNE = ["tune", "s.toml", "--parameter", "a=0:1", "--parameter", "idle=1:9:log", "--trials", "2"]


@pytest.fixture(autouse=True)
def study(here):
    Path("tunable.py").write_text(SOURCE)
    Path("s.toml").write_text(text_of("a = 0.1, noise = 0.1", others=', "minimalistic"', accuracy=0.8))


def lines_of(path):
    """The lines of a log, without the seconds."""
    with open(path, newline="") as file:
        return [row if row[0].startswith("#") else row[:-1] for row in csv.reader(file)]


@pytest.mark.long
def test_it_writes_a_fragment_a_log_and_results(here, accepted):
    out = accepted(*TUNE, "--budget", "37").out
    assert out.startswith("final error: tunable.py a=")
    assert out.splitlines()[-1].startswith("tunable-tuned.toml: 37 evaluations, ")
    text = Path("tunable-tuned.toml").read_text()
    [brain] = tomllib.loads(text)["swarm"]["brain"]
    assert brain.pop("file") == "tunable.py"
    assert brain.keys() == {"a", "noise", "idle"}  # all that was searched
    assert brain["idle"] == 1.0  # of which it is said that it changes nothing
    assert " idle=1 is better than tunable.py a=0.1 idle=1: " in out  # the noise is the same in both
    assert all(len(line) < 120 for line in text.splitlines())
    said = "seed 1, the study's own|a=0:1|idle=1:9:log|37 evaluations|idle changes nothing"
    assert all(one in text.replace("\n#  ", "") for one in said.split("|"))
    assert sc.load("tunable-tuned.nc").attrs["title"].startswith("tuned: tunable.py")
    assert main(["compare", "tunable-tuned.nc", "--metric", "final_error"]) == 0
    assert sorted(os.listdir()) == [
        "s.toml", "tunable-tuned.csv", "tunable-tuned.nc", "tunable-tuned.toml", "tunable.py"
    ]  # fmt: skip
    before = Path("tunable-tuned.toml").read_bytes()
    assert "found 37 evaluations" in accepted(*TUNE, "--budget", "37").err
    assert Path("tunable-tuned.toml").read_bytes() == before


@pytest.mark.parametrize(("changed", "said"), [
    ("--parameter b=0:1", "--parameter b=0"),
    ("--parameter idl=0:1", "did you mean 'idle'?"),
    ("--parameter a=1:0", "--parameter a=1"),
    ("--parameter a=0:1:log", "both ends should be above 0"),
    ("--parameter many=0:1.5:whole", "both ends should be whole"),
    ("--parameter a=0:1 --parameter a=0:2", "a is given twice"),
    ("--parameter pair=0:1 --parameter pair[1]=0:2", "pair[1] is given twice"),
    ("--parameter a[0]=0:1", "there is no 'a[0]'"),
    ("--brain minimalistic", "--brain minimalistic"),
    ("--metric finalerror", "--metric finalerror"),
    ("--metric right_consensus_round", "no variable consensus_round and no consensus_right"),
    ("--metric correct:low", "of correct, high is better"),
    ("--budget 5", "--budget 5"),
    ("--trials 1000000", "--trials 1000000"),
    ("--out s.toml", "cannot write s.toml: it is an input"),
])  # fmt: skip
def test_what_cannot_be_is_said_in_one_sentence(changed, said, refused):
    assert said in refused(*TUNE[:-2], *with_usual(changed.split(), TUNE[-2:]))


def test_a_study_without_parameters_and_one_with_several(refused):
    text = Path("s.toml").read_text()
    Path("s.toml").write_text(text.replace('{file = "tunable.py", a = 0.1, noise = 0.1}, ', ""))
    assert "no brain of the study (minimalistic) has PARAMETERS" in refused(*TUNE)
    Path("other.py").write_text(SOURCE)
    Path("s.toml").write_text(text.replace('"minimalistic"', '"tunable.py", "other.py"'))
    assert "several brains have parameters" in refused(*TUNE)


@pytest.mark.long(but=["seed"])
@pytest.mark.parametrize("differs", ["parameters", "metric", "seed", "worlds", "source", "version"])
def test_a_log_of_another_search_is_refused(differs, monkeypatch, refused):
    again = {"metric": [*TUNE, "--metric", "convergence_error"], "seed": [*TUNE, "--seed", "9"]}.get(differs, TUNE)
    assert main([*TUNE, "--budget", "13"]) == 0
    if differs == "parameters":
        again = ["a=0:2" if word == "a=0:1" else word for word in TUNE]
    elif differs == "worlds":
        Path("s.toml").write_text(Path("s.toml").read_text().replace("fill_ratio = 0.5", "fill_ratio = 0.6"))
    elif differs == "source":
        Path("tunable.py").write_text(SOURCE + "\n# another\n")
    elif differs == "version":
        monkeypatch.setattr("swarmcensus.search.tuning.plans.__version__", "9.9")
    error = refused(*again, "--budget", "13")
    assert f"tunable-tuned.csv is of another search: {differs} is " in error
    assert "--fresh" in error
    assert main([*again, "--budget", "13", "--fresh"]) == 0


@pytest.mark.parametrize("where", ["tuning.new_search", "training.Training.compile"])
def test_ctrl_c_before_the_first_evaluation(where, here, capsys, monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"swarmcensus.search.tuning.{where}", stop)
    assert main(TUNE) == 130
    assert "kept" not in capsys.readouterr().err
    assert sorted(os.listdir()) == ["s.toml", "tunable.py"]


@pytest.mark.long
def test_ctrl_c_keeps_finished_evaluations(here, capsys, monkeypatch):
    through, calls = Training.run, []

    def stop(*given):
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return through(*given)

    with monkeypatch.context() as patch:
        patch.setattr(Training, "run", stop)
        assert main([*TUNE, "--budget", "37"]) == 130
    said = capsys.readouterr().err
    assert "kept finished evaluations in tunable-tuned.csv: the same command continues" in said
    assert sorted(os.listdir()) == ["s.toml", "tunable-tuned.csv", "tunable.py"]
    kept = lines_of("tunable-tuned.csv")
    for out in ("tunable-tuned.toml", "whole.toml"):
        assert main([*TUNE, "--budget", "37", "--out", out]) == 0
    assert 3 < len(kept) < len(lines_of("whole.csv"))
    assert kept == lines_of("whole.csv")[: len(kept)]
    assert lines_of("tunable-tuned.csv") == lines_of("whole.csv")


def test_two_searches_on_one_output(refused):
    with Owner(Path(".tunable-tuned.csv.lock")):
        assert "tunable-tuned.csv: another search is writing it" in refused(*TUNE, "--budget", "13")


def test_explanation_as_json(here, accepted):
    printed = accepted(*TUNE, "--budget", "13", "--json")
    found = json.loads(printed.out, parse_constant=pytest.fail)
    assert (found["format"], found["command"]) == ("swarmcensus answer 1", "tune")
    brain = tomllib.loads(Path("tunable-tuned.toml").read_text())["swarm"]["brain"][0]
    assert found["values"]["a"] == brain["a"]
    assert "tunable-tuned.toml: 13 evaluations" in printed.err
    assert [row["world"] for row in found["rows"]] == [0]
