"""Random studies of fixed networks with all that a study may have, and whether two engines give the same of them."""

import dataclasses
import warnings

import numpy as np

import swarmcensus as sc
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation import run_batch
from swarmcensus.translation.selftest import is_exact
from tests.support.places import EXAMPLE

GO_ON = np.zeros(1, np.uint8)
BRAINS = (
    "minimalistic", "commons", "swift", "census", "steadfast", "sure", "tracking", "voter", "belief-sharing",
    "bayes-bots", "alone", "information-filter", "three-state", "w-msr", "oracle", "changing-floor", "recurrent",
    *(str(EXAMPLE / f"{name}.py") for name in ("pairwise", "histogram", "quiet", "sprt", "leader", "shy")),
)  # fmt: skip
HONEST = ("oracle", "histogram.py", "sprt.py")  # that no adversary can wear
ADVERSARIES = ("always-black", "jammer", "random", "creeper")


def random_study(number: int, brains=BRAINS, most=300) -> sc.Study:
    """The study of this number, of at most so many robots."""
    rng = np.random.default_rng(number)

    def one(*values):
        return values[rng.integers(len(values))]

    robots, rounds = min(int(one(1, 2, 7, 30, 100, 300)), most), int(one(5, 40, 130))
    accuracy = one(
        0.7, 1.0, "U(0.525, 0.975)", {"black": 0.9, "white": "U(0.5, 0.8)"},
        {"start": 0.9, "drift": -0.002}, {"start": "U(0.6, 0.8)", "drift": 0.001},
    )  # fmt: skip
    world = {
        "topology": one("full", "full", "ring", "line", "scale-free"),
        "fill_ratio": one(0.55, 0.02, 1.0, {"from": 0.8, "to": 0.3, "at": 3, "until": 5}),
        "link_success": one(1.0, 1.0, 0.7),
        "message_delay": int(one(0, 0, 1, 3)),
        "message": one("double", "double", "float32", "float16", "ratio16", "ratio8"),
    }
    if robots > 2:
        world["missing_links"] = one(0.0, 0.0, 0.0, 0.3)
    given = {
        "swarm": {
            "brain": one(*brains), "robots": robots, "accuracy": accuracy,
            "precision": one("double", "double", "single"),
        },
        "world": world,
        "schedule": {"rounds": rounds, "observations_per_round": int(one(1, 10, 15, 37))},
        "measure": {"checkpoints": [1, 5, rounds]} | {key: bool(one(True, False)) for key in ("estimates", "local")},
    }  # fmt: skip
    if isinstance(accuracy, float) and one(True, False):
        given["swarm"]["assumed_accuracy"] = one(0.8, {"error": "N(0, 0.05)"})
    if robots > 5:
        if one(True, False, False):
            parts = one("sensing", "talking", ["sensing", "talking"])
            until = one({}, {"until": 30 if rounds > 30 else 5})
            given["faults"] = [{"at": 3, "robots": 0.4, "stop": parts} | until]
        if one(True, False, False) and not given["swarm"]["brain"].endswith(HONEST):
            given["members"] = [one({"brain": one(*ADVERSARIES), "honest": False}, {"accuracy": 0.9}) | {"robots": 0.3}]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return sc.Study(name=f"random {number}", seed=number, trials=3, **given)


def are_same(setting, x, y) -> bool:
    """Whether results are equal, or nearly so where brains use functions that each machine rounds in its own way."""
    if all(map(is_exact, setting.brains)):
        return np.array_equal(x, y, equal_nan=True)
    near = np.isclose(x, y, rtol=0.0, atol=1e-4 if setting.precision == "single" else 1e-9, equal_nan=True)
    return bool(near.mean() >= 0.99) if near.size else True


def differences(card, study: sc.Study, trials=3, first=2) -> list[str]:
    """What differs between a card's results and the engine's, bit by bit."""
    found, metrics = [], metrics_of(study)
    for setting in study.settings():
        for local in (False, True)[: 1 + study.measure.local]:
            given = (setting, study.seed, first, trials, metrics, GO_ON, local)
            ours, theirs = run_batch(*given), card.run_batch(*given)
            for field in dataclasses.fields(ours):
                x, y = getattr(ours, field.name), getattr(theirs, field.name)
                if local and field.name not in ("convergence", "error", "final"):
                    continue
                if field.name == "verdicts":
                    x, y = x[..., :7], y[..., :7]  # the last one is of invalid decisions
                if isinstance(x, np.ndarray) and not (x.shape == y.shape and are_same(setting, x, y)):
                    found.append(f"{setting}{' alone' * local}: {field.name}")
    return found
