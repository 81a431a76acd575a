"""One trial in full, in arrays (round, robot)."""

from types import SimpleNamespace

import numpy as np

from swarmcensus.simulation import Stepped, ended

AT_ONCE = 500  # rounds


def record_trial(setting, seed, trial):
    """What states hold, estimates, and black readings on a fixed network."""
    trace = Stepped(setting, seed, trial, use=setting.use)
    fields, blacks = trace.states(0, trace.rounds + 1), trace.blacks()
    if any(brain.ends for brain in setting.brains):
        blacks[1:][ended(setting.brains, fields)] = 0.0
    return fields, trace.estimates(0, trace.rounds + 1), blacks


def record_ride(setting, seed, trial):
    """The same of robots that move, with where they are and what they see."""
    trace = Stepped(setting, seed, trial)
    shown, rounds = trace.dataset(links=True), np.arange(trace.rounds + 1)
    names = ("estimate", "position", "heading", "looked", "tile", "reading", "link")
    seen = {name: shown[name].values for name in names}
    return SimpleNamespace(
        fields=trace.states(0, trace.rounds + 1), estimates=seen["estimate"], looked=seen["looked"] == 1,
        poses=np.concatenate([seen["position"], seen["heading"][..., np.newaxis]], axis=2), colours=seen["tile"],
        readings=seen["reading"], links=seen["link"], true_fill_ratio=trace.truths(rounds, on_floor=True),
    )  # fmt: skip


def difference(trace, other):
    """The first round, robot and field in which two traces differ; None if they do not, in what both know."""
    robots = [label for label in trace.labels if label in {*other.labels}]
    last = min(trace.rounds, other.rounds)
    for a in range(0, last + 1, AT_ONCE):
        mine, theirs = (_of_robots(one, robots, a, min(a + AT_ONCE, last + 1)) for one in (trace, other))
        for name in mine.keys() & theirs.keys():
            one, two = mine[name], theirs[name]
            for row, robot, *_ in np.argwhere((one != two) & ~np.isnan(one) & ~np.isnan(two)):
                return a + int(row), robots[robot], name
    return None


def _of_robots(trace, robots, a, b):
    columns = [[*trace.labels].index(label) for label in robots]
    return {name: one[:, columns] for name, one in {"estimate": trace.estimates(a, b), **trace.states(a, b)}.items()}
