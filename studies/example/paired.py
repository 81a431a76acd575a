"""How two brains of a study differ, trial by trial: python paired.py RESULTS.nc BRAIN BRAIN.

Prints, for each setting that both have, the median error of the final estimates of either, and the difference of
the trials' medians, each with its 95 % interval by bootstrap over trials.
"""

import sys

import numpy as np

import swarmcensus as sc
from swarmcensus.support import intervals

ALIKE = ("floor", "fill_ratio", "accuracy", "assumed_accuracy", "topology", "robots", "density", "link_success")


def errors(results, brain):
    """The errors (trial, robot) of all settings of a brain, by all else that they are."""
    off = np.abs(results["final_estimate"] - results["fill_ratio"])
    return {
        tuple(str(results[name].values[k]) for name in ALIKE): off.values[k][:, : int(results["robots"][k])]
        for k in np.flatnonzero(results["brain"] == brain)
    }


def main(path, one, other):
    results = sc.load(path)
    counts = intervals.resample(results.sizes["trial"])
    before, after = errors(results, one), errors(results, other)
    print(f"{'floor':14} {'f':5} {'accuracy':9} {one:25} {other:25} difference")
    for setting in sorted(before.keys() & after.keys()):
        medians = [intervals.medians(each[setting], counts) for each in (before, after)]
        difference = np.median(after[setting], axis=1) - np.median(before[setting], axis=1)
        columns = [*map(intervals.interval, medians), intervals.interval(intervals.means(difference, counts))]
        shown = (f"{value:.4f} [{low:.4f}, {high:.4f}]" for value, low, high in columns)
        print(f"{setting[0]:14} {setting[1]:5} {setting[2]:9}", *(f"{text:25}" for text in shown))


if __name__ == "__main__":
    main(*sys.argv[1:])
