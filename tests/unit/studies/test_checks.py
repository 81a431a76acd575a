"""Keys that mean nothing are errors; values that mean something are taken however they are given."""

import numpy as np
import pandas as pd
import pytest

import swarmcensus as sc
from tests.support.small import BOTH, MOVING, RING


def study(world=RING, robots=5, **tables):
    return sc.Study(**{"trials": 1, "swarm": {"robots": robots, "accuracy": 0.7}, "world": world} | tables)


def fault(**changes):
    return [{"at": 1, "robots": 1, "stop": "talking"} | changes]


USELESS = [
    (RING, {"schedule": {"ticks": 5}}, "schedule.ticks"),
    (RING | {"density": 1}, {}, "world.density"),
    (RING | {"body": {"radius": 0.1}}, {}, "world.body is of robots that move"),
    (RING, {"measure": {"truth": "floor"}}, 'measure.truth = "floor"'),
    (MOVING, {"schedule": {"rounds": 5}}, "schedule.rounds"),
    (MOVING, {"schedule": {"observations_per_round": 5}}, "schedule.observations_per_round"),
    (MOVING | {"body": {"message_delay": 40}}, {"schedule": {"ticks": 40}}, "no message is heard within 40 ticks"),
    (RING, {"faults": fault(at=1001)}, "faults[0].at = 1001"),
    (RING, {"faults": fault(robots=0.05)}, "faults[0].robots = 0.05"),
    # of a base that only cases use, and of which they use something else
    (RING | {"density": 1}, {"case": [{"topology": "moving", "density": 2}]}, "world.density"),
]


@pytest.mark.parametrize(("world", "tables", "said"), USELESS)
def test_what_means_nothing_is_an_error(world, tables, said):
    with pytest.raises(sc.InputError) as caught:
        study(world, **tables)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("world", "tables"),
    [
        (BOTH | {"floor": "half", "body": {"radius": 0.05}},
         {"schedule": {"rounds": 5, "ticks": 9, "observations_per_round": 2}, "measure": {"truth": "floor"}}),
        (RING | {"density": None, "side": None, "floor": None}, {}),
        (RING | {"density": 1, "body": {}}, {"case": [{"topology": "moving", "ticks": 5}]}),
        (RING, {"faults": fault(at=1000, robots=1.0)}),
        (RING, {"schedule": {"rounds": [5, 10]}, "faults": fault(at=10)}),
    ],
)  # fmt: skip
def test_what_means_something_somewhere_is_taken(world, tables):
    made = study(world, **tables)
    assert sc.Study.parse(made.text).settings() == made.settings()


@pytest.mark.parametrize(
    "robots",
    [range(3, 6), np.arange(3, 6), (3, 4, 5), pd.Series([3, 4, 5]), [np.int64(3), np.uint8(4), 5]],
    ids=lambda v: type(v).__name__,
)
def test_whole_numbers_come_as_lists_of_any_kind(robots):
    made = study(robots=robots)
    assert [s.robots for s in made.settings()] == [3, 4, 5]
    assert sc.Study.parse(made.text).settings() == made.settings()


@pytest.mark.parametrize(("value", "shown"), [(np.float64(3.0), "3.0"), (3.0, "3.0"), (np.bool_(True), "true")])
def test_other_numbers_are_not_whole(value, shown):
    with pytest.raises(sc.InputError, match=f"schedule.rounds = {shown}: should be a valid integer"):
        study(schedule={"rounds": value})


def test_numbers_of_numpy_are_numbers():
    made = study(
        MOVING | {"link_success": np.float32(0.5), "body": {"radius": np.float64(0.07)}}, trials=np.int64(2),
        seed=np.uint16(3), robots=np.int32(5), schedule={"ticks": np.arange(5, 8)},
        measure={"bins": np.int8(5), "checkpoints": np.array(5)}, faults=fault(at=np.int64(2), robots=np.float64(0.5)),
    )  # fmt: skip
    assert (made.trials, made.seed, made.measure.bins, made.checkpoints) == (2, 3, 5, [5])
    assert sc.Study.parse(made.text).settings() == made.settings()
    with pytest.raises(sc.InputError, match=r"world\.density = true"):
        study(MOVING | {"density": True})


def test_keys_of_fixed_networks_do_not_multiply_those_that_move():
    settings = study(BOTH | {"message_delay": [0, 2]}).settings()
    assert [(s.topology.name, s.delay) for s in settings] == [("ring", 0), ("ring", 2), ("moving", 0)]
