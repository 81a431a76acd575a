"""Texts of hundreds of kilobytes in place of short ones: refused within the time that a short one takes, or nearly."""

import time
from pathlib import Path

import pytest

from swarmcensus.analysis.explaining.wrong_beliefs import _read
from swarmcensus.figures.styles import looks_of
from swarmcensus.support.formatting import distinct_texts
from swarmcensus.support.read_table import NUMBER

LONG = 400_000
STUDY = "trials = {1}\n[swarm]\nrobots = 5\n{0}\n[world]\ntopology = 'ring'\nfill_ratio = 0.7\n[schedule]\nrounds = 5\n"
MOST_SECONDS = 20.0  # where the time goes with the square of the length, minutes


@pytest.fixture(autouse=True)
def _soon():
    began = time.process_time()
    yield
    assert time.process_time() - began < MOST_SECONDS


@pytest.mark.parametrize(
    ("swarm", "trials"),
    [
        (f"accuracy = '{' ' * LONG}x'", "2"),
        (f"accuracy = '{'1' * LONG}x'", "2"),
        ("accuracy = 0.7", f"{{until = '{' ' * LONG}'}}"),
        ("accuracy = 0.7", f"{{until = 'convergence_error median +- {'1' * LONG}x'}}"),
        (f"accuracy = 0.7\n[[faults]]\nat = '{'1' * LONG}x'", "2"),
    ],
)  # fmt: skip
def test_of_studies(swarm, trials, here, refused):
    Path("s.toml").write_text(STUDY.format(swarm, trials))
    assert "s.toml" in refused("run", "s.toml")


@pytest.mark.parametrize(
    ("readings", "links", "options"),
    [
        (
            "time,robot,reading\n0,0,1\n0,1,1\n",
            f"time,sender,receiver\n{'1' * LONG}x,0,1\n",
            ("--links", "l.txt", "--period", "1"),
        ),
        (f"time,robot,reading\n{'1' * LONG}x,0,1\n", "", ("--period", "1")),
        ("time,robot,reading\n0,0,1\n0,1,1\n", f"1 2 {'a{' * LONG}\n", ("--links", "l.txt")),
    ],
)
def test_of_tables(readings, links, options, here, refused):
    Path("o.csv").write_text(readings)
    Path("l.txt").write_text(links)
    refused("infer", "o.csv", "--accuracy", "0.7", *options)


def test_of_names_and_labels():
    digits = "1" * LONG
    assert not NUMBER.fullmatch(f"{digits}x")
    assert distinct_texts([f"{digits}x"]) == [f"{digits}x"]
    assert looks_of([f"{digits}x"], "o")
    with pytest.raises(ValueError, match="a sensor accuracy is a number"):
        _read("a" * LONG)
