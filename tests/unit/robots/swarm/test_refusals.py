"""What a swarm does not believe or take: forged reports, messages too large for UDP, too many readings a round."""

import os
import socket
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from swarmcensus.robots.swarm import plans
from swarmcensus.robots.swarm.air import Air
from swarmcensus.robots.swarm.plans import plan_of
from swarmcensus.robots.swarm.reports import Report, read_report
from swarmcensus.studies.study import Study
from swarmcensus.support.errors import InputError


def test_reports_without_the_token_or_out_of_range_are_ignored():
    assert read_report(b"secret 2 1 40000 0", "secret").port == 40000
    forged = (b"2 1 40000 0", b"wrong 2 1 40000 0", b"", b"secret", b"secret 2 1 99999999 0", b"secret 2 1 0 0",
              b"secret -1 1 40000 0", b"secret 2 1 40000 " + b"9" * 500, b"secret 2 1 40000 x",
              b"\xff\x00 2 1 4 0")  # fmt: skip
    for datagram in forged:
        assert read_report(datagram, "secret") is None
    report = "secret 2 1 40000 3 7 7 {} {} 1 2 3 4 5 6 7 8 9" + " 10" * (len(Report._fields) - 17)
    assert read_report(report.format("0.5", "-1.0").encode(), "secret").ticks == 7
    for wrong in (("nan", "-1.0"), ("1e999", "-1.0"), ("0.5", "inf")):
        assert read_report(report.format(*wrong).encode(), "secret") is None


def test_a_large_message_is_heard_whole():
    here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    here.bind(("127.0.0.1", 0))
    here.setblocking(False)
    messages = SimpleNamespace(size=9000, mark=1, unpack=lambda _: None)
    heard = Air(here, messages, lambda: 0.0, 1, 7)
    with here:
        for size in (9000, 9100):
            here.sendto(bytes(size), here.getsockname())
        assert [len(heard.receive()), len(heard.receive())] == [9000, 9001]  # the longer one is refused as noise


def small(observations=1):
    schedule = {"rounds": 2, "observations_per_round": observations}
    return Study(
        name="small", trials=1, swarm={"robots": 2, "accuracy": 0.8, "brain": "commons"},
        world={"topology": "full", "fill_ratio": 0.5, "message": "ratio16"}, schedule=schedule,
    )  # fmt: skip


def test_what_no_datagram_or_log_holds_is_refused(monkeypatch):
    with pytest.raises(InputError, match="65,536 observations a round"):
        plan_of(small(65536), 0, 0, 0, plans.Air())
    monkeypatch.setattr(plans, "MOST_BYTES", 8)
    with pytest.raises(InputError, match="a message of 13 bytes: UDP carries up to 8 in a datagram"):
        plan_of(small(), 0, 0, 0, plans.Air())


@pytest.mark.parametrize("hz", ["0", "0.0009", "501"])
def test_periods_of_no_or_too_many_milliseconds_are_refused(refused, hz):
    assert f"--hz {float(hz):g}: should be ticks a second, from 0.001 to 500" in refused("swarm", "commons", "--hz", hz)


def test_a_delay_as_long_as_the_run_is_refused(refused):
    assert "--delay 2s" in refused("swarm", "commons", "--hz", "20", "--rounds", "40", "--delay", "2s")
    air = plans.Air(hz=20.0, delay=99)
    assert plan_of(small(), 0, 0, 0, air).air is air  # a run of 100 ms


SUBREAPER = """
import ctypes, subprocess, sys, time
ctypes.CDLL(None).prctl(36, 1, 0, 0, 0)
process = subprocess.Popen([sys.executable, "-m", "swarmcensus", "swarm", "commons", "--robots", "3", "--rounds", "900",
                            "--hz", "20", "--quiet", "--fault", "0.1s stop 1", "--out", sys.argv[1]])
input()
process.kill()
process.wait()
input()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="needs a subreaper, as process 1 of a container is")
def test_stopped_robot_ends_with_the_command(tmp_path):
    """The system then sends nothing to its group."""

    def states():
        found = subprocess.run(["ps", "-ww", "-eo", "stat,args"], capture_output=True, text=True, check=True).stdout
        lines = [line for line in found.splitlines() if "import node" in line and str(tmp_path) in line]
        return [line[0] for line in lines if line[0] != "Z"]

    def comes(condition):
        until = time.monotonic() + 20
        while not condition() and time.monotonic() < until:
            time.sleep(0.05)
        return condition()

    with subprocess.Popen([sys.executable, "-c", SUBREAPER, str(tmp_path / "out")], stdin=subprocess.PIPE) as parent:
        assert comes(lambda: "T" in states())
        os.write(parent.stdin.fileno(), b"\n")
        assert comes(lambda: not states())
        os.write(parent.stdin.fileno(), b"\n")


def test_folders_in_use_are_refused(here, refused):
    assert "--out .: this is the folder that you are in" in refused("swarm", "commons", "--out", ".")
    (here / "mine").mkdir()
    (here / "mine" / "notes").write_text("my notes")
    assert "the folder mine is not empty, it holds 'notes'" in refused("swarm", "commons", "--out", "mine")
    assert "is a file: name a new folder" in refused("swarm", "commons", "--out", "mine/notes")
