"""The live page of a swarm of processes: served while it runs and afterwards, and ended with it."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
import types
from urllib.parse import urlsplit

import pytest

from tests.support.watching import ask, programs, talk

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="processes with signals"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]


@pytest.fixture
def started(tmp_path):
    """Starts a swarm with its page; returns the process, what a page needs to talk to it, and the line of the page."""
    running = []

    def start(*arguments):
        words = ["swarm", "commons", "--set", "robots=4", "--out", str(tmp_path / "out"), "--watch", "--no-browser"]
        # brains run as plain Python: what is compiled here is told elsewhere
        command, pipe = [sys.executable, "-m", "swarmcensus", *words, *arguments], subprocess.PIPE
        env = os.environ | {"NUMBA_DISABLE_JIT": "1"}
        process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=env)
        running.append(process)
        line = next(line for line in process.stderr if "http" in line)
        address = urlsplit(re.search(r"http://\S+", line)[0])
        return process, types.SimpleNamespace(port=address.port, token=address.query.removeprefix("token=")), line

    yield start
    for process in running:
        process.kill()
        process.communicate()


def news(page, since=0):
    """What is new, with the estimates of the newest round."""
    told = ask(page, id=1, do="news", since=since)[1]
    [frames], _ = ask(page, id=2, do="frames", **{"from": told["rounds"], "count": 1})
    return told, frames


def test_live_page_of_a_running_swarm(started, tmp_path):
    faults = "faults=[{at = 51, do = 'stop', robots = {named = [2]}}]"
    process, served, line = started("--set", "rounds=5000", "--hz", "50", "--set", faults)
    assert line.startswith("live page: http://127.0.0.1:")
    with talk(served) as page:
        assert ask(page, id=0, do="begin", ask={})[1]["form"]["grows"]
        first, _ = news(page)
        until = time.monotonic() + 20
        while (last := news(page, first["version"])[0])["rounds"] < first["rounds"] + 20 and time.monotonic() < until:
            time.sleep(0.05)
        assert last["rounds"] >= first["rounds"] + 20
        assert first["rounds"] - 10 < last["changed"] <= last["rounds"]
        told = ask(page, id=3, do="robot", robot=1, tick=last["rounds"])[1]["told"]
        assert told["fields"]["s"] is not None
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=20)
        assert time.monotonic() - began < 5  # on a busy machine; else within a second
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert "next: swarmcensus relive" in errors
    assert not programs(tmp_path)


@pytest.mark.long
def test_the_page_goes_on_after_the_end_until_ctrl_c(started, tmp_path):
    process, served, _ = started("--set", "rounds=60", "--hz", "50", "--json")
    told = next(line for line in process.stderr if "goes on" in line)
    assert told == "The live page goes on showing the recording. Press Ctrl-C to stop.\n"
    assert not programs(tmp_path)
    with talk(served) as page:
        ask(page, id=0, do="begin", ask={})
        end, _ = news(page)
        assert end["wait"] is None
        begun = ask(page, id=3, do="begin", ask={})[1]
        assert [scene["rounds"] for scene in begun["scenes"]] == [end["rounds"]]
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=20)
    assert process.returncode == 0, errors
    assert "Traceback" not in errors
    assert len(json.loads(output)["estimates"]) == 4


def test_what_does_not_go_together_starts_nothing(refused, monkeypatch):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        for arguments, says in (
            (["--port", "8000"], "--port is for the live page: it goes with --watch"),
            (["--no-browser"], "--no-browser is for the live page: it goes with --watch"),
            (["--watch", "--port", port], f"port {port}: Address already in use; without --port any free one is taken"),
            (["--watch", "--port", "70000"], "should be a port, from 1 to 65535, or 0 for a free one"),
        ):
            assert says in refused("swarm", "commons", *arguments)
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    assert "watch needs uvicorn: pip install 'swarmcensus[watch]'" in refused("swarm", "commons", "--watch")
