"""me.name: robots are told apart, and a brain that asks for it is not anonymous."""

import pytest

import swarmcensus as sc
from swarmcensus import brains
from tests.support.places import EXAMPLE
from tests.support.second import MEANS, brain, changed, fixed
from tests.support.small import SEED, study_of
from tests.support.trials import record_trial

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
