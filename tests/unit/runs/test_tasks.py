"""What a study's work is cut into, and the order in which it is run."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.runs.tasks import plan_tasks

LONG = {
    "trials": 40,
    "swarm": {"robots": [50, 100], "accuracy": [0.6, 0.8]},
    "world": {"topology": ["ring", "scale-free", "moving"], "density": 1, "fill_ratio": [0.55, 0.95]},
    "schedule": {"rounds": 1000, "ticks": 1000},
}


@pytest.mark.parametrize("local", [False, True])
@pytest.mark.parametrize("seconds", [0.1, 30.0], ids=["threads", "workers of a cluster"])
def test_some_trials_of_every_setting_come_before_more_of_any(seconds, local):
    tables = LONG
    if local:
        tables = LONG | {"world": {"topology": ["ring", "full"], "fill_ratio": 0.55}, "schedule": {"rounds": 1000}}
    settings = sc.Study(**tables).settings()
    wanted = np.ones((len(settings), 40), np.bool_)
    tasks = plan_tasks(settings, wanted, wanted if local else None, seconds)
    seen = np.zeros((2, *wanted.shape), np.int64)
    for task in tasks:
        of_kind = seen[int(task.kind == "local")]
        before = of_kind.any(axis=1)
        again = before[list(task.settings)].any()
        assert not again or seen[: 1 + local].any(axis=2).all(), "a second task before the first of another setting"
        of_kind[list(task.settings), task.first : task.first + task.trials] += 1
    assert (seen[: 1 + local] == 1).all(), "every trial once"


def test_trials_done_already_are_left_out():
    settings = sc.Study(**LONG).settings()
    wanted = np.random.default_rng(1).random((len(settings), 40)) < 0.3
    seen = np.zeros(wanted.shape, np.int64)
    for task in plan_tasks(settings, wanted, None, 0.1):
        seen[list(task.settings), task.first : task.first + task.trials] += 1
    assert np.array_equal(seen, wanted)
