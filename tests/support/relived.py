"""Logs of robots in memory, to be replayed."""

import swarmcensus as sc
from swarmcensus.robots import Clock, Logged
from tests.support.lockstep import Swarm

SEED = 3


def setting_of(brain="commons", robots=5, rounds=40, message="float32", topology="ring", looks=1, **more):
    world = {"message": message, "link_success": 0.7, "fill_ratio": 0.6, "topology": topology}
    study = sc.Study(
        trials=1, seed=SEED, swarm={"brain": brain, "robots": robots, "accuracy": 0.8,
        "precision": more.pop("precision", "double")}, world=world,
        schedule={"rounds": rounds, "observations_per_round": looks}, **more,
    )  # fmt: skip
    return study, study.settings()[0]


def logged(folder, brain="commons", more=(), **given):
    """Logs of a lockstep swarm, and its setting; the folder holds the brain's file."""
    study, setting = setting_of(brain, **given)
    swarm = Swarm(folder, setting, SEED, **dict(more))
    (folder / "brain.py").write_text(setting.brain.source)
    return study, setting, swarm


def recorded(folder, brain="commons", **given):
    """Logs of a swarm that lived to its end: its study, and what its robots showed."""
    study, _, swarm = logged(folder, brain, **given)
    swarm.run()
    return study, swarm.close()


def estimates_of(recording, lives, rounds):
    return Logged(recording, lives, Clock(recording.members)).estimates(0, rounds + 1)


def told(folder, study, /, **more):
    """Write swarm.json."""
    import json

    about = {"format": 1, "title": "day", "brain": {"file": "brain.py"}, "fill_ratio": 0.6, "seed": SEED, "trial": 0,
             "study": study.text, "robots": []} | more  # fmt: skip
    (folder / "swarm.json").write_text(json.dumps(about))
