"""All brains and adversaries keep the contract, with parameters that let much happen in short histories too.

One suite for all of them: what each promises, what it prints of its size, and that machine code does what CPython does.
"""

import functools
import os

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains import adversary
from swarmcensus.checks import sample_states, suite
from swarmcensus.checks.contract_checks import PROMISES
from swarmcensus.checks.machine_code import agrees
from tests.support.long import in_two_sizes
from tests.support.lying import RICH, wrapped
from tests.support.opinions import QUICK, quick
from tests.support.places import EXAMPLE
from tests.support.second import ADDS, ALL, RANDOM, WALD, brain

SHIPPED = brains.shipped()
OF_EACH_FAMILY = [
    "minimalistic", "commons", "sure", "steadfast", "self-taught", "leaver", "oracle", "asdf", "recurrent",
    "three-state", "weighted-voter", "w-msr", "information-filter",
]  # fmt: skip
EXAMPLES = ["pairwise", "prior", "histogram", "quiet", "sprt", "leader", "liar", "forgetful"]
ADVERSARIES = adversary.PLUGINS.shipped
SHORT_PHASES = {"phase": 2.0, "debiased": 1.0}
PARAMETERS = {  # with the defaults, these do what they are for after more rounds than the suite has
    "linear-consensus": SHORT_PHASES,
    "w-msr": SHORT_PHASES,
    "gated-mean": SHORT_PHASES,
    "bayes-bots": {"every": 3, "feedback": 2, "prior": 1, "patience": 4, "threshold": 0.7},
    "changing-floor": {"every": 1, "detect": 1, "tell": 5, "alarm": 1.5, "debiased": 1},
    "belief-sharing": {"every": 1, "debiased": 1},
    "belief-sharing-indexed": {"every": 1, "debiased": 1},
    "asdf": {"every": 4},
    "bayes-cpf": {"window": 60, "past": 5},
}


def case(name):
    """The brain of a case: `name`, `name busy`, `example NAME`, or `ADVERSARY on BRAIN`."""
    if name.startswith("example "):
        return brains.load(EXAMPLE / f"{name.removeprefix('example ')}.py")
    if " on " in name:
        liar, by = name.split(" on ")
        return wrapped(liar, by=brain(RICH) if by == "rich" else by)
    if name.endswith(" busy"):
        name = name.removesuffix(" busy")
        return quick(name, debiased=1.0) if name in QUICK else brains.load(name).with_parameters(PARAMETERS[name])
    return brains.load(name)


BUSY = [f"{name} busy" for name in (*PARAMETERS, *QUICK)]
OTHERS = [
    *BUSY, *(f"example {name}" for name in EXAMPLES),
    *(f"{liar} on {by}" for liar in ADVERSARIES for by in ("minimalistic", "rich")), "always-black on alone",
    "shouter on steadfast",
]  # fmt: skip


def faults(used, left_out=()):
    """What is wrong with a brain, by promise."""
    kept = {what: test for what, test in PROMISES.items() if not what.startswith(tuple(left_out))}
    found = {what: suite.fault_of(test, used) for what, test in kept.items()}
    return {what: fault for what, fault in found.items() if fault is not None}


@pytest.mark.interpreted
@pytest.mark.long(but=[f"{name}-quick" for name in OF_EACH_FAMILY])
@in_two_sizes(
    ("accuracies", "long"), ((0.0, 0.75), sample_states.LONG[:1]), (sample_states.ACCURACIES, sample_states.LONG)
)
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_brains_keep_their_promises(name, accuracies, long, monkeypatch):
    """Quick runs make fewer kinds of sensors; all of them, and all that the suite makes, where there is time."""
    monkeypatch.setattr(sample_states, "ACCURACIES", accuracies)
    monkeypatch.setattr(sample_states, "LONG", long)
    sample_states.messages.cache_clear()
    found = list(suite.examine(brains.load(name), PROMISES))
    sample_states.messages.cache_clear()  # those of fewer sensors
    assert [one.fault for one in found] == [None] * len(PROMISES)


@pytest.mark.long(but=["example quiet", "jammer on minimalistic"])
@pytest.mark.parametrize("name", OTHERS)
def test_others_keep_their_promises(name, untraced):
    assert faults(case(name), ["readings at once"] * name.endswith(" on rich")) == {}


@pytest.mark.long(but=["commons", "minimalistic", "jammer on minimalistic"])
@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")
@pytest.mark.parametrize("name", [*SHIPPED, *OTHERS])
def test_machine_code_does_what_cpython_does(name, untraced):
    agrees(case(name))


LIVES = {  # brains that change what they do with time, beyond the suite's twelve rounds; what must have happened
    **{f"{name} busy": lambda data: len(np.unique(data["estimate"])) > 1 for name in QUICK},
    "asdf busy": lambda data: len(np.unique(data["mended"])) > 2,
    "bayes-cpf busy": lambda data: len(np.unique(data["mu"])) > 2,
    "self-taught": lambda data: data["out"].values[:, 0].max() == 1.0,  # the robot with the wrong sensor steps back
    "tracking": lambda data: (np.diff(data["long_v"].values, axis=0) < -3).any(),  # a robot forgets what was before
}


@functools.cache
def history():
    """Readings (step, robot) of eight robots: the floor changes in the middle, and robot 0 has another sensor."""
    chance = np.random.default_rng(9)
    black = np.where(np.arange(320) < 160, 0.74, 0.26)[:, None] + np.zeros(8)
    black[:, 0] = 0.05
    links = [[k, (k + 1) % 8] for k in range(8)] + [[0, 3], [2, 6]]
    return (chance.random((320, 8)) < black).astype(float), links


@pytest.mark.long(but=["voter busy"])
@pytest.mark.parametrize("name", LIVES)
def test_machine_code_lives_long_lives_of_cpython(name):
    readings, links = history()
    slow, fast = (sc.infer(readings, links, 0.9, 2, brain=case(name), compiled=compiled) for compiled in (False, True))
    for field in slow.data_vars:
        assert fast[field].values == pytest.approx(slow[field].values, rel=1e-9, abs=1e-9), field
    assert LIVES[name](slow)


OWN = {"all": ALL, "adds": ADDS, "wald": WALD, "random": RANDOM}
LINKS = {"edges": [[0, 1], [1, 2], [3, 1]], "nobody": None}
LINKS["messages"] = [[k, k % 4, (k + 1 + k % 2) % 4] for k in range(10)]


@pytest.mark.long(but=["all-edges", "random-messages"])
@pytest.mark.parametrize("links", LINKS)
@pytest.mark.parametrize("name", OWN)
def test_machine_code_and_cpython_agree_on_recorded_data(name, links):
    random = np.random.default_rng(3)
    readings = random.integers(0, 2, (50, 4)).astype(float)
    readings[random.random(readings.shape) < 0.2] = np.nan
    slow, fast = (sc.infer(readings, LINKS[links], 0.8, 5, brain(OWN[name]), compiled=flag) for flag in (False, True))
    assert set(slow.data_vars) == set(fast.data_vars) >= {"estimate", *brain(OWN[name]).memory}
    for field in fast.data_vars:
        assert fast[field].dims == slow[field].dims
        assert (fast[field].values == slow[field].values).all(), field


@pytest.mark.interpreted
@pytest.mark.parametrize("name", SHIPPED)
def test_sizes_are_those_of_the_fields(name):
    used = brains.load(name)
    assert used.message_bytes == 4 * sum(max(length, 1) for length in used.message.values())
    numbers = sum(len(value) if isinstance(value, tuple) else 1 for value in used.memory.values())
    assert used.memory_bytes == 4 * (numbers + 2)


NO_MIRROR = ("recurrent", "steadfast", "census", "three-state", "weighted-voter")  # trained, or rounded at gates


@pytest.mark.interpreted
@pytest.mark.parametrize("name", [n for n in SHIPPED if n not in NO_MIRROR and not brains.load(n).is_opinion])
def test_colours_may_change_places(name):
    """Black read as white, with b and w changed, gives the rest of each estimate to 1."""
    readings, links = history()
    both = 0.0
    for given, b, w in ((readings, 0.9, 0.8), (1.0 - readings, 0.8, 0.9)):
        both += sc.infer(given[:80], links, {"black": b, "white": w}, 2, brain=name, compiled=False)["estimate"].values
    assert both == pytest.approx(1.0, abs=1e-9)
