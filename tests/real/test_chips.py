"""Translated brains on simulated chips give the bits of CPython in single precision."""

import re
import subprocess
from pathlib import Path

import pytest

from swarmcensus.brains import load
from swarmcensus.brains.brain import parse, shipped
from swarmcensus.cli.commands import main
from swarmcensus.robots import chips
from swarmcensus.robots.targets.kilobot import FLAGS
from swarmcensus.support.errors import BrainError
from swarmcensus.translation.pieces import BOARDS
from swarmcensus.translation.selftest import is_exact
from tests.support import hosts
from tests.support.pages import cells_of
from tests.support.places import DATA, DOCS, EXAMPLE
from tests.support.translated import BRAINS, CLOSE, differs, load_busy, named


def needs(programs):
    missing = chips.missing(programs)
    return pytest.mark.skipif(bool(missing), reason=f"not installed: {', '.join(missing)} (tools/install-chips.sh)")


AVR, CORTEX = needs(hosts.AVR), needs(hosts.CORTEX)
KILOLIB = (f"-I{BOARDS}", f"{BOARDS}/no_kilolib.c")
SHORT = 17  # rounds in an AVR, which is slow to simulate


def on_atmega(source):
    return hosts.selftest_on_avr(source, SHORT)


@pytest.mark.long(but=["commons-atmega", "commons-cortex", "w-msr-cortex"])
@pytest.mark.parametrize(("chip", "rounds"), [
    pytest.param(on_atmega, SHORT, id="atmega", marks=AVR),
    pytest.param(hosts.on_cortex, None, id="cortex", marks=CORTEX),
])  # fmt: skip
@pytest.mark.parametrize("name", BRAINS, ids=named)
def test_brains_on_chips(name, chip, rounds, tmp_path):
    brain = load_busy(name, "single", "ratio8" if is_exact(load_busy(name, "single")) else "float32")
    difference = differs(brain, tmp_path, chip, rounds)
    assert difference.line == 0 if is_exact(brain) else difference.largest < CLOSE


KILOBOT = """
#include "kilolib.h"
#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/sleep.h>
static void put(char c) { while (!(UCSR0A & _BV(UDRE0))) {} UDR0 = (uint8_t)c; }
static void end(void) { while (!(UCSR0A & _BV(UDRE0))) {} cli(); sleep_enable(); sleep_cpu(); }
void kilo_init(void) { UBRR0 = 0; UCSR0B = _BV(TXEN0); }
#else
#include <stdio.h>
static void put(char c) { putchar(c); }
static void end(void) {}
#endif
uint16_t kilo_uid = 50000;
int16_t get_ambientlight(void) { return (int16_t)(kilo_ticks * 37 % 600); }
uint8_t rand_hard(void) { return 200; }
void kilo_start(void (*setup)(void), void (*loop)(void)) {
    setup();
    for (uint16_t tick = 1; tick <= 40; tick++) {
        kilo_ticks += 100;
        loop();
        message_t *said = kilo_message_tx();
        for (uint8_t k = 0; said && k < 9; k++) {
            put((char)('a' + (said->data[k] >> 4)));
            put((char)('a' + (said->data[k] & 15)));
        }
        put('\\n');
        if (said) {  // it is heard in two other names
            message_t heard = *said;
            kilo_message_tx_success();
            for (uint8_t k = 1; k < 3; k++) {
                heard.data[3] = (uint8_t)(heard.data[3] + k);
                kilo_message_rx(&heard, 0);
            }
        }
    }
    end();
}
"""


@AVR
def test_kilobot_program_sends_on_its_chip_what_it_sends_on_a_computer(tmp_path):
    options = ["--target", "kilobot", "--accuracy", "{black = 0.9, white = 0.8}"]
    assert main(["deploy", str(DATA / "whole.py"), str(tmp_path / "robot"), *options]) == 0
    robot = tmp_path / "robot"
    (robot / "all.c").write_text(f'#include "main.c"\n{KILOBOT}')
    sent = hosts.on_avr(robot / "all.c", chips.KILOBOT, *FLAGS, *KILOLIB)
    command = ["gcc", "-std=gnu99", "-ffp-contract=off", *KILOLIB, "-o", robot / "all", robot / "all.c", "-lm"]
    subprocess.run(command, check=True)
    assert sent.split() == subprocess.run([robot / "all"], capture_output=True, text=True, check=True).stdout.split()
    assert len(set(sent.split())) == 32


COUNTING = """
#include <avr/io.h>
#include <avr/interrupt.h>
#include <avr/sleep.h>
static int put(char c, FILE *to) { (void)to; while (!(UCSR0A & _BV(UDRE0))) {} UDR0 = (uint8_t)c; return 0; }
static FILE serial = FDEV_SETUP_STREAM(put, 0, _FDEV_SETUP_WRITE);
static inline void debug_init(void) { UBRR0 = 0; UCSR0B = _BV(TXEN0); stdout = &serial; }
uint16_t kilo_uid = 50000;
int16_t get_ambientlight(void) { return (int16_t)(kilo_ticks * 37 % 600); }
void kilo_start(void (*setup)(void), void (*loop)(void)) {
    for (setup(); kilo_ticks < 3 * 2611; kilo_ticks += 3) {
        loop();
    }
    put(' ', 0);
    cli();
    sleep_enable();
    sleep_cpu();
}
"""


@AVR
def test_a_kilobot_counts_readings_on_its_chip(tmp_path):
    robot = tmp_path / "robot"
    assert main(["deploy", "commons", str(robot), "--target", "kilobot", "--calibrate"]) == 0
    (robot / "debug.h").write_text(f"#include <stdio.h>\n{COUNTING}")
    rows = ["robot,strip,readings,black,changes"]
    for strip, first in (("black", 0), ("white", 1610)):
        seen = [tick * 3 * 37 % 600 < 300 for tick in range(first, first + 1000)]
        rows.append(f"50000,{strip},1000,{sum(seen)},{sum(map(bool.__ne__, seen, seen[1:]))}")
    assert hosts.on_avr(robot / "calibrate.c", chips.KILOBOT, *FLAGS, f"-I{robot}", *KILOLIB).split() == rows


@pytest.fixture
def avr(benchmark):
    return benchmark("avr")


def table_of_costs():
    """The rows of the table of costs, by brain."""
    return {name: cells for name, *cells, _ in map(dict.values, cells_of("atmega328p"))}


def test_the_table_has_the_costs_of_all_brains(avr):
    rows = table_of_costs()
    assert list(cells_of("atmega328p")[0]) == [*avr.COLUMNS]
    assert list(rows) == shipped()
    assert rows["commons"][-1] == "yes"
    assert rows["bayes-bots"][-1].startswith("no: RAM")


def test_brains_that_fit_a_kilobot():
    page = (DOCS / "which-brain.md").read_text(encoding="utf-8")
    named = page.partition("these brains fit:\n\n")[2].partition("\n\n")[0]
    fit = [name for name, cells in table_of_costs().items() if cells[-1] == "yes" and not load(name).is_oracle]
    assert sorted(re.findall("`(.*?)`", named)) == sorted(fit)


@pytest.mark.long
@AVR
def test_costs(avr):
    one = avr.cost(load("commons"))
    written = [float(cell) for cell in table_of_costs()["commons"][:-1]]
    found = (one.flash, one.cycles, one.coded_flash, one.coded_cycles, one.longest, one.ram, one.stack, one.message)
    assert written == pytest.approx([*found, one.milliseconds], rel=0.1)  # other compilers have other figures
    assert 28 <= one.ram < 64
    assert (one.too_large, one.kilobot) == ((), "yes")
    assert one._replace(ram=1800).too_large == ("RAM",)
    assert one._replace(message=4, coded_flash=30_000).kilobot == "no: flash, message"


@AVR
@pytest.mark.long
def test_longest_tick_is_that_of_a_phase_with_twenty_senders(avr):
    """No overflow of the chip's timer is lost: twice as many rounds of a loop take twice as long."""
    assert avr.cost(load("w-msr")).longest > 200_000
    own = (EXAMPLE / "my_brain.py").read_text(encoding="utf-8").replace("MEMORY = {", 'MEMORY = {"past": 0.0, ', 1)
    rare = "me.past += 1.0\n    if me.past % 500.0 == 0.0:\n        "
    loop = "for _ in range(TURNS):\n            me.x = 0.5 * me.x + 0.25\n"
    slow = own.replace("def fuse(me):\n", f"def fuse(me):\n    {rare}{loop}")
    brains = [parse(slow.replace("TURNS", turns), "slow", Path("slow.py")) for turns in ("6000", "12000")]
    short, long = (avr.cost(one).longest for one in brains)
    assert short > 2**20
    assert long == pytest.approx(2 * short, rel=0.02)


@AVR
def test_a_brain_that_no_chip_has_room_for_is_named(avr, tmp_path):
    own = (EXAMPLE / "my_brain.py").read_text(encoding="utf-8")
    file = tmp_path / "large.py"
    for numbers in (4096, 4060):  # more than the chip has, and as much as would leave no room for a stack
        large = own.replace("MEMORY = {", f'MEMORY = {{"large": (0.0,) * {numbers}, ', 1)
        file.write_text(large, encoding="utf-8")
        with pytest.raises(BrainError, match="with 128 KB of flash and 16 KB of RAM, is too small"):
            avr.cost(load(file))
