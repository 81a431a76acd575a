"""Who owns an output: dead owners are told from living ones, without locks of the file system."""

import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from swarmcensus.support import owners
from swarmcensus.support.owners import Busy, Owner, owner_of


@pytest.fixture
def path(tmp_path, monkeypatch):
    monkeypatch.setattr(owners, "LOOK", 0.01)
    return tmp_path / "of" / "lock"


def left(path, seconds=0.0, **changed):
    """A file that an owner left so many seconds ago, of which something is changed."""
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(owners._myself() | changed))
    os.utime(path, (time.time() - seconds,) * 2)


def ended():
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        return process.pid


@pytest.mark.parametrize("seconds", [0.0, 1e6])
def test_one_owner_at_a_time(path, seconds):
    with Owner(path) as first:
        os.utime(path, (time.time() - seconds,) * 2)  # this process is seen, whatever the time of the file
        assert owner_of(path).startswith(f"process {os.getpid()} on ")
        with pytest.raises(Busy, match=f"if that has ended, remove {path}"):
            Owner(path).__enter__()
        assert first.keeps()
        path.unlink()  # by somebody who was mistaken
        assert first.keeps()
    assert not any(path.parent.iterdir())
    assert owner_of(path) == ""


@pytest.mark.skipif(sys.platform == "win32", reason="processes are not seen")
@pytest.mark.parametrize("changed", [{"process": ended}, {"began": lambda: "1"}, {"process": lambda: 1 << 70}])
def test_a_dead_process_is_known_at_once(path, changed):
    left(path, **{key: value() for key, value in changed.items()})
    assert owner_of(path) == ""
    with Owner(path):
        assert owner_of(path)


@pytest.mark.parametrize("text", ["", "[1]", "{", '{"process": "1"}'])
def test_files_of_others_are_known_by_their_age(path, text):
    for seconds in (0.0, 2 * owners.SILENT):
        left(path)
        path.write_text(text)
        os.utime(path, (time.time() - seconds,) * 2)
        assert (owner_of(path) == "") is bool(seconds)
    with Owner(path):
        assert "process ?" not in owner_of(path)


def test_another_machine_is_known_by_its_signs_of_life(path, monkeypatch):
    there = {"process": 1, "host": "node17", "system": "node17"}
    left(path, 2 * owners.SILENT, **there)
    with Owner(path):
        pass
    left(path, **there)  # it died just now, or lives
    assert "process 1 on node17" in owner_of(path)
    monkeypatch.setattr(owners, "SILENT", 0.4)
    with Owner(path) as lock:
        left(path, **there)
        assert not lock.keeps()
    assert path.exists()
    stop = threading.Event()

    def beat():
        while not stop.wait(0.05):
            os.utime(path)

    thread = threading.Thread(target=beat)
    thread.start()
    with pytest.raises(Busy, match="process 1 on node17"):
        Owner(path).__enter__()
    stop.set()
    thread.join()


def test_an_owner_gives_signs_of_life(path, monkeypatch):
    slept = threading.Event()
    monkeypatch.setattr(owners.time, "sleep", lambda _: slept.wait(60))
    thread = threading.Thread(target=owners._beat, daemon=True)
    with Owner(path):
        os.utime(path, (1.0, 1.0))
        slept.set()
        thread.start()
        while path.stat().st_mtime == 1.0:
            pass
        slept.clear()


def test_of_many_that_see_a_dead_owner_one_follows(path):
    inside, most = [], []

    def work():
        with Owner(path, 60.0):
            inside.append(1)
            most.append(len(inside))
            time.sleep(0.002)
            inside.pop()

    left(path, process=ended())
    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1] * 8
    assert not any(path.parent.iterdir())


def test_a_link_that_leads_nowhere_is_refused(path):
    path.parent.mkdir()
    path.symlink_to(Path("nowhere"))
    with pytest.raises(FileNotFoundError):
        Owner(path).__enter__()
