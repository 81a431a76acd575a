"""What brains cost beside the paper's: `python benchmarks/brains.py [BRAIN...]`.

CPU time of a study's trials of 100 robots as a multiple of what `minimalistic` takes right before: the median of eleven
ratios, brains in turn. By default of those that share everything. Six minutes on a quiet machine.
"""

import sys
import time
from statistics import median

import swarmcensus as sc

WORLDS = {
    "ring": {"topology": "ring"},
    "full": {"topology": "full"},
    "ring, half lost": {"topology": "ring", "link_success": 0.5},
    "moving, D = 10": {"topology": "moving", "density": 10},
}
BRAINS = ["commons", "swift", "sure", "steadfast", "tracking", "self-taught"]


def study(brain, world):
    """One brain in one world."""
    return sc.Study(
        trials=20,
        seed=1,
        swarm={"brain": brain, "robots": 100, "accuracy": 0.675},
        world=world | {"fill_ratio": 0.55},
        schedule={"ticks": 1000} if "density" in world else {"rounds": 1000, "observations_per_round": 10},
        measure={"local": False},
    )


def seconds(brain, world):
    """The CPU time of one run."""
    begun = time.process_time()
    sc.run(study(brain, world), jobs=1)
    return time.process_time() - begun


def main(brains):
    """A line a world."""
    print(f"{'':16}", *(f"{name:>12}" for name in brains))
    for name, world in WORLDS.items():
        ratios = {brain: [] for brain in brains}
        for k in range(12):  # the first compiles
            for brain in brains:
                usual = seconds("minimalistic", world)
                ratios[brain] += [seconds(brain, world) / usual] * (k > 0)
        print(f"{name:16}", *(f"{median(ratios[brain]):12.2f}" for brain in brains), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or BRAINS)
