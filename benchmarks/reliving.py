"""What reliving and exporting logs cost: python benchmarks/reliving.py [--robots 100] [--ticks 5000].

Robots with `commons` on a ring live without sockets and write their logs; of their messages 30 % are lost. Then
`swarmcensus relive` lives the minds again, under their own brain and also under another. `swarmcensus export` writes
480,000 messages of other logs as MCAP: of a fifth of the robots, without losses. Each command is a process of its own:
seconds, processor seconds, and the largest memory of one process. Two minutes on two cores.
"""

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from swarmcensus import brains
from swarmcensus.brains.packing import FORMATS, Numbers
from swarmcensus.deployment.messages import messages_of
from swarmcensus.robot.log import Log
from swarmcensus.robot.runtime import Robot

BRAIN, OTHER, MESSAGE = "commons", "minimalistic", "ratio16"
LOSS, BLACK, ACCURACY = 0.3, 0.55, 0.8
BEGUN, PERIOD = 1_700_000_000_000, 100  # ms
A_TICK = 5  # messages of an MCAP file: the reading, what was said, two heard, and the estimate


class Body:
    """A sensor that says black now and then, and a radio whose datagrams are put in by hand."""

    def __init__(self, chance):
        self.chance, self.sent, self.waiting = chance, None, []

    def start(self):
        pass

    def read(self):
        return self.chance.random() < BLACK * ACCURACY + (1.0 - BLACK) * (1.0 - ACCURACY)

    def send(self, datagram):
        self.sent = datagram

    def receive(self):
        return self.waiting.pop(0) if self.waiting else None


def write_logs(folder, robots, ticks, loss=LOSS):
    """Let robots on a ring live together; each tick they all speak, and then they all hear."""
    folder.mkdir()
    brain = brains.load(BRAIN).with_numbers(Numbers(message=MESSAGE))
    chance, now = random.Random(1), 0
    bodies = [Body(random.Random(number)) for number in range(robots)]
    swarm = [
        Robot(brain.functions, messages_of(brain), body, body, lambda: now % 2**30, ACCURACY, ACCURACY, number, PERIOD)
        for number, body in enumerate(bodies)
    ]
    mark, form = bytes.fromhex(brain.sha256)[:8], FORMATS.index(MESSAGE)
    for robot in swarm:
        robot.record(Log(str(folder / f"robot-{robot.number}.log"), mark, form, BEGUN))
    for _ in range(ticks):
        now += PERIOD
        for robot in swarm:
            robot.speak()
        for i, robot in enumerate(swarm):
            for j in (i - 1, (i + 1) % robots):
                if chance.random() >= loss:
                    bodies[i].waiting.append(bodies[j].sent)
            while robot._hear():
                pass
            robot.think()
            robot.log.tick(robot, now % 2**30)
    for robot in swarm:
        robot.log.close()


def megabytes(folder):
    return sum(path.stat().st_size for path in folder.iterdir()) / 1e6


def measured(says, *arguments):
    """Run a command that says this; its seconds, its processor seconds, and MB of its largest process."""
    begun = time.perf_counter()
    command = [sys.executable, "-m", "swarmcensus", *map(str, arguments)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    answer = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - begun
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode or says not in answer:
        sys.exit(f"swarmcensus {' '.join(map(str, arguments))} should say {says!r}: {answer}")
    unit = 1 if sys.platform == "darwin" else 1024
    return seconds, used.ru_utime + used.ru_stime, used.ru_maxrss * unit / 1e6


def rows(folder, robots, ticks):
    day, few = folder / "day", max(3, robots // 5)
    write_logs(day, robots, ticks)
    size, count = f"{megabytes(day):,.1f} MB", robots * ticks
    for what, *more in (("under their own brain",), (f"also under {OTHER}", "--brain", OTHER)):
        seconds, used, memory = measured(f"{count:,} of {count:,} ticks", "relive", day, *more)
        yield f"relive, {what}", f"{count:,} ticks in {size}", seconds, used, memory, f"{count / seconds:,.0f} ticks"
    day, out = folder / "other", folder / "other.mcap"
    each = round(ticks * 0.96)
    write_logs(day, few, each, loss=0.0)
    count, size = few * each * A_TICK, megabytes(day)
    seconds, used, memory = measured(f"{count:,} messages", "export", day, "--format", "mcap", "--out", out)
    size = f"{size:,.1f} MB to {out.stat().st_size / 1e6:,.1f} MB"
    yield (
        "export --format mcap",
        f"{count:,} messages, {size}",
        seconds,
        used,
        memory,
        f"{count / seconds:,.0f} messages",
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--robots", type=int, default=100)
    parser.add_argument("--ticks", type=int, default=5000, help="of each robot")
    options = parser.parse_args()
    print("| | of | seconds | processor seconds | memory, MB | a second |")
    print("|---|---|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for what, size, seconds, used, memory, rate in rows(Path(folder), options.robots, options.ticks):
            print(f"| {what} | {size} | {seconds:.1f} | {used:.1f} | {memory:,.0f} | {rate} |", flush=True)


if __name__ == "__main__":
    main()
