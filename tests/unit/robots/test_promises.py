"""What all robots promise, on every target: one table, of which each cell is a test, or says why there is none.

Random numbers have an address (the robot's number and its boot), a robot has a number that no other has, a message fits
the radio, a tick takes as long as was asked, a log is lived again to the bit, readings are counted for a
calibration, and a robot starts, stops and reports as it is ordered. `docs/onto-a-robot.md` shows the table.
"""

import subprocess
import sys

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.targets import PLUGINS, find
from tests.support.board_modules import MODULES
from tests.support.pages import page_named
from tests.support.places import DATA, ROOT
from tests.support.second import changed

WHOLE = str(DATA / "whole.py")
ACCURACY = ["--accuracy", "{black = 0.9, white = 0.85}"]
PYTHON = ("udp", "espnow", "serial")
HERE, BOARDS, FLEET, KILOBOTS, POGOBOTS, SWARMS, LOGS, RELIVED, COUNTS, ROS, ARGOS, IN_ARGOS, CHIPS = (
    f"tests/{file}.py::"
    for file in (
        "unit/robots/test_promises", "unit/robots/test_boards", "unit/robots/swarm/test_fleet",
        "unit/robots/test_kilobots", "unit/robots/test_pogobots", "unit/robots/swarm/test_processes",
        "unit/robots/logs/test_mcap", "unit/robots/logs/test_relive", "unit/robots/test_calibrating",
        "unit/runtime/test_ros2_node", "unit/robots/test_argos", "real/test_argos", "real/test_chips",
    )
)  # fmt: skip
PROMISES = (
    "random numbers", "robots' numbers", "message sizes", "ticks", "logs", "counts to calibrate", "orders, reports"
)  # fmt: skip
OURS = [f"{HERE}test_{what}" for what in ("robots_and_boots_draw", "numbers", "messages_that", "ticks")]
PROGRAM, PC, NONE = "your program", "computer", ("none", None)
IN_C, FROM_LOGS = (PC, f"{COUNTS}test_robots_in_c"), ("from logs", f"{COUNTS}test_robots_logs_of")
ON_CHIP = f"{CHIPS}test_kilobot_program_sends_on_its_chip"
TABLE = {  # by target: where each promise is tested, and its test; or why there is none
    **{
        name: [
            *((PC, test) for test in OURS), (PC, f"{BOARDS}test_a_life_that_a_board_logged"),
            (PC, f"{COUNTS}test_a_board_counts"), (PC, f"{FLEET}test_deployed_programs"),
        ]
        for name in PYTHON
    },
    "kilobot": [(PC, f"{KILOBOTS}test_robots_and_boots_draw"), *((PC, test) for test in OURS[1:]), NONE, IN_C, NONE],
    "pogobot": [
        (PC, f"{POGOBOTS}test_a_run_in_a_simulator"), *((PC, test) for test in OURS[1:]),
        (PC, f"{POGOBOTS}test_a_run_in_a_simulator"), IN_C, NONE,
    ],
    "avr": [
        *[("simulated chip", ON_CHIP)] * 3, ("not tried: no hardware", None), NONE,
        ("simulated chip", f"{CHIPS}test_a_kilobot_counts"), NONE,
    ],
    "argos": [
        (PC, f"{ARGOS}test_two_brains"), (PC, OURS[1]), (PC, f"{ARGOS}test_messages_that"), (PC, OURS[3]),
        ("ARGoS, any folder", f"{IN_ARGOS}test_from_any_folder"), ("simulated sensors", None), NONE,
    ],
    "c": [(PROGRAM, None), (PC, OURS[1]), (PROGRAM, None), (PC, OURS[3]), (PROGRAM, None), IN_C, (PROGRAM, None)],
    "ros2": [
        (PC, f"{ROS}test_nodes_and_boots_draw"), (PC, f"{ROS}test_a_node_without_a_number"), (PC, OURS[2]),
        (PC, f"{ROS}test_ticks_follow"), (PC, f"{ROS}test_a_node_that_starts_again"), FROM_LOGS,
        (PC, f"{ROS}test_nodes_are_started"),
    ],
    "swarm": [
        (PC, f"{SWARMS}test_shares_are_uniform"), (PC, f"{LOGS}test_wrong_input_is"), (PC, f"{SWARMS}test_what_no"),
        (PC, OURS[3]), (PC, f"{RELIVED}test_logs_are_lived_again"), FROM_LOGS, (PC, f"{SWARMS}test_a_swarm_bears"),
    ],
}  # fmt: skip


def test_the_table_is_whole_and_its_tests_are_there():
    assert {*PLUGINS.names} <= {*TABLE}
    for row in TABLE.values():
        assert len(row) == len(PROMISES)
        for _, test in filter(lambda cell: cell[1], row):
            file, _, name = test.partition("::")
            assert f"\ndef {name}" in (ROOT / file).read_text(encoding="utf-8"), test


def test_the_page_shows_the_table():
    """For each promise where it is tested on most targets, and then on the others."""
    spelled, lines = {"ros2": "ROS 2", "avr": "ATmega328P"}, [("promise", "tested on"), ("---", "---")]
    for promise, column in zip(PROMISES, zip(*TABLE.values(), strict=True), strict=True):
        names = {}
        for name, (where, _) in zip(TABLE, column, strict=True):
            names.setdefault(where, []).append(spelled.get(name, f"`{name}`"))
        most = max(names, key=lambda where: len(names[where]))
        others = [f"{', '.join(of)}: {where}" for where, of in names.items() if where != most]
        lines.append((promise, "; ".join([most, *others])))
    shown = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    assert shown in page_named("onto-a-robot").read_text(encoding="utf-8"), shown


# ---- random numbers: each robot and each boot has its own
ON_PYTHON = """
import os, random
del os.urandom
import main
for number in (1, 1, 2, 2):
    random.seed(7)  # as a board without noise, on which all starts begin with the same
    robot = main.made(None, None, number, memory=f"memory-{number}")
    print(*[robot.draws() for _ in range(3)])
"""


def needs_of(target):
    return [] if "accuracy" in find(target).refuses else ACCURACY


def deployed(folder, target, *more):
    assert main(["deploy", WHOLE, str(folder), "--target", target, *needs_of(target), *more]) == 0
    return folder


@pytest.mark.parametrize("target", PYTHON)
def test_robots_and_boots_draw_numbers_of_their_own(target, tmp_path):
    """Also where all boards make the same noise: each number and boot has another sequence."""
    command, folder = [sys.executable, "-c", ON_PYTHON], deployed(tmp_path / "robot", target)
    for name, text in MODULES.items():
        (folder / name).write_text(text)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    draws = [float(word) for word in done.stdout.split()]
    assert len(set(draws)) == len(draws) == 12
    assert all(0.0 < draw < 1.0 for draw in draws)


# ---- robots' numbers
BY_PROGRAM = "the program around brain.h decides that"


@pytest.mark.parametrize(("target", "number", "says"), [
    *((name, 65536, "should be from 0 to 65535") for name in PYTHON),
    *(("kilobot", number, "should be from 1 to 65534") for number in (0, 65535)),
    ("pogobot", 3, "has a number of its own"), ("argos", 3, "gets a number of its own"), ("c", 3, BY_PROGRAM),
])  # fmt: skip
def test_numbers_that_no_robot_has_are_refused(refused, target, number, says):
    said = refused("deploy", "commons", "robot", "--target", target, "--robot", number, *needs_of(target))
    assert f"--robot {number}" in said
    assert says in said


def test_numbers_are_missing_on_a_computer(tmp_path):
    folder = deployed(tmp_path / "robot", "udp")
    done = subprocess.run([sys.executable, "main.py"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "NUMBER in settings.py should be this robot's: a computer has no chip that tells one\n"


# ---- message sizes
LARGE = changed(
    ('"t": 0.0', '"t": 0.0, "v": (0.0,) * SIZE'),
    ('("x",)', '("v",)'),
    ("(estimate(me),)", "(me.v,)"),
    ("message):\n    pass", "message):\n    me.v[0] += message[0][0]"),
)


@pytest.mark.long(but=["pogobot"])
@pytest.mark.parametrize("target", [name for name in PLUGINS.names if find(name).largest is not None])
def test_messages_that_a_radio_does_not_hold_are_refused(refused, here, target):
    """As many numbers as fit are taken, and one more is not, in a message of a vector."""
    radio, header = find(target), 10 if find(target).checked else 6
    fit = (radio.largest - header) // 4
    for size in (fit + 1, fit):
        (here / "large.py").write_text(LARGE.replace("SIZE", str(size)))
        words = ["deploy", "large.py", f"robot-{size}", "--target", target, "--message", "float32", *ACCURACY]
        if size > fit:
            assert f"sends datagrams of {header + 4 * size} bytes as float32" in refused(*words)
    assert fit == 0 or main(words) == 0


# ---- ticks
LIMITS = "should be ticks a second, from 0.001 to"


@pytest.mark.parametrize(("target", "hz", "says"), [
    *((name, hz, LIMITS) for name in (*PYTHON, "kilobot", "pogobot") for hz in (0, 1001)),
    *(("swarm", hz, LIMITS) for hz in (0, 501)),
    ("kilobot", 11, "a Kilobot has at most 10 ticks a second"),
    *(("pogobot", hz, "a whole number of ticks a second, from 1 to 255") for hz in (0.5, 2.5, 256)),
    ("argos", 5, "the tick of the study decides that"),
    ("c", 5, BY_PROGRAM),
])  # fmt: skip
def test_ticks_that_a_robot_cannot_make_are_refused(refused, target, hz, says):
    start = "swarm commons" if target == "swarm" else f"deploy commons robot --target {target}"
    said = refused(*start.split(), "--hz", hz, *([] if target in ("swarm", "c") else ACCURACY))
    assert f"--hz {hz}" in said
    assert says in said


@pytest.mark.parametrize(("target", "given", "line"), [
    *((name, f"--robot {number}", f"NUMBER = {number} ") for name in PYTHON for number in (0, 65535)),
    *((name, "--hz 4", "PERIOD = 250 ") for name in PYTHON),
    ("kilobot", "--hz 10", "#define PERIOD 3  // of a tick; a second has 30.5"),
    ("kilobot", "--hz 0.5", "#define PERIOD 61  // of a tick; a second has 30.5"),
    ("pogobot", "--hz 20", "#define HZ 20  //"),
])  # fmt: skip
def test_ticks_and_numbers_are_those_that_were_asked_for(tmp_path, target, given, line):
    folder = deployed(tmp_path / "robot", target, *given.split())
    assert line in (folder / ("settings.py" if target in PYTHON else "settings.h")).read_text()
