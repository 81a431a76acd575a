"""What a wrong accuracy costs: `python benchmarks/unknown.py [FIGURE.png]`. A minute on two cores.

Six of twenty robots that move have sensors of 0.75 and are told another accuracy, the others the right one. Prints the
median error over all robots and trials after 3,000 ticks, by what the six were told, and draws it. Errors are held
against the floor's own share of black, for no brain is to be blamed for a floor that is not quite f.
"""

import sys

import drawing
import numpy as np

import swarmcensus as sc

TRIALS = 40
BRAINS = ["self-taught", "commons", "minimalistic", "asdf", "oracle"]
TOLD = [0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95]
FLOORS = [0.55, 0.75]


def main():
    """Run, print and draw."""
    study = sc.Study(
        trials=TRIALS,
        seed=3,
        swarm={
            "brain": [BRAINS[0], *BRAINS[1:3], {"file": "asdf", "every": 1000}, "oracle"],
            "robots": 20,
            "accuracy": 0.75,
        },
        members=[{"robots": 6, "assumed_accuracy": TOLD}],
        world={"topology": "moving", "density": 10, "fill_ratio": FLOORS},
        schedule={"ticks": 3000},
    )
    results = sc.run(study)
    table = results[["brain", "fill_ratio"]].to_dataframe()
    table["told"] = results["members"].to_series().str.split().str[-1].astype(float)
    error = abs(results["final_estimate"] - results["true_fill_ratio"])
    table["error"] = error.median(["trial", "robot"]).values
    found = table.pivot_table("error", ["fill_ratio", "told"], "brain", sort=False)[BRAINS]
    print(found.round(4).to_string())
    if len(sys.argv) > 1:
        draw(found, sys.argv[1])


def draw(found, path):
    """Against what the six were told, a panel a floor."""
    figure, axes = drawing.panels(1, 2, 7.2, 3.9)
    for one, floor in zip(axes, FLOORS, strict=True):
        handles = []
        for brain, colour, marker in zip(BRAINS, drawing.COLOURS, drawing.MARKERS, strict=False):
            row = np.maximum(found.loc[floor, brain], 1e-4)
            handles += one.plot(row.index, row, color=colour, marker=marker, ms=4, lw=1.6)
        one.axvline(0.75, color="0.6", lw=0.8, ls=":")
        one.set_title(f"f = {floor}", fontsize=10)
        one.set(yscale="log", ylim=(0.0005, 0.1), xlabel="accuracy that six of twenty are told")
    axes[0].set_ylabel("median error |x - share of black|")
    drawing.save(figure, path, BRAINS, handles)


if __name__ == "__main__":
    main()
