"""How often the intervals of `sure` hold, and how many robots stop on a wrong answer: `python benchmarks/sure.py`.

Every cell of two grids; lines for the extremes, and for how they lie. Five minutes on two cores.
"""

import numpy as np

import swarmcensus as sc
from swarmcensus import theory

SENSORS = [0.525, 0.875, 1.0, "U(0.525, 0.975)"]


def cell(results, i):
    """What a setting is, in a line."""
    names = ("robots", "topology", "accuracy", "fill_ratio", "link_success")
    return " ".join(str(results[name].values[i]) for name in names)


def coverage():
    """Shares of robots whose interval holds f, cell by cell and at each checkpoint."""
    brain = {"file": "sure", "within": 1e-9, "alpha": [0.05, 0.2]}
    study = sc.Study(
        trials=100,
        seed=13,
        swarm={"brain": brain, "robots": [10, 40], "accuracy": SENSORS},
        world={"topology": ["full", "ring", "scale-free"], "fill_ratio": [0.55, 0.95], "link_success": [1.0, 0.3]},
        schedule={"rounds": 248, "observations_per_round": 10},
        measure={"checkpoints": [20, 56, 120, 248]},
    )
    results = sc.run(study)
    shares = results["coverage"].values
    mean, error = shares.mean(axis=2), shares.std(axis=2, ddof=1) / shares.shape[2] ** 0.5
    for alpha in (0.05, 0.2):
        rows = results["alpha"].values == alpha
        off, sd = mean[rows] - (1 - alpha), error[rows]
        low, high, middle = mean[rows].min(), mean[rows].max(), mean[rows].mean()
        print(f"alpha = {alpha}: {off.size} shares from {low:.3f} to {high:.3f}, mean {middle:.4f}")
        beyond = np.abs(off) > 0.015 + 1.96 * sd
        below = (beyond & (off < 0)).sum()
        print(f"  beyond 1.5 points by more than its 95 % interval: {beyond.sum()}, of them below: {below}")
        row, at = np.unravel_index(mean[rows].argmin(), off.shape)
        print(f"  lowest: {cell(results, np.flatnonzero(rows)[row])} at round {results['checkpoint'].values[at]}")


def stops():
    """Shares of robots that stop on a wrong answer, and when they stop."""
    brain = {"file": "sure", "within": [0.02, 0.05]}
    study = sc.Study(
        trials=100,
        seed=14,
        swarm={"brain": brain, "robots": [10, 40], "accuracy": [0.625, *SENSORS[1:]]},
        world={"topology": ["full", "ring", "scale-free"], "fill_ratio": [0.05, 0.55], "link_success": [1.0, 0.3]},
        schedule={"rounds": 1016, "observations_per_round": 10},
        measure={"checkpoints": [1016]},
    )
    results = sc.run(study)
    at, said = results["done_round"].values, results["done_estimate"].values
    there, done = np.isfinite(results["final_estimate"].values), np.isfinite(said)
    truth, within = results["fill_ratio"].values, results["within"].values
    wrong = np.nanmean(np.where(there, np.abs(said - truth[:, None, None]) > within[:, None, None], np.nan), axis=2)
    mean, error = wrong.mean(axis=1), wrong.std(axis=1, ddof=1) / wrong.shape[1] ** 0.5
    worst = mean.argmax()
    print(f"stopped: {done.sum() / there.sum():.1%} of all robots, {mean.mean():.2%} on a wrong answer;")
    print(f"  most of {len(mean)} cells {mean[worst]:.1%} +- {1.96 * error[worst]:.1%}:")
    print(f"  {cell(results, worst)} within {within[worst]}")
    variance = float(theory.reading_variance(0.55, 0.625))
    for i in np.flatnonzero([cell(results, i) == "40 ring 0.625 0.55 1.0" for i in range(len(at))]):
        needed = (1.96 / within[i]) ** 2 * variance / 400
        print(f"  {cell(results, i)} within {within[i]}: round {np.median(at[i][done[i]]):.0f}, oracle {needed:.0f}")


def patches():
    """The same among robots that move over clusters, held against the floor's own share."""
    study = sc.Study(
        trials=40,
        seed=15,
        swarm={"brain": {"file": "sure", "within": 1e-9}, "robots": 30, "accuracy": [0.525, 0.875, 1.0]},
        world={
            "topology": "moving",
            "density": [1, 10],
            "fill_ratio": [0.55, 0.95],
            "floor": ["tiles", {"clusters": 0.3}],
        },
        schedule={"ticks": 2040},
        measure={"truth": "floor", "checkpoints": [504, 1016, 2040]},
    )
    results = sc.run(study)
    mean = results["coverage"].mean("trial").values
    for floor in dict.fromkeys(results["floor"].values):
        rows = mean[results["floor"].values == floor]
        print(f"moving, floor {floor}: shares from {rows.min():.2f} to {rows.max():.2f}, mean {rows.mean():.3f}")


if __name__ == "__main__":
    coverage()
    stops()
    patches()
