"""`swarmcensus deploy`: folders for boards whose programs run, talk, and prove that they compute what they should."""

import json
import re
import shlex
import struct
import subprocess
import sys

import pytest

from swarmcensus import brains
from swarmcensus.brains.packing import Numbers
from swarmcensus.cli.commands import main
from swarmcensus.robots import board_tests, deploy
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from swarmcensus.robots.target import mark_of
from swarmcensus.translation import selftest
from tests.support.board_modules import MODULES
from tests.support.boards import needs_micropython, on_board
from tests.support.options import with_usual
from tests.support.places import DATA

NEEDED = ["--accuracy", "{black = 0.9, white = 0.85}"]
WHOLE = str(DATA / "whole.py")
FILES = {"brain.py", "codec.py", "runtime.py", "settings.py", "main.py", "selftest.py", "history.py", "README.md"}


def deployed(folder, brain="commons", radio="udp", *more):
    assert main(["deploy", brain, str(folder), *with_usual(more, ["--target", radio, *NEEDED])]) == 0
    return folder


def texts(folder):
    return {path.name: path.read_text() for path in folder.iterdir()}


def checked(capsys, folder, output, encoding="utf-8"):
    """The exit code of `deploy --selftest`, and what it says."""
    (folder.parent / "board.txt").write_text(output, encoding=encoding)
    capsys.readouterr()
    code = main(["deploy", str(folder), "--selftest", str(folder.parent / "board.txt")])
    out, err = capsys.readouterr()
    return code, out + err


@pytest.mark.parametrize("radio", ["udp", "espnow", "serial"])
def test_a_folder_for_micropython(tmp_path, capsys, radio):
    folder = deployed(tmp_path / "robot", "sure", radio, "--message", "ratio16", "--robot", "7", "--hz", "4")
    assert {path.name for path in folder.iterdir()} == FILES | ({"lines.py"} if radio == "serial" else set())
    assert list(tmp_path.iterdir()) == [folder]
    for name in FILES - {"README.md"}:
        compile((folder / name).read_text(), name, "exec")
    space = {}
    exec((folder / "settings.py").read_text(), space)
    assert (space["NUMBER"], space["PERIOD"], space["B"], space["W"]) == (7, 250, 0.9, 0.85)
    brain = brains.load("sure")
    assert (folder / "brain.py").read_text() == brain.source
    kept = brain.with_numbers(Numbers(message="ratio16")).memory_bytes
    assert f"memory    {kept:,} bytes" in capsys.readouterr().out


def test_options_are_the_robots_and_json_tells_the_sizes(tmp_path, capsys):
    options = ["--parameter", "memory=50", "--json", "--message", "ratio8", "--log", "20000"]
    files = texts(deployed(tmp_path / "robot", "tracking", "serial", *options))
    assert set(files) == FILES | {"lines.py", "log.py"}
    assert "up to 20,000 bytes" in files["README.md"]
    assert "PARAMETERS = {'memory': 50.0}" in files["settings.py"]
    told = json.loads(capsys.readouterr().out)
    assert (told["command"], told["datagram_bytes"], told["measured"]["readings"]) == ("deploy", 14, 864_000)


@pytest.mark.parametrize(("options", "says"), [
    ("commons --target upd", "--target upd"),
    ("commons --target kilobot --log 9", "--log 9"),
    ("commons --log 9999", "--log 9999: should be 10,000 bytes at least"),
    ("commons --message double", "--message double"),
    ("commons --accuracy 1.2", "--accuracy 1.2"),
    ("commons --accuracy 'U(0.6, 0.8)'", "is no accuracy of a single sensor"),
    ("commons --accuracy '{black=0.9}'", "--accuracy '{black = 0.9}': white is missing"),
    ("commons --accuracy '{black = 0.4, white = 0.6}'", "such a sensor says the same of black and white"),
    ("commons --parameter keep", "--parameter keep"),
    ("commons --parameter keep=0.5", "--parameter"),
    ("commons --target kilobot --message float32", "--message ratio16 makes 9 and --message ratio8 makes 8"),
    ("belief-sharing --target kilobot", "no format makes it small enough"),
    ("oracle", "is a bound"),
    ("commons --target espnow --report 10.0.0.2",
     "--report 10.0.0.2 does not go with --target espnow: it reports to gateway or usb"),
    ("commons --target serial --report gateway", "it reports to usb"),
    ("commons --target kilobot --report usb", "it reports to nobody"),
])  # fmt: skip
def test_bad_input_is_one_sentence(refused, options, says):
    brain, *options = shlex.split(options)
    assert says in refused("deploy", brain, "robot", *with_usual(options, ["--target", "udp", *NEEDED]))


@pytest.mark.usefixtures("here")
def test_a_sensor_that_takes_black_for_white_is_named(accepted):
    said = accepted("deploy", "commons", "robot", "--target", "udp", "--accuracy", "0.3").err
    assert "b + w of 1 robot is below 1: black taken for white?" in said


@pytest.mark.parametrize(("robots", "hz", "report"), [(8, 10, "gateway"), (20, 1.9, "gateway"), (20, 39, "usb")])
def test_reports_that_a_serial_port_cannot_carry_are_said(here, accepted, robots, hz, report):
    """So many robots and ticks it can carry, and a tenth more it cannot."""
    table = ", ".join(f"{{number = {k}, b = 0.9, w = 0.8}}" for k in range(robots))
    (here / "robots.toml").write_text(f"robots = [{table}]")
    words = ["--target", "espnow", "--robots", "robots.toml", "--report", report, "--hz"]
    assert "caution" not in accepted("deploy", "commons", "few", *words, hz).out
    said = accepted("deploy", "commons", "many", *words, 1.1 * hz).out
    assert "bytes a second, and a serial port carries 11,520: lower --hz" in said


@pytest.mark.parametrize("radio", ["udp", "kilobot", "argos", "pogobot"])
def test_the_name_of_a_brain_file_is_no_code(tmp_path, radio):
    """Neither docstrings nor comments end where the name says so."""
    file = tmp_path / 'a"""\nimport evil\n"""\n#include evil\\.py'
    file.write_text(brains.load("minimalistic").source)
    found = texts(deployed(tmp_path / "robot", str(file), radio))
    del found["README.md"]
    code = re.compile(r"^(import evil|#include evil)", re.MULTILINE)
    assert [name for name, text in found.items() if code.search(text)] == []
    assert any("import evil" in text for text in found.values())


def output_of(brain="commons", precision="double", format_="float32"):
    """What a board of the default folder should print."""
    one = brains.load(brain).with_numbers(Numbers(precision, format_))
    head = f"{board_tests.FIRST} {brain} {mark_of(one)} bits {53 if precision == 'double' else 24}\n"
    return f"{head}{selftest.expected(one)}heap 99 bytes a robot; 3 seconds\n{board_tests.LAST}\n"


@needs_micropython
@pytest.mark.long(but=["commons-ratio16"])
@pytest.mark.parametrize(("name", "format_"), [
    ("commons", "ratio16"), (WHOLE, "ratio16"), ("sure", "ratio8"), ("bayes-cpf", "float32"), ("leaver", "ratio16")
])  # fmt: skip
def test_a_board_proves_itself(tmp_path, capsys, name, format_):
    folder = deployed(tmp_path / "robot", name, "udp", "--message", format_)
    (tmp_path / "node").mkdir()
    printed = on_board(tmp_path / "node", texts(folder) | {"main.py": "import selftest\n"})
    code, said = checked(capsys, folder, "MicroPython v1.27\r\n>>> " + "\r\n" + printed.replace("\n", "\r\n"))
    assert code == 0, said
    assert "53 binary digits" in said
    numbers, equal = re.search(r"(\S+) numbers compared, (\S+) equal", said).groups()
    assert numbers == equal or name == "sure"  # which uses exp and log
    assert "1,800 messages compared, 1,800 equal" in said


@pytest.mark.parametrize("radio", ["udp", "espnow", "serial"])
def test_whole_contract_runs_on_boards(tmp_path, capsys, radio):
    """In CPython: the board's files compute what the reference does, with each function that a brain may have."""
    folder = deployed(tmp_path / "robot", WHOLE, radio, "--message", "ratio16")
    done = subprocess.run([sys.executable, "selftest.py"], cwd=folder, capture_output=True, text=True, check=True)
    code, said = checked(capsys, folder, done.stdout)
    assert code == 0
    assert "1,800 messages compared, 1,800 equal" in said


def test_a_board_of_single_precision_is_compared_in_it(tmp_path, capsys):
    folder = deployed(tmp_path / "robot", "commons", "udp", "--message", "ratio16")
    single = output_of(precision="single", format_="ratio16")
    code, said = checked(capsys, folder, single)
    assert (code, "24 binary digits" in said, "largest difference 0.0e+00" in said) == (0, True, True), said
    assert checked(capsys, folder, single.replace("bits 24", "bits 53"))[0] == 2
    assert checked(capsys, folder, single.replace("\n", "\r\n"), "utf-16") == (code, said)  # as PowerShell writes it


@pytest.mark.parametrize(("change", "says"), [
    (lambda text: "", "has no line that begins with 'selftest 2'"),
    (lambda text: text[: len(text) // 2], "the line 'selftest ends' is missing"),
    (lambda text: text.replace("\n17 1 memory", "\n17 7 memory"), "lacks lines of the self-test"),
    (lambda text: re.sub(r"(commons) \d+", r"\1 7", text), "the brain 'commons' with the mark 7, and the folder"),
    (lambda text: re.sub(r"(\n17 1 memory .*) \S+\n", r"\1\n", text), "has a damaged line: '17 1 memory"),
    (lambda text: re.sub(r"(\n17 1 memory \S\S)", r"\1x", text), "has a damaged line: '17 1 memory"),
    (lambda text: re.sub(r"(\n17 1 memory (?:\S+ ){3})\S+", rf"\1 {struct.pack('>d', 123.0).hex()}", text),
     "\nround 17, robot 1, v_rest: 123 on the board, "),
    (lambda text: re.sub(r"(\n17 1 \S+) \S+\n", r"\1 ffff\n", text), "FAIL: 1 messages differ, although all"),
])  # fmt: skip
def test_a_wrong_or_damaged_output_is_found_out(tmp_path, capsys, change, says):
    code, said = checked(capsys, deployed(tmp_path / "robot"), change(output_of()))
    assert code == 2
    assert says in said


def test_only_deployed_folders_have_a_selftest(tmp_path, capsys, refused):
    folder = deployed(tmp_path / "robot")
    assert "--hz does not go with --selftest" in refused("deploy", folder, "--selftest", "nothing.txt", "--hz", "3")
    settings = folder / "settings.py"
    for text in ("PARAMETERS = input()", "", None):
        settings.unlink() if text is None else settings.write_text(text)
        assert "settings.py: should be one made by `swarmcensus deploy`" in checked(capsys, folder, output_of())[1]


TWO = """
import robot as program
import settings
from binascii import hexlify

robots = []
for number in (1, 2):
    robots.append(program.made(program.Sensor(), program.Radio(), number, memory="memory%d" % number))
    if number == 1 and hasattr(settings, "LOG"):  # the other one keeps no log
        del settings.LOG
for tick in range(100):
    for robot in robots:
        robot.tick()
    if NOISY and tick % 10 == 0:
        program.machine.UART.made[0].data += bytes([192, 1, 219, 5, 192, 7])
for robot in robots:
    print(robot.status())
print(robots[0].numbers())
if robots[0].log:
    robots[0].log.close()
    with open("robot.log", "rb") as file:
        print(hexlify(file.read()).decode())
"""


def two_on_boards(folder, noisy, *deployment):
    """What the program of two robots prints that hear each other on boards."""
    files = texts(deployed(folder / "robot", "commons", *deployment))
    files["robot.py"] = files.pop("main.py")
    files |= MODULES
    (folder / "node").mkdir()
    return on_board(folder / "node", files | {"main.py": TWO.replace("NOISY", str(noisy))}).splitlines()


@needs_micropython
@pytest.mark.parametrize(("radio", "refused"), [("serial", 20), ("espnow", 0)])
def test_robots_hear_each_other_on_boards(tmp_path, radio, refused):
    """Every byte may occur in a datagram, and noise on a line costs none."""
    first, second, _ = two_on_boards(tmp_path, radio == "serial", radio)
    assert f"heard 99 stale 0 refused {refused}" in first
    assert "heard 100 stale 0 refused 0" in second
    assert "undone 0 blanked 0 sensor_faults 0 radio_faults 0" in first


WATCHED = """
import gateway
import robot as program
from lines import Line
from reports import MAGIC

class Sensor:
    def start(self):
        pass
    def read(self):
        return True

now, said, told = [0], [], []
program.clock = lambda: now[0]
robot = program.made(Sensor(), program.Radio, 3, lambda: now[0])
reports, radio = program.reports_of(robot), program.Radio()
line = Line(lambda: told.pop(0) if told else b"", said.append)
lives = []
for words in (b"state 4", b"start 3 1700000000000", b"", b"stop 3"):
    now[0] += 200
    lives.append(reports.obey())
    if lives[-1]:
        robot.tick()
    told.append(b"key" + b"\\xc0" + MAGIC + words + b"\\xc0")
    while gateway.passed(line, radio):
        pass
robot.tick()  # in which it hears the last order
now[0] += 200
lives.append(reports.obey())
for _ in range(5):
    gateway.passed(line, radio)
print(lives, robot.log.now, robot.refused, program.BUFFER, [len(one) for one in said], reports.link.watcher)
"""


@needs_micropython
def test_a_gateway_passes_orders_and_reports_on_boards(tmp_path):
    """The robot says that it waits, is started, reports its state and each tick to the gateway alone, and stops."""
    files = texts(deployed(tmp_path / "robot", "commons", "espnow", "--report", "gateway"))
    files["robot.py"] = files.pop("main.py")
    files["gateway.py"] = files["gateway.py"].replace("import main", "import robot as main")
    (tmp_path / "node").mkdir()
    printed = on_board(tmp_path / "node", files | MODULES | {"main.py": WATCHED})
    assert printed == "[False, False, True, True, False] 1700000000000 0 16384 [9, 9, 159, 50, 50, 50, 9] b'sender'\n"


@needs_micropython
@pytest.mark.parametrize("format_", ["float32", "ratio16"])
def test_a_life_that_a_board_logged_is_lived_again_to_the_bit(tmp_path, accepted, format_):
    *_, numbers, log = two_on_boards(tmp_path, False, "serial", "--log", "20000", "--message", format_)
    (tmp_path / "recording").mkdir()
    (tmp_path / "recording" / "robot.log").write_bytes(bytes.fromhex(log))
    assert "1 of 1 robot lived again to the bit, 100 of 100 ticks" in accepted("relive", tmp_path / "recording").out
    (member,) = read_recording(tmp_path / "recording").members
    assert str(max(relive(member, keep=True).lived.items())[1].memory) == numbers
    assert sum(len(tick.heard) for tick in member.log.ticks) == 99


def test_a_board_without_motors_says_so(tmp_path):
    with pytest.warns(UserWarning, match="^leaver steers, and the program has nothing that moves the robot"):
        deploy("leaver", tmp_path / "robot", "udp", accuracy=0.9)
