"""What other programs read from a results file, by the very lines that docs/data-format.md shows."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from tests.support.pages import blocks
from tests.support.places import ROOT


def skip_without(program, *options):
    """Skip where a program is not here, or has not what it needs."""
    found = shutil.which(program) and not subprocess.run([program, *options], capture_output=True).returncode
    if not found:
        pytest.skip(f"{' '.join((program, *options))} does not run here: see tests/real/install.sh")


@pytest.fixture(scope="module")
def r():
    skip_without("Rscript", "-e", "library(ncdf4)")


@pytest.fixture(scope="module")
def octave():
    skip_without("octave-cli", "--no-history", "--eval", "pkg load netcdf")


@pytest.fixture(params=["as written", "with a fill value", "without one", "one trial of one setting"])
def expected(request, small_results, here):
    """In a folder with ring.nc, of swarms of several sizes: its settings and their medians, as Python has them.

    Whole numbers that are missing are -1, with or without an attribute that says so to readers.
    """
    sc.save(small_results, "ring.nc")
    if request.param != "as written":
        with xr.open_dataset("ring.nc", engine="h5netcdf", mask_and_scale=False) as file:
            data = file.load()
        data["convergence_round"].attrs.pop("_FillValue", None)
        if request.param == "with a fill value":
            data["convergence_round"].attrs["_FillValue"] = data["convergence_round"].dtype.type(-1)
        if request.param.startswith("one"):
            data = data.isel(setting=[3], trial=[2])
        data.to_netcdf("ring.nc", engine="h5netcdf")
    with xr.open_dataset("ring.nc", engine="h5netcdf", mask_and_scale=False) as file:
        data = file.load()
    assert (data["convergence_round"].values == -1).any() or "one" in request.param
    rounds = data["convergence_round"].where(data["convergence_round"] >= 0)
    return data, np.nanmedian(rounds, axis=(1, 2))


def run(language, name, *command):
    [text] = blocks(ROOT / "docs" / "data-format.md", language)
    Path(name).write_text(text)
    done = subprocess.run([*command, name], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_r(r, expected):
    data, medians = expected
    rows = [line.split() for line in run("r", "read.R", "Rscript")[1:]]
    assert [accuracy for _, accuracy, _ in rows] == list(data["accuracy"].values)
    assert [float(median) for *_, median in rows] == list(medians)


def test_octave(octave, expected):
    data, medians = expected
    said = run("matlab", "read_results.m", "octave-cli", "--no-history")
    assert said == [
        f"setting {k}, f = {f:g}: {median:g}"
        for k, f, median in zip(data["setting"].values, data["fill_ratio"].values, medians, strict=True)
    ]
