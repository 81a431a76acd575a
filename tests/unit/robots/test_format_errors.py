"""What `swarmcensus deploy` tells of number formats: the error of a shipped brain, a warning, how to find out."""

import math
import re

import pytest

from swarmcensus import brains
from swarmcensus.robots import format_errors
from swarmcensus.robots.target import SENT
from tests.support.pages import cells_of
from tests.support.places import ROOT

OWN = ROOT / "studies" / "example" / "my_brain.py"


@pytest.fixture
def deploying(tmp_path, accepted):
    """A function that deploys a brain, and returns what is told of errors, and stderr."""

    def deployed(brain, radio, message, *more):
        to = [str(tmp_path / "robot"), "--target", radio, "--accuracy", "0.9", "--message", message]
        out, error = accepted("deploy", brain, *to, *more)
        return re.findall("^error     (.*)$", out, re.MULTILINE), error.partition("next: ")[0]

    return deployed


@pytest.mark.parametrize(("brain", "radio", "message", "told", "warned"), [
    ("commons", "udp", "ratio16", "0.0002 after 864,000 readings in ratio16 (0.0002 in double precision)", ""),
    ("commons", "udp", "float16", "0.4499 after 864,000 readings in float16 (0.0002 in double precision)",
    "commons errs by 0.4499 after 864,000 readings in float16, and by 0.0002 in double precision: float32, "
    "ratio16 or ratio8 is right"),
    ("self-taught", "udp", "ratio16", "no number after 864,000 readings in ratio16 (0.0002 in double precision)",
    "self-taught fails in ratio16: float32 is right"),
    ("voter", "udp", "ratio8", "0.3450 of opinions wrong after 864,000 readings in ratio8 (0.3117 in double "
    "precision)", ""),
    ("covariance-intersection", "kilobot", "ratio16", "0.0057 after 864,000 readings in ratio16 (0.0006 in double "
    "precision)", "covariance-intersection errs by 0.0057 after 864,000 readings in ratio16, and by 0.0006 in "
    "double precision: no format that fits this radio is right"),
])  # fmt: skip
def test_the_error_of_a_shipped_brain(deploying, brain, radio, message, told, warned):
    assert deploying(brain, radio, message) == ([f"{told}, docs/machines.md"], f"warning: {warned}\n" * bool(warned))


@pytest.mark.parametrize(("brain", "target", "message", "fits"), [
    ("commons", "espnow", "float32", "float32, float16, ratio16, ratio8"),
    ("commons", "kilobot", "ratio16", "ratio16, ratio8"),
    ("kalman-consensus", "kilobot", "ratio8", "ratio8"),  # refused in ratio16
    ("voter", "kilobot", "ratio16", "ratio16, ratio8"),
    (OWN, "kilobot", "ratio16", "float16, ratio16, ratio8"),  # its errors are unknown
])  # fmt: skip
def test_without_a_format_the_best_of_those_that_fit_is_taken(accepted, here, brain, target, message, fits):
    out = accepted("deploy", brain, "robot", "--target", target, "--accuracy", "0.9").out
    assert f"format    {message}: of those that fit ({fits}), none is known to err less" in out


@pytest.mark.parametrize(("formats", "message"), [
    (SENT, "float32"), (("ratio16", "ratio8"), "ratio16"), (("float16", "ratio16"), "float16"), ((), "float32")
])  # fmt: skip
def test_a_format_is_chosen_by_measured_errors(monkeypatch, formats, message):
    """Those that do not differ within the interval of the best are as good, and the preferred one is taken."""
    errors = {"float32": (0.0102, 0.01, 0.011), "float16": (0.01, 0.009, 0.0103), "ratio16": (0.02, 0.01, 0.03)}
    found = {one: format_errors.Measured(one, 9, *its, 0.01) for one, its in errors.items()}
    monkeypatch.setattr(format_errors, "measured", lambda _, one: found.get(one))
    assert format_errors.least_wrong(brains.load("commons"), formats) == message


def test_an_unmeasured_brain_is_named_with_a_way_to_measure_it(deploying, tmp_path):
    study = "studies/formats.toml"
    [told], warned = deploying(OWN, "udp", "ratio16")
    assert (told, warned) == (f"not measured in ratio16: add this brain to {study}, and run that", "")
    (tmp_path / "robot").rename(tmp_path / "first")
    [told], _ = deploying("leaver", "udp", "float32")
    assert told == "not measured in float32: add this brain to a study of robots that move, and run that"


def test_the_table_has_the_errors_that_the_package_has():
    rows = [row for row in cells_of("number-formats") if row["readings"] == "864000"]
    assert {row["measure"] for row in rows} == {"error", "share of wrong opinions"}
    for row in rows:
        found = [format_errors.measured(brains.load(row["brain"]), message) for message in SENT]
        told = [row[column] for column in ("double", "single", *SENT[1:])]
        numbers = [math.nan if cell == "fails" else float(cell) for cell in told]
        errors = [found[0].double, *(one.error for one in found)]
        assert errors == pytest.approx(numbers, abs=6e-5, nan_ok=True), row["brain"]
