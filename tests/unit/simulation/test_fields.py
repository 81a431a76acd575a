"""Fields of brains: vectors, names, and records that are no arrays."""

from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.checks import suite
from swarmcensus.checks.contract_checks import PROMISES
from swarmcensus.cli.commands import main
from swarmcensus.engine.records import record_type
from swarmcensus.simulation.trials import Metrics, run_batch
from swarmcensus.support.errors import InputError
from tests.support.places import EXAMPLE
from tests.support.second import MEANS, brain, changed, fixed
from tests.support.small import GO, SEED, study_of
from tests.support.trials import record_trial

MEASURE = Metrics(0.01, 10, (2, 3))
COUNTS = changed(
    ("MEMORY = {", 'MEMORY = {"seen": (0.0, 0.5), "heard": (0.0, 0.0), '),
    ('MESSAGE = ("x",)', 'MESSAGE = ("seen",)'),
    ("return (estimate(me),)", "return (me.seen,)"),
    ("    me.n += blacks\n", "    me.n += blacks\n    me.seen[0] += looks - blacks\n    me.seen[-1] += blacks\n"),
    (
        "def receive(me, message):\n    pass",
        "def receive(me, message):\n    for k in range(2):\n        me.heard[k] += message[0][k]",
    ),
)


BEYOND = {
    "read": ("    me.n += blacks\n", "    me.n += blacks + me.seen[int(me.t)] * 0.0\n", "observe"),
    "set": ("    me.n += blacks\n", "    me.n += blacks\n    me.seen[2 * int(me.t)] = 1.0\n", "observe"),
    "said": ("message[0][k]", "message[0][k + int(me.t)]", "receive"),
    "before": ("    me.n += blacks\n", "    me.n += blacks + me.seen[-2 - int(me.t)] * 0.0\n", "observe"),
}


@pytest.mark.long(but=["before"])
@pytest.mark.parametrize("what", BEYOND)
def test_an_item_beyond_the_end_is_an_error_and_no_crash(here, what):
    old, new, function = BEYOND[what]
    Path("beyond.py").write_text(changed((old, new), source=COUNTS))
    faults = [one.fault for one in suite.examine(brains.load("beyond.py"), PROMISES) if one.fault]
    assert any(f"{function} fails at line" in fault and "IndexError" in fault for fault in faults)
    study = study_of("beyond.py", robots=3, accuracy=0.7, rounds=4, trials=1, fill_ratio=0.5)
    said = r"brain 'beyond.py' fails in trial 0 of .*IndexError.*at .*beyond.py, line \d+"
    with pytest.raises(InputError, match=said):
        sc.run(study)


@pytest.mark.parametrize(("message", "given", "said"), [
    pytest.param(
        '("seen",)', "((1.0, 2.0, 3.0),)", "vector of another length than MESSAGE says", marks=pytest.mark.long
    ),
    ('("seen",)', "(me.n,)", "it cannot be compiled"),
    ('{"n": 0.0}', "(me.seen,)", "it cannot be compiled"),
])  # fmt: skip
def test_a_message_of_another_shape_is_refused(message, given, said):
    changes = ('MESSAGE = ("seen",)', f"MESSAGE = {message}"), ("return (me.seen,)", f"return {given}")
    source = changed(*changes, source=COUNTS)
    source = changed(("me.heard[k] += message[0][k]", "me.heard[k] += 1.0"), source=source)
    (setting,) = fixed(brain(source))
    with pytest.raises(InputError, match=said):
        run_batch(setting, SEED, 0, 1, MEASURE, GO)
    assert suite.fault_of(PROMISES["gives finite messages and estimates in [0, 1]"], brain(source))


@pytest.mark.interpreted
def test_names_of_fields_and_of_their_items_do_not_meet(here):
    declared = '"seen": (0.0, 0.5), "item_seen": (1.0, 2.0, 3.0), '
    (here / "b.py").write_text(changed(('"seen": (0.0, 0.5), ', declared), source=COUNTS))
    sc.save(sc.run(study_of("b.py", robots=3, rounds=2, trials=1), jobs=1), "r.nc")
    assert main(["replay", "r.nc", "--setting", "0", "--trial", "0", "--out", "t.csv"]) == 0
    head = Path("t.csv").read_text().splitlines()[0]
    assert "seen[1]" in head
    assert "item_seen[2]" in head


def test_a_belief_over_ten_bins_is_bayes_rule():
    """The example by hand: logarithms of binomial likelihoods, of its own readings and of those that it hears of."""
    used = brains.load(EXAMPLE / "histogram.py")
    me, other = used.robot(0.8, 0.8), used.robot(0.8, 0.8)
    used.functions.observe(me, 5.0, 7.0)
    used.functions.observe(other, 6.0, 9.0)
    used.functions.receive(me, used.functions.broadcast(other))
    used.functions.fuse(me)
    middles = (np.arange(10) + 0.5) / 10
    p = 0.8 * middles + 0.2 * (1.0 - middles)
    log = 11.0 * np.log(p) + 5.0 * np.log(1.0 - p)
    assert list(me.belief) == pytest.approx(log, rel=1e-12)
    assert used.functions.estimate(me) == pytest.approx((np.exp(log) @ middles) / np.exp(log).sum(), rel=1e-12)
    assert used.functions.decide(me) == np.argmax(log)


# ---- fields of a record are its attributes in CPython, whatever NumPy calls so
NUMPYS = sorted(name for name in {*dir(np.recarray), *dir(np.record)} if not name.startswith("_"))


def test_fields_hide_numpy_attributes():
    record = np.zeros(1, record_type([(name, "f8") for name in NUMPYS] + [("vector", "f8", (3,))]))[0]
    for k, name in enumerate(NUMPYS):
        setattr(record, name, k)
    record.vector[1] = 7.0
    assert [getattr(record, name) for name in NUMPYS] == [*range(len(NUMPYS))]
    assert record.vector.tolist() == [0.0, 7.0, 0.0]
    with pytest.raises(AttributeError):
        record.other = 1.0


def test_a_number_is_one_of_cpython():
    record = np.zeros(1, record_type([("mean", "f8")]))[0]
    with pytest.raises(ZeroDivisionError):
        1.0 / record.mean


# ---- me.name: robots are told apart, and a brain that asks for it is not anonymous
LEADER = brains.load(EXAMPLE / "leader.py")
HEARS = changed(
    ("MEMORY = {", 'MEMORY = {"own": -1.0, "sum": 0.0, '),
    ("return (estimate(me),)", "return (me.name,)"),
    ("def receive(me, message):\n    pass", "def receive(me, message):\n    me.sum += message[0]"),
    ("def fuse(me):\n    pass", "def fuse(me):\n    me.own = me.name"),
)


@pytest.mark.interpreted
def test_news_of_the_leader_come_a_robot_further_each_round():
    """The example by hand: on a line, robot i believes in round k what robot 0 had seen in round k - i."""
    (setting,) = fixed(LEADER, robots=5, rounds=9, topology="line")
    fields, estimates, _ = record_trial(setting, SEED, 0)
    for k in range(1, 10):
        for i in range(min(k, 5)):
            assert estimates[k, i] == fields["x_hat"][k - i, 0]
            assert fields["since"][k, i] == k - i
            assert fields["leader"][k, i] == 0.0


@pytest.mark.interpreted
def test_results_say_who_is_anonymous():
    study = study_of(["minimalistic", LEADER], robots=3, accuracy=0.7, rounds=2, trials=1, fill_ratio=0.5)
    assert sc.run(study)["anonymous"].values.tolist() == [1, 0]


@pytest.mark.interpreted
def test_partly_named_swarm_is_not_anonymous():
    study = study_of(
        brain(MEANS, "means.py"), robots=3, accuracy=0.7, rounds=2, trials=1,
        members=[{"robots": [0, 1], "brain": brain(HEARS)}], fill_ratio=0.5,
    )  # fmt: skip
    assert sc.run(study)["anonymous"].values.tolist() == [1, 0]
