"""Brains on a floor that changes: `python benchmarks/changing.py [FIGURE.png]`. A minute on two cores.

Prints the median error over robots and trials at some rounds around the change, which the figure shows round by round.
"""

import sys

import drawing
import numpy as np

import swarmcensus as sc

TRIALS = 20
ROUNDS, CHANGE = 1000, 301
FORGETFUL = "studies/example/forgetful.py"
BRAINS = {
    "tracking": "tracking",
    "commons": "commons",
    "minimalistic": "minimalistic",
    "forgetful, half = 30": {"file": FORGETFUL, "half": 30},
    "changing-floor, detect = 1": {"file": "changing-floor", "detect": 1, "debiased": 1, "every": 1},
    "bayes-cpf": {"file": "bayes-cpf", "drift": 0},
}
SHOWN = [300, 310, 320, 350, 400, 600, 1000]


def run(floor):
    """The median error of each brain after each round, (brain, round)."""
    study = sc.Study(
        trials=TRIALS,
        seed=5,
        swarm={"brain": list(BRAINS.values()), "robots": 50, "accuracy": 0.75},
        world={"topology": "ring", "fill_ratio": floor},
        schedule={"rounds": ROUNDS, "observations_per_round": 10},
    )
    results = sc.run(study)
    truth = np.where(np.arange(1, ROUNDS + 1) < CHANGE, floor["from"], floor["to"])[:, np.newaxis]
    found = []
    for setting in range(len(BRAINS)):
        lives = [
            sc.replay(results, setting=setting, trial=trial, brain_file=[FORGETFUL])["estimate"].values[1:]
            for trial in range(TRIALS)
        ]
        found.append(np.median(np.abs(np.stack(lives) - truth), axis=(0, 2)))
    return np.array(found)


def main():
    """A large change and a small one."""
    floors = {
        "0.85 to 0.25": {"from": 0.85, "to": 0.25, "at": CHANGE},
        "0.65 to 0.55": {"from": 0.65, "to": 0.55, "at": CHANGE},
    }
    found = {name: run(floor) for name, floor in floors.items()}
    print("median error after round".ljust(42), *(f"{r:>6}" for r in SHOWN))
    for name, errors in found.items():
        for brain, row in zip(BRAINS, errors, strict=True):
            print(f"{name}  {brain}".ljust(42), *(f"{row[r - 1]:.4f}" for r in SHOWN))
    if len(sys.argv) > 1:
        draw(found, sys.argv[1])


def draw(found, path):
    """Round by round, a panel a change."""
    figure, axes = drawing.panels(1, 2, 7.2, 3.9)
    for one, (name, errors) in zip(axes, found.items(), strict=True):
        handles = []
        for brain, row, colour in zip(BRAINS, errors, drawing.COLOURS, strict=True):
            broken = (
                {"ls": "--", "zorder": 5} if brain == "commons" else {}
            )  # it covers others, and they are to be seen
            handles += one.plot(np.arange(1, ROUNDS + 1), row, color=colour, lw=1.6, **broken)
        one.axvline(CHANGE, color="0.6", lw=0.8, ls=":")
        one.set_title(f"floor {name}", fontsize=10)
        one.set(yscale="log", xlim=(1, ROUNDS), ylim=(0.001, 1.0), xlabel="round of communication")
    axes[0].set_ylabel("median error |x - f|")
    drawing.save(figure, path, list(BRAINS), handles)


if __name__ == "__main__":
    main()
