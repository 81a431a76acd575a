"""Brains that share everything beside the paper's: `python benchmarks/beyond.py [FIGURE.png]`.

Prints medians of the cells that docs/beyond.md begins with, the first rounds of swarms with poor sensors, and what the
weights of unequal sensors cost; and draws how the error falls on a ring of 100, round by round, beside theory's bounds.
Two minutes on two cores.
"""

import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

import swarmcensus as sc
from swarmcensus import theory

TRIALS = 100
BRAINS = {"minimalistic": "#0072B2", "commons": "#D55E00", "swift": "#009E73"}


def ring(accuracy, topology="ring", rounds=1000):
    """A study of 100 robots that hold still."""
    return sc.Study(
        trials=TRIALS,
        seed=13,
        swarm={"brain": list(BRAINS), "robots": 100, "accuracy": accuracy},
        world={"topology": topology, "fill_ratio": 0.55},
        schedule={"rounds": rounds, "observations_per_round": 10},
    )


def moving(accuracy, density):
    """A study of 100 robots that move for 1,000 s."""
    return sc.Study(
        trials=TRIALS,
        seed=13,
        swarm={"brain": list(BRAINS), "robots": 100, "accuracy": accuracy},
        world={"topology": "moving", "density": density, "fill_ratio": 0.55},
        schedule={"ticks": 10000},
    )


def tell(name, results):
    """A line a brain: median final error, median K."""
    errors = np.abs(results["final_estimate"] - 0.55).median(("trial", "robot")).values
    settled = results["convergence_round"].median(("trial", "robot")).values
    for brain, error, k in zip(results["brain"].values, errors, settled, strict=True):
        print(f"{name:34} {brain:14} error {error:.4f}   K {k:6.0f}", flush=True)


def tell_early():
    """In how many cells the mean error at round 10 is above the paper's, and which."""
    study = sc.Study(
        trials=60,
        seed=13,
        swarm={"brain": list(BRAINS), "robots": 100, "accuracy": [0.525, 0.575]},
        world={
            "topology": ["full", "ring", "scale-free"],
            "fill_ratio": [0.55, 0.75, 0.95],
            "link_success": [1.0, 0.5, 0.1],
        },
        schedule={"rounds": 10, "observations_per_round": 10},
    )
    results = sc.run(study)
    errors = np.abs(results["final_estimate"] - results["fill_ratio"]).mean(("trial", "robot")).values
    cells = [
        results[name].values.reshape(len(BRAINS), -1)[0]
        for name in ("topology", "accuracy", "fill_ratio", "link_success")
    ]
    paper, *others = errors.reshape(len(BRAINS), -1)
    for brain, other in zip(list(BRAINS)[1:], others, strict=True):
        worse = np.flatnonzero(other > paper)
        print(f"round 10: the mean error of {brain} is above the paper's in {worse.size} of {paper.size} cells")
        for i in worse:
            print("  ", *(cell[i] for cell in cells), f"by {other[i] / paper[i] - 1:.1%}")


def tell_weights():
    """What weights of k^2 leave of the information, where sensors are U(0.525, 0.975)."""
    b = np.linspace(0.525, 0.975, 10_001)
    weight = (2.0 * b - 1.0) ** 2
    for f in (0.55, 0.75, 0.95, 0.99):
        variance = np.sum(weight**2 * theory.reading_variance(f, b)) / np.sum(weight) ** 2
        print(f"weights of k^2, f = {f}: {1.0 / variance / np.sum(theory.information(f, b)):.3f} of the information")


def draw(results, path):
    """The median error of all robots and trials after each round, and what theory allows."""
    matplotlib.use("agg")
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    rounds = np.arange(1, 1001)
    for setting, (brain, colour) in enumerate(BRAINS.items()):
        lives = [sc.replay(results, setting=setting, trial=trial)["estimate"].values[1:] for trial in range(TRIALS)]
        errors = np.median(np.abs(np.stack(lives) - 0.55), axis=(0, 2))
        axes.plot(rounds, errors, color=colour, lw=2.0, label=brain)
    accuracy = 0.525
    bounds = {
        "a robot alone": theory.robot_bound(10 * rounds, 0.55, accuracy),
        "a neighbourhood of three": theory.robot_bound(30 * rounds, 0.55, accuracy),
        "the whole swarm": theory.swarm_bound(10 * rounds, 0.55, np.full(100, accuracy)),
    }
    for dashes, (name, variance) in zip((":", "--", "-."), bounds.items(), strict=True):
        axes.plot(rounds, theory.median_error(variance), color="0.35", lw=1.0, ls=dashes, label=f"bound: {name}")
    axes.set(xscale="log", yscale="log", xlim=(1, 1000), ylim=(0.004, 0.5))
    axes.set(xlabel="round of communication", ylabel="median error |x - f|")
    axes.set_title("100 robots on a ring, 10 readings a round, b = w = 0.525", fontsize=10)
    axes.legend(fontsize=8, frameon=False, loc="lower left")
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=160)


def main():
    """All cells, and the figure if a path is given."""
    poor = sc.run(ring(0.525))
    tell("ring, 0.525", poor)
    tell("ring, 0.625", sc.run(ring(0.625)))
    tell("ring, U(0.525, 0.975)", sc.run(ring("U(0.525, 0.975)")))
    tell("scale-free, U(0.525, 0.975)", sc.run(ring("U(0.525, 0.975)", "scale-free")))
    tell("moving, D = 10, 0.875", sc.run(moving(0.875, 10)))
    tell("moving, D = 1, 0.525", sc.run(moving(0.525, 1)))
    tell_early()
    tell_weights()
    if len(sys.argv) > 1:
        draw(poor, sys.argv[1])


if __name__ == "__main__":
    main()
