"""Films, as another program than the one that wrote them sees them."""

import json
import shutil
import subprocess

import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main

MOVING = """
trials   = 1
swarm    = {robots = 4, accuracy = 0.7}
world    = {topology = "moving", density = 1, fill_ratio = 0.3}
schedule = {ticks = 40}
"""


@pytest.mark.skipif(shutil.which("ffprobe") is None, reason="no ffprobe here: see tests/real/install.sh")
@pytest.mark.parametrize(
    ("ending", "expected"),
    [
        ("mp4", {"codec_name": "h264", "pix_fmt": "yuv420p", "avg_frame_rate": "10/1", "nb_read_frames": "3"}),
        ("gif", {"codec_name": "gif", "avg_frame_rate": "10/1", "nb_read_frames": "3"}),
    ],
)
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
