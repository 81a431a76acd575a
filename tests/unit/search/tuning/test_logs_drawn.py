"""The log of a search is a results file of its own: what `show` and `plot` make of it, also while the search runs."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.search import candidates_in
from swarmcensus.support.errors import InputError
from swarmcensus.support.quantities import BEST, SEARCHED
from tests.support.tunable import SOURCE, study_of


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """A search with three generations, and the folder of its log, which is t.csv."""
    folder = tmp_path_factory.mktemp("searched")
    (folder / "tunable.py").write_text(SOURCE)
    study = study_of(folder, "a = 0.1, noise = 0.1")
    return sc.tune(study, ["a=0:1", "idle=1:9:log"], budget=37, trials=2, out=folder / "t.toml"), folder


@pytest.fixture
def log(searched, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_bytes((searched[1] / "t.csv").read_bytes())
    return Path("t.csv")


def test_the_dataset_has_every_candidate(searched, log):
    found, data = searched[0], candidates_in(log)
    assert data.attrs[SEARCHED] == "final_error"
    assert data.sizes == {"setting": 37, "trial": 1}
    for k, name in enumerate(("a", "idle")):
        assert data[name].values.tolist() == [one.values[k] for one in found.evaluations]
    assert data["loss"].values[:, 0].tolist() == [one.loss for one in found.evaluations]
    assert data["final_error"].values[:, 0].tolist() == [one.numbers[0] for one in found.evaluations]
    # all robots of this brain err by (a - 0.6)^2, but for noise of up to 0.05
    expected = (data["a"].values - 0.6) ** 2
    assert data["final_error"].values[:, 0] == pytest.approx(expected, abs=0.05)


def test_the_best_so_far_is_that_of_whole_generations(log):
    data = candidates_in(log)
    values, generation = data["final_error"].values[:, 0], data["generation"].values
    best = [values[generation <= g].min() for g in generation]
    assert data[f"{BEST}final_error"].values[:, 0].tolist() == best
    assert (np.diff(best) <= 0).all()


def test_high_numbers_are_best_of_what_is_to_be_high(searched, tmp_path):
    study = study_of(searched[1], "a = 0.1, noise = 0.1")
    sc.tune(study, ["a=0:1"], None, "correct", budget=25, trials=2, out=tmp_path / "c.toml")
    data = candidates_in(tmp_path / "c.csv")
    assert data[f"{BEST}correct"].values[-1, 0] == data["correct"].values.max()
    assert "final_error" in data  # which breaks ties


def test_show_prints_candidates(log, capsys):
    assert main(["show", "t.csv", "--sort", "loss", "--save", "sorted.csv"]) == 0
    assert "the least loss so far, 0." in capsys.readouterr().out
    rows = [*csv.DictReader(Path("sorted.csv").read_text(encoding="utf-8").splitlines())]
    assert len(rows) == 37
    losses = [float(row["loss"]) for row in rows]
    assert losses == sorted(losses)
    assert [*rows[0]][:5] == ["evaluation", "generation", "a", "idle", "loss"]
    assert main(["show", "t.csv", "--json", "--where", "generation == 3"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert {row["generation"] for row in said["rows"]} == {3}
    assert "37 evaluations in 3 generations" not in said["title"]  # of these
    assert said["sentences"][0].startswith("the least loss so far, 0.")


def test_lines_and_dots_are_those_of_the_log(log):
    data = candidates_in(log)
    lines, dots = sc.plot.lines(data, width=3.5).axes[0], sc.plot.scatter(data, x="a", width=3.5).axes[0]
    (line,) = [one for one in lines.lines if str(one.get_label()).startswith("line ")]
    best = data[f"{BEST}final_error"].values[:, 0]
    assert line.get_xdata().tolist() == [0, 1, 2, 3]
    assert line.get_ydata().tolist() == best[[0, 12, 24, 36]].tolist()
    assert lines.get_ylabel() == "best final error"
    assert dots.get_xscale() == "linear"  # as it was searched
    assert sc.plot.scatter(data, x="idle").axes[0].get_xscale() == "log"
    drawn = np.concatenate([d.get_xydata() for d in dots.lines if str(d.get_label()).startswith("dots ")])
    assert sorted(map(tuple, drawn.tolist())) == sorted(
        zip(data["a"].values.tolist(), data["final_error"].values[:, 0].tolist(), strict=True)
    )


def test_a_scatter_plot_of_trials_against_any_number():
    study = sc.Study(
        trials=3, swarm={"robots": [5, 9], "accuracy": 0.8}, world={"topology": "ring", "fill_ratio": 0.3},
        schedule={"rounds": 10},
    )  # fmt: skip
    results = sc.run(study)
    (axes,) = sc.plot.scatter(results, x="robots", y="final_error").axes
    drawn = np.concatenate([d.get_xydata() for d in axes.lines if str(d.get_label()).startswith("dots ")])
    table = sc.frame(results).groupby(["robots", "trial"])["final_estimate"]
    expected = table.apply(lambda x: (x - 0.3).abs().median()).reset_index()
    assert drawn == pytest.approx(expected[["robots", "final_estimate"]].to_numpy())
    with pytest.raises(InputError, match="no numbers"):
        sc.plot.scatter(results, x="topology")
    with pytest.raises(InputError, match="goes with x"):
        sc.plot.scatter(results, y="final_error")


def test_the_command_draws_it_also_while_the_search_is_at_work(log, capsys):
    whole = log.read_bytes()
    lines = whole.splitlines(keepends=True)
    log.write_bytes(b"".join(lines[:20]) + lines[20][:9])  # as a search leaves it that is writing
    assert main(["plot", "t.csv", "--kind", "lines"]) == 0
    assert main(["plot", "t.csv", "--kind", "scatter", "--x", "idle", "--out", "dots.png"]) == 0
    assert {"t-lines.png", "dots.png"} <= {path.name for path in Path().iterdir()}
    capsys.readouterr()
    assert main(["show", "t.csv", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["rows"]) == 17


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("plot t.csv --kind curves", "lines and scatter draw candidates"),
        ("compare t.csv", "t.csv is the log of a search"),
        ("show t.csv --sort lost", "did you mean 'loss'"),
        ("plot t.csv --x b", "x 'b': the coordinates that vary here are a, "),
        ("show head.csv", "head.csv has no evaluation yet"),
    ],
)
def test_what_a_log_has_not_is_refused(command, said, log, refused):
    Path("head.csv").write_bytes(b"".join(log.read_bytes().splitlines(keepends=True)[:1]))
    assert said in refused(*command.split())
