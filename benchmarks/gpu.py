"""What a graphics card gains: python benchmarks/gpu.py [--check] [--quick] [--emulated].

Without --check: seconds of the CPU's engine with all cores, of the kernels alone, of a whole `run` from study to file,
and of the same swarm in JAX, where that is installed; and which variables of the file differ from the CPU's. With
--check: whether a card gives the bits of the CPU on a wide swarm and on random studies, half of them cut as wide ones
are. --emulated runs the kernels by g++ on the CPU, where there is no card: only its bits count.
"""

import contextlib
import functools
import multiprocessing
import sys
import tempfile
import time
import warnings
from pathlib import Path

import harness
from swarm_in_jax import seconds_in_jax

import swarmcensus as sc
from swarmcensus.gpu import Card, CardError, cards, open_driver
from swarmcensus.runs import devices
from swarmcensus.runs.pools import tiny_settings
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation import run_batch
from swarmcensus.support.cores import cores

sys.path.insert(0, str(harness.ROOT))
from tests.support.emulator import Emulator
from tests.support.random_studies import differences, random_study

LONG = 2.0  # seconds of a run that is timed once
WIDE = {"SHARED": 0, "PIECE": 3, "CHUNK": 8}  # with these numbers of `cards`, small swarms run as large ones do
MILLION = 1_000_000


def networks(brain="minimalistic", robots=100, topology="ring", rounds=1000, trials=3000, accuracy=0.7):
    """A study of one network."""
    return sc.Study(
        name="gpu", seed=1, trials=trials, swarm={"brain": brain, "robots": robots, "accuracy": accuracy},
        world={"topology": topology, "fill_ratio": 0.55}, schedule={"rounds": rounds, "observations_per_round": 10},
    )  # fmt: skip


def works(quick):
    """The studies by name, and whether JAX runs the same."""
    few, trials = (500, 1) if quick else (1, 10)
    yield f"ring of 100, 1,000 rounds, {3000 // few:,} trials", networks(trials=3000 // few), True
    yield "full network of 100, 1,000 rounds, 30 trials", networks(topology="full", trials=30), True
    crowd = {"robots": MILLION // few, "rounds": 100, "trials": 1}
    yield f"ring of {MILLION // few:,}, 100 rounds", networks(**crowd), True
    yield "the same, random accuracies", networks(**crowd, accuracy="U(0.525, 0.975)"), False
    yield "the same, scale-free", networks(**crowd, topology="scale-free"), False
    yield f"census, ring of 100, 1,000 rounds, {60 * trials} trials", networks("census", trials=60 * trials), False
    paper = sc.Study.load(harness.ROOT / "studies" / "paper" / "topologies.toml")
    small = {"brain": "minimalistic", "robots": 10, "accuracy": 0.675}
    yield "the paper's static runs", paper.with_(swarm=small) if quick else paper, False
    board = sc.Study.load(harness.ROOT / "studies" / "leaderboard.toml")
    board = board.with_(
        world={"topology": "scale-free", "fill_ratio": [0.47, 0.88]}, trials=trials, accuracy=0.7,
        schedule={"rounds": 3000, "observations_per_round": 1}, case=[{"link_success": 0.5}], groups={},
        brain=["census", "voter"] if quick else None,
    )  # fmt: skip
    yield f"the leaderboard's networks, {trials} of its trials", board, False


class Timed:
    """A driver that sums up the seconds from the first launch of a batch to its end."""

    def __init__(self, driver):
        self.driver, self.seconds, self.begun = driver, 0.0, None

    def __getattr__(self, name):
        return getattr(self.driver, name)

    def launch(self, *given):
        self.begun = self.begun or time.perf_counter()
        self.driver.launch(*given)

    def wait(self, stop):
        done = self.driver.wait(stop)
        if self.begun:
            self.seconds += time.perf_counter() - self.begun
            self.begun = None
        return done


def whole(study, device):
    """Seconds of a run from the study to its file, and what it found."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        begun = time.perf_counter()
        found = sc.run(study, progress=False, out=Path(folder) / "out.nc", device=device, cautions=False)
        return time.perf_counter() - begun, found.load()


@functools.cache
def kinds(studies, quick):
    """A small setting for each kind of swarm in so many random studies, or in those of the table."""
    chosen = [random_study(n) for n in range(studies)] or [study for _, study, _ in works(quick)]
    return [(setting, metrics_of(study), local) for study in chosen for setting in tiny_settings(study.settings())
            for local in {False, study.measure.local}]  # fmt: skip


def compile_kind(number, *given):
    """Run a trial of a kind of swarm, for what that compiles."""
    setting, metrics, local = kinds(*given)[number]
    with contextlib.suppress(sc.InputError):
        run_batch(setting, 0, 0, 1, metrics, harness.GO, local)


def compile_on_cpu(*given):
    """Compile for the CPU in many processes: in one of them Numba takes one core."""
    with multiprocessing.get_context("spawn").Pool(cores()) as pool:
        pool.starmap(compile_kind, [(number, *given) for number in range(len(kinds(*given)))], 1)


def kernels(timed, study):
    """Seconds of the kernels of a study, whose robots do not move."""
    card, metrics = Card(timed), metrics_of(study)
    timed.seconds = 0.0
    for setting in study.settings():
        most = card.most_trials(setting, metrics)
        for first in range(0, study.trials if setting.body is None else 0, most):
            card.run_batch(setting, study.seed, first, min(most, study.trials - first), metrics, harness.GO)
    return timed.seconds


@harness.question
def gpu(check=False, studies=30, emulated=False, quick=False):
    """Print the table, or with `check` whether the bits of so many random studies are those of the CPU."""
    try:
        driver = Emulator(level="-O1") if emulated else open_driver()
    except CardError as error:
        sys.exit(f"benchmarks/gpu.py: {error}")
    quick |= emulated and not check
    studies = check * (5 if quick else studies)
    compile_on_cpu(studies, quick)
    if check:
        return compare(Card(driver), [random_study(number) for number in range(studies)])
    timed = Timed(driver)
    card = Card(timed)
    devices.the_card = lambda: card
    title = f"Seconds on {card.name}{', which is this processor: of smaller studies, and only bits count' * emulated}"
    table = harness.table(title, "work", "CPU, all cores", "kernels", "whole run", "JAX", "other than the CPU's")
    for name, study, in_jax in works(quick):
        print(name, end=": ", file=sys.stderr, flush=True)
        try:
            row = row_of(timed, study, in_jax, 1 if quick else 3)
        except sc.InputError as error:
            row = "-", "-", "-", "-", str(error)
        print(*row, sep=", ", file=sys.stderr, flush=True)
        table.add_row(name, *row)
    return harness.show(table)


def row_of(timed, study, in_jax, times):
    """What the table says of a study."""
    _, theirs = whole(study, "gpu")  # compiles
    seconds, ours = whole(study, "cpu")
    times = times if seconds < LONG else 1
    alone = min(kernels(timed, study) for _ in range(times))
    cpu, run = (min(whole(study, device)[0] for _ in range(times)) for device in ("cpu", "gpu"))
    jax = seconds_in_jax(study) if in_jax else None
    differ = [name for name in ours if not ours[name].equals(theirs[name])]
    return f"{cpu:.2f}", f"{alone:.4f}", f"{run:.2f}", "-" if jax is None else f"{jax:.4f}", ", ".join(differ) or "none"


def compare(card, studies):
    """Compare studies bit by bit; those of brains with exp, log or lgamma may differ in a few places."""
    begun, same, plain = time.perf_counter(), 0, {name: getattr(cards, name) for name in WIDE}
    wide = networks("commons", cards.PIECE + 616, rounds=70).with_(checkpoints=[1, 70], topology=["ring", "full"])
    for way, some in ((plain, [wide, *studies[::2]]), (WIDE, studies[1::2])):
        vars(cards).update(way)
        ways = [(study, local) for study in some for local in {False, study.measure.local}]
        with contextlib.suppress(sc.InputError):
            card.compile_for({(setting, local) for study, local in ways for setting in study.settings()}, 0)
        for study in some:
            try:
                found = differences(card, study)
            except sc.InputError as error:
                found = [str(error)]
            same += not found
            print(f"{study.swarm.brain[0].name}, seed {study.seed}: {'; '.join(found[:5]) or 'same'}", flush=True)
    took = time.perf_counter() - begun
    print(f"{card.name}: {same} of {len(studies) + 1} studies have every bit of the CPU, in {took:.0f} s")


if __name__ == "__main__":
    harness.answer(globals())
