"""What other programs read from a results file, by the very lines that docs/data-format.md shows."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.cli.commands import main
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
    return data, np.nanmedian(data["convergence_round"].where(data["convergence_round"] >= 0), axis=(1, 2))


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


# ---- films, as another program than the one that wrote them sees them
MOVING = """
trials   = 1
swarm    = {robots = 4, accuracy = 0.7}
world    = {topology = "moving", density = 1, fill_ratio = 0.3}
schedule = {ticks = 40}
"""


@pytest.mark.skipif(shutil.which("ffprobe") is None, reason="no ffprobe here: see tests/real/install.sh")
@pytest.mark.parametrize(("ending", "expected"), [
    ("mp4", {"codec_name": "h264", "pix_fmt": "yuv420p", "avg_frame_rate": "10/1", "nb_read_frames": "3"}),
    ("gif", {"codec_name": "gif", "avg_frame_rate": "10/1", "nb_read_frames": "3"}),
])  # fmt: skip
def test_a_film_is_what_players_take(here, ending, expected):
    """H.264 with halved colours is what browsers and slides play."""
    if ending == "mp4":
        pytest.importorskip("imageio_ffmpeg")
    sc.save(sc.run(sc.Study.parse(MOVING), jobs=2), "x.nc")
    which = ["--setting", "0", "--trial", "0", "--first", "3", "--last", "12", "--every", "4", "--fps", "10"]
    assert main(["plot", "x.nc", "--kind", "film", *which, "--out", f"x.{ending}"]) == 0
    asked = ["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", f"x.{ending}"]
    done = subprocess.run(asked, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    [stream] = json.loads(done.stdout)["streams"]
    assert {key: stream[key] for key in expected} == expected
    assert int(stream["width"]) % 2 == int(stream["height"]) % 2 == 0
