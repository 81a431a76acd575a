"""Minds of mixed swarms, lived again from their logs: python benchmarks/swarm.py --minds.

Five swarms of 20 processes each, with other brains, message formats, precisions, networks and liars. Of their messages
30 % are lost, and some are late or doubled. Robots are killed and start again with and without memory, start late, are
stopped and cut off, and random datagrams come to all. Two robots of each swarm run MicroPython where it is installed.
Then half of the logs are cut at a random byte. Each mind should be lived again to the bit, of a cut log up to the cut.
"""

import random
import shutil
import struct
import time
from typing import NamedTuple

from swarmcensus.deployment import on_node
from swarmcensus.reliving.folders import read_day
from swarmcensus.reliving.lives import relive_all
from swarmcensus.studies.study import Study
from swarmcensus.swarm.faults import faults_of
from swarmcensus.swarm.plans import Air, plan_of
from swarmcensus.swarm.running import run

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
HZ = 40.0
FAULTS = (  # shares of the run, and robots of at least 8
    (0.08, "start 3"), (0.1, "garbage 0-{last}"), (0.2, "stop 4"), (0.25, "partition 0-{half}"), (0.3, "continue 4"),
    (0.35, "kill 2"), (0.4, "restart 2 blank"), (0.45, "kill 1"), (0.5, "heal"), (0.55, "restart 1"),
    (0.6, "garbage 0-{last}"), (0.7, "kill 5"), (0.8, "kill 1"), (0.85, "restart 1"),
)  # fmt: skip
CUT = 0.5  # share of logs


class Again(NamedTuple):
    """What came of living the minds of a folder again."""

    minds: int
    to_the_bit: int
    ticks: int  # whole ones in the logs
    relived: int
    starts: dict[str, int]  # blank, resumed, unknown
    heard: int  # messages
    differences: list[str]
    seconds: float


def lived(given, folder, robots=20, rounds=400, seed=0):
    """Run a swarm of SWARMS; its outcome."""
    study = Study(
        name="minds", trials=1,
        swarm={"brain": given["brain"], "robots": robots, "accuracy": "U(0.6, 0.9)"}
        | ({"precision": given["precision"]} if "precision" in given else {}),
        world={"topology": given["topology"], "fill_ratio": 0.55, "link_success": 0.7, "message": given["message"]},
        schedule={"rounds": rounds, "observations_per_round": 1}, members=given["members"],
    )  # fmt: skip
    air = Air(hz=HZ, delay=given.get("delay", 0), duplicate=0.1)
    plan = plan_of(study, 0, seed, 0, air, 2 if on_node.micropython() else 0)
    places = {"last": robots - 1, "half": robots // 2 - 1}
    texts = [f"{at * plan.seconds:.2f}s {what.format(**places)}" for at, what in FAULTS]
    return run(plan, faults_of(texts, robots, plan.period, plan.seconds), folder)


def lived_again(folder):
    """Live all minds of a folder again."""
    begun = time.perf_counter()
    lives = relive_all(day := read_day(folder))
    seconds = time.perf_counter() - begun
    starts = [start.kind for life in lives for start in life.starts]
    return Again(
        len(lives), sum(life.to_the_bit for life in lives), sum(life.ticks for life in lives),
        sum(life.relived for life in lives), {kind: starts.count(kind) for kind in ("blank", "resumed", "unknown")},
        sum(len(tick.heard) for member in day.members for tick in member.log.ticks),
        [f"robot {life.number}, tick {one.tick}: {one.reason}" for life in lives for one in life.breaks], seconds,
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
    """For each swarm: what it is, its outcome, and its minds lived again before and after the cuts."""
    for k, given in enumerate(swarms):
        outcome = lived(given, folder / str(k), robots, rounds, k)
        whole = lived_again(folder / str(k))
        shutil.copytree(folder / str(k), folder / f"{k}-cut")
        logs = cut(folder / f"{k}-cut", random.Random(k))
        yield given, outcome, whole, logs, lived_again(folder / f"{k}-cut")


def table(folder):
    """The lines of a table."""
    heads = ("brain", "message", "minds", "to the bit", "ticks", "lived again", "messages heard", "resumed", "blank",
             "logs cut", "to the bit then", "ticks then", "lived again then", "seconds of both")  # fmt: skip
    yield f"| {' | '.join(heads)} |"
    yield "|---|---|" + "---:|" * (len(heads) - 2)
    sums = [0] * 4
    for given, outcome, whole, logs, then in rows(folder):
        what = given["message"] + (", single" if "precision" in given else "")
        numbers = (
            whole.minds, whole.to_the_bit, whole.ticks, whole.relived, whole.heard, whole.starts["resumed"],
            whole.starts["blank"], logs, then.to_the_bit, then.ticks, then.relived,
        )  # fmt: skip
        cells = [given["brain"], what, *(f"{n:,}" for n in numbers), f"{whole.seconds + then.seconds:.1f}"]
        yield f"| {' | '.join(cells)} |"
        sums = [a + b for a, b in zip(sums, (whole.to_the_bit, whole.minds, then.to_the_bit, then.minds), strict=True)]
        for line in [*outcome.died.values(), *whole.differences, *then.differences]:
            yield f"differs: {line}"
    yield ""
    yield f"{sums[0]} of {sums[1]} minds to the bit; {sums[2]} of {sums[3]} after the cuts."
