"""`swarmcensus swarm --on`: robots that wait are started, report, are lost and come back, and their logs live again."""

import json
import os
import shutil
import socket
import subprocess
import sys

import pytest

from swarmcensus.brains import load
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from swarmcensus.robots.logs.logs import Gap, read_log
from swarmcensus.robots.swarm.fleet import Fleet, Reporting, run_fleet
from swarmcensus.runtime import log, runtime
from swarmcensus.runtime.reports import STATE, STOP, Reports
from swarmcensus.support.errors import InputError
from swarmcensus.worlds import KnownRobot
from tests.support.boards import Air, Clock, Readings, free_port, messages_of

BRAIN = load("commons")


@pytest.fixture
def watcher():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        one.setblocking(False)
        yield one


@pytest.fixture
def fleet(watcher, tmp_path):
    return Fleet(tmp_path, BRAIN, watcher, {7: Reporting(), 8: Reporting()})


@pytest.fixture
def reporting(watcher):
    """A robot that keeps no log, and its reports."""
    sensor, radio = Readings([True] * 1000), Air().radio()
    robot = runtime.Robot(BRAIN.functions, messages_of(BRAIN), sensor, radio, Clock(), 0.9, 0.8, 7)
    robot.record(log.Log(None, bytes.fromhex(BRAIN.sha256)[:8], form=3))
    reports = Reports(watcher.getsockname(), robot)
    yield robot, reports
    if reports.socket:
        reports.socket.close()


def test_a_robot_waits_starts_and_stops_as_it_is_told(fleet, reporting):
    robot, reports = reporting
    assert not reports.obey()
    fleet.listen()
    assert fleet.robots[7].address is not None
    assert fleet.robots[8].address is None
    assert not reports.obey()  # the swarm has not begun
    fleet.began = 1.0
    fleet.listen()  # it still waits, and is started
    assert reports.obey()
    assert robot.log.now > 1_700_000_000_000
    for _ in range(30):
        robot.tick()
    fleet.listen()
    assert (fleet.robots[7].ticks, fleet.robots[7].lost, fleet.robots[7].estimate) == (30, 0, robot.estimate)
    fleet.tell(7, STOP)
    assert not reports.obey()
    written = read_log(fleet.folder / "robot-7.log")
    assert [tick.tick for tick in written.ticks] == [*range(1, 31)]


def test_lost_reports_are_counted_and_a_state_is_asked_for(fleet, reporting):
    """From it on, the log is lived again; noise and strangers are left out."""
    robot, reports = reporting
    fleet.began = 1.0
    reports.lives = True
    robot.log.state(robot, True)
    for tick in range(40):
        lost = 10 <= tick < 15
        robot.log.sends = None if lost else reports.send
        robot.tick()
        if not lost:
            fleet.listen()
            reports.obey()
    head = log.MAGIC + bytes([log.VERSION + 1]) + bytes(60)
    for block in (b"noise", log.block(log.STATE, b""), log.block(log.STATE, head), log.block(log.TICK, bytes(9))):
        reports.send(block)
    reports.send(log.block(0x01, bytes(99)))
    reports.socket.sendto(b"\x09\x00" + log.block(log.TICK, bytes(40)), fleet.command.getsockname())
    fleet.listen()
    assert (fleet.robots[7].ticks, fleet.robots[7].lost, fleet.robots[7].refused) == (35, 5, 5)
    shutil.copy(BRAIN.path, fleet.folder / "brain.py")
    (member,) = read_recording(fleet.folder).members
    assert not any(isinstance(block, Gap) for block in member.log.blocks)
    life = relive(member)
    assert (life.ticks, life.relived, life.breaks) == (35, 34, [])  # the tick before the state is not


def test_a_robot_of_which_no_state_came_is_asked_for_it(fleet, reporting):
    robot, reports = reporting
    reports.lives = True
    robot.tick()
    fleet.listen()
    assert reports.socket.recvfrom(64)[0] == STATE
    assert not (fleet.folder / "robot-7.log").exists()


def test_another_brain_is_named(fleet, reporting):
    robot, _ = reporting
    fleet.brain = load("voter")
    robot.log.state(robot, True)
    with pytest.raises(InputError, match="robot 7 runs another brain than voter: its hash begins with"):
        fleet.listen()


def test_a_full_log_and_none_report_on(fleet, reporting, tmp_path):
    robot, _ = reporting
    robot.log = log.Log(tmp_path / "kept", most=0)
    sent = []
    robot.log.sends = sent.append
    for _ in range(5):
        robot.tick()
    assert len(sent) == robot.log.faults == 5
    assert not (tmp_path / "kept").exists()


def test_orders_that_are_none_do_nothing(watcher, reporting):
    _, reports = reporting
    reports.obey()
    for order in (b"", b"strt", b"startx", STATE):
        watcher.sendto(order, reports.socket.getsockname())
        assert not reports.obey()


def test_robots_that_do_not_come_are_named(tmp_path):
    robots = [KnownRobot(number=number, b=0.9, w=0.8) for number in (3, 4)]
    with pytest.raises(InputError, match="robots that do not report: 3, 4"):
        run_fleet(BRAIN, robots, tmp_path / "out", ("127.0.0.1", free_port()), patience=0.1)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("--on robots.toml --trial 3", "--trial 3 is for processes: it does not go with --on"),
        ("--on robots.toml --set robots=4", "--set is for processes"),
        ("--on robots.toml --hz 5", "--hz 5 is for processes"),
        ("--on robots.toml --set fill_ratio=2", "world.fill_ratio = 2: should be"),
        ("--duration 3s", "--duration goes with --on"),
        ("--on nothing.toml", "nothing.toml: there is no such file"),
        ("--on robots.toml --host 10.1.2.3.4:1", "--host 10.1.2.3.4"),
        ("--on robots.toml --host foo:bar", "--host foo:bar: should be an address"),
    ],
)
def test_wrong_options_are_refused(here, refused, words, says):
    (here / "robots.toml").write_text("robots = [{number = 1, b = 0.9, w = 0.8}]")
    assert says in refused("swarm", "commons", *words.split())


@pytest.mark.skipif(sys.platform != "linux", reason="needs broadcasts on loopback, as Linux has them")
def test_deployed_programs_are_started_gathered_and_lived_again(here, accepted):
    """Three processes run what `deploy` writes, but for the sensor."""
    report, talk = free_port(), free_port()
    table = ", ".join(f"{{number = {k}, b = 0.9, w = 0.8}}" for k in (1, 2, 3))
    (here / "robots.toml").write_text(f"robots = [{table}]")
    words = ["--target", "udp", "--robots", "robots.toml", "--report", f"127.0.0.1:{report}", "--hz", "50"]
    said = accepted("deploy", "commons", "fleet", *words).out
    assert "report    43 bytes a tick and 13 for each message heard" in said
    program = (here / "fleet" / "main.py").read_text().replace("255.255.255.255", "127.255.255.255")
    program = program.replace("47230", str(talk)).replace("import machine", "return")
    (here / "fleet" / "main.py").write_text(program.replace("self.adc.read_u16() < THRESHOLD", "True"))
    running = []
    try:
        for number in (1, 2, 3):
            place = shutil.copytree(here / "fleet", here / f"run-{number}")
            shutil.copy(place / f"robot-{number}" / "settings.py", place)
            running.append(subprocess.Popen([sys.executable, "-S", "main.py"], cwd=place, env={**os.environ}))
        words = ["--on", "robots.toml", "--host", f"127.0.0.1:{report}", "--duration", "1s", "--out", "day", "--json"]
        found = json.loads(accepted("swarm", "commons", *words).out)
    finally:
        for process in running:
            process.kill()
            process.wait()
    assert [(row["robot"], row["lost"], row["silent"]) for row in found["rows"]] == [(k, 0, False) for k in (1, 2, 3)]
    assert all(row["ticks"] > 20 and row["heard"] > 20 and row["estimate"] > 0.8 for row in found["rows"])
    assert "3 of 3 robots lived again to the bit" in accepted("relive", "day").out
