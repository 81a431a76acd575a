"""The radios of boards with MicroPython: nothing that they raise ends a robot, and what was lost comes back."""

import sys

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.logs import read_log
from tests.support.board_modules import MODULES

FAILING = """
import espnow
import network
import robot as program
network.WLAN.connected = True

def live(ticks):
    for _ in range(ticks):
        now.append(now[-1] + 100)
        robot.tick()

def since_then(*names):
    out = [one for one in network.calls if one[0] in names]
    network.calls.clear()
    return out

now = [0]
program.clock = lambda: now[-1]
robot = program.made(program.Sensor(), program.Radio, 1, lambda: now[-1])
SCRIPT
print(robot.status())
"""


@pytest.fixture
def on_a_failing_board(here, monkeypatch):
    """The namespace of a script that runs a deployed robot, whose modules of a board fail as they are made to. CPython
    runs it, because it has sockets too."""

    def run(radio, script, *more):
        board, needs = here / "board", ["--target", radio, "--accuracy", "{black = 0.9, white = 0.85}"]
        assert main(["deploy", "commons", str(board), *needs, *more]) == 0
        (board / "main.py").rename(board / "robot.py")
        files = MODULES | {path.name: path.read_text() for path in board.glob("*.py")}
        for name, text in files.items():
            (board / name).write_text(text)
            monkeypatch.delitem(sys.modules, name.removesuffix(".py"), raising=False)
        monkeypatch.chdir(board)
        monkeypatch.syspath_prepend(board)
        space = {}
        exec(FAILING.replace("SCRIPT", script), space)
        for name in files:
            sys.modules.pop(name.removesuffix(".py"), None)
        return space

    return run


@pytest.mark.parametrize("method", ["WLAN", "active", "channel", "ESPNow", "add_peer"])
def test_espnow_is_switched_on_again_until_that_works(on_a_failing_board, method):
    """The constructor raises: the robot lives on without a radio, and tries in each tick."""
    space = on_a_failing_board("espnow", f"""
now_class = espnow.ESPNow
if hasattr(now_class, "{method}") or "{method}" == "ESPNow":
    def fail(*_):
        raise OSError(12389, "ESP_ERR_ESPNOW_NOT_INIT")
    whole = now_class.__init__, now_class.add_peer
    setattr(now_class, "__init__" if "{method}" == "ESPNow" else "add_peer", fail)
network.fails.add(("{method}",))
live(5)
faults = robot.radio_faults
network.fails.clear()
if "whole" in globals():
    now_class.__init__, now_class.add_peer = whole
live(5)
""")  # fmt: skip
    robot = space["robot"]
    assert (robot.ticks, space["faults"], robot.radio_faults) == (10, 10, 10)  # a send and a receive each tick
    assert "OSError" in robot.trouble
    assert robot.radio.is_open


def test_an_esp8266_takes_its_channel_as_an_access_point(on_a_failing_board):
    space = on_a_failing_board("espnow", """
network.fails |= {("channel", 0), ("pm", 0), ("disconnect", 0)}
live(1)
calls = since_then("active", "channel")
""")  # fmt: skip
    assert space["calls"][-4:] == [("channel", 0, 1), ("active", 1, True), ("channel", 1, 1), ("active", 1, False)]
    assert space["robot"].radio_faults == 0


def test_espnow_goes_on_after_full_buffers_and_after_it_was_switched_off(on_a_failing_board):
    space = on_a_failing_board("espnow", """
live(1)
other = espnow.ESPNow()
espnow.ESPNow.worn = True
live(3)
worn, espnow.ESPNow.worn = robot.radio_faults, False
robot.radio.now.active(False)
live(1)
off = robot.radio_faults
live(5)
""")  # fmt: skip
    assert (space["worn"], space["off"], space["robot"].radio_faults) == (3, 4, 4)
    assert len(space["other"].box) == 1 + 5 - 1


def test_udp_joins_a_lost_network_again(on_a_failing_board):
    """From a network of before, and also where connect raises; no tick waits, and none asks twice in 20 s."""
    space = on_a_failing_board("udp", """
network.fails.add(("connect", 0))
live(5)
first = since_then("disconnect", "connect")
network.fails.clear()
live(200)
second = since_then("connect")
network.WLAN.connected = True
live(10)
joined, faults = since_then("connect", "pm"), robot.radio_faults
network.WLAN.connected = False
live(3)
lost = since_then("connect")
robot.radio.tried = (now[-1] - 2**29 - 5) % 2**30  # six days ago, where the difference of two times changes its sign
live(1)
late = since_then("connect")
network.WLAN.connected = True
live(5)
""")  # fmt: skip
    assert (space["first"], space["second"]) == ([("disconnect", 0), ("connect", 0)], [("connect", 0)])
    assert space["joined"] == [("pm", 0, 0)]
    assert space["lost"] == space["late"] == [("connect", 0)]
    robot = space["robot"]
    assert (robot.ticks, robot.radio_faults) == (224, space["faults"] + 2 * 4)
    robot.radio.socket.close()


@pytest.mark.parametrize("error", ["EAGAIN", "ENOMEM", "ETIMEDOUT", "ENETUNREACH"])
def test_udp_keeps_its_socket_where_there_is_no_room(on_a_failing_board, error):
    space = on_a_failing_board("udp", f"""
import errno
class Full:
    def recvfrom(self, size):
        raise OSError(errno.{error})
    sendto = close = lambda *_: None
live(1)
network.WLAN.connected = True
live(1)
robot.radio.socket.close()
robot.radio.socket = full = Full()
live(1)
kept = robot.radio.socket is full
live(1)
""")  # fmt: skip
    assert space["kept"] == (error != "ENETUNREACH")
    space["robot"].radio.socket.close()


def test_udp_hears_where_it_cannot_send(on_a_failing_board):
    space = on_a_failing_board("udp", """
import errno
messages = program.Messages(program.settings.LENGTHS, program.settings.PLAN, program.settings.MARK, True)
waiting = [messages.pack((1.0, 2.0), 0, 7, tick) for tick in range(1, 6)]
class Mute:
    def recvfrom(self, size):
        if not waiting:
            raise OSError(errno.EAGAIN)
        return waiting.pop(), None
    def sendto(self, *_):
        raise OSError(errno.ENETUNREACH)
    close = None
network.WLAN.connected = False
live(1)
network.WLAN.connected = True
robot.radio.socket, robot.radio.address, faults = Mute(), None, robot.radio_faults
waiting.reverse()
live(3)
""")  # fmt: skip
    assert (space["robot"].heard, space["robot"].radio_faults - space["faults"]) == (5, 3)


def test_a_serial_line_has_pins_and_is_opened_again(on_a_failing_board):
    space = on_a_failing_board("serial", """
import machine
program.PINS = {"tx": 17, "rx": 99}
given, real = [], machine.UART
def line(*numbers, **pins):
    given.append(pins)
    if pins["rx"] == 99:
        raise ValueError("invalid pin")
    return real()
machine.UART, line.made = line, []
live(3)
faults, program.PINS["rx"] = robot.radio_faults, 16
live(3)
""")  # fmt: skip
    assert space["faults"] == space["robot"].radio_faults == 6
    assert space["given"][-1] == {"timeout": 0, "tx": 17, "rx": 16}


def test_a_program_that_is_stopped_has_logged_all_ticks(on_a_failing_board):
    on_a_failing_board("espnow", """
def sleep(seconds):
    now.append(now[-1] + 100)
    if len(now) == 300:
        raise KeyboardInterrupt
program.time, program.own_number = type("Time", (), {"sleep": sleep, "time": lambda: 0.0}), lambda: 1
robot.log.close()
made, program.made = program.made, lambda sensor, radio, number: made(sensor, radio, number, lambda: now[-1])
try:
    program.main()
except KeyboardInterrupt:
    pass
""", "--log", "100000")  # fmt: skip
    assert [tick.tick for tick in read_log("robot.log").ticks] == [*range(1, 300)]
