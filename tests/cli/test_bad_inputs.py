"""Inputs that once did harm, or ended in something else than one clear sentence; test_fuzz.py looks for more."""

import os
import time
from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.analysis.explaining.wrong_beliefs import _read
from swarmcensus.figures.styles import looks_of
from swarmcensus.simulation import rows_of
from swarmcensus.summaries import recordings
from swarmcensus.support import files
from swarmcensus.support.formatting import distinct_texts
from swarmcensus.support.read_table import NUMBER
from swarmcensus.worlds import read_links
from tests.support.small import MOVING, SMALL

BRAIN = brains.load("minimalistic").source


@pytest.mark.parametrize("key", ["__class__", "__slots__", "\uff54"])
@pytest.mark.parametrize("table", ["MEMORY", "PARAMETERS"])
def test_fields_have_names_that_python_keeps(table, key):
    source = BRAIN.replace("MEMORY = {", f"MEMORY = {{{key!r}: 0.0, ") if table == "MEMORY" else ""
    with pytest.raises(sc.InputError, match=rf"{table} key {key!r}.* Python"):
        brains.parse(source or f"{BRAIN}\nPARAMETERS = {{{key!r}: 0.0}}", "mine.py", "mine.py")


def test_a_link_stays_and_its_target_is_written(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "x.csv").symlink_to(tmp_path / "there" / "y.csv")
    with files.atomic_write(tmp_path / "x.csv") as temporary:
        temporary.write_text("new")
    assert (tmp_path / "x.csv").is_symlink()
    assert (tmp_path / "there" / "y.csv").read_text() == "new"
    assert os.listdir(tmp_path / "there") == ["y.csv"]


@pytest.mark.parametrize("kind", ["pipe", "device", "circle", "folder", "long"])
def test_what_cannot_be_written_stays_as_it_is(kind, small_file, here, refused):
    name = "x" * 300 + ".csv" if kind == "long" else "x.csv"
    if kind == "pipe":
        os.mkfifo(name)
    elif kind == "folder":
        os.mkdir(name)
    elif kind != "long":
        os.symlink("/dev/full" if kind == "device" else name, name)
    assert "cannot write" in refused("export", small_file, "--out", name)


def test_links_too_large_for_a_number(tmp_path):
    (tmp_path / "l.csv").write_text(f"2,{'9' * 5000}\n")
    with pytest.raises(sc.InputError, match="should be a whole number from 0"):
        rows_of(read_links(tmp_path / "l.csv"), recordings.NUMBERED)


@pytest.mark.parametrize("tables", [
    {"world": {"body": {"radius": 1e308}}}, {"world": {"body": {"radius": 1e-320}}},
    {"world": {"body": {"sensor": [float("inf"), 0.0]}}}, {"world": {"body": {"tile": 1e-9, "radio_range": 1e9}}},
    {"faults": [{"at": 10**30, "robots": 1, "stop": "talking"}]}, {"swarm": {"accuracy": 10**400}},
    {"swarm": {"accuracy": 2**20000}},
    {"swarm": {"accuracy": [k / 2000 for k in range(2000)]}, "world": {"fill_ratio": [k / 999 for k in range(999)]}},
])  # fmt: skip
def test_numbers_out_of_all_bounds(tables):
    whole = {"swarm": {"robots": 3, "accuracy": 0.8}, "world": MOVING}
    mixed = {k: whole.get(k, {}) | v if isinstance(v, dict) else v for k, v in (whole | tables).items()}
    with pytest.raises(sc.InputError, match="study"):
        sc.Study(trials=1, **mixed)


def test_a_long_comment_is_kept_with_the_results(tmp_path):
    study = sc.Study.parse(SMALL.replace("trials = 4", "trials = 1") + "# long\n" * 100_000)
    sc.save(sc.run(study, jobs=1), tmp_path / "x.nc")
    assert sc.load(tmp_path / "x.nc").attrs["study"] == study.text


@pytest.mark.parametrize("name", ["title", "brains", "study", "seed", "trials_done"])
def test_results_without_an_attribute(name, small_results, tmp_path):
    changed = small_results.copy()
    del changed.attrs[name]
    with pytest.raises(sc.InputError, match=f"the attribute {name}: field required"):
        sc.save(changed, tmp_path / "x.nc")


@pytest.mark.parametrize(("ends", "raised", "said"), [
    (OSError(28, "No space left on device"), sc.InputError, r"^cannot write .*x\.nc: No space left on device$"),
    (KeyboardInterrupt(), KeyboardInterrupt, "^$"),
])  # fmt: skip
def test_a_writer_that_ends_early_leaves_nothing(ends, raised, said, tmp_path):
    def write():
        with files.atomic_write(tmp_path / "x.nc") as temporary:
            temporary.write_text("half")
            raise ends

    with pytest.raises(raised, match=said):
        write()
    assert not os.listdir(tmp_path)


# ---- texts of a hundred kilobytes in place of short ones: refused within the time that a short one takes, or nearly
LONG = 100_000
DIGITS = "1" * LONG
STUDY = "trials = {1}\n[swarm]\nrobots = 5\n{0}\n[world]\ntopology = 'ring'\nfill_ratio = 0.7\n[schedule]\nrounds = 5\n"
READINGS = "time,robot,reading\n0,0,1\n0,1,1\n"
MOST_SECONDS = 5.0  # where the time goes with the square of the length, minutes


@pytest.fixture
def soon():
    began = time.process_time()
    yield
    assert time.process_time() - began < MOST_SECONDS


@pytest.mark.parametrize(("command", "files"), [
    ("run", {"s.toml": STUDY.format(f"accuracy = '{' ' * LONG}x'", 2)}),
    ("run", {"s.toml": STUDY.format(f"accuracy = '{DIGITS}x'", 2)}),
    ("run", {"s.toml": STUDY.format("accuracy = 0.7", f"{{until = '{' ' * LONG}'}}")}),
    ("run", {"s.toml": STUDY.format("accuracy = 0.7", f"{{until = 'convergence_error median +- {DIGITS}x'}}")}),
    ("run", {"s.toml": STUDY.format(f"accuracy = 0.7\n[[faults]]\nat = '{DIGITS}x'", 2)}),
    ("infer --links l.txt", {"o.csv": READINGS, "l.txt": f"time,sender,receiver\n{DIGITS}x,0,1\n"}),
    ("infer", {"o.csv": f"time,robot,reading\n{DIGITS}x,0,1\n"}),
    ("infer --links l.txt", {"o.csv": READINGS, "l.txt": f"1 2 {'a{' * LONG}\n"}),
], ids=range(8))  # fmt: skip
def test_of_files(command, files, here, refused, soon):
    for name, text in files.items():
        Path(name).write_text(text)
    given = ["--accuracy", "0.7", "--period", "1"] if "infer" in command else []
    assert min(files) in refused(*command.split(), *given, max(files))


def test_of_names_and_labels(soon):
    assert not NUMBER.fullmatch(f"{DIGITS}x")
    assert distinct_texts([f"{DIGITS}x"]) == [f"{DIGITS}x"]
    assert looks_of([f"{DIGITS}x"], "o")
    with pytest.raises(ValueError, match="a sensor accuracy is a number"):
        _read("a" * LONG)
