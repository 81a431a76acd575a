"""The command `swarm`: processes over sockets, what happens to them, what they leave, and what is refused."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from swarmcensus.engine.constants import LISTED
from swarmcensus.robots.logs.folders import about_of
from swarmcensus.robots.logs.logs import read_log
from swarmcensus.robots.swarm import air, plans
from swarmcensus.robots.swarm.plans import Air, hearers, plan_of
from swarmcensus.robots.swarm.reports import read_report
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.trials import record_readings
from swarmcensus.support.errors import InputError
from tests.support.small import study_of
from tests.support.watching import programs

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes with signals")
QUICK = ["--hz", "100", "--json", "--quiet", "--set", "robots=4", "--set", "message=ratio16"]


def faults(*tables):
    """The option with these faults, of robots by their numbers."""
    shown = (f"{{do = '{do}', at = {at}, robots = {{named = {robots}}}{more}}}" for do, at, robots, more in tables)
    return ["--set", f"faults=[{', '.join(shown)}]"]


def run(accepted, folder, *arguments, what="commons", quick=(*QUICK, "--set", "rounds=50")):
    return json.loads(accepted("swarm", what, *quick, "--out", folder, *arguments).out)


def logs(folder):
    return [read_log(path) for path in sorted(Path(folder).glob("robot-*.log"))]


def study(**world):
    given = {"topology": "scale-free", "fill_ratio": 0.3, "link_success": 0.5, "message": "ratio16"} | world
    return study_of("commons", 5, "U(0.6, 0.9)", rounds=50, looks=3, **given)


def test_robots_read_what_the_simulator_reads(tmp_path, accepted):
    """Also their beliefs, their network and their number of rounds are those of the trial; losses can be told later."""
    (tmp_path / "five.toml").write_text(study().text)
    quick = ["--hz", "20", "--json", "--quiet"]  # slow, for clocks that are read late on a busy machine
    arguments = ["--trial", "2", "--seed", "7", "--duplicate", "0.2"]
    run(accepted, tmp_path / "out", *arguments, what=str(tmp_path / "five.toml"), quick=quick)
    [setting] = study().settings()
    readings = record_readings(setting, 7, 2).reshape(50, 3, 5).sum(axis=1)
    given = inputs_of(setting, 7, 2)
    about = json.loads((tmp_path / "out" / "swarm.json").read_text())
    (tmp_path / "swarm.json").write_text(json.dumps(about | {"fill_ratio": 0.5}))
    with pytest.raises(InputError, match="damaged or edited since it was written"):
        about_of(tmp_path)
    seed, loss = about["chance"]["seed"], about["chance"]["loss"]
    pairs = {(r, s) for r, s in zip(given.links.receivers, given.links.senders, strict=True)}
    assert given.links.mode == LISTED
    assert {tuple(link) for link in about["links"]} == pairs
    for k, log in enumerate(logs(tmp_path / "out")):
        assert log.states[0].b == given.beliefs[0][0, k] == about["robots"][k]["b"]
        phase = int(50 * air.share(seed, air.PHASE, k))
        rounds = [(tick.clock - phase) // 50 for tick in log.ticks]
        assert rounds == sorted(set(rounds))
        assert rounds[-1] < 50
        assert [tick.blacks for tick in log.ticks] == readings[rounds, k].tolist()
        heard = [message for tick in log.ticks for message in tick.heard]
        assert {m.sender for m in heard} <= {s for r, s in pairs if r == k}
        assert all(air.share(seed, air.LOSS, m.sender, m.boot, m.tick, log.number) >= loss for m in heard)


def test_shares_are_uniform_and_independent_of_order():
    drawn = np.array([air.share(9, air.LOSS, s, 0, t, r) for s in range(20) for t in range(100) for r in range(20)])
    assert abs(drawn.mean() - 0.5) < 4 / np.sqrt(12 * drawn.size)
    counts = np.histogram(drawn, 64, (0, 1))[0]
    assert ((counts - drawn.size / 64) ** 2 / (drawn.size / 64)).sum() < 63 + 4 * np.sqrt(2 * 63)
    assert air.share(1, 2, 3, 4, 5, 6) == air.share(1, 2, 3, 4 + 256, 5 + 65536, 6) != air.share(1, 2, 3, 5, 5, 6)


def test_a_swarm_bears_all_that_can_happen(tmp_path, accepted):
    all_faults = faults(("kill", 11, [3], ", until = 31"), ("stop", 21, [0], ", until = 41"),
                        ("cut", 31, [0, 1], ", until = 51"), ("restart", 31, [2], ", blank = true"),
                        ("kill", 1, [1], ", until = 41"))  # fmt: skip
    quick = [*QUICK, "--set", "rounds=100", "--set", "link_success=0.8"]
    told = run(accepted, tmp_path / "out", "--delay", "20ms", *all_faults, quick=quick)
    assert (told["at_work"], told["died"], told["undone"]) == (4, {}, 0)
    boots = [[state.boot for state in log.states if state.starts] for log in logs(tmp_path / "out")]
    assert boots == [[0], [0], [0, 1], [0, 1]]
    lived = [len(log.ticks) for log in logs(tmp_path / "out")]
    assert lived[1] <= 65  # it started late
    assert all(0 < counted <= ticks for counted, ticks in zip(told["ticks"], lived, strict=True))
    assert not programs(tmp_path)


@pytest.mark.long
def test_a_partition_parts(tmp_path, accepted):
    run(accepted, tmp_path / "out", "--set", "topology=full", *faults(("cut", 1, [0, 1], "")))
    for log in logs(tmp_path / "out"):
        assert {message.sender // 2 for tick in log.ticks[10:] for message in tick.heard} == {log.number // 2}


def test_crashed_robot_is_reported(tmp_path):
    process = started(tmp_path / "out", "--json", rounds=120)
    [pid] = [line.split()[0] for line in programs(tmp_path, "pid,args") if " robot_1 " in line]
    os.kill(int(pid), signal.SIGKILL)
    told = json.loads(process.communicate()[0])
    assert (process.returncode, told["died"]) == (1, {"1": "signal 9"})
    assert told["at_work"] == 2  # one is stopped


def test_liars_are_processes_too(tmp_path, accepted):
    world = {"topology": "full", "fill_ratio": 0.2, "message": "ratio16"}
    members = [{"robots": 1, "brain": "forger", "honest": False}]
    lied = study_of("commons", 4, 0.9, rounds=60, trials=1, members=members, **world)
    (tmp_path / "lied.toml").write_text(lied.text)
    run(accepted, tmp_path / "out", what=str(tmp_path / "lied.toml"), quick=QUICK[:4])
    about = json.loads((tmp_path / "out" / "swarm.json").read_text())
    [liar] = [robot for robot in about["robots"] if not robot["honest"]]
    assert (liar["brain"], liar["adversary"]) == ("liar-1.py", "forger")
    assert [robot["adversary"] for robot in about["robots"] if robot is not liar] == [None] * 3
    assert (tmp_path / "out" / "liar-1.py").is_file()
    honest = next(log for log in logs(tmp_path / "out") if log.number != liar["number"])
    assert liar["number"] in {m.sender for tick in honest.ticks for m in tick.heard}


@pytest.mark.parametrize("precision", ["double", "single"])
def test_robots_import_nothing_but_python(tmp_path, accepted, precision):
    told = run(accepted, tmp_path / "out", "--set", f"precision={precision}", what="sure")
    assert (told["died"], told["undone"]) == ({}, 0)
    assert logs(tmp_path / "out")[0].states[0].single == (precision == "single")
    for file in (tmp_path / "out" / "run").glob("*.py"):
        assert "import swarmcensus" not in file.read_text()
        assert "from swarmcensus" not in file.read_text()


def started(folder, *arguments, rounds=5000):
    command = [sys.executable, "-m", "swarmcensus", "swarm", "commons", "--set", "robots=4", "--out", str(folder)]
    more = ["--hz", "50", "--set", f"rounds={rounds}", *faults(("stop", 6, [2], "")), *arguments]
    process = subprocess.Popen([*command, *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    until = time.monotonic() + 60
    log = folder / "robot-0.log"
    while time.monotonic() < until and not (log.exists() and len(read_log(log).ticks) > 30):
        time.sleep(0.05)
    assert len(programs(folder)) == 4
    return process


@pytest.mark.long(but=[str(int(signal.SIGKILL))])
@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_nothing_is_left_behind(tmp_path, by):
    """Also of a robot that is stopped, and when the command itself is killed."""
    process = started(tmp_path / "out")
    os.kill(process.pid, by)
    process.communicate()
    until = time.monotonic() + 10
    while programs(tmp_path) and time.monotonic() < until:
        time.sleep(0.05)
    assert not programs(tmp_path)
    assert process.returncode == (-by if by == signal.SIGKILL else 128 + by)
    assert json.loads((tmp_path / "out" / "swarm.json").read_text())["ended"] is None or by != signal.SIGKILL
    assert len(read_log(tmp_path / "out" / "robot-0.log").ticks) > 30


@pytest.mark.parametrize(("table", "says"), [
    ({"do": "kil"}, "did you mean 'kill'"),
    ({}, "should have either stop, or, for processes, do"),
    ({"do": "kill", "robots": {"named": [20]}}, "there are 20 robots, numbered from 0"),
    ({"do": "kill", "blank": True}, 'blank goes with do = "restart"'),
    ({"do": "restart", "until": 9}, 'until does not go with do = "restart"'),
    ({"do": "cut", "robots": 20}, "these are all robots"),
    ({"do": "kill", "at": 500}, "comes after the last round"),
])  # fmt: skip
def test_wrong_faults_are_refused_in_a_sentence(table, says):
    fault = {"at": 5, "robots": {"named": [3]}} | table
    first = {"at": 50, "robots": {"named": [3]}, "do": "kill"}
    with pytest.raises(InputError, match=says):
        plan_of(twenty(first, fault), 0, 0, 0, Air())


def twenty(*faults):
    return study_of(robots=20, accuracy=0.8, rounds=100, looks=2, trials=1, fill_ratio=0.5, faults=faults)


def test_faults_in_order_and_of_the_simulator_s_robots():
    """A robot that senses nothing has no readings; one that does not talk is heard by nobody."""
    drawn = [{"at": 20, "robots": 3, "stop": "talking"}, {"at": 10, "until": 30, "robots": 0.1, "stop": "sensing"}]
    plan = plan_of(twenty({"at": 50, "robots": {"named": [4]}, "do": "kill", "until": 60}, *drawn), 0, 7, 2, Air())
    failing = [fault.failing(n, 7, 2, 20).tolist() for n, fault in enumerate(plan.setting.faults)]
    wanted = [(20, "mute", failing[1]), (50, "kill", [4]), (60, "start", [4])]
    assert [(e.round, e.what, [*e.robots]) for e in plan.events] == [(a, b, sorted(c)) for a, b, c in wanted]
    blind = plan.readings.reshape(100, 2, 20) == 2.0
    assert blind[9:29, :, failing[2]].all()
    assert blind.sum() == 20 * 2 * 2
    kinds = [("kill", 10, 40, [1]), ("stop", 20, 30, [1, 2]), ("restart", 25, None, [2, 3]), ("kill", 50, None, [1])]
    faults = [{"do": do, "at": at, "robots": {"named": named}} | ({"until": end} if end else {})
              for do, at, end, named in kinds]  # fmt: skip
    happens = [(e.round, e.what, e.robots) for e in plan_of(twenty(*faults), 0, 0, 0, Air()).events]
    assert happens == [  # what is killed or stopped already stays so until that fault ends
        (10, "kill", (1,)), (20, "stop", (2,)), (25, "restart", (3,)), (30, "continue", (2,)), (40, "start", (1,)),
        (50, "kill", (1,)),
    ]  # fmt: skip
    heard_by = hearers(plan, [], failing[1])
    assert [k for k in range(20) if not heard_by[k]] == sorted(failing[1])


@pytest.mark.parametrize(("arguments", "says"), [
    (["commons", "--hz", "0.0009"], "--hz 0.0009: should be ticks a second, from 0.001 to 500"),
    (["commons", "--hz", "501"], "--hz 501: "),
    (["commons", "--delay", "5"], "--delay 5"),
    (["commons", "--duplicate", "1"], "--duplicate 1"),
    (["commons", "--set", "topology=moving"], "a swarm of processes needs a fixed network"),
    (["commons", "--host", "192.0.2.1"], "--host 192.0.2.1"),
    (["commons", "--set", "robots=5000"], "1,000 processes"),
    (["commons", "--setting", "1"], "swarm has 1 setting, numbered from 0"),
    (["oracle"], "is a bound"),
])  # fmt: skip
def test_wrong_options_are_refused_in_a_sentence(refused, arguments, says):
    assert says in refused("swarm", *arguments)


def test_folders_in_use_are_refused(here, refused):
    assert "--out .: this is the folder that you are in" in refused("swarm", "commons", "--out", ".")
    (here / "mine").mkdir()
    (here / "mine" / "notes").write_text("my notes")
    assert "the folder mine is not empty, it holds 'notes'" in refused("swarm", "commons", "--out", "mine")
    assert "is a file: name a new folder" in refused("swarm", "commons", "--out", "mine/notes")


@pytest.mark.skipif(sys.platform != "linux", reason="0.0.0.0 is sent to as this machine")
def test_who_can_reach_other_addresses_is_said(tmp_path, accepted):
    arguments = [*QUICK[:2], "--set", "robots=2", "--set", "rounds=20", "--host", "0.0.0.0"]
    assert "Anyone who can reach 0.0.0.0" in accepted("swarm", "commons", *arguments, "--out", tmp_path / "out").err


@pytest.mark.long
@pytest.mark.parametrize("number", range(5))
def test_all_states_of_a_mixed_swarm_are_replayed(tmp_path, benchmark, number):
    """Also from logs that are cut anywhere."""
    robots, rounds, swarm = 8, 320, benchmark("swarm")
    [(_, outcome, whole, logs, cut)] = swarm.rows(tmp_path, swarm.SWARMS[number : number + 1], robots, rounds)
    assert (outcome["died"], whole.differences, cut.differences) == ({}, [], [])
    assert (whole.to_the_bit, cut.to_the_bit) == (robots, robots)
    assert sum(whole.starts.values()) > robots  # on a busy machine not all of them come in time
    assert whole.ticks > robots * rounds * 0.5
    assert whole.heard > whole.ticks / 2
    assert logs > 0
    assert cut.ticks < whole.ticks
    assert (whole.relived, cut.relived) == (whole.ticks, cut.ticks)


# ---- what is not believed or taken
def test_reports_without_the_token_are_ignored():
    assert read_report(b"secret 2 1 40000 0", "secret").port == 40000
    assert read_report(b"secret 2 1 40000 3 7 0 0.5 9 2 3 4 5 6 7 8 9", "secret").ticks == 9
    for datagram in (b"2 1 40000 0", b"wrong 2 1 40000 0", b"", b"\xff\x00 2 1 4 0"):
        assert read_report(datagram, "secret") is None


def test_a_large_message_is_heard_whole_and_when_its_delay_is_over():
    here, clock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), iter([0.0, 19.0, 20.0, 20.0])
    here.bind(("127.0.0.1", 0))
    here.setblocking(False)
    messages = SimpleNamespace(size=9000, mark=1, unpack=lambda _: None)
    heard = air.Air(here, messages, lambda: next(clock), 1, 7, delay=20)
    with here:
        for size in (9000, 9100):
            here.sendto(bytes(size), here.getsockname())
        assert heard.receive() is None
        assert [len(heard.receive()), len(heard.receive())] == [9000, 9001]  # the longer one is refused as noise


def small(observations=1):
    return study_of("commons", 2, 0.8, rounds=2, looks=observations, trials=1, topology="full", message="ratio16")


def test_what_no_datagram_or_log_holds_is_refused(monkeypatch):
    with pytest.raises(InputError, match="65,536 observations a round"):
        plan_of(small(65536), 0, 0, 0, Air())
    monkeypatch.setattr(plans, "MOST_BYTES", 8)
    with pytest.raises(InputError, match="a message of 13 bytes: UDP carries up to 8 in a datagram"):
        plan_of(small(), 0, 0, 0, Air())
