"""`swarmcensus deploy --target kilobot`: a program that Kilobot's own library and simulators of Kilobots take."""

import re
import shutil
import subprocess

import pytest

from swarmcensus import brains
from swarmcensus.brains.float32 import rounded_to_single
from swarmcensus.brains.packing import Numbers
from swarmcensus.cli.commands import main
from swarmcensus.runtime import runtime
from swarmcensus.translation.messages import codec as codec_of
from tests.support.boards import Air, Readings
from tests.support.places import DATA, ROOT

NEEDED = ["--accuracy", "{black = 0.9, white = 0.85}"]
WHOLE = str(DATA / "whole.py")
FILES = {"brain.h", "robot.h", "sensor.h", "settings.h", "main.c", "Makefile", "README.md"}
KILOBOT = pytest.mark.skipif(not shutil.which("avr-gcc"), reason="needs avr-gcc, of Debian's package gcc-avr")
HOST = pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
BOARDS = ROOT / "src" / "swarmcensus" / "translation" / "boards"
BOOTS = """
#include <stdint.h>
static inline uint8_t eeprom_read_byte(const uint8_t *at) { (void)at; return 4; }
static inline void eeprom_write_byte(uint8_t *at, uint8_t x) { (void)at; (void)x; }
"""
HARNESS = """
#include <stdio.h>
#include "kilolib.h"
uint16_t kilo_uid = NUMBER;
static int light;
int16_t get_ambientlight(void) { return (int16_t)light; }
uint8_t rand_hard(void) { return 7; }
void set_color(uint8_t color) { if (kilo_ticks == 600) fprintf(stderr, "%d ", color); }
void kilo_start(void (*setup)(void), void (*loop)(void)) {
    char word[64];
    setup();
    while (scanf("%d", &light) == 1) {  // of a tick: light, the messages that have arrived before it, and one of + -
        while (scanf("%63s", word) == 1 && word[0] != '-' && word[0] != '+') {
            message_t message = {{0}, 0, 0};
            for (int k = 0; k < 9; k++) {
                unsigned byte;
                sscanf(word + 2 * k, "%2x", &byte);
                message.data[k] = (uint8_t)byte;
            }
            kilo_message_rx(&message, 0);
        }
        kilo_ticks += 100;
        loop();
        message_t *said = word[0] == '-' ? 0 : kilo_message_tx();  // - if others never stop talking
        for (int k = 0; said && k < 9; k++) {
            printf("%02x", said->data[k]);
        }
        printf("\\n");
        if (said) {
            kilo_message_tx_success();
            if (kilo_message_tx()) {
                printf("again ");
            }
        }
    }
}
"""


def deployed(folder, brain="commons", *more):
    assert main(["deploy", brain, str(folder), "--target", "kilobot", *NEEDED, *more]) == 0
    return folder


@KILOBOT
@pytest.mark.long(but=["voter", "whole"])
@pytest.mark.parametrize("name", ["voter", "leaver", pytest.param(WHOLE, id="whole")])
def test_program_compiles_without_a_warning(tmp_path, name, capsys):
    """Also that of a brain that calls its own things what the headers call other things."""
    folder = deployed(tmp_path / "robot", name)
    assert int(re.search(r"flash +([\d,]+)", capsys.readouterr().out)[1].replace(",", "")) < 20_000
    assert {path.name for path in folder.iterdir()} == FILES
    command = ["make", "main.o", f"KILOLIB={BOARDS}"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "main.c" not in done.stderr


def mixed(x):
    for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
        x = (x ^ x >> shift) * factor % 2**32
    return x ^ x >> 16


def draws_of(number, boot):
    """The random numbers of a robot, of which 23 binary digits are random."""
    key = mixed(number << 8 | boot) ^ 0x07070707
    return [((mixed((mixed(k) + key) % 2**32) >> 9) * 2 + 1) / 2**24 for k in range(1000)]


def test_robots_and_boots_draw_different_numbers():
    """Though all robots measure the same noise."""
    draws = [draws_of(number, boot) for number in (1, 2, 256, 512) for boot in (0, 1, 2)]
    assert len({tuple(each[:2]) for each in draws}) == len(draws)
    assert all(0.0 < x < 1.0 for each in draws for x in each)
    assert 0.48 < sum(map(sum, draws)) / 12_000 < 0.52


def built(folder, options="", number=2):
    """The folder of a program for this machine, around which a harness stands in for Kilobot's library."""
    (folder / "avr").mkdir()
    (folder / "avr" / "eeprom.h").write_text(BOOTS)
    (folder / "host.c").write_text(HARNESS)
    flags = f"-std=gnu11 -O1 -Wall -Wextra -Werror -ffp-contract=off -DNUMBER={number} {options}"
    command = f"gcc {flags} -I. -I{BOARDS} main.c host.c {BOARDS}/no_kilolib.c -lm -o robot"
    subprocess.run(command.split(), cwd=folder, check=True)
    return folder


@HOST
@pytest.mark.parametrize(("number", "given", "speaks_as"), [
    (0xFFFF, None, None), (0, None, None), (0xFFFE, None, 0xFFFE), (0xFFFF, 7, 7), (3, 7, 7)
])  # fmt: skip
def test_a_kilobot_without_a_number_blinks_and_says_nothing(tmp_path, number, given, speaks_as):
    """New ones all have 0xFFFF; robots of one number would not hear each other."""
    folder = built(deployed(tmp_path / "robot", "commons", *(["--robot", str(given)] if given else [])), number=number)
    done = subprocess.run(["./robot"], cwd=folder, input="9 +\n" * 9, capture_output=True, text=True, check=True)
    senders = {int.from_bytes(bytes.fromhex(line)[2:4], "little") for line in done.stdout.split()}
    assert senders == ({speaks_as} if speaks_as else set())
    is_yellow = done.stderr.split() == ["15"]
    assert is_yellow == (speaks_as is None)


@HOST
@pytest.mark.parametrize("boot", [0, 5], ids=["simulator", "kilobot"])
@pytest.mark.parametrize("name", ["commons", pytest.param(WHOLE, id="whole")])
def test_kilobot_says_what_a_robot_of_single_precision_says(tmp_path, name, boot):
    """Its program, compiled for this machine, and the runtime send the same bytes. Some messages come twice, and some
    of its own are never sent. A simulator has no memory of boots."""
    folder = built(deployed(tmp_path / "robot", name), "-D__AVR__" * (boot > 0))
    brain = brains.load(name).with_numbers(Numbers("single", "ratio16"))
    mark = int(re.search(r"MARK 0x(\w+)", (folder / "settings.h").read_text())[1], 16)
    plan = tuple(tuple(part) for part in brain.parts)
    lights, air, robots = [(k * 37) % 600 for k in range(60)], Air(), []
    accuracies = rounded_to_single(0.9), rounded_to_single(0.85)
    for number, seen in ((1, lights), (2, lights[::-1])):
        sensor = Readings(light < 300 for light in seen)
        messages = runtime.Messages((0, 0), plan, mark, False, codec=codec_of(True)[3])
        robot = runtime.Robot(brain.functions, messages, sensor, air.radio(), lambda: 0, *accuracies, number)
        if brain.uses.luck:
            robot.draws = iter(draws_of(number, boot)).__next__
        robots.append(robot)
    robots[1].boot = boot
    lines, sent, first = [], [], None
    for tick in range(60):
        robots[0].tick()
        first = first or air.boxes[1][0]
        if tick % 7 == 3:  # an old message again, and one of another mark
            air.boxes[1] += [first, bytes([mark ^ 1]) + first[1:]]
        words = [data.hex() for data in air.boxes[1]]
        is_sent, owed = tick % 5 != 2, robots[1].messages.owed[:]
        said = len(air.boxes[0])
        robots[1].tick()
        sent += [*(data.hex() for data in air.boxes[0][said:] if is_sent)] or [""]
        if not is_sent:
            del air.boxes[0][said:]
            robots[1].messages.owed[:] = owed
        lines.append(" ".join([str(lights[::-1][tick]), *words, "-+"[is_sent]]))
    done = subprocess.run(["./robot"], cwd=folder, input="\n".join(lines), capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == sent
    assert sum(map(bool, sent)) > 30


@pytest.mark.long
@KILOBOT
def test_brain_too_large_for_a_kilobot(here, refused):
    large = here / "large.py"
    for length, says in ((400, "and a Kilobot has 1,300 for it"), (303, r"needs [\d,]+ bytes of flash and 1,\d+ of")):
        source = brains.load("commons").source
        large.write_text(source.replace("MEMORY = {", f'MEMORY = {{"belief": (0.0,) * {length}, ', 1))
        assert re.search(says, refused("deploy", large, "k", "--target", "kilobot", *NEEDED))
