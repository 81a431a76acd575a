"""Who owns an output: locks are the system's, and end with their process."""

import errno
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from swarmcensus.support.owners import Busy, Owner, owner_of

HOLDS = """
import os, sys, time
from pathlib import Path
from swarmcensus.support.owners import Owner
with Owner(Path(sys.argv[1])):
    child = os.fork()
    if child:
        print(child, flush=True)
    time.sleep(60)
"""


@pytest.fixture
def path(tmp_path):
    return tmp_path / "of" / "lock"


def test_one_owner_at_a_time(path):
    with Owner(path) as first:
        assert owner_of(path).startswith(f"process {os.getpid()} on ")
        with pytest.raises(Busy, match=f"^process {os.getpid()} on "):
            Owner(path).__enter__()
        assert first.keeps()
        path.unlink()  # by somebody who was mistaken
        assert first.keeps()
        path.unlink()
        with Owner(path):
            assert not first.keeps()
    assert not any(path.parent.iterdir())
    assert owner_of(path) == ""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no process is forked here")
def test_a_killed_process_leaves_no_lock_though_its_copies_live(path):
    with subprocess.Popen([sys.executable, "-c", HOLDS, str(path)], stdout=subprocess.PIPE) as process:
        child = int(process.stdout.readline())
        assert owner_of(path).startswith(f"process {process.pid} on ")
        process.kill()
        process.wait()
        try:
            with Owner(path):
                os.kill(child, 0)  # it lives
        finally:
            os.kill(child, signal.SIGKILL)


@pytest.mark.parametrize("text", ["", "[1]", "\x1b[2J"])
def test_files_of_others_are_no_locks(path, text):
    path.parent.mkdir()
    path.write_text(text)
    assert owner_of(path) == ""
    with Owner(path):
        assert f"process {os.getpid()}" in owner_of(path)
        path.write_text(text)
        assert "\x1b" not in owner_of(path) != ""


def test_of_many_that_wait_one_follows(path):
    inside, most = [], []

    def work():
        with Owner(path, 60.0):
            inside.append(1)
            most.append(len(inside))
            time.sleep(0.002)
            inside.pop()

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1] * 8
    assert not any(path.parent.iterdir())


def test_where_files_cannot_be_locked_it_is_said(path, monkeypatch, caplog):
    def flock(*_):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(pytest.importorskip("fcntl"), "flock", flock)
    with caplog.at_level("INFO"), Owner(path) as owner:
        assert owner.keeps()
        assert owner_of(path) == ""
    assert "files cannot be locked here (No locks available)" in caplog.text


def test_a_link_is_refused(path):
    path.parent.mkdir()
    path.symlink_to(Path("nowhere"))
    with pytest.raises(OSError, match="symbolic link"):
        Owner(path).__enter__()
