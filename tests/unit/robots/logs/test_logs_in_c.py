"""robot_log.h: a swarm in C writes logs, and the runtime lives them again to the bit."""

import shutil
import subprocess

import pytest

from swarmcensus import brains
from swarmcensus.brains.packing import Numbers
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from swarmcensus.translation import header, logged, piece
from tests.support.second import changed

pytestmark = pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
TICKS = 40
SWARM = """
#include <stdlib.h>
#include "brain.h"
#include "logged.h"
#define MARK 0xC5
#define ROBOT_SENDERS 4
#include "robot.h"
#include "robot_log.h"

#define ROBOTS 3
static struct robot robots[ROBOTS];
static struct robot_log logs[ROBOTS];

static uint32_t chance(void) {
    static uint32_t x = 2463534242u;
    x ^= x << 13;
    x ^= x >> 17;
    return x ^= x << 5;
}

#if LUCK
static number robot_draw(struct robot *robot) {
    const number x = ((number)(chance() >> 8) + (number)0.5) / (number)16777216;
    robot_log_drew(&logs[robot - robots], x);
    return x;
}
#endif

int main(void) {
    for (int k = 0; k < ROBOTS; k++) {
        char name[] = "robot-0.log";
        name[6] = (char)('0' + k);
        robot_start(&robots[k], (number)0.9, (number)0.8, (uint16_t)(300 + k), (uint8_t)k);
        robot_log_open(&logs[k], name, &robots[k], 100, 0x3FFFFF00u);
    }
    for (uint32_t tick = 0; tick < TICKS; tick++) {
        uint8_t said[ROBOTS][ROBOT_DATAGRAM];
        bool speaks[ROBOTS];
        for (int k = 0; k < ROBOTS; k++) {
            if (!robots[k].is_done) {
                const uint16_t looks = chance() % 3, blacks = looks && chance() % 10 < 6;
                robot_observe(&robots[k], blacks, looks);
                robot_log_read(&logs[k], blacks, looks);
            }
            speaks[k] = robot_say(&robots[k], said[k]);
            if (speaks[k]) {
                robot_log_said(&logs[k], said[k]);
            }
        }
        for (int k = 0; k < 4 * ROBOTS; k++) {  // all that is said, twice
            const int from = k % ROBOTS, to = k / 4;
            if (speaks[from] && chance() % 4 && robot_hear(&robots[to], said[from])) {
                robot_log_heard(&logs[to], said[from]);
            }
        }
        for (int k = 0; k < ROBOTS; k++) {
            const number x = robot_end(&robots[k]);
            robot_log_tick(&logs[k], &robots[k], 0x3FFFFF00u + 100 * tick, x);
        }
    }
    return 0;
}
"""

WILD = changed(
    ('("x",)', '("t",)'),
    ("me.t += looks\n    me.n += blacks", "me.t += blacks"),
    ("(estimate(me),)", "(me.t,)"),
    ("message):\n    pass", "message):\n    me.t += 0.5 * message[0]"),
    ("fuse(me):\n    pass", "fuse(me):\n    me.t *= 0.75"),
    ("return me.n / me.t if me.t > 0.0 else 0.5", "return 0.25 * me.t"),
)


@pytest.mark.parametrize(("name", "precision", "message", "compiler"), [
    ("census", "single", "ratio16", "gcc -std=c99"), ("sure", "double", "float32", "g++ -std=c++17 -x c++"),
    ("wild.py", "double", "float32", "gcc -std=c99"),
])  # fmt: skip
def test_a_log_written_in_c_is_lived_again_to_the_bit(tmp_path, name, precision, message, compiler):
    wild = name == "wild.py"  # its estimate leaves [0, 1] again and again, and it starts blank
    if wild:
        name = tmp_path / name
        name.write_text(WILD)
    brain = brains.load(name).with_numbers(Numbers(precision, message))
    for file, text in {"brain.h": header(brain), "logged.h": logged(brain, 0xAAC5), "swarm.c": SWARM}.items():
        (tmp_path / file).write_text(text)
    for file in ("robot.h", "robot_log.h"):
        (tmp_path / file).write_text(piece(file))
    uses = {"LUCK": brain.uses.luck, "NAMED": brain.uses.name, "ENDS": brain.ends, "STEERS": brain.steers}
    defined = [f"-D{key}={int(value)}" for key, value in uses.items()]
    flags = ["-Wall", "-Wextra", "-Werror", "-ffp-contract=off", f"-DTICKS={TICKS}", *defined]
    subprocess.run([*compiler.split(), *flags, "swarm.c", "-lm", "-o", "swarm"], cwd=tmp_path, check=True)
    subprocess.run(["./swarm"], cwd=tmp_path, check=True)
    members = read_recording(tmp_path, name if wild else None).members
    assert [member.number for member in members] == [300, 301, 302]
    for member in members:
        life = relive(member)
        assert (life.relived, life.ticks, life.breaks, life.lost) == (TICKS, TICKS, [], [])
        assert any(tick.heard for tick in member.log.ticks)
        assert (sum(tick.estimate == 0.5 for tick in member.log.ticks) > 2) >= wild
