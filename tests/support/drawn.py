"""Random valid studies, short and long, in every kind of world: for tests of what holds for any study."""

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains import adversary
from swarmcensus.brains.metrics.metric import PLUGINS as METRICS

EDGES = [[0, 1], [1, 2], [2, 0], [3, 0], [0, 3]]
NETWORKS = [
    "full", "ring", "line", "scale-free", {"name": "some", "edges": EDGES},
    {"name": "one way", "edges": EDGES, "directed": True}, {"networkx": "gnp_random_graph", "p": 0.4},
]  # fmt: skip
FLOORS = ["tiles", "half", {"clusters": 0.3}, {"stripes": 0.4}]
ACCURACIES = [
    0.5, 0.8, 0.95, 1.0, "U(0.525, 0.975)", "N(0.75, 0.1)", {"black": 0.9, "white": 0.6},
    {"start": 0.9, "drift": -0.02, "least": 0.6},
]  # fmt: skip
BELIEFS = [0.7, "U(0.5, 0.9)", {"error": "N(0, 0.05)"}]
MESSAGES = ["double", "double", "float32", "float16", "ratio16", "ratio8"]
FILLS = [0.0, 0.1, 0.5, 0.55, 0.85, 1.0]
TRIALS = 2
LIARS = tuple(adversary.PLUGINS.shipped)


def drawn(rng, brain, liars=LIARS, longest=1500, on_a_card=False):
    """A random valid study of this brain, perhaps with members of others that say the same, or of `liars`.

    It has no more than `longest` rounds; `on_a_card`, it is one of networks, in any number format.
    """
    while True:
        try:
            return sc.Study(**tables_of(rng, brain, liars, longest, on_a_card))
        except sc.InputError:  # its values do not go together
            continue


def tables_of(rng, brain, liars=LIARS, longest=1500, on_a_card=False):
    """The tables of such a study, which may not go together."""

    def one(values):
        return values[rng.integers(len(values))]

    def whole(low, high):
        return int(rng.integers(low, high + 1))

    def chance(p):
        return bool(rng.random() < p)

    moving = not on_a_card and chance(0.4)
    robots = 300 if chance(0.05) else whole(1, 9)
    long = min(61, longest)
    rounds = one([1, 1, 1, 2, 3, whole(4, 60), whole(4, 60), whole(long, longest)]) if robots < 300 else one([1, 2])
    rounds = min(rounds, longest)
    sensors = one(ACCURACIES) if chance(0.7) else [0.6, 0.8]  # two settings, of which one walk carries both
    swarm = {"robots": robots, "brain": _wrapped(rng, brain), "accuracy": sensors}
    if chance(0.2):
        swarm["assumed_accuracy"] = one(BELIEFS)
    fill = one(FILLS)
    if rounds > 2 and chance(0.4):
        at = whole(2, rounds - 1)
        fill = {"from": 0.9, "to": 0.2, "at": at} | ({"until": whole(at, rounds + 3)} if chance(0.5) else {})
    world, measure = {"fill_ratio": fill}, {"delta": one([0.001, 0.01, 0.05, 0.3]), "bins": one([2, 10, 7])}
    if moving:
        world |= {"topology": "moving", "density": one([0.5, 3, 8]), "body": {"tile": 0.05}}
        world |= {"floor": one(FLOORS)} if chance(0.5) else {}
        if chance(0.5):
            world["body"]["message_delay"] = whole(0, 3)
        schedule = {"ticks": rounds}
        measure |= {"truth": "floor"} if chance(0.5) else {}
    else:
        world["topology"] = one(NETWORKS)
        world |= {"message_delay": whole(1, 4)} if chance(0.3) else {}
        schedule = {"rounds": rounds, "observations_per_round": one([1, 1, 3, 10, 17])}
        measure |= {"local": True} if chance(0.3) else {}
    world |= {"link_success": one([0.0, 0.6])} if chance(0.3) else {}
    if chance(0.7):
        measure["checkpoints"] = sorted({whole(1, rounds) for _ in range(4)})
    if chance(0.5):
        measure["estimates"] = True
    if on_a_card:
        world |= {"message": one(MESSAGES), "missing_links": 0.3 if robots > 2 and chance(0.2) else 0.0}
        swarm["precision"] = one(["double", "double", "single"])
    elif chance(0.3):
        measure["metrics"] = sorted({one(list(METRICS.shipped)) for _ in range(2)})
    faults = [
        {"at": (at := whole(1, rounds)), "robots": one([1, 0.5]), "stop": one(["sensing", "talking"])}
        | ({"until": at + whole(1, 5)} if chance(0.5) else {})
        for _ in range(whole(1, 2) if chance(0.3) else 0)
    ]
    members = [_member(one, chance, brain, liars) for _ in range(whole(1, 2) if chance(0.35) else 0)]
    return {
        "seed": whole(0, 2**40), "trials": TRIALS, "swarm": swarm, "world": world, "schedule": schedule,
        "measure": measure, "faults": faults, "members": members,
    }  # fmt: skip


def _wrapped(rng, name):
    """A brain as a study names it, half of the time with other parameters, some that it was not made for."""
    known = {key: value for key, value in brains.load(name).parameters.items() if isinstance(value, float)}
    if not known or rng.random() < 0.5:
        return name
    table = {"file": name}
    for key in rng.choice(list(known), min(2, len(known)), replace=False):
        value = known[str(key)]
        others = [0.0, 1.0 - value] if value in (0.0, 1.0) else [0.0, 1.0, 0.1 * value, 0.5 * value, 2.0 * value]
        table[str(key)] = float(others[rng.integers(len(others))])
    return table


def _member(one, chance, brain, liars):
    table = {"robots": one([1, 2, 0.3])}
    if chance(0.5):
        table["accuracy"] = one(ACCURACIES)
    if chance(0.4):
        return table | {"brain": one(liars), "honest": False}
    message = brains.load(brain).message
    alike = [brain, *(name for name in brains.shipped() if len(liars) > 1 and brains.load(name).message == message)]
    return table | ({"brain": one(alike)} if chance(0.6) else {}) | ({"honest": False} if chance(0.3) else {})
