"""What each part of steadfast does: `python benchmarks/steadfast.py`. Half a minute on two cores.

Twenty robots on random geometric graphs, six kinds of liars, two kinds of sensors and two floors; prints the mean and
the worst of the settings' median errors, as shipped and with one part switched off, or set otherwise.
"""

import numpy as np

import swarmcensus as sc
from swarmcensus import brains

TRIALS = 10
NEVER = 1e9
VARIANTS = {
    "as shipped": {},
    "near = 1e9": {"near": NEVER},
    "sure = 1e9": {"sure": NEVER},
    "lean = 0": {"lean": 0.0},
    "cap = 1e9": {"cap": NEVER},
    "sure = 3": {"sure": 3.0},
}
KINDS = ["always-black", "opposite", "random", "shouter", "slow-liar", "forger"]


def main():
    """A line a variant."""
    study = sc.Study(
        trials=TRIALS,
        seed=13,
        swarm={
            "robots": 20,
            "accuracy": [0.625, "U(0.525, 0.975)"],
            "brain": [{"file": "steadfast", **given} for given in VARIANTS.values()],
        },
        members=[{"robots": [0, 0.1, 0.3], "brain": KINDS, "honest": False}],
        world={"topology": {"networkx": "random_geometric_graph", "radius": 0.4}, "fill_ratio": [0.12, 0.55]},
        schedule={"rounds": 500, "observations_per_round": 10},
    )
    results = sc.run(study)
    error = abs(results["final_estimate"] - results["fill_ratio"]).median(["trial", "robot"]).values
    shares = (results["liars"] / results["robots"]).values.round(1)
    shipped = {name: results[name].values for name in ("near", "sure", "lean", "cap")}
    usual = {name: brains.load("steadfast").parameters[name] for name in shipped}
    print("mean, worst".ljust(14), *(f"{100 * share:>12.0f} % liars" for share in (0, 0.1, 0.3)))
    for name, given in VARIANTS.items():
        mine = np.logical_and.reduce([values == given.get(key, usual[key]) for key, values in shipped.items()])
        cells = [error[mine & (shares == share)] for share in (0.0, 0.1, 0.3)]
        print(name.ljust(14), *(f"{one.mean():.4f}, {one.max():.4f}".rjust(20) for one in cells))


if __name__ == "__main__":
    main()
