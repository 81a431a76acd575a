"""What brains cost beside the paper's: `python benchmarks/brains.py [BRAIN...] [--single | --against FOLDER]`.

CPU time of a study's trials of 100 robots as a multiple of what `minimalistic` takes right before: the median of eleven
ratios, brains in turn. By default of those that share everything. Four minutes on a quiet machine.

With --single, every brain in single precision as a multiple of the same brain in double. With --against, every shipped
brain as a multiple of the file of the same name in a folder, such as files of an earlier release. Both take the least
of 40 times in turn, on fixed networks: the same twice differs by up to 2 % on a quiet machine. Ten seconds a brain.
"""

import argparse
import time
from pathlib import Path
from statistics import median

import numpy as np

import swarmcensus as sc
from swarmcensus.simulation.trials import Metrics, run_batch

WORLDS = {
    "ring": {"topology": "ring"},
    "full": {"topology": "full"},
    "ring, half lost": {"topology": "ring", "link_success": 0.5},
    "moving, D = 10": {"topology": "moving", "density": 10},
}
BRAINS = ["commons", "swift", "sure", "steadfast", "tracking", "self-taught", "census"]


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


def seconds(brain, world):
    """The CPU time of one run."""
    begun = time.process_time()
    sc.run(study(brain, world), jobs=1)
    return time.process_time() - begun


def beside_the_papers(brain, world):
    """The cost of a brain in a world as a multiple of the paper's."""
    ratios = []
    for _ in range(12):  # the first compiles
        usual = seconds("minimalistic", world)
        ratios.append(seconds(brain, world) / usual)
    return median(ratios[1:])


def beside(new, old, world):
    """The cost of one (brain, precision) as a multiple of another's: rounds alone, without a run's start and end."""
    settings = [study(brain, world, 1, precision).settings()[0] for brain, precision in (new, old)]
    least = [float("inf")] * 2
    for _ in range(41):  # the first compiles, and is not the least
        for k, setting in enumerate(settings):
            begun = time.process_time()
            run_batch(setting, 1, 0, 3, Metrics(0.01, 10, ()), np.zeros(1, np.uint8))
            least[k] = min(least[k], time.process_time() - begun)
    return least[0] / least[1]


def main(chosen, single, against):
    """A line a world."""
    print(f"{'':16}", *(f"{name:>12}" for name in chosen))
    for name, world in WORLDS.items():
        if "density" in world and (single or against):
            continue
        print(f"{name:16}", end="", flush=True)
        for brain in chosen:
            if single:
                ratio = beside((brain, "single"), (brain, "double"), world)
            elif against:
                ratio = beside((brain, "double"), (str(against / f"{brain}.py"), "double"), world)
            else:
                ratio = beside_the_papers(brain, world)
            print(f" {ratio:12.3f}", end="", flush=True)
        print()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("brains", nargs="*", default=BRAINS)
    parser.add_argument("--single", action="store_true", help="single precision beside double")
    parser.add_argument("--against", type=Path, help="a folder of brain files to compare with")
    given = parser.parse_args()
    main(given.brains, given.single, given.against)
