"""The trained net: its equations by hand, its weights as its training left them, and what they are worth."""

import tomllib

import numpy as np
import pytest

from swarmcensus import brains
from tests.support.places import ROOT

NET = brains.load("recurrent")
STUDIES = ROOT / "studies" / "rivals"


def sigma(z):
    return 1.0 / (1.0 + np.exp(-z))


def drawn(seed):
    chance = np.random.default_rng(seed)
    return {
        "tau": tuple(chance.uniform(1.0, 20.0, 5)),
        **{name: tuple(chance.normal(size=size)) for name, size in (("bias", 5), ("inputs", 15), ("weights", 25))},
        "output": tuple(chance.normal(size=5)),
        "offset": 0.3,
    }


@pytest.mark.parametrize("debiased", [0.0, 1.0])
def test_rounds_by_hand(debiased):
    """With matrices, from the equation."""
    given = drawn(1) | {"debiased": debiased}
    me = NET.with_parameters(given).robot(0.9, 0.8)
    tau, bias, output = (np.array(given[name]) for name in ("tau", "bias", "output"))
    weights, inputs = np.reshape(given["weights"], (5, 5)), np.reshape(given["inputs"], (5, 3))
    y, fires = np.zeros(5), np.zeros(5)
    for blacks, looks, heard in [(1, 1, []), (3, 4, [0.2, 0.9]), (0, 0, [0.6]), (2, 5, [])]:
        if looks:
            NET.functions.observe(me, float(blacks), float(looks))
        for x in heard:
            NET.functions.receive(me, (x,))
        NET.functions.fuse(me)
        share = blacks / looks if looks else 0.5
        reading = 2 * share - 1 if not debiased or not looks else 2 * (share + 0.8 - 1) / 0.7 - 1
        opinion = 2 * np.mean(heard) - 1 if heard else 0.0
        y = y + (weights @ fires + inputs @ [reading, opinion, float(bool(heard))] - y) / tau
        fires = sigma(y + bias)
        assert list(me.y) == pytest.approx(y, abs=1e-12)
        assert NET.functions.estimate(me) == pytest.approx(sigma(output @ fires + 0.3), abs=1e-12)
        assert NET.functions.broadcast(me) == (me.x,)


def found(name):
    """What a search left: the line for a study."""
    text = (ROOT / "tests" / "data" / f"{name}-tuned.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)["swarm"]["brain"][0], text


def test_the_weights_are_those_that_the_search_found():
    line, text = found("recurrent")
    for key, value in line.items():
        if key != "file":
            assert NET.parameters[key] == (tuple(value) if isinstance(value, list) else value)
    said = " ".join(text.replace("#", "").split())
    assert "15265 evaluations in 477 generations" in said
    assert "over all 16 worlds: better in 89%" in said
    line, _ = found("recurrent-debiased")
    unseen = tomllib.loads((STUDIES / "recurrent-unseen.toml").read_text(encoding="utf-8"))
    assert unseen["swarm"]["brain"][1] == line
    assert NET.parameters["debiased"] == 0.0
