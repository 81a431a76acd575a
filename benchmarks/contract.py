"""What the contract's second edition costs: python benchmarks/contract.py [--quick].

Prints, on one core, how many ns a robot and round take of brains that are alike but for one thing: whether they ask for
luck, whether ten numbers are ten fields or a vector, whether they may be silent, whether they decide; on rings and with
robots that move; and how long a parameter's new value takes until it runs, beside a new constant.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from swarmcensus import Study, brains
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics, run_batch

GO = np.zeros(1, np.uint8)
MOST = Metrics(0.01, 10, ())
TEN = range(10)

PLAIN = '''"""Averages what it hears of ten numbers."""
PARAMETERS = {"own": 0.5}
MEMORY = {"t": 0.0, "n": 0.0, "x": 0.5, "heard": 0.0, "sum": 0.0, "lot": 0.5}
MESSAGE = ("x",)


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    me.lot = LOT


def broadcast(me):
    return (me.x,)


def receive(me, message):
    me.heard += 1.0
    me.sum += message[0]
    me.lot = LOT


def fuse(me):
    me.lot = LOT
    me.x = me.own * me.n / max(me.t, 1.0) + (1.0 - me.own) * me.sum / max(me.heard, 1.0)
    me.heard = 0.0
    me.sum = 0.0


def estimate(me):
    return min(max(me.x, 0.0), 1.0)
'''
FIELDS = '''"""Ten numbers that decay and are said."""
MEMORY = {FIELDS"x": 0.5}
MESSAGE = (NAMES)


def observe(me, blacks, looks):
    share = blacks / max(looks, 1.0)
OBSERVE

def broadcast(me):
    return (SAID)


def receive(me, message):
RECEIVE

def fuse(me):
    me.x = min(max(SUM, 0.0), 1.0)


def estimate(me):
    return me.x
'''


def ten_fields():
    """Ten fields, written out."""
    return (
        FIELDS.replace("FIELDS", "".join(f'"a{k}": 0.1, ' for k in TEN))
        .replace("NAMES", "".join(f'"a{k}", ' for k in TEN))
        .replace("OBSERVE", "".join(f"    me.a{k} = 0.9 * me.a{k} + 0.01 * share\n" for k in TEN))
        .replace("SAID", "".join(f"me.a{k}, " for k in TEN))
        .replace("RECEIVE", "".join(f"    me.a{k} = 0.9 * me.a{k} + 0.1 * message[{k}]\n" for k in TEN))
        .replace("SUM", " + ".join(f"me.a{k}" for k in TEN))
    )


def vector_of_ten():
    """The same as a vector."""
    loop = "    for k in range(10):\n        "
    source = (
        FIELDS.replace("FIELDS", '"a": (0.1,) * 10, ')
        .replace("NAMES", '"a",')
        .replace("OBSERVE", f"{loop}me.a[k] = 0.9 * me.a[k] + 0.01 * share\n")
        .replace("SAID", "me.a,")
        .replace("RECEIVE", f"    said = message[0]\n{loop}me.a[k] = 0.9 * me.a[k] + 0.1 * said[k]\n")
    )
    return source.replace(
        "    me.x = min(max(SUM", f"    total = 0.0\n{loop}total += me.a[k]\n    me.x = min(max(total"
    )


def cases():
    """Pairs of brains that differ in one thing: what, one, other, and in how many calls a ring's round differs."""
    without, lucky = PLAIN.replace("LOT", "me.own"), PLAIN.replace("LOT", "me.luck")
    silent = without.replace("    return (me.x,)\n", "    if me.x < -1.0:\n        return None\n    return (me.x,)\n")
    decides = without + "\n\ndef decide(me):\n    return 1 if me.x > 0.5 else 0\n"
    return [
        ("luck: none, four draws", without, lucky, 4),
        ("ten numbers: fields, a vector", ten_fields(), vector_of_ten(), None),
        ("silence: never, perhaps", without, silent, None),
        ("decision: none, each round", without, decides, None),
    ]


def study(brain, robots, moving):
    world = {"topology": "moving", "density": 5.0} if moving else {"topology": "ring"}
    length = {"ticks": 1000} if moving else {"rounds": 1000}
    return Study(
        trials=1, swarm={"brain": brain, "robots": robots, "accuracy": 0.675}, world=world | {"fill_ratio": 0.55},
        schedule=length,
    ).settings()[0]  # fmt: skip


def cost(settings, repeats):
    """The least ns a robot and round of each of some settings, timed in turn: the machine's speed varies."""
    best = [float("inf")] * len(settings)
    for _ in range(repeats + 1):  # the first compiles
        for k, setting in enumerate(settings):
            begun = time.perf_counter()
            if setting.body:
                run_ride([setting], 1, 0, MOST, GO)
            else:
                run_batch(setting, 1, 0, 1, MOST, GO)
            best[k] = min(best[k], time.perf_counter() - begun)
    return [1e9 * one / (setting.robots * setting.rounds) for one, setting in zip(best, settings, strict=True)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repeats")
    quick = parser.parse_args().quick
    console = Console(width=110)
    table = Table("what", "world", "one", "other", "difference", "ns a draw", title="ns per robot and round, one core")
    for what, *sources, draws in cases():
        pair = [brains.parse(source, f"{k}.py", Path(f"{k}.py")) for k, source in enumerate(sources)]
        for moving in (False, True):
            one, other = cost([study(brain, 100, moving) for brain in pair], 3 if quick else 15)
            each = f"{(other - one) / draws:.2f}" if draws and not moving else ""
            world = "moving, walk included" if moving else "ring"
            table.add_row(what, world, f"{one:.1f}", f"{other:.1f}", f"{other - one:+.1f}", each)
    console.print(table)
    brain = brains.parse(PLAIN.replace("LOT", "me.own"), "new.py", Path("new.py"))
    value = time.time() % 1.0
    begun = time.perf_counter()
    run_batch(study(brain.with_parameters({"own": value}), 10, False), 1, 0, 1, MOST, GO)
    parameter = time.perf_counter() - begun
    constant = brains.parse(PLAIN.replace("LOT", f"{value!r}"), "new.py", Path("new.py"))
    begun = time.perf_counter()
    run_batch(study(constant, 10, False), 1, 0, 1, MOST, GO)
    console.print(
        f"until a new value runs: {1e3 * parameter:.1f} ms as a parameter, "
        f"{1e3 * (time.perf_counter() - begun):.0f} ms as a constant in a function"
    )


if __name__ == "__main__":
    main()
