"""Logs that grow while they are watched: read, lived and shown as the whole day would be, each tick once."""

import itertools
import json
import random

import pytest

from swarmcensus.live.choices import offer_of, wanted
from swarmcensus.live.frames import Show
from swarmcensus.live.robots import robot_of
from swarmcensus.live.sessions import Session
from swarmcensus.robots.logs import growing, lives
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.logs import Gap, LogReader, read_log
from swarmcensus.support.errors import InputError
from tests.support.watching import parsed

pytestmark = pytest.mark.interpreted


def asked(session, **words):
    *parts, end = session.answer(json.dumps(words))
    return parts, end


@pytest.fixture
def session(recording):
    """That of a page, which has asked for the day from the start of its logs."""
    session = Session(offer_of(recording.folder))
    assert asked(session, do="begin", ask={})[1]["form"]["grows"]
    return session


def test_log_read_byte_by_byte(whole, tmp_path):
    path = tmp_path / "robot-1.log"
    reader = LogReader(path)
    assert not reader.more()
    content = (whole / "robot-1.log").read_bytes()
    sizes = [0, *sorted(random.Random(1).sample(range(1, len(content)), 60)), len(content)]
    for first, last in itertools.pairwise(sizes):
        with path.open("ab") as log:
            log.write(content[first:last])
        before = len(reader.blocks)
        assert reader.more() == (len(reader.blocks) > before)
    known = read_log(path)
    assert any(isinstance(block, Gap) for block in known.blocks)
    assert (tuple(reader.blocks), reader.log.number) == (known.blocks, known.number)


@pytest.fixture
def lived(monkeypatch):
    """The ticks that brains are run for again, from now on."""
    lived, live = [], lives.is_relived
    monkeypatch.setattr(lives, "is_relived", lambda *given: lived.append(given) or live(*given))
    return lived


def test_growing_recording_replays_each_tick_once(whole, recording, lived, session):
    version, rounds = 0, 0
    for step in range(101):
        recording.grow(step / 100)
        _, news = asked(session, do="news", since=version)
        assert news["wait"] == 0.1
        assert news["rounds"] >= rounds
        assert news["changed"] <= news["rounds"] + 1
        version, rounds = news["version"], news["rounds"]
        asked(session, do="frames", **{"from": rounds, "count": 1})
    recording.tell({})
    assert asked(session, do="news", since=version)[1]["wait"] is None
    assert len(lived) == sum(life.relived for life in lives.relive_all(read_recording(whole)))
    lived.clear()
    [grown] = session.shown.shows
    offer = offer_of(whole)
    trial = wanted(offer, {})
    static = Show(offer.live(trial.settings[0], trial.seed, trial.trial), trial.study.measure)
    ticks = list(range(static.rounds + 1))
    assert grown.rounds == static.rounds
    assert grown.frames(ticks) == static.frames(ticks)
    for tick, robot in itertools.product(ticks, range(4)):
        assert robot_of(grown, tick, robot) == robot_of(static, tick, robot)


def test_working_robots_are_shown_after_their_last_ticks(recording, session, monkeypatch):
    for name in ("robot-0.log", "robot-1.log"):
        with (recording.folder / name).open("ab") as log:
            log.write(recording.contents[name][log.tell() : 900 if name == "robot-0.log" else 500])
    _, news = asked(session, do="news", since=0)
    [show] = session.shown.shows
    last = {number: show.trace._last[number][0] for number in (0, 1, 2)}
    assert last[0] == news["rounds"] > last[1] > last[2] >= 0
    now = [robot_of(show, news["rounds"], robot) for robot in range(4)]
    assert [one["estimate"] for one in now[:3]] == [robot_of(show, last[k], k)["estimate"] for k in range(3)]
    assert now[1]["fields"] == robot_of(show, last[1], 1)["fields"]
    assert now[3]["estimate"] is None
    later = growing.time.time() + 10.0
    monkeypatch.setattr(growing.time, "time", lambda: later)
    _, after = asked(session, do="news", since=news["version"])
    assert (after["changed"], after["wait"]) == (last[2] + 1, 1.0)
    assert robot_of(show, news["rounds"], 1)["estimate"] is None
    [frames], _ = asked(session, do="frames", **{"from": news["rounds"], "count": 1})
    assert (parsed(frames)["layers"][0, 0] == 65_535).tolist() == [False, True, True, True]


def test_a_page_learns_that_the_swarm_has_ended(recording, session):
    recording.grow(1.0)
    recording.tell({})
    asked(session, do="begin", ask={})
    assert asked(session, do="news", since=0)[1]["wait"] is None
    assert not asked(session, do="begin", ask={})[1]["form"]["grows"]


def test_a_swarm_that_was_killed_long_ago_counts_as_ended(recording, monkeypatch):
    recording.grow(1.0)
    assert growing.may_grow(recording.folder)
    later = growing.time.time() + 100.0
    monkeypatch.setattr(growing.time, "time", lambda: later)
    assert not growing.may_grow(recording.folder)
    assert not asked(Session(offer_of(recording.folder)), do="begin", ask={})[1]["form"]["grows"]


@pytest.mark.parametrize("robot", [0, 2])
def test_two_logs_of_one_robot_are_refused(recording, session, robot):
    (recording.folder / "copy.log").write_bytes(recording.contents[f"robot-{robot}.log"])
    says = f"{recording.folder}: two logs are of robot {robot}: each robot has one"
    with pytest.raises(InputError, match=says):
        read_recording(recording.folder)
    assert asked(session, do="news", since=0)[1]["error"] == says
