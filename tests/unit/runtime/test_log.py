"""A robot's log: what it holds, and what is left of it after a cut or damage at any byte."""

import pytest

from swarmcensus import brains
from swarmcensus.brains.packing import Numbers
from swarmcensus.robots.logs.logs import Gap, State, read_log
from swarmcensus.runtime import log as log_module
from swarmcensus.runtime.log import Log
from swarmcensus.runtime.runtime import Robot
from swarmcensus.support.errors import InputError
from swarmcensus.translation.messages import messages_of
from tests.support.logged import Air


def gaps(log):
    """What is lost of a log."""
    return [block for block in log.blocks if isinstance(block, Gap)]


@pytest.fixture(autouse=True)
def logs(monkeypatch):
    """All logs of a test, which are closed after it."""
    made = []

    def record(self, log):
        made.append(log)
        recorded(self, log)

    recorded = Robot.record
    monkeypatch.setattr(Robot, "record", record)
    yield
    for log in made:
        log.close()


def robot(path, number=1, name="commons", hold=0, **more):
    brain = brains.load(name).with_numbers(Numbers(message="ratio16"))
    air = Air(1)
    made = Robot(brain.functions, messages_of(brain), air, air, lambda: 0, 0.9, 0.8, number, period=100, **more)
    made.record(Log(path, bytes.fromhex(brain.sha256)[:8], form=3, now=5, hold=hold))
    return made, air


def lives(path, ticks=20, **more):
    """A robot that hears another one for some ticks; returns it and what it sent."""
    one, air = robot(path, **more)
    other, far = robot(path.with_name("other"), 7)
    for _ in range(ticks):
        other.tick()
        air.waiting.extend(far.sent[-1:])
        one.tick()
    return one, air


def test_a_log_holds_what_was_read_said_and_heard(tmp_path):
    one, air = lives(tmp_path / "log")
    first, *ticks = read_log(tmp_path / "log").blocks
    assert isinstance(first, State)
    assert (first.starts, first.boot, first.number, first.tick, first.now) == (True, 0, 1, 0, 5)
    assert (first.b, first.w, first.period, first.form, first.code_bytes) == (0.9, 0.8, 100, 3, 3)
    assert first.brain.hex() == brains.load("commons").sha256[:16]
    assert [tick.tick for tick in ticks] == [*range(1, 21)]
    assert [tick.said for tick in ticks] == [datagram[6:9] for datagram in air.sent]
    assert all(tick.looks == 1 and [heard.sender for heard in tick.heard] == [7] for tick in ticks)
    assert [tick.heard[0].tick for tick in ticks] == [*range(1, 21)]
    assert ticks[-1].estimate == one.estimate


def test_a_log_cut_at_any_byte_keeps_all_whole_ticks(tmp_path):
    lives(tmp_path / "log", 4)
    data = (tmp_path / "log").read_bytes()
    whole = read_log(tmp_path / "log").blocks
    for cut in range(len(data)):
        (tmp_path / "cut").write_bytes(data[:cut])
        try:
            kept = read_log(tmp_path / "cut").blocks
        except InputError:
            kept = ()
            assert cut < len(data) - 4 * 20  # the state itself is cut
        blocks = [block for block in kept if not isinstance(block, Gap)]
        assert tuple(blocks) == whole[: len(blocks)]
        assert sum(gap.length for gap in kept if isinstance(gap, Gap)) < 100


def test_ticks_that_are_held_are_written_together(tmp_path, monkeypatch):
    """The bytes are those of a log that is written in each tick; what a cut loses is shorter than `hold`."""
    (one, _), (each, _) = robot(tmp_path / "log", hold=500), robot(tmp_path / "each")
    flushed, flush = [], Log.flush
    monkeypatch.setattr(Log, "flush", lambda log, synced=True: (flushed.append(log.path), flush(log, synced)))
    for _ in range(400):
        one.tick()
        each.tick()
        whole, kept = (tmp_path / "each").read_bytes(), (tmp_path / "log").read_bytes()
        assert whole.startswith(kept)
        assert len(whole) - len(kept) < 500
    assert flushed.count(tmp_path / "each") == 400
    assert flushed.count(tmp_path / "log") == len(kept) // 500 < 30
    one.log.close()
    assert (tmp_path / "log").read_bytes() == whole


def test_a_saved_memory_finds_all_ticks_before_it_in_the_log(tmp_path):
    one, _ = robot(tmp_path / "log", hold=100_000)
    one.keep(str(tmp_path / "memory"), 50)
    for _ in range(120):
        one.tick()
    log = read_log(tmp_path / "log")
    assert [tick.tick for tick in log.ticks] == [*range(1, 101)]
    assert [state.tick for state in log.states] == [0, 50, 100]


@pytest.mark.parametrize("damage", ["flip", "cut"])
def test_after_damage_a_log_goes_on_with_the_next_state(tmp_path, damage):
    one, _ = robot(tmp_path / "log")
    one.keep(str(tmp_path / "memory"), 5)
    for _ in range(3):
        one.tick()
    before = (tmp_path / "log").stat().st_size
    for _ in range(9):
        one.tick()
    data = bytearray((tmp_path / "log").read_bytes())
    data[before - 3] ^= damage == "flip"
    if damage == "cut":
        del data[before - 3 : before + 2]
    (tmp_path / "log").write_bytes(data)
    log = read_log(tmp_path / "log")
    assert [tick.tick for tick in log.ticks] == [1, 2, 6, 7, 8, 9, 10, 11, 12]
    assert ([state.tick for state in log.states], len(gaps(log))) == ([0, 5, 10], 1)


@pytest.mark.parametrize("hold", [0, 500])
def test_a_full_log_stays_full_and_lacks_no_tick_before(tmp_path, hold):
    """Although later ticks are shorter, also over starts; all of its bytes count."""
    one, air = robot(tmp_path / "log", hold=hold)
    far, sent = robot(tmp_path / "other", 7)
    one.log.most = most = one.log.size + 4 * 80 + 40  # it hears 8 bytes in every other tick
    for k in range(30):
        far.tick()
        air.waiting.extend(sent.sent[-1:] if k % 2 == 0 else [])
        one.tick()
    one.log.close()
    kept = (tmp_path / "log").read_bytes()
    assert len(kept) == most - 40
    assert [tick.tick for tick in read_log(tmp_path / "log").ticks] == [*range(1, 9)]
    assert one.log.faults == 22
    for _ in range(3):
        again = Robot(one.brain, one.messages, air, air, lambda: 0, 0.9, 0.8, 1, period=100)
        again.record(Log(tmp_path / "log", most=most))
        again.tick()
        again.log.close()
        assert (again.log.faults, (tmp_path / "log").read_bytes()) == (2, kept)


def test_after_a_failed_write_a_log_goes_on_with_a_state(tmp_path):
    one, _ = robot(tmp_path / "log")
    for tick in range(1, 200):
        if tick == 20:
            one.log.close()
            one.log.path = tmp_path / "away" / "log"
        one.tick()
        one.log.path = tmp_path / "log"
    log = read_log(tmp_path / "log")
    assert [tick.tick for tick in log.ticks] == [*range(1, 20), *range(65, 200)]
    assert ([state.tick for state in log.states], one.log.faults) == ([0, 64], 45)


def test_without_memory_and_with_a_broken_file_a_robot_goes_on(tmp_path, monkeypatch):
    one, _ = robot(tmp_path / "log", hold=100)
    one.keep(str(tmp_path / "memory"), 10)

    def fail(*_):
        raise MemoryError

    for broken, at in ((log_module, "numbers_of"), (log_module, "block"), (Robot, "numbers"), (Robot, "_is_new")):
        before, faults = one.ticks, one.log.faults
        with monkeypatch.context() as patch:
            patch.setattr(broken, at, fail)
            for _ in range(10):
                one.tick()
        assert one.ticks == before + 10
        assert one.log.faults > faults or at == "_is_new"
    file = open(tmp_path / "log")  # noqa: SIM115 - it is not for writing
    one.log.close()
    one.log.file = file
    one.save()
    assert file.closed
    faults = one.log.faults
    one.log.file = type("Broken", (), {"close": fail})()
    one.log.close()
    assert one.log.faults == faults + 1
