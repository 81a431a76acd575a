"""Texts of a hundred kilobytes in place of short ones: refused within the time that a short one takes, or nearly."""

import time
from pathlib import Path

import pytest

from swarmcensus.analysis.explaining.wrong_beliefs import _read
from swarmcensus.figures.styles import looks_of
from swarmcensus.support.formatting import distinct_texts
from swarmcensus.support.read_table import NUMBER

LONG = 100_000
DIGITS = "1" * LONG
STUDY = "trials = {1}\n[swarm]\nrobots = 5\n{0}\n[world]\ntopology = 'ring'\nfill_ratio = 0.7\n[schedule]\nrounds = 5\n"
READINGS = "time,robot,reading\n0,0,1\n0,1,1\n"
MOST_SECONDS = 5.0  # where the time goes with the square of the length, minutes


@pytest.fixture(autouse=True)
def _soon():
    began = time.process_time()
    yield
    assert time.process_time() - began < MOST_SECONDS


@pytest.mark.parametrize(
    ("command", "files"),
    [
        ("run", {"s.toml": STUDY.format(f"accuracy = '{' ' * LONG}x'", 2)}),
        ("run", {"s.toml": STUDY.format(f"accuracy = '{DIGITS}x'", 2)}),
        ("run", {"s.toml": STUDY.format("accuracy = 0.7", f"{{until = '{' ' * LONG}'}}")}),
        ("run", {"s.toml": STUDY.format("accuracy = 0.7", f"{{until = 'convergence_error median +- {DIGITS}x'}}")}),
        ("run", {"s.toml": STUDY.format(f"accuracy = 0.7\n[[faults]]\nat = '{DIGITS}x'", 2)}),
        ("infer --links l.txt", {"o.csv": READINGS, "l.txt": f"time,sender,receiver\n{DIGITS}x,0,1\n"}),
        ("infer", {"o.csv": f"time,robot,reading\n{DIGITS}x,0,1\n"}),
        ("infer --links l.txt", {"o.csv": READINGS, "l.txt": f"1 2 {'a{' * LONG}\n"}),
    ],
    ids=range(8),
)
def test_of_files(command, files, here, refused):
    for name, text in files.items():
        Path(name).write_text(text)
    given = ["--accuracy", "0.7", "--period", "1"] if "infer" in command else []
    assert min(files) in refused(*command.split(), *given, max(files))


def test_of_names_and_labels():
    assert not NUMBER.fullmatch(f"{DIGITS}x")
    assert distinct_texts([f"{DIGITS}x"]) == [f"{DIGITS}x"]
    assert looks_of([f"{DIGITS}x"], "o")
    with pytest.raises(ValueError, match="a sensor accuracy is a number"):
        _read("a" * LONG)
