"""Swarms of processes, and their logs: python benchmarks/swarm.py [QUESTION] [--quick]. Needs SciPy."""

import itertools
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import harness
import numpy as np

from swarmcensus.robots.logs.logs import read_log
from swarmcensus.robots.swarm.plans import Air, plan_of
from swarmcensus.robots.swarm.running import run
from swarmcensus.simulation.trials import record_estimates
from swarmcensus.studies.study import Study
from swarmcensus.support.bins import right_bin

try:
    from scipy.stats import ks_2samp, mannwhitneyu
except ImportError:
    sys.exit("benchmarks/swarm.py needs SciPy: pip install 'swarmcensus[test]'")
import random
import shutil
import struct
import time
from typing import NamedTuple

from swarmcensus import brains
from swarmcensus.brains.packing import FORMATS, Numbers
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive_all
from swarmcensus.runtime.log import Log
from swarmcensus.runtime.runtime import Robot
from swarmcensus.translation.messages import messages_of

COSTS = (  # robots, Hz, rounds, topology, loss, delay in ms
    (20, 10.0, 300, "ring", 0.3, 0),
    (100, 10.0, 300, "ring", 0.3, 0),
    (100, 10.0, 300, "ring", 0.3, 50),
    (50, 10.0, 300, "full", 0.3, 0),
    (20, 100.0, 1500, "ring", 0.3, 0),
    (20, 100.0, 1500, "scale-free", 0.0, 0),
)
COST_HEADS = (
    "robots", "ticks a second", "network", "loss", "delay (ms)", "cores", "heard (%)", "missed ticks",
    "ticks",
)  # fmt: skip
WORLDS = tuple(itertools.product(("ring", "scale-free"), (0.0, 0.3)))
ROBOTS, HZ, ROUNDS = 20, 100.0, 200
AT_ONCE = 2  # swarms
SIMULATED = 2000  # trials of the simulator
SEEDS = 0, 1  # of sockets, and of the simulator
LEVEL = 0.001


def study(robots, rounds, topology, loss, trials=1):
    return Study(
        name="desk", trials=trials, swarm={"brain": "commons", "robots": robots, "accuracy": 0.8},
        world={"topology": topology, "fill_ratio": 0.55, "link_success": 1.0 - loss, "message": "ratio16"},
        schedule={"rounds": rounds, "observations_per_round": 1},
    )  # fmt: skip


def lived(plan, ages=False):
    """The outcome of a swarm, and with `ages` how many messages are of the hearer's tick, the one before, and older."""
    with tempfile.TemporaryDirectory() as folder:
        outcome = run(plan, Path(folder) / "swarm").fields
        counts = np.zeros(3, np.int64)
        for path in Path(folder, "swarm").glob("robot-*.log") if ages else ():
            for tick in read_log(path).ticks:
                for message in tick.heard:
                    counts[min(max(tick.tick - message.tick, 0), 2)] += 1
    return outcome, counts


def costs(swarms):
    for robots, hz, rounds, topology, loss, delay in swarms:
        plan = plan_of(study(robots, rounds, topology, loss), 0, 0, 0, Air(hz=hz, delay=delay))
        o, _ = lived(plan)
        spent = f"{o['cores']:.2f}", f"{100 * o['heard']:.2f}"
        yield [*map(str, (robots, f"{hz:g}", topology, f"{loss:g}", delay, *spent, o["missed"], robots * rounds))]


def simulated(setting, seed, trial):
    """The mean error of a trial at its end, and the share of robots that are right."""
    return measured(record_estimates(setting, seed, trial)[-1])


def measured(estimates):
    low, high = right_bin(0.55)
    return np.abs(estimates - 0.55).mean(), ((estimates >= low) & (estimates < high)).mean()


def against(runs):
    """The heads and rows of a table, and how many messages are of which age."""
    each = runs // len(WORLDS)
    compared = ("sockets", "simulator", "effect", "p (MW)", "p (KS)", "paired", "standard error")
    heads, rows = ["network", "loss", "at the end", "runs", "trials", *compared], []
    ages = np.zeros(3, np.int64)
    for topology, loss in WORLDS:
        world = study(ROBOTS, ROUNDS, topology, loss, trials=each)
        [setting] = world.settings()
        plans = [plan_of(world, 0, SEEDS[0], trial, Air(hz=HZ)) for trial in range(each)]
        with ThreadPoolExecutor(AT_ONCE) as pool:
            ends = list(pool.map(lambda plan: lived(plan, ages=True), plans))
        ages += sum(counts for _, counts in ends)
        over = np.array([measured(np.array(outcome["estimates"])) for outcome, _ in ends])
        twins = np.array([simulated(setting, SEEDS[0], trial) for trial in range(each)])
        within = np.array([simulated(setting, SEEDS[1], trial) for trial in range(SIMULATED)])
        for k, what in enumerate(("mean error", "share right")):
            test = mannwhitneyu(over[:, k], within[:, k])
            effect = 2.0 * test.statistic / (each * SIMULATED) - 1.0
            p = ks_2samp(over[:, k], within[:, k]).pvalue
            apart = over[:, k] - twins[:, k]
            error = apart.std(ddof=1) / np.sqrt(each)
            means = f"{over[:, k].mean():.4f}", f"{within[:, k].mean():.4f}"
            tests = f"{effect:+.2f}", f"{test.pvalue:.3f}", f"{p:.3f}", f"{apart.mean():+.4f}", f"{error:.4f}"
            rows.append([topology, f"{loss:g}", what, str(each), str(SIMULATED), *means, *tests])
    return heads, rows, ages


# ---- states replayed from logs


LIAR = {"honest": False}
SWARMS = (
    {"brain": "commons", "message": "ratio16", "topology": "ring", "delay": 30,
     "members": [{"robots": 0.1, "brain": "shouter", **LIAR}]},
    {"brain": "steadfast", "message": "ratio16", "precision": "single", "topology": "scale-free",
     "members": [{"robots": 0.1, "brain": "slow-liar", **LIAR}]},
    {"brain": "minimalistic", "message": "float32", "topology": "full", "delay": 10,
     "members": [{"robots": 0.25, "brain": "legacy"}, {"robots": 0.1, "accuracy": 0.55}]},
    {"brain": "tracking", "message": "float16", "precision": "single", "topology": "ring", "delay": 70, "members": []},
    {"brain": "voter", "message": "ratio16", "topology": "full",
     "members": [{"robots": 0.1, "brain": "forger", **LIAR}]},
)  # fmt: skip
STORM_HZ = 40.0
FAULTS = (  # from and until, shares of the run, what, and one of at least 8 robots, or half of them
    (0.0, 0.08, "kill", 3), (0.2, 0.3, "stop", 4), (0.25, 0.5, "cut", None), (0.35, 0.4, "kill", 2),
    (0.45, 0.55, "kill", 1), (0.7, None, "kill", 5), (0.8, 0.85, "kill", 1),
)  # fmt: skip
BLANK = 2  # the robot that loses its memory
CUT = 0.5  # share of logs


class Again(NamedTuple):
    """What came of living the states of a folder again."""

    states: int
    to_the_bit: int
    ticks: int  # whole ones in the logs
    relived: int
    starts: dict[str, int]  # blank, resumed, unknown
    heard: int  # messages
    differences: list[str]
    seconds: float


def stormed(given, folder, robots=20, rounds=400, seed=0):
    """Run a swarm of SWARMS; its outcome."""
    study = Study(
        name="states", trials=1,
        swarm={"brain": given["brain"], "robots": robots, "accuracy": "U(0.6, 0.9)"}
        | ({"precision": given["precision"]} if "precision" in given else {}),
        world={"topology": given["topology"], "fill_ratio": 0.55, "link_success": 0.7, "message": given["message"]},
        schedule={"rounds": rounds, "observations_per_round": 1}, members=given["members"],
        faults=[
            {"at": 1 + round(at * rounds), "do": do}
            | {"robots": {"named": range(robots // 2) if robot is None else [robot]}}
            | ({} if until is None else {"until": 1 + round(until * rounds), "blank": robot == BLANK})
            for at, until, do, robot in FAULTS
        ],
    )  # fmt: skip
    air = Air(hz=STORM_HZ, delay=given.get("delay", 0), duplicate=0.1)
    plan = plan_of(study, 0, seed, 0, air)
    return run(plan, folder).fields


def lived_again(folder):
    """Live all states of a folder again."""
    begun = time.perf_counter()
    lives = relive_all(recording := read_recording(folder))
    seconds = time.perf_counter() - begun
    starts = [state.tick for member in recording.members for state in member.log.states if state.starts]
    return Again(
        len(lives), sum(life.to_the_bit for life in lives), sum(life.ticks for life in lives),
        sum(life.relived for life in lives), {"blank": starts.count(0), "resumed": len(starts) - starts.count(0)},
        sum(len(tick.heard) for member in recording.members for tick in member.log.ticks),
        [f"robot {life.number}, tick {one.tick}: {one.field}" for life in lives for one in life.breaks], seconds,
    )  # fmt: skip


def cut(folder, chance):
    """Cut some of the logs at a random byte behind their first block; how many."""
    count = 0
    for path in sorted(folder.glob("robot-*.log")):
        data = path.read_bytes()
        if chance.random() < CUT:
            first = 7 + struct.unpack_from("<I", data, 1)[0]
            path.write_bytes(data[: chance.randrange(first, len(data))])
            count += 1
    return count


def rows(folder, swarms=SWARMS, robots=20, rounds=400):
    """For each swarm: what it is, its outcome, and its states lived again before and after the cuts."""
    for k, given in enumerate(swarms):
        outcome = stormed(given, folder / str(k), robots, rounds, k)
        whole = lived_again(folder / str(k))
        shutil.copytree(folder / str(k), folder / f"{k}-cut")
        logs = cut(folder / f"{k}-cut", random.Random(k))
        yield given, outcome, whole, logs, lived_again(folder / f"{k}-cut")


def table(folder, swarms):
    """The lines of a table."""
    heads = ("brain", "message", "states", "to the bit", "ticks", "lived again", "messages heard", "resumed", "blank",
             "logs cut", "to the bit then", "ticks then", "lived again then", "seconds of both")  # fmt: skip
    yield f"| {' | '.join(heads)} |"
    yield "|---|---|" + "---:|" * (len(heads) - 2)
    sums = [0] * 4
    for given, outcome, whole, logs, then in rows(folder, swarms):
        what = given["message"] + (", single" if "precision" in given else "")
        numbers = (
            whole.states, whole.to_the_bit, whole.ticks, whole.relived, whole.heard, whole.starts["resumed"],
            whole.starts["blank"], logs, then.to_the_bit, then.ticks, then.relived,
        )  # fmt: skip
        found = whole.to_the_bit, whole.states, then.to_the_bit, then.states
        cells = [given["brain"], what, *(f"{n:,}" for n in numbers), f"{whole.seconds + then.seconds:.1f}"]
        yield f"| {' | '.join(cells)} |"
        sums = [a + b for a, b in zip(sums, found, strict=True)]
        for line in [*outcome["died"].values(), *whole.differences, *then.differences]:
            yield f"differs: {line}"
    yield ""
    yield f"{sums[0]} of {sums[1]} states to the bit; {sums[2]} of {sums[3]} after the cuts."


# ---- what logs cost


BRAIN, MESSAGE = "commons", "ratio16"
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


def measured_as(says, *arguments):
    """Run a command that says this; its seconds, its processor seconds, and MB of its process."""
    spent = harness.program(*arguments)
    if says not in spent.out:
        sys.exit(f"swarmcensus {' '.join(map(str, arguments))} should say {says!r}: {spent.out}")
    return spent.seconds, spent.processor, spent.memory / 1e6


def log_rows(folder, robots, ticks):
    recording, few = folder / "day", max(3, robots // 5)
    write_logs(recording, robots, ticks)
    size, count = f"{megabytes(recording):,.1f} MB", robots * ticks
    seconds, used, memory = measured_as(f"{count:,} of {count:,} ticks", "relive", recording)
    yield "relive", f"{count:,} ticks in {size}", seconds, used, memory, f"{count / seconds:,.0f} ticks"
    recording, out = folder / "other", folder / "other.mcap"
    each = round(ticks * 0.96)
    write_logs(recording, few, each, loss=0.0)
    count, size = few * each * A_TICK, megabytes(recording)
    seconds, used, memory = measured_as(f"{count:,} messages", "export", recording, "--out", out)
    size = f"{size:,.1f} MB to {out.stat().st_size / 1e6:,.1f} MB"
    yield (
        "export",
        f"{count:,} messages, {size}",
        seconds,
        used,
        memory,
        f"{count / seconds:,.0f} messages",
    )


@harness.question
def sockets(runs=200, write=False, quick=False):
    """What processes cost and hear; and swarms over sockets beside the simulator, in four worlds.

    20 robots at 100 ticks a second, 200 rounds: errors and shares of right robots at the end, in trials of other seeds.
    Two-sample tests are Mann and Whitney's, and Kolmogorov and Smirnov's. Ten minutes on two cores, of which the first
    two are for the first table; `runs` = 0 for that alone.
    """
    spent = list(costs(COSTS[:1] if quick else COSTS))
    print(harness.markdown(COST_HEADS, spent))
    if write:
        harness.write_csv("swarm-costs", COST_HEADS, spent)
    if not runs or quick:
        return
    heads, rows, ages = against(runs)
    same, before, older = 100 * ages / ages.sum()
    print(f"\n{harness.markdown(heads, rows)}\n")
    print(f"Messages heard: {same:.0f} % of the hearer's tick, {before:.0f} % of the one before, {older:.1f} % older.")
    if write:
        harness.write_csv("swarm-simulator", heads, rows)


@harness.question(unasked=False)
def states(quick=False):
    """Replays from logs of mixed swarms: each robot's state should be so to the bit, of a cut log up to the cut.

    Five swarms of 20 processes each, with other brains, message formats, precisions, networks and liars. Of their
    messages 30 % are lost, and some are late or doubled. Robots are killed and start again with and without memory,
    start late, are stopped and cut off, and random datagrams come to all. Then half of the logs are
    cut at a random byte. A good minute.
    """
    with tempfile.TemporaryDirectory() as folder:
        for line in table(Path(folder), SWARMS[:1] if quick else SWARMS):
            print(line, flush=True)


@harness.question(unasked=False)
def logs(robots=100, ticks=5000, quick=False):
    """What replaying and exporting logs costs: seconds, processor seconds, memory. Two minutes on two cores.

    Robots with `commons` on a ring write their logs without sockets; of their messages 30 % are lost. `swarmcensus
    relive` replays them. `swarmcensus export` writes 480,000 messages of
    other logs as MCAP: of a fifth of the robots, without losses. Each command is a process.
    """
    robots, ticks = (10, 200) if quick else (robots, ticks)
    with tempfile.TemporaryDirectory() as folder:
        rows = [
            [what, size, f"{seconds:.1f}", f"{used:.1f}", f"{memory:,.0f}", rate]
            for what, size, seconds, used, memory, rate in log_rows(Path(folder), robots, ticks)
        ]
    print(harness.markdown(["", "of", "seconds", "processor seconds", "memory, MB", "a second"], rows))


if __name__ == "__main__":
    harness.answer(globals())
