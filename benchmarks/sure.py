"""How often the intervals of `sure` hold, and how many robots stop on a wrong answer: `python benchmarks/sure.py`.

Coverage in every cell of a grid, stops in every world of studies/beyond.toml; lines for the extremes, and for how they
lie. Twenty minutes on two cores.
"""

import tomllib
from pathlib import Path

import numpy as np

import swarmcensus as sc
from swarmcensus import theory

WORLDS = Path(__file__).parents[1] / "studies" / "beyond.toml"
SENSORS = [0.525, 0.875, 1.0, "U(0.525, 0.975)"]


def cell(results, i):
    """What a setting is, in a line."""
    names = ("robots", "topology", "accuracy", "fill_ratio", "link_success")
    return " ".join(str(results[name].values[i]) for name in names)


def coverage():
    """Shares of robots whose interval holds f, cell by cell and at each checkpoint."""
    brain = {"file": "sure", "within": 1e-9, "alpha": [0.05, 0.2]}
    study = sc.Study(
        trials=400,
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
    """Shares of robots that stop on a wrong answer, and when they do, beside who knew all readings."""
    alpha, within, rounds = 0.05, 0.05, 1016
    tables = tomllib.loads(WORLDS.read_text(encoding="utf-8"))
    tables["trials"] = 50
    tables["swarm"]["brain"] = {"file": "sure", "within": within, "alpha": alpha}
    tables["schedule"]["rounds"] = rounds
    tables["measure"]["checkpoints"] = [rounds]
    results = sc.run(sc.Study(**tables))
    at, said = results["done_round"].values, results["done_estimate"].values
    there, done = np.isfinite(results["final_estimate"].values), np.isfinite(said)
    truth = results["fill_ratio"].values
    off = np.abs(said - truth[:, None, None]) > within
    wrong = np.where(there, off, np.nan)
    wrong = np.nansum(wrong, axis=2) / there.sum(axis=2)
    mean, error = wrong.mean(axis=1), wrong.std(axis=1, ddof=1) / wrong.shape[1] ** 0.5
    print(f"stopped: {done.sum() / there.sum():.1%} of robots, {off[there].mean():.2%} of all on a wrong answer;")
    print(f"  above {alpha} in {(mean > alpha).sum()} of {mean.size:,} cells, surely so in", end=" ")
    print(f"{(mean - 1.96 * error > alpha).sum()}; most in")
    for i in np.argsort(-mean)[:5]:
        print(f"  {cell(results, i)}: {mean[i]:.1%} +- {1.96 * error[i]:.1%}")
    variance = float(theory.reading_variance(0.55, 0.625))
    for i in range(mean.size):
        robots = int(results["robots"].values[i])
        if cell(results, i).endswith(" 0.625 0.55 1.0") and robots == 100:
            needed = (1.96 / within) ** 2 * variance / 10 / robots
            when = f"round {np.median(at[i][done[i]]):.0f}" if done[i].any() else "nobody"
            print(f"  {cell(results, i)}: {when}, oracle {max(needed, 1.0):.1f}")


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
