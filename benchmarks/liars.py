"""What liars cost: `python benchmarks/liars.py RESULTS.nc`, of studies/beyond/liars*.toml, `FIGURE.png` or `worst`.

Of results it prints tables by world and by kind: medians of the final errors over honest robots and trials, then means
over settings. inf: estimates are no numbers any more, as those of commons where somebody shouts. A figure it makes of a
small study of its own, which takes a minute on two cores, and prints what is drawn. `worst` runs the liars that beat
steadfast on three networks, prints a table beside the paper's brain and a robot alone, and takes a minute too.
"""

import sys

import drawing
import numpy as np

import swarmcensus as sc

BRAINS = ["steadfast", "commons", "minimalistic", "alone", "gated-mean"]
KINDS = ["always-black", "opposite", "random", "shouter", "slow-liar", "forger"]
SHARES = [0, 0.1, 0.2, 0.3]
TRIALS = 20
TOP = 1.0
GEOMETRIC = {"networkx": "random_geometric_graph", "radius": 0.4}
WORST_TRIALS = 200


def errors(results):
    """A row a setting: the median error of honest robots, the brain, the kind of liar and their share."""
    error = abs(results["final_estimate"] - results["fill_ratio"]).median(["trial", "robot"])
    table = error.to_dataframe("error").fillna({"error": np.inf})
    table["kind"] = table["adversary"].str.split("/").str[-1]
    table["share"] = (table["liars"] / table["robots"]).round(1)
    return table


def tell(results):
    """Both tables."""
    table = errors(results)
    table["world"] = table["topology"].str.split("(").str[0] + " " + table["robots"].astype(str)
    order = list(dict.fromkeys(table["brain"]))
    for rows in (["world", "share"], ["kind", "share"]):
        part = table if rows[0] == "world" else table[table["robots"] == 20]
        print(part.pivot_table("error", rows, "brain", "mean", sort=False)[order].round(4).to_string())


def draw(path):
    """The final error against the share of liars, a line a brain and a panel a kind."""
    study = sc.Study(
        trials=TRIALS,
        seed=13,
        swarm={
            "robots": 20,
            "accuracy": 0.625,
            "brain": [*BRAINS[:-1], {"file": "gated-mean", "phase": 10, "debiased": 1}],
        },
        members=[{"robots": SHARES, "brain": KINDS, "honest": False}],
        world={"topology": GEOMETRIC, "fill_ratio": 0.55},
        schedule={"rounds": 500, "observations_per_round": 10},
    )
    table = errors(sc.run(study))
    found = table.pivot_table("error", ["kind", "share"], "brain", "mean", sort=False)[BRAINS]
    print(found.round(4).to_string())
    figure, axes = drawing.panels(2, 3, 7.2, 5.0)
    none = table[table["liars"] == 0].groupby("brain")["error"].mean()
    for one, kind in zip(axes, KINDS, strict=True):
        handles = []
        for brain, colour, marker in zip(BRAINS, drawing.COLOURS, drawing.MARKERS, strict=False):
            values = [none[brain], *(found.loc[(kind, share), brain] for share in SHARES[1:])]
            shown = np.minimum(values, TOP)
            handles += one.plot(100 * np.array(SHARES), shown, color=colour, marker=marker, ms=4, lw=1.6, clip_on=False)
            for share, value in zip(SHARES, values, strict=True):
                if value > TOP:
                    one.annotate("∞", (100 * share, TOP), (0, 3), textcoords="offset points", ha="center", fontsize=9)
        one.set_title(kind, fontsize=10)
        one.set(yscale="log", ylim=(0.002, 2.0 * TOP), xticks=[0, 10, 20, 30])
    for one in axes[3:]:
        one.set_xlabel("liars, % of 20 robots")
    for one in axes[::3]:
        one.set_ylabel("median error |x - f|")
    drawing.save(figure, path, BRAINS, handles)


def worst():
    """Median errors among creepers, and among many opposite liars."""
    study = sc.Study(
        trials=WORST_TRIALS,
        seed=13,
        swarm={"robots": 20, "accuracy": 0.625, "brain": ["steadfast", "minimalistic", "alone"]},
        members=[{"robots": [0, 0.1, 0.2, 0.4], "brain": ["creeper", "opposite"], "honest": False}],
        world={"topology": ["full", GEOMETRIC, "ring"], "fill_ratio": 0.55},
        schedule={"rounds": 500, "observations_per_round": 10},
    )
    table = errors(sc.run(study))
    table["network"] = table["topology"].str.split("(").str[0]
    table["kind"] = table["kind"].where(table["liars"] > 0, "none")
    columns = ["steadfast", "minimalistic", "alone"]
    print(table.pivot_table("error", ["kind", "share", "network"], "brain", sort=False)[columns].round(4).to_string())


if __name__ == "__main__":
    if sys.argv[1].endswith(".nc"):
        tell(sc.load(sys.argv[1]))
    elif sys.argv[1] == "worst":
        worst()
    else:
        draw(sys.argv[1])
