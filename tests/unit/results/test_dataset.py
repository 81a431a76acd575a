"""The dataset: its schema, its file, its table."""

import json
import sys
import types

import h5py
import numpy as np
import pandas as pd
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.figures.notebook import shown
from swarmcensus.results import store as results
from swarmcensus.results.reading import packed, readable
from swarmcensus.runs import progress
from swarmcensus.runs.collect import Progress
from swarmcensus.studies.coordinates import NUMERIC
from swarmcensus.summaries import measures
from swarmcensus.summaries.selecting import where
from swarmcensus.worlds import sensors
from swarmcensus.worlds.spreads import uniform


def test_schema(small_results):
    assert dict(small_results.sizes) == {"setting": 32, "trial": 4, "robot": 12, "checkpoint": 2}
    assert small_results["checkpoint"].values.tolist() == [10, 60]
    for dims, names in (
        (("setting",), "brain topology robots density fill_ratio rounds observations_per_round accuracy"),
        (("setting", "trial", "robot"), "convergence_round convergence_error final_estimate"),
        (("setting", "checkpoint", "trial"), "correct"),
    ):
        assert {name: small_results[name].dims for name in names.split()} == dict.fromkeys(names.split(), dims)
    assert "U(0.525,0.975)" in small_results["accuracy"].values
    assert packed(small_results)["convergence_round"].dtype == np.int32


def test_provenance(small_results, small_study):
    attributes = small_results.attrs
    assert (attributes["study"], attributes["seed"]) == (small_study.text, 7)
    assert attributes["swarmcensus_version"] == sc.__version__
    assert "numba" in attributes["library_versions"]
    assert json.loads(attributes["brains"])["minimalistic"]["sha256"] == brains.load("minimalistic").sha256
    assert attributes["trials_done"] == attributes["trials_total"] == 128


def test_file_and_back(small_results, small_file):
    assert sc.load(small_file).identical(small_results)
    with xr.open_dataset(small_file, engine="h5netcdf") as plain:  # other readers see what is missing too
        for name in ("final_estimate", "convergence_round"):
            assert plain[name].variable.equals(small_results[name].variable)
        assert not {*NUMERIC} & {*plain.variables}


def test_missing_times_are_nan_in_python(small_results, small_file, tmp_path):
    times = small_results["convergence_round"]
    exists = xr.DataArray(np.arange(12), dims="robot") < small_results["robots"]
    assert (times.notnull() == exists).all()
    assert times.min() >= 0
    kept = results.load_packed(small_file)
    assert kept["convergence_round"].dtype == np.int32
    assert kept["convergence_round"].values.min() == -1
    assert packed(small_results).identical(kept)
    assert packed(kept).identical(kept)
    sc.save(sc.load(small_file), tmp_path / "again.nc")
    assert (tmp_path / "again.nc").read_bytes() == small_file.read_bytes()


ACCURACIES = {  # mean b, mean w, standard deviation, drift
    "0.675": (0.675, 0.675, 0.0, 0.0),
    "U(0.525,0.975)": (0.75, 0.75, 0.45 / 12**0.5, 0.0),
    "black=0.9 white=0.6": (0.9, 0.6, 0.0, 0.0),
    "black=U(0.6,0.9) white=0.7": (0.75, 0.7, 0.3 / 12**0.5, 0.0),
    "0.9 drift=-1e-05 least=0.6": (0.9, 0.9, 0.0, -1e-5),
    "elsewhere(1.0)": (np.nan, np.nan, np.nan, 0.0),
}


def test_accuracies_are_numbers_too(small_results):
    few = packed(small_results).isel(setting=range(len(ACCURACIES)))
    few = readable(few.assign_coords(accuracy=("setting", np.array([*ACCURACIES], object))))
    found = np.stack([few[name].values for name in NUMERIC], axis=1)
    np.testing.assert_allclose(found, [*ACCURACIES.values()], rtol=1e-12)
    high = few.sel(setting=few.accuracy_black > 0.8)["accuracy"].values.tolist()
    assert high == ["black=0.9 white=0.6", "0.9 drift=-1e-05 least=0.6"]


def test_moments_of_a_distribution_without_its_own(monkeypatch):
    exact = sensors.parse_accuracy("U(0.525,0.975)").moments
    monkeypatch.delattr(uniform, "moments")
    np.testing.assert_allclose(sensors.parse_accuracy("U(0.525,0.975)").moments, exact, rtol=1e-6)


@pytest.mark.parametrize("text", ["N(0.75,0.1)", "N(0.95,0.3)", "N(0.0,0.2)"])
def test_moments_of_normal_accuracies(text):
    mean, same, sd = sensors.parse_accuracy(text).moments
    drawn, _ = sensors.parse_accuracy(text).draw(1, "moments", 0, 1, 200_000)
    assert mean == same
    assert abs(drawn.mean() - mean) < 4 * sd / drawn.size**0.5
    assert abs(drawn.std() - sd) < 4 * sd / drawn.size**0.5


@pytest.mark.parametrize("damage", ["text", "other", "missing", "folder", "zeros"])
def test_what_is_no_results_file(damage, small_file, tmp_path):
    path, whole = tmp_path / "bad.nc", small_file.read_bytes()
    if damage == "text":
        path.write_text("hello")
    elif damage == "other":
        xr.Dataset({"x": 1}).to_netcdf(path, engine="h5netcdf")
    elif damage == "folder":
        path.mkdir()
    elif damage == "zeros":  # as a failing disk leaves them, within a block of texts
        at = whole.index(b"GCOL") + 16
        path.write_bytes(whole[:at] + bytes(64) + whole[at + 64 :])
    with pytest.raises(sc.InputError, match=r"bad\.nc"):
        sc.load(path)


def test_a_disk_that_is_full_leaves_no_file_open(small_results, tmp_path):
    """HDF5 ends the process with a signal where such a file is still open at the end."""
    resource = pytest.importorskip("resource")  # not on Windows
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (9_000, before[1]))
    try:
        with pytest.raises(sc.InputError, match="cannot write"):
            sc.save(small_results, tmp_path / "x.nc")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert h5py.h5f.get_obj_count(h5py.h5f.OBJ_ALL, h5py.h5f.OBJ_FILE) == 0
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_export(kind, small_results, tmp_path):
    path = tmp_path / f"table.{kind}"
    assert results.export(small_results, path, kind) == 1088
    read = pd.read_csv(path) if kind == "csv" else pd.read_parquet(path)
    assert np.allclose(read["final_estimate"], results.frame(small_results)["final_estimate"], rtol=0, atol=1e-15)


def test_a_table_has_a_row_a_robot_and_trial(small_results):
    data = small_results.copy()
    shares = np.arange(data["true_fill_ratio"].size, dtype=float).reshape(data["true_fill_ratio"].shape)
    data["true_fill_ratio"] = data["true_fill_ratio"].dims, shares
    frame = results.frame(data)
    assert len(frame) == 4 * 16 * (5 + 12)
    row = frame.iloc[777]
    place = {"setting": row.setting, "trial": row.trial, "robot": row.robot}
    for name in ("convergence_round", "convergence_error", "final_estimate"):
        assert row[name] == data[name].sel(place)
    assert (frame["topology"].values == data["topology"].values[frame["setting"].values]).all()
    assert (frame["true_fill_ratio"] == shares[frame["setting"], frame["trial"]]).all()


def test_names_in_any_letters(small_results, tmp_path):
    named = small_results.assign_coords(brain=("setting", np.full(small_results.sizes["setting"], "bräin.py", object)))
    sc.save(named, tmp_path / "x.nc")
    assert results.load_packed(tmp_path / "x.nc")["brain"].values.tolist() == named["brain"].values.tolist()


def test_trials_that_were_not_run_are_left_out(small_results):
    part = small_results.copy(deep=True)
    part["final_estimate"][:, 2:] = np.nan
    assert len(results.frame(part)) == 544


class TestSelecting:
    @pytest.mark.parametrize(("expression", "count"), [
        ('topology == "ring"', 8),
        ("robots == 12 and fill_ratio > 0.6", 8),
        ("0.675 == accuracy", 16),
        ('accuracy == "U(0.525,0.975)" or robots == 5', 24),
        ('not topology in ["ring", "line"]', 16),
        ('topology not in ("ring", "line") and not robots == 5', 8),
        ("5 <= robots < 12", 16),
    ])  # fmt: skip
    def test_expressions(self, expression, count, small_results):
        assert where(small_results, expression).sizes["setting"] == count

    @pytest.mark.parametrize(("expression", "said"), [
        ("topolgy == 'ring'", "no coordinate 'topolgy': did you mean 'topology'"),
        ("topology == ring", """no coordinate 'ring': a text is quoted, as "ring\""""),
        ("robots = 5", "robots = 5"),
        ("7 == robots", "no setting is so: robots is 5, 12$"),
        ("robots > 12", "no setting is so$"),
        ('robots == 5 and topology == "rng"', "mean 'ring'. topology is full, ring, line, scale-free"),
        ("robots", "should compare"),
        ("__import__('os').system('true') == 0", "neither a coordinate nor a value"),
        ("robots in 5", "comes a list"),
        ("robots is 5", "should compare with"),
    ])  # fmt: skip
    def test_faults(self, expression, said, small_results):
        with pytest.raises(sc.InputError, match=said):
            where(small_results, expression)


def test_a_measure_of_robots_is_what_trials_are_summed_up_by(small_results):
    """NaN where a smaller swarm has no robot."""
    data = small_results
    every = np.arange(data.sizes["setting"])
    found = measures.sample(data, "final_error", every)
    of = np.arange(12) < data["robots"].values[:, np.newaxis, np.newaxis]
    off = np.abs(data["final_estimate"].values - data["fill_ratio"].values[:, np.newaxis, np.newaxis])
    np.testing.assert_array_equal(found, np.where(of, off, np.nan))
    np.testing.assert_allclose(np.nanmedian(found, axis=2), measures.numbers(data, "final_error"), rtol=1e-12)
    sent = measures.sample(data, "bytes_sent", every)
    bytes_sent = data["messages_sent"].values * data["message_bytes"].values[:, np.newaxis, np.newaxis]
    np.testing.assert_array_equal(sent, np.where(of, bytes_sent, np.nan))
    np.testing.assert_allclose(np.nanmean(sent, axis=2), measures.numbers(data, "bytes_sent"), rtol=1e-12)
    np.testing.assert_array_equal(measures.numbers(data, "worst_error"), np.nanmax(found, axis=2))


# ---- what notebooks show: a study's grid, a summary of results, a trace's curves, and a bar while a study runs
CELLS = [
    "import swarmcensus as sc\nstudy = sc.Study(trials=2, swarm={'robots': [2, 3], 'accuracy': 0.8}, "
    "world={'topology': 'ring', 'fill_ratio': 0.55}, schedule={'rounds': 5})\nstudy",
    "results = sc.run(study)\nresults", "sc.replay(results, setting=1, trial=0)",
    "import xarray as xr\nxr.Dataset({'mine': 1})",
]  # fmt: skip


@pytest.mark.long
def test_a_notebook_shows_them():
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [next(o for o in cell.outputs if o.output_type == "execute_result").data for cell in notebook.cells]
    results, trace, other = (output["text/html"] for output in outputs[1:])
    assert "2 settings of 2 trials" in outputs[0]["text/plain"]
    assert "2 settings, 4 of 4 trials done" in results
    assert "data:image/png;base64," in trace
    assert "mine" in other
    assert "<details><summary>the dataset" not in other
    assert outputs[1]["text/plain"].startswith("<xarray.Dataset>")


def test_results_show_the_numbers_of_their_summary(small_results):
    text = shown(small_results)
    assert f"{sc.summary(small_results).iloc[0]['convergence_error']:.3g}" in text
    count = small_results.sizes["setting"]
    assert text.count("<tr") == 1 + min(count, 40) + text.partition("<details>")[2].count("<tr")
    assert "assumed_accuracy" not in text.partition("<details>")[0]
    assert "<summary>the dataset" not in shown(small_results.drop_vars("convergence_round"))


def test_lines_in_a_notebook(monkeypatch, capsys):
    shell = types.SimpleNamespace(kernel=1)
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: shell))
    with progress.showing(True, "<mine>") as show:
        show(Progress(1, 4, 0.25, 1.0))
        assert not capsys.readouterr().err
        show(Progress(0, 0, 0.0, 0.0, "compiling"))
        show(Progress(1, 4, 0.25, 1.0))
        show(Progress(2, 4, 0.5, 1.0))
    first, second = capsys.readouterr().err.splitlines()
    assert first == "<mine>: compiling"
    assert second.startswith("<mine>: 1 of 4 trials, ")
