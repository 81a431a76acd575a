"""What a graphics card gains: python benchmarks/gpu.py [--check] [--quick] [--emulated].

Without --check: seconds of the CPU's engine with all cores, of the kernels alone, of a whole `run` from study to file,
and of the same swarm in JAX, where that is installed. With --check: whether a card gives the bits of the CPU on a
hundred random studies. --emulated runs the kernels by g++ on the CPU, to try this file where there is no card.
"""

import sys
import tempfile
import time
import warnings
from pathlib import Path

import harness
from swarm_in_jax import seconds_in_jax

import swarmcensus as sc
from swarmcensus.gpu import Card, CardError, open_driver
from swarmcensus.runs import devices
from swarmcensus.runs.tasks import metrics_of

sys.path.insert(0, str(harness.ROOT))
from tests.support.emulator import Emulator
from tests.support.random_studies import differences, random_study

STUDIES = 100
MILLION = 1_000_000


def networks(brain="minimalistic", robots=100, topology="ring", rounds=1000, trials=3000, accuracy=0.7):
    """A study of one network."""
    return sc.Study(
        name="gpu", seed=1, trials=trials, swarm={"brain": brain, "robots": robots, "accuracy": accuracy},
        world={"topology": topology, "fill_ratio": 0.55}, schedule={"rounds": rounds, "observations_per_round": 10},
    )  # fmt: skip


def works(quick):
    """The studies by name, and whether JAX runs the same."""
    few = 500 if quick else 1
    yield "ring of 100, 1,000 rounds, 3,000 trials", networks(trials=3000 // few), True
    yield "full network of 100, 1,000 rounds, 30 trials", networks(topology="full", trials=30), True
    crowd = {"robots": MILLION // few, "rounds": 100, "trials": 1}
    yield f"ring of {MILLION // few:,}, 100 rounds", networks(**crowd), True
    yield "the same, random accuracies", networks(**crowd, accuracy="U(0.525, 0.975)"), False
    yield "the same, scale-free", networks(**crowd, topology="scale-free"), False
    yield "census, ring of 100, 1,000 rounds, 600 trials", networks("census", trials=600 // few), False
    paper = sc.Study.load(harness.ROOT / "studies" / "paper" / "topologies.toml")
    small = {"brain": "minimalistic", "robots": 10, "accuracy": 0.675}
    yield "the paper's static runs", paper.with_(swarm=small) if quick else paper, False
    board = sc.Study.load(harness.ROOT / "studies" / "leaderboard.toml").with_(trials=1 if quick else 10)
    yield "the leaderboard's worlds, 10 trials", board, False


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
    """Seconds of a run from the study to its file."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        begun = time.perf_counter()
        sc.run(study, progress=False, out=Path(folder) / "out.nc", device=device, cautions=False)
        return time.perf_counter() - begun


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
def gpu(check=False, emulated=False, quick=False):
    """Print the table, or with `check` whether the bits are those of the CPU."""
    try:
        driver = Emulator(level="-O1") if emulated else open_driver()
    except CardError as error:
        sys.exit(f"benchmarks/gpu.py: {error}")
    if check:
        return compare(Card(driver), 5 if quick else STUDIES)
    timed = Timed(driver)
    card = Card(timed)
    devices.the_card = lambda: card
    table = harness.table(f"Seconds on {card.name}", "work", "CPU, all cores", "kernels", "whole run", "JAX")
    for name, study, in_jax in works(quick):
        print(name, file=sys.stderr, flush=True)
        whole(study, "gpu"), whole(study, "cpu")  # compiles
        alone = min(kernels(timed, study) for _ in range(1 if quick else 3))
        cpu, run = (min(whole(study, device) for _ in range(1 if quick else 2)) for device in ("cpu", "gpu"))
        theirs = seconds_in_jax(study) if in_jax else None
        table.add_row(name, f"{cpu:.2f}", f"{alone:.4f}", f"{run:.2f}", "-" if theirs is None else f"{theirs:.4f}")
    return harness.show(table)


def compare(card, studies):
    """Compare random studies bit by bit; those of brains with exp, log or lgamma may differ in a few places."""
    begun, differ, ran = time.perf_counter(), [], 0
    for number in range(studies):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            study = random_study(number)
            found = differences(card, study)
        ran += 1
        if found:
            differ.append(number)
            print(f"study {number}: {study.swarm.brain[0].name}: {'; '.join(found[:5])}", flush=True)
    print(f"{card.name}: {ran - len(differ)} of {ran} random studies have every bit of the CPU, in "
          f"{time.perf_counter() - begun:.0f} s")  # fmt: skip


if __name__ == "__main__":
    harness.answer(globals())
