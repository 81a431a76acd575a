"""The first seconds of a page on a new installation: CPython computes them in another process."""

import json
import subprocess
import sys
import threading
import time
from concurrent.futures import Future

import psutil
import pytest

from swarmcensus import live
from swarmcensus.cli.commands import main
from swarmcensus.live import interpreted, previews, sessions
from swarmcensus.live.choices import offer_of, wanted
from swarmcensus.live.interpreted import INTERPRETER
from swarmcensus.live.previews import Preview
from swarmcensus.live.sessions import Session
from swarmcensus.live.shown import Shown
from swarmcensus.simulation import Stepped
from tests.support.trials import difference

LIARS = "[{robots = 0.25, brain = 'always-black', honest = false}]"
WORLDS = [
    {"robots": "8", "density": "4"},
    {"robots": "8", "density": "4", "floor": "{clusters = 0.3}"},
    {"topology": "ring", "robots": "8", "brain": "commons", "beside": "minimalistic", "link_success": "0.7"},
    {"topology": "scale-free", "robots": "8", "members": LIARS, "fill_ratio": "0.55"},
]


@pytest.fixture
def is_compiled(monkeypatch):
    """An event before which this process has nothing compiled."""
    event = threading.Event()
    monkeypatch.setattr(previews, "Stepped", lambda *given: event.wait(60) and Stepped(*given))
    yield event
    event.set()


def shown_by(make, trial):
    return Shown(trial.settings, trial.seed, trial.trial, trial.study.measure, make)


def picture(shown, rounds):
    """All that a page asks of these rounds: scenes, frames one by one, and a robot in each."""
    parts = [shown.scenes()]
    field = parts[0][0]["fields"][0]
    for tick in rounds:
        for does, given in (
            ("frames", (range(tick, tick + 1),)),
            ("robot", (0, tick, 3)),
            ("memory", (0, 3, field, range(tick, tick + 1))),
        ):
            while "going" in (answers := getattr(shown, does)(*given))[-1]:
                pass
            parts.append(answers)
    return parts


def ended():
    """Wait until the process has ended."""
    for _ in range(200):
        if INTERPRETER._process is None:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.long(but=["asked0"])
@pytest.mark.parametrize("asked", WORLDS)
def test_cpython_shows_what_machine_code_shows(asked, is_compiled):
    rounds, trial = [0, 1, 2, 40, 130, 20], wanted(offer_of(None), asked)
    expected, shown = picture(shown_by(Stepped, trial), rounds), shown_by(Preview, trial)
    assert picture(shown, rounds) == expected
    assert not shown.is_compiled
    is_compiled.set()
    for show in shown.shows:
        show.trace.own.result(60)
    assert picture(shown, rounds) == expected
    assert ended()


def test_a_session_goes_on_with_machine_code(monkeypatch, is_compiled):
    """A page that has a picture waits for the next one, so that a brain that fails is refused."""
    monkeypatch.setattr(sessions, "needs_compiling", lambda settings: True)
    session = Session(offer_of(None), interprets=True)

    def ask(does, **words):
        return session.answer(json.dumps({"do": does, **words}))

    world = {"robots": "5", "ticks": "300"}
    for seed in "1", "2":  # also while the first one is still shown by CPython
        assert "scenes" in ask("begin", ask={"seed": seed, **world})[0]
        assert isinstance(ask("frames", **{"from": 1})[0], bytes)
    assert ask("settled") == [{"id": None, "going": True}]
    is_compiled.set()
    assert session.shown.shows[0].trace.own.result(60).rounds == 300
    while ask("settled")[0].get("going"):
        pass
    assert "scenes" in ask("begin", ask={"seed": "3", **world})[0]
    assert isinstance(session.shown.shows[0].trace, Stepped)
    assert ended()


def test_an_endless_loop_in_cpython_holds_up_nobody(monkeypatch):
    """What this process has first is shown, although the other one has not answered."""
    monkeypatch.setattr(INTERPRETER, "ask", lambda *given: Future())
    [setting] = wanted(offer_of(None), WORLDS[0]).settings
    assert Preview(setting, 1, 0).estimates(0, 3).shape == (3, 8)


def test_without_a_process_the_page_waits(monkeypatch):
    def none_started(*_, **__):
        raise OSError("no more processes")

    monkeypatch.setattr(interpreted.subprocess, "Popen", none_started)
    [setting] = wanted(offer_of(None), WORLDS[0]).settings
    assert difference(Preview(setting, 1, 0), Stepped(setting, 1, 0)) is None


def test_the_command_starts_the_process_where_nothing_is_compiled(tmp_path, monkeypatch):
    served, settings = [], wanted(offer_of(None), WORLDS[0]).settings
    shown_by(Stepped, wanted(offer_of(None), WORLDS[0])).shows[0].trace.at(0)
    assert not interpreted.needs_compiling(settings)
    assert interpreted.prepared() is not INTERPRETER
    # where the command takes them from, which keeps what it has once imported
    monkeypatch.setattr(live, "warm", lambda *given: served.append((INTERPRETER._process is not None, given[2])))
    monkeypatch.setattr(live, "serve", lambda served: served.socket.close())
    monkeypatch.setenv("SWARMCENSUS_CACHE", str(tmp_path))
    assert interpreted.needs_compiling(settings)
    assert main(["watch", "--no-browser"]) == 0
    [(is_running, until)] = served
    assert is_running
    until.close()
    assert ended()
    assert main(["watch", "--set", "robots=many"]) == 2
    assert ended()


def test_the_process_ends_with_its_parent():
    start = "from swarmcensus.live.interpreted import INTERPRETER as it; it.start()"
    program = f"{start}; print(it._process.pid, flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as parent:
        assert parent.stdout
        child = psutil.Process(int(parent.stdout.readline()))
        assert child.is_running()
        parent.kill()
    psutil.wait_procs([child], timeout=20)
    assert not child.is_running()
