"""`swarmcensus calibrate`, the file of robots that it writes, and who takes it: `deploy` and studies."""

import json
import re
import shutil
import subprocess
import sys
from functools import partial

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.translation.pieces import BOARDS
from swarmcensus.worlds import read_robots
from tests.support.board_modules import MODULES
from tests.support.boards import needs_micropython, on_board
from tests.support.places import ROOT
from tests.support.small import study_of

ROBOTS = """robots = [
  {number = 7, b = 0.9, w = 0.8, b_error = 0.01, w_error = 0.02, port = "/dev/ttyUSB0"},
  {number = 3, b = 0.7, w = 0.75, address = "pi@10.0.0.3"},
]
"""
HEAD = "robot,strip,readings,black,changes\n"


@pytest.fixture
def robots(here):
    (here / "robots.toml").write_text(ROBOTS)
    return here / "robots.toml"


@pytest.fixture
def answer(accepted):
    return lambda *words: json.loads(accepted("calibrate", *words, "--json").out)


def counts(*rows):
    return HEAD + "".join(f"{','.join(map(str, row))}\n" for row in rows)


def test_counts_readings_and_logs_say_the_same(here, answer):
    """The same readings in three forms."""
    chance = np.random.default_rng(1)
    rows, single = [], ["robot,strip,reading"]
    for robot in (4, 9):
        for strip, black in (("black", 0.9), ("white", 0.25)):
            seen = (chance.random(400) < black).astype(int)
            rows.append((robot, strip, 400, seen.sum(), np.count_nonzero(np.diff(seen))))
            single += [f"{robot},{strip},{('white', 'black')[one]}" for one in seen]
    (here / "counts.csv").write_text(counts(*rows[:2]))
    (here / "more.csv").write_text("# put robot 9 on black\n" + counts(*rows[2:]))
    (here / "readings.csv").write_text("\n".join(single))
    found = answer("counts.csv", "more.csv")
    assert found["rows"] == answer("readings.csv")["rows"]
    assert [row["robot"] for row in found["rows"]] == [4, 9]
    assert "no difference between robots was found" in found["sentences"][0]
    own = [rows[k][3] / 400 for k in (0, 2)]
    drawn = [row["b"] for row in found["rows"]]  # towards that of both
    assert abs(drawn[0] - drawn[1]) < abs(own[0] - own[1])


def test_robots_logs_of_a_run_on_each_strip(here, answer):
    words = ["swarm", "commons", "--set", "robots=2", "--set", "rounds=40", "--hz", "50", "--quiet"]
    for strip, f in (("black", 1), ("white", 0)):
        assert main([*words, "--set", f"fill_ratio={f}", "--out", strip]) == 0
    rows = answer("--black", "black", "--white", "white")["rows"]
    for row, member in zip(rows, read_recording(here / "white").members, strict=True):
        assert row["white_readings"] == sum(tick.looks for tick in member.log.ticks)
        assert 0.4 < row["w"] < 1.0


def test_robots_that_differ_and_readings_that_depend_are_said(here, answer):
    rows = [row for k in range(5) for row in ((k, "black", 1000, 700 + 60 * k, 100), (k, "white", 1000, 100, 60))]
    (here / "c.csv").write_text(counts(*rows))
    found = answer("c.csv", "--width", "0.05", "--out", "robots.toml")
    robots, alone, more, added = found["sentences"]
    assert robots.startswith("robots differ (p < 1e-06, level 1 %)")
    assert re.search(r"readings depend on the one before, .*: robots 0 \(1,000 count as \d+\), 1 ", alone)
    assert "on white would make each robot's interval 0.05 wide" in more
    assert "adds to an estimate's error" in added
    assert [one.number for one in read_robots(here / "robots.toml")] == [0, 1, 2, 3, 4]


def test_a_swarm_is_no_worse_than_its_worst_robot(here, answer):
    """Also where one of two stood still: they do not differ, so both have what the other one found."""
    rows = [(k, *strip, few) for k, few in ((1, 320), (2, 6)) for strip in (("black", 1000, 800), ("white", 1000, 200))]
    (here / "c.csv").write_text(counts(*rows))
    found = answer("c.csv")
    assert found["error_swarm"] <= found["error_alone"] == pytest.approx(0.0211, rel=0.02)  # sqrt(0.16 / 1000) / 0.6


def test_measuring_again_keeps_where_robots_are(robots, here, answer):
    rows = [(k, strip, 100, n, 20) for k in (3, 7) for strip, n in (("black", 80), ("white", 20))]
    (here / "c.csv").write_text(counts(*rows))
    answer("c.csv", "--out", "robots.toml")
    found = {one.number: one for one in read_robots(robots)}
    assert (found[7].port, found[3].address) == ("/dev/ttyUSB0", "pi@10.0.0.3")
    assert found[7].b == pytest.approx(0.8, abs=0.01)
    assert found[7].b_error > 0.02
    answer("c.csv", "--out", "robots.toml")
    (here / "c.csv").write_text(counts((5, "black", 100, 80, 20), (5, "white", 100, 20, 20)))
    answer("c.csv", "--out", "robots.toml")
    assert read_robots(robots)[::2] == [found[3], found[7]]


def test_sensors_that_say_little_or_the_opposite_are_named(here, answer):
    rows = [(1, "black", 1000, 500), (1, "white", 1000, 500), (2, "black", 1000, 100), (2, "white", 1000, 900)]
    (here / "c.csv").write_text(counts(*((*row, "") for row in rows)).replace(",changes", "").replace(",\n", "\n"))
    found = answer("c.csv")
    assert "adds to an estimate's error 1 or more in a robot alone" in found["sentences"][-1]
    assert found["cautions"] == [
        "robot 1: b + w may be 1, with which readings say nothing",
        "robot 2: b + w is below 1: is black taken for white?",
    ]
    assert "is unknown: counts lack `changes`" in found["sentences"][1]


@pytest.mark.parametrize(("table", "says"), [
    (HEAD, "no readings"),
    ("robot,strip\n1,black\n", "should have columns robot,strip,readings,black,changes"),
    (counts((1, "grey", 9, 5, 2)), "column 'strip': 'grey': should be black or white"),
    (counts((1, "black", 9, 10, 2)), "10 black, 2 changes: more black than readings"),
    (counts((1, "black", 9, 8, 5)), "line 2: 9 readings, 8 black, 5 changes: that cannot be"),
    (counts((1, "black", 9, 8, 2)), "c.csv: robot 1 has no readings on the white strip"),
    (counts((1, "black", 9, 8, 0)), "line 2: 9 readings, 8 black, 0 changes: that cannot be"),
    (counts((70000, "black", 9, 8, 2)), "'70000': should be a robot's number, from 0 to 65535"),
    (counts((1, "0.5", 9, 8, 2)), "column 'strip': '0.5': should be black or white"),
    ("robot,strip,reading\n1,black,0.5\n", "line 2: column 'reading': '0.5': should be 0 (white)"),
    ("robot,strip,reading,black\n1,black,1,1\n", "has counts and single readings"),
])  # fmt: skip
def test_wrong_tables_are_refused_in_a_sentence(here, refused, table, says):
    (here / "c.csv").write_text(table)
    assert says in refused("calibrate", "c.csv")


# ---- robots.toml
@pytest.mark.parametrize(("old", "new", "says"), [
    ("number = 3", "number = 7", "number = 7: 2 robots have it"),
    ("number = 3", "number = 70000", "should be a robot's number, from 0 to 65535"),
    ("b = 0.7", "b = 1.7", "robots[1].b = 1.7"),
    ("b = 0.7, w = 0.75, ", "", "robots[1].b is missing (and 1 more)"),
    ("b = 0.7, w = 0.75", "b = 0.7, w = 0.3", "robot 3, b = 0.7 and w = 0.3: black and white read the same"),
    ('"pi@10.0.0.3"', '""', "robots[1].address = "),
    ('"/dev/ttyUSB0"', '""', "robots[0].port = "),
    ('address = "pi@10.0.0.3"', 'port = "/dev/ttyUSB0"', "port = /dev/ttyUSB0: 2 robots have it"),
    ("w = 0.75", "W = 0.75", "unknown key robots[1].W"),
])  # fmt: skip
def test_wrong_files_of_robots_are_refused(robots, refused, old, new, says):
    robots.write_text(ROBOTS.replace(old, new))
    said = refused("deploy", "commons", "fleet", "--target", "udp", "--robots", "robots.toml")
    assert says in said
    assert "robots.toml" in said


@pytest.mark.parametrize("target", ["udp", "kilobot", "pogobot"])
def test_each_robot_of_a_fleet_has_its_number_and_sensor(robots, here, target):
    words = ["deploy", "commons", "fleet", "--target", target, "--message", "ratio16", "--robots", "robots.toml"]
    assert main(words) == 0
    file = "settings.py" if target == "udp" else "settings.h"
    own = {number: (here / "fleet" / f"robot-{number}" / file).read_text() for number in (7, 3)}
    for number, b in ((7, "0.9"), (3, "0.7")):
        assert re.search(rf"\bB (= )?{b}", own[number])
        assert target == "pogobot" or re.search(rf"\b(NUMBER =|ROBOT) {number}\b", own[number])
    assert not (here / "fleet" / file).exists()


@pytest.mark.parametrize("target", ["udp", "kilobot", "pogobot"])
def test_a_fleet_is_calibrated_by_its_table(robots, here, answer, target):
    """Robots count before b and w are known; the table then has them, and still has the ports and addresses."""
    robots.write_text('robots = [{number = 7, port = "/dev/ttyUSB0"}, {number = 3, b = 0.7, address = "pi"}]')
    words = f"--target {target} --message ratio16 --robots robots.toml --calibrate"
    assert main(["deploy", "commons", "fleet", *words.split()]) == 0
    programs(here, make="", mpremote="", scp="")
    names = {"PATH": f"{here}:/usr/bin:/bin", "KILOLIB": "k", "SDK": "s", "SOURCES": "x"}
    flash = partial(subprocess.run, ["sh", "fleet/flash.sh"], capture_output=True, text=True)
    assert flash(input="\n\n", env=names, check=True).stdout.count("calibrate") >= 2
    (here / "c.csv").write_text(counts((7, "black", 100, 80, 30), (7, "white", 100, 20, 30)))
    answer("c.csv", "--out", "robots.toml")
    three, seven = read_robots(robots, calibrated=False)
    assert (seven.port, seven.b > 0.7, three.address, three.b) == ("/dev/ttyUSB0", True, "pi", 0.7)


def programs(folder, **does):
    """Stand-ins for programs, which do something after they said what they are given."""
    for name, what in does.items():
        (folder / name).write_text(f'#!/bin/sh\necho {name} "$@"\n{what}\n')
        (folder / name).chmod(0o755)


def test_a_script_puts_files_onto_one_robot_after_another(robots, here):
    assert main(["deploy", "commons", "fleet", "--target", "udp", "--robots", "robots.toml"]) == 0
    programs(here, mpremote="", scp="")
    robots.write_text(ROBOTS.replace(', address = "pi@10.0.0.3"', "")[:-2] + "  {number = 5, b = 0.9, w = 0.9},\n]\n")
    assert main(["deploy", "commons", "plain", "--target", "udp", "--robots", "robots.toml"]) == 0
    flash = partial(subprocess.run, env={"PATH": f"{here}:/usr/bin:/bin"}, capture_output=True, text=True, check=False)
    done = flash(["sh", "plain/flash.sh"], input="\n")
    assert done.stdout.splitlines()[3].startswith("connect robot 3 alone")
    assert done.stdout.splitlines()[4].startswith("mpremote connect auto cp")
    assert done.stdout.splitlines()[-1].startswith("connect robot 5 alone")  # and nobody presses Enter
    assert done.returncode == 1
    done = flash(["sh", "plain/flash.sh", "3", "8"], input="\n")
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "there is no robot 8, but: 7 3 5 \n")
    for wanted, begins in (
        ([], ["robot 7", "mpremote connect /dev/ttyUSB0 cp", "robot 3", "scp"]),
        (["3"], ["robot 3", "scp"]),
    ):
        lines = flash(["sh", "fleet/flash.sh", *wanted], check=True).stdout.splitlines()
        assert [line[: len(begin)] for line, begin in zip(lines, begins, strict=True)] == begins
        assert "brain.py" in lines[-1]
        assert lines[-1].endswith("robot-3/settings.py pi@10.0.0.3:")


def test_firmware_comes_first_where_its_file_is_named(robots, here):
    """It may lie anywhere; a robot with an address is a computer, and needs none."""
    assert main(["deploy", "commons", "fleet", "--target", "espnow", "--robots", "robots.toml"]) == 0
    programs(here, mpremote="", scp="", sleep="", esptool='[ "$3" = erase-flash ] || cat "$5"')
    (here / "esp32.bin").write_text("bytes\n")
    names = {"PATH": f"{here}:/usr/bin:/bin", "FIRMWARE": "esp32.bin"}
    flash = partial(subprocess.run, ["sh", "fleet/flash.sh"], capture_output=True, text=True, check=False)
    lines = flash(env=names | {"OFFSET": "0x1000"}).stdout.splitlines()
    to = "esptool --port /dev/ttyUSB0"
    assert lines[1:5] == [f"{to} erase-flash", f"{to} write-flash 0x1000 esp32.bin", "bytes", "sleep 5"]
    assert [line.split()[0] for line in lines[5:]] == ["mpremote", "robot", "scp"]
    for wrong, says in (({}, "such as 0x1000 on an ESP32"), ({"OFFSET": "0", "FIRMWARE": "no.bin"}, "no such file")):
        done = flash(env=names | wrong)
        assert says in done.stderr
        assert (done.returncode, *(word in done.stdout for word in ("esptool", "mpremote"))) == (1, False, False)


def test_kept_logs_are_fetched_and_lived_again(here, accepted):
    """From a port, and from a computer."""
    accepted("swarm", "commons", "--set", "robots=2", "--set", "rounds=20", "--hz", "100", "--out", "day")
    table = '{number = 0, b = 0.8, w = 0.8, port = "day/robot-0.log"}, {number = 1, b = 0.8, w = 0.8, address = "pi"}'
    (here / "robots.toml").write_text(f"robots = [{table}]")
    accepted("deploy", "commons", "fleet", "--target", "udp", "--robots", "robots.toml", "--log", "20000")
    programs(here, mpremote='[ "$4" = :robot.log ] && cp ../"$2" "$5"', scp='cp ../day/robot-1.log "$2"')
    path = {"PATH": f"{here}:/usr/bin:/bin"}
    fetch = partial(subprocess.run, ["sh", "fleet/fetch.sh"], env=path, capture_output=True, text=True)
    for _ in range(2):  # the same log again is no other one
        assert fetch(check=True).stdout.splitlines()[1::2] == [
            "mpremote connect day/robot-0.log cp :robot.log logs/robot-0.part", "scp pi:robot.log logs/robot-1.part"
        ]  # fmt: skip
    assert "2 of 2 robots lived again to the bit" in accepted("relive", "fleet/logs").out
    (here / "day" / "robot-0.log").unlink()  # this board is off
    (here / "day" / "robot-1.log").write_text("another run")
    done = fetch(check=False)
    assert (done.returncode, done.stderr.splitlines()[-1]) == (1, "these robots failed, the others are done: 0")
    assert re.search(r"\nthe earlier log is kept as logs/robot-1\.log\.\d", done.stdout)


@pytest.mark.parametrize(("words", "says"), [
    ("--target udp --robots robots.toml --accuracy 0.9", "--accuracy 0.9 does not go with --robots robots.toml"),
    ("--target udp --robots robots.toml --robot 1", "--robot 1 does not go with --robots robots.toml"),
    ("--target argos --robots robots.toml", "--robots robots.toml does not go with --target argos"),
    ("--target kilobot --robots robots.toml --message float32", "--message ratio16 makes 9"),
    ("--target udp --accuracy 0.9 --report bad?host:1", "--report 'bad?host:1': should be an address, such as"),
    ("--target argos --calibrate", "--calibrate does not go with --target argos"),
    ("--target udp --accuracy 0.9 --study s.toml", "--target udp: it has no arena"),
    ("--target argos", "--accuracy is missing"),
])  # fmt: skip
def test_what_does_not_go_together_is_refused(robots, refused, words, says):
    robots.with_name("s.toml").write_text(study_of(ticks=9).text)
    assert says in refused("deploy", "commons", "fleet", *words.split())


def test_a_study_has_measured_sensors(robots, here):
    """Robot by robot, again from the first where there are more; results need the file no longer."""
    (here / "study.toml").write_text("""
        trials = 200
        swarm = {robots = 5, accuracy = "robots.toml", assumed_accuracy = ["robots.toml", {black = 0.9, white = 0.8}]}
        world = {topology = "full", fill_ratio = 0.5}
        schedule = {rounds = 2, observations_per_round = 1}
    """)
    with pytest.raises(sc.InputError, match=r"study file .*: swarm.accuracy = 'no.toml': .*no such file"):
        sc.Study.load(here / "study.toml", {"accuracy": "no.toml"})
    with pytest.warns(UserWarning, match=r"accuracy has 2 measured robots, and robots = \[5\]: the first"):
        study = sc.Study.load(here / "study.toml")
    results = sc.run(study)
    robots.unlink()
    first, second = study.settings()
    assert str(first.assumed_accuracy) == "black=M(0.9,0.0,0.7,0.0) white=M(0.8,0.0,0.75,0.0)"
    b, w = first.accuracy.draw(1, "accuracy", 0, 200, 5)
    assert b[:, ::2].mean(axis=0) == pytest.approx([0.9] * 3, abs=0.004)  # five standard errors
    assert b[:, 0].std() == pytest.approx(0.01, rel=0.25)
    assert (b[:, 1::2] == 0.7).all()
    assert (w[:, 1::2] == 0.75).all()
    assert (sc.verify(results).code, second.assumed_accuracy.black.numbers) == (0, (0.9,))


def test_a_plan_has_what_the_uncertainty_adds(robots, here):
    """Of two robots the closed form, over 200 trials to a sixth; nothing where robots know their sensors."""
    swarm = {"brain": "commons", "robots": 2, "accuracy": "robots.toml"}
    tables = {"name": "m", "world": {"topology": "full", "fill_ratio": 0.5}, "wanted": {"error": 0.1}}
    found = []
    for assumed in ({}, {"assumed_accuracy": "robots.toml"}):
        asked = tables | {"swarm": swarm | assumed, "schedule": {"observations_per_round": 1}}
        found += sc.plan(asked, progress=False).frame["calibration"].tolist()
    b, w, errors = np.array([0.9, 0.7]), np.array([0.8, 0.75]), np.array([[0.01, 0.0], [0.02, 0.0]])
    weights = sc.theory.information(0.5, b, w)
    expected = weights[0] * sc.theory.calibration_error(0.5, b, w, *errors)[0] / weights.sum()
    assert found == [None, pytest.approx(float(expected), rel=0.17)]


# ---- the program that counts
COUNTING = """
import sys
if "calibrate" not in sys.modules:  # which imports this file
    import calibrate
    calibrate.run("black", 300)
    calibrate.run("white", 300)
"""


def folder_that_counts(folder, target):
    words = ["deploy", "commons", str(folder), "--target", target, "--calibrate", "--robot", "4", "--hz", "1000"]
    assert main(words) == 0
    return {path.name: path.read_text() for path in folder.glob("*.py")}


@needs_micropython
def test_a_board_counts_readings_on_both_strips(here, answer):
    files = MODULES | folder_that_counts(here / "robot", "serial")
    files["main.py"] = files["main.py"].partition("\nif __name__")[0] + COUNTING
    (here / "node").mkdir()
    printed = on_board(here / "node", files)
    first, second = (HEAD + rows for rows in printed.split(HEAD)[1:])  # of two runs, and nothing else
    (here / "black.csv").write_text(first)
    (here / "white.csv").write_text(second)
    (row,) = answer("black.csv", "white.csv")["rows"]
    assert (row["robot"], row["black_readings"], row["white_readings"]) == (4, 300, 300)
    assert 0.3 < row["b"] < 0.6  # the stand-in's sensor reads the same on both


READ = """
static int robot_read_sensor(void) { int black; return scanf("%d", &black) == 1 ? black : -1; }
"""
KILOLIB = """
#define debug_init()
uint16_t kilo_uid = 1000;
void kilo_start(void (*setup)(void), void (*loop)(void)) {
    for (setup(); kilo_ticks < 3 * TURNS; kilo_ticks += 3) {
        loop();
    }
}
static uint32_t robot_now(void) { return kilo_ticks; }
"""
BETWEEN = {"c": 0, "kilobot": 610, "pogobot": 600}  # ticks in which somebody puts the robot onto white
LIBRARIES = {"kilobot": f"-I{BOARDS} {BOARDS}/no_kilolib.c", "pogobot": f"-I{ROOT}/tests/support/pogobot"}
STRICT = "gcc -std=gnu11 -Wall -Wextra -Werror -I. -DROBOTS=1"


def counted_in_c(folder, target, strips):
    """What the program that counts prints, of readings on both strips."""
    run = partial(subprocess.run, cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
    if target == "c":
        run(["make", "calibrate"])
        runs = [(["./calibrate", "1000", strip], readings) for strip, readings in strips.items()]
    else:
        (folder / "sensor.h").write_text(READ)
        (folder / "debug.h").write_text(KILOLIB)
        given = f"-DTURNS={2000 + BETWEEN[target] + 4} {LIBRARIES[target]} calibrate.c -o counting"
        run([*STRICT.split(), *given.split()])
        runs = [(["./counting"], [*strips["black"], *[0] * BETWEEN[target], *strips["white"]])]
    return [run(command, input=" ".join(map(str, readings))).stdout for command, readings in runs]


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
@pytest.mark.parametrize("target", BETWEEN)
def test_robots_in_c_count_what_they_read(here, answer, target):
    """On both strips, with a reading in ten that is none. Robots print again and again, for a cable that comes late."""
    chance, expected = np.random.default_rng(5), [HEAD]
    strips = {strip: chance.choice([-1, 0, 1], 1000, p=p) for strip, p in (("black", [0.1, 0.1, 0.8]),
                                                                          ("white", [0.1, 0.7, 0.2]))}  # fmt: skip
    assert main(["deploy", "commons", "robot", "--target", target, "--calibrate"]) == 0
    for strip, readings in strips.items():
        seen = readings[readings >= 0]
        expected.append(f"1000,{strip},{seen.size},{seen.sum()},{np.count_nonzero(np.diff(seen))}\n")
    printed = counted_in_c(here / "robot", target, strips)
    if target == "c":
        assert printed == [HEAD + row for row in expected[1:]]
        for number, read in (("x", "1"), (" 7", "1"), ("7x", "1"), ("", "1"), ("7", "1 2"), ("7", "257")):
            call = ["robot/calibrate", number, "black"]
            done = subprocess.run(call, input=read, capture_output=True, text=True, check=False)
            assert (done.returncode, done.stdout, "should be" in done.stderr) == (2, "", number == "7")
    else:
        assert printed == ["".join(expected) * 4]
        (here / "serial").write_text(printed[0][9:])
        command = re.search(r"head .* \| sort -ru", (here / "robot" / "calibrate.c").read_text())[0]
        printed = [subprocess.run(["sh", "-c", command.replace("/dev/ttyUSB0", "serial")], capture_output=True,
                                  text=True, check=True).stdout]  # fmt: skip
    for k, text in enumerate(printed):
        (here / f"{k}.csv").write_text(text)
    (row,) = answer(*[f"{k}.csv" for k in range(len(printed))])["rows"]
    assert row["robot"] == 1000
    for name, true in (("b", 8 / 9), ("w", 7 / 9)):  # at 3.3 standard errors: one seed in 1,000 fails
        assert abs(row[name] - true) < 3.3 * row[f"{name}_error"]


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
def test_a_program_in_c_of_unknown_accuracies_does_not_compile(here):
    assert main(["deploy", "commons", "robot", "--target", "pogobot", "--calibrate"]) == 0
    command = f"{STRICT} -DTURNS=9 {LIBRARIES['pogobot']} -fsyntax-only robot/main.c"
    done = subprocess.run(command.split(), capture_output=True, text=True, check=False)
    assert re.search(r"settings\.h:3:11: error: .*FILL_IN.* undeclared", done.stderr)


def test_a_robot_that_was_not_calibrated_says_so(here):
    folder_that_counts(here / "robot", "udp")
    done = subprocess.run([sys.executable, "main.py"], cwd=here / "robot", capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "B and W in settings.py should be those of this sensor" in done.stderr
