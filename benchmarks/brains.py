"""What brains and metrics cost: python benchmarks/brains.py [QUESTION] [--quick].

`beside` and the two questions that have to be named compare brains with each other; `parts` prints what the optional
parts of the contract cost, and `metrics` what metrics of files cost.
"""

import json
import tempfile
import time
from functools import partial
from pathlib import Path

import harness
import single_lives

import swarmcensus as sc
from swarmcensus.brains import load, parse
from swarmcensus.brains.brain import shipped
from swarmcensus.brains.metrics import PLUGINS
from swarmcensus.checks import lives_in_single
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics, run_batch

WORLDS = {
    "ring": {"topology": "ring"},
    "full": {"topology": "full"},
    "ring, half lost": {"topology": "ring", "link_success": 0.5},
    "moving, D = 10": {"topology": "moving", "density": 10},
}
BRAINS = ["commons", "swift", "sure", "steadfast", "tracking", "self-taught", "census"]
FIXED = [name for name, world in WORLDS.items() if "density" not in world]
MOST = Metrics(0.01, 10, ())
ROBOTS, ROUNDS, TRIALS = 100, 1000, 10  # of metrics


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


TEN = range(10)


COMPILE = """
import sys, time, numpy as np
from swarmcensus.engine.compiler import blank_record, compile_metric
from swarmcensus.brains.metrics import load
known = load("largest-jump" if sys.argv[1] == "mean-error" else "mean-error")  # compiles what Numba itself needs
blank = blank_record(known, rounds=1.0)
compile_metric(known).follow(blank, blank.repeat(2), np.zeros((1, 2)), 1, np.full((1, 3), 0.5), np.zeros(2))
begun = time.perf_counter()
metric = load(sys.argv[1])
blank = blank_record(metric, rounds=1.0)
compile_metric(metric).follow(blank, blank.repeat(2), np.zeros((1, 2)), 1, np.full((1, 3), 0.5), np.zeros(2))
print(time.perf_counter() - begun)
"""


def study(brain, world, trials=20, precision="double"):
    """One brain in one world."""
    return sc.Study(
        trials=trials,
        seed=1,
        swarm={"brain": brain, "robots": 100, "accuracy": 0.675, "precision": precision},
        world=world | {"fill_ratio": 0.55},
        schedule={"ticks": 1000} if "density" in world else {"rounds": 1000, "observations_per_round": 10},
        measure={"local": False},
    )


def by_world(brains, measure, worlds):
    """A row a world: what `measure` finds of each brain there."""
    table = harness.table("as a multiple", "world", *brains)
    for name in worlds:
        table.add_row(name, *(f"{measure(brain, WORLDS[name]):.3f}" for brain in brains))
    harness.show(table)


def first_apart(name):
    """The reading at which single and double precision part, in a day, or from 2^20, 2^21, ..., 2^26 readings on.

    There a brain begins with so many readings at once, so that counts come to the end of what float32 can count.
    """
    found = single_lives.life(load(name), [(0, single_lives.DAY), *((1 << power, 1 << 19) for power in range(20, 27))])
    return min((at for at in found if at is not None), default=None)


@harness.question(unasked=False)
def lives():
    """How long all shipped brains live in single precision, which `list brains` says. Minutes."""
    lives_in_single.TABLE.write_text(json.dumps({name: first_apart(name) for name in shipped()}, indent=2) + "\n")


@harness.question
def beside(*brains, quick=False):
    """Processor time of a study's trials as a multiple of what `minimalistic` takes: four minutes."""

    def measure(brain, world):
        whole = [study(one, world, 2 if quick else 20) for one in (brain, "minimalistic")]
        runs = [partial(sc.run, one, jobs=1) for one in whole]
        return harness.ratio(*runs, 3 if quick else 11, time.process_time).value

    by_world(brains or BRAINS, measure, WORLDS)


def rounds_of(brain, world, precision="double"):
    """A call that runs three trials' rounds alone, without a run's start and end."""
    [setting] = study(brain, world, 1, precision).settings()
    return partial(run_batch, setting, 1, 0, 3, MOST, harness.GO)


def against_each_other(one, other, repeats):
    """The least of many: the same twice differs by up to 2 % on a quiet machine."""
    spent = harness.least([one, other], repeats, time.process_time)
    return spent[0] / spent[1]


@harness.question(unasked=False)
def single(*brains, quick=False):
    """Single precision as a multiple of double, on fixed networks: ten seconds a brain."""

    def measure(brain, world):
        return against_each_other(rounds_of(brain, world, "single"), rounds_of(brain, world), 3 if quick else 41)

    by_world(brains or BRAINS, measure, FIXED)


@harness.question(unasked=False)
def against(folder, *brains, quick=False):
    """Shipped brains as a multiple of the files of the same names in a folder, such as those of an earlier release."""

    def measure(brain, world):
        old = rounds_of(str(Path(folder) / f"{brain.replace('-', '_')}.py"), world)
        return against_each_other(rounds_of(brain, world), old, 3 if quick else 41)

    by_world(brains or BRAINS, measure, FIXED)


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
    without, drawing = PLAIN.replace("LOT", "me.own"), PLAIN.replace("LOT", "me.luck")
    silent = without.replace("    return (me.x,)\n", "    if me.x < -1.0:\n        return None\n    return (me.x,)\n")
    decides = without + "\n\ndef decide(me):\n    return 1 if me.x > 0.5 else 0\n"
    return [
        ("luck: none, four draws", without, drawing, 4),
        ("ten numbers: fields, a vector", ten_fields(), vector_of_ten(), None),
        ("silence: never, perhaps", without, silent, None),
        ("decision: none, each round", without, decides, None),
    ]


def one_setting(source, moving, robots=100):
    """A brain of this source on a ring, or among robots that move."""
    used = parse(source, "some.py", Path("some.py"))
    world = {"topology": "moving", "density": 5.0} if moving else {"topology": "ring"}
    return sc.Study(
        trials=1,
        swarm={"brain": used, "robots": robots, "accuracy": 0.675},
        world=world | {"fill_ratio": 0.55},
        schedule={"ticks": 1000} if moving else {"rounds": 1000},
    ).settings()[0]


def once(setting):
    """Run a trial."""
    if setting.body:
        run_ride([setting], 1, 0, MOST, harness.GO)
    else:
        run_batch(setting, 1, 0, 1, MOST, harness.GO)


@harness.question
def parts(quick=False):
    """Random draws, vectors, silence and decisions: brains that differ in one of them; and a parameter's new value."""
    table = harness.table(
        "ns per robot and round, one core", "what", "world", "one", "other", "difference", "ns a draw"
    )
    for what, *sources, draws in cases():
        for moving in (False, True):
            settings = [one_setting(source, moving) for source in sources]
            runs = [partial(once, setting) for setting in settings]
            one, other = harness.least(runs, 4 if quick else 16) * 1e9 / (100 * 1000)  # the first compiles
            each = f"{(other - one) / draws:.2f}" if draws and not moving else ""
            world = "moving, walk included" if moving else "ring"
            table.add_row(what, world, f"{one:.1f}", f"{other:.1f}", f"{other - one:+.1f}", each)
    harness.show(table)
    value = time.time() % 1.0
    plain = parse(PLAIN.replace("LOT", "me.own"), "new.py", Path("new.py")).with_parameters({"own": value})
    constant = parse(PLAIN.replace("LOT", f"{value!r}"), "new.py", Path("new.py"))
    settings = [study(brain, WORLDS["ring"], 1).settings()[0] for brain in (plain, constant)]
    parameter, other = harness.least([partial(once, setting) for setting in settings], 1)
    harness.show(f"until a new value runs: {1e3 * parameter:.1f} ms as a parameter, {1e3 * other:.0f} ms as a constant")


def compiled_in(name):
    """Seconds until a metric is compiled on a machine that never saw it."""
    with tempfile.TemporaryDirectory() as cache:
        return float(harness.process("-c", COMPILE, name, cache=cache).out)


@harness.question
def metrics(quick=False):
    """A ring of 100 robots without metrics of files, with each shipped one and with all, and how long each compiles."""
    asked = {"none": [], **{name: [name] for name in PLUGINS.shipped}, "all of them": list(PLUGINS.shipped)}
    runs = []
    for names in asked.values():
        whole = sc.Study(
            trials=TRIALS,
            swarm={"robots": ROBOTS, "accuracy": 0.7},
            world={"topology": "ring", "fill_ratio": 0.55},
            schedule={"rounds": ROUNDS},
            measure={"metrics": names},
        )
        runs.append(partial(run_batch, whole.settings()[0], whole.seed, 0, TRIALS, metrics_of(whole), harness.GO))
    spent = dict(zip(asked, harness.least(runs, 4 if quick else 16), strict=True))
    table = harness.table(f"ring of {ROBOTS} robots", "metrics", "ns a robot and round", "ratio", "compiled in")
    for what, seconds in spent.items():
        compiled = f"{compiled_in(what):.1f} s" if what in PLUGINS.shipped and not quick else "-"
        cost = 1e9 * seconds / (ROBOTS * ROUNDS * TRIALS)
        table.add_row(what, f"{cost:.1f}", f"{seconds / spent['none']:.2f}", compiled)
    harness.show(table)


if __name__ == "__main__":
    harness.answer(globals())
