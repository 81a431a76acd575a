"""Where our own brains are worse than the paper's, than a robot alone, or than another: `python benchmarks/worse.py`.

Twenty robots. Prints the median of the final errors of honest robots in each world, beside `minimalistic`, `alone` and
one more brain. A minute on two cores.
"""

from pathlib import Path

import numpy as np

import swarmcensus as sc

TRIALS = 100
FORGETFUL = {"file": str(Path(__file__).parents[1] / "studies" / "example" / "forgetful.py"), "half": 30}
FULL, RING, LATE = {"topology": "full"}, {"topology": "ring"}, {"topology": "full", "message_delay": 10}
CLUSTERS = {"topology": "moving", "side": 2.0, "floor": {"clusters": 0.4}}


def liars(brain, robots):
    """Members that lie."""
    return [{"robots": robots, "brain": brain, "honest": False}]


WORLDS = {  # what it is: our brain, one more, accuracy, world, members
    "2 of 20 say that all is black, full": ("commons", "steadfast", 0.625, FULL, liars("always-black", 2)),
    "messages 10 rounds late, full": ("commons", "swift", 0.625, LATE, []),
    "2 of 20 creep, full": ("steadfast", "commons", 0.625, FULL, liars("creeper", 2)),
    "8 of 20 are opposite, full": ("steadfast", "commons", 0.625, FULL, liars("opposite", 8)),
    "black in clusters, moving": ("steadfast", "commons", 0.7, CLUSTERS, []),
    "6 of 20 told 0.55 for 0.75, full": (
        "self-taught", "commons", 0.75, FULL, [{"robots": 6, "assumed_accuracy": 0.55}]
    ),
    "f from 0.8 to 0.2 in rounds 301 to 1000, ring": (
        "tracking", FORGETFUL, 0.75, RING | {"fill_ratio": {"from": 0.8, "to": 0.2, "at": 301, "until": 1000}}, []
    ),
}  # fmt: skip


def errors(brains, accuracy, world, members):
    """The median error of each brain after the last round."""
    moving = world["topology"] == "moving"
    change = world.get("fill_ratio")
    length = 1000 if change else 500
    study = sc.Study(
        trials=TRIALS,
        seed=17,
        swarm={"robots": 20, "accuracy": accuracy, "brain": brains},
        members=members,
        world={"fill_ratio": 0.55} | world,
        schedule={"ticks": 3000} if moving else {"rounds": length, "observations_per_round": 10},
        measure={"truth": "floor"} if moving else {},
    )
    results = sc.run(study)
    truth = results["true_fill_ratio"] if moving else change["to"] if change else 0.55
    return abs(results["final_estimate"] - truth).median(["trial", "robot"]).values


def slow():
    """The share of robots more than 0.05 off, 700 rounds after f fell from 0.75 to 0.35, with poor sensors."""
    study = sc.Study(
        trials=TRIALS,
        seed=17,
        swarm={"robots": 20, "accuracy": 0.55, "brain": ["tracking", FORGETFUL]},
        world=RING | {"fill_ratio": {"from": 0.75, "to": 0.35, "at": 301}},
        schedule={"rounds": 1000, "observations_per_round": 10},
    )
    off = abs(sc.run(study)["final_estimate"] - 0.35) > 0.05
    ours, forgetful = off.mean(["trial", "robot"]).values
    print("700 rounds after f fell from 0.75 to 0.35, ring, accuracy 0.55, robots more than 0.05 off:", end=" ")
    print(f"tracking {ours:.0%}; forgetful, half = 30 {forgetful:.0%}")


def main():
    """A line a world."""
    print(f"{'world':46}{'brain':12}{'error':>8}{'minimalistic':>14}{'alone':>8}  another")
    for world, (ours, other, *rest) in WORLDS.items():
        mine, paper, alone, more = errors([ours, "minimalistic", "alone", other], *rest)
        name = other if isinstance(other, str) else "forgetful, half = 30"
        found = " ".join(f"{x:{width}.4f}" for x, width in ((mine, 8), (paper, 13), (alone, 7)))
        print(f"{world:46}{ours:12}{found}  {more:.4f} {name}".replace("nan", "inf"))
    slow()


if __name__ == "__main__":
    np.seterr(invalid="ignore")
    main()
