"""Messages that are rounds late on fixed networks: held against the reference and sums by hand, and what is told."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.engine.constants import HEARD, SENT
from swarmcensus.simulation.trials import Metrics, run_batch
from swarmcensus.studies import addresses
from swarmcensus.studies.coordinates import coordinates_of
from swarmcensus.summaries.replaying import recording
from tests.support.places import ROOT
from tests.support.small import GO, MOVING, RING, SEED, settings_of, study_of
from tests.support.trials import record_trial

COMMONS = ROOT / "tests" / "support" / "commons.py"


def test_without_a_delay_all_is_as_before():
    """To the bit, and to the fingerprint by which finished trials are found."""
    plain, told, late = (settings_of(message_delay=delay) if delay else settings_of() for delay in ((), [0], [2]))
    assert plain == told
    assert addresses.fingerprint(plain[0], 1) == addresses.fingerprint(told[0], 1) != addresses.fingerprint(late[0], 1)
    assert "message_delay" not in coordinates_of(plain[0])
    assert str(late[0]) == str(plain[0]).replace(", C =", ", delay 2, C =")


def test_late_messages_have_the_same_draws_and_losses():
    """Settings that differ in the delay alone see the same tiles, and lose the messages of the same rounds."""
    now, late = settings_of(robots=8, rounds=60, link_success=0.5, message_delay=[0, 5])
    for key in ("readings_key", "losses_key"):
        assert (getattr(addresses, key)(now, SEED) == getattr(addresses, key)(late, SEED)).all()
    counts = [run_batch(one, SEED, 0, 1, Metrics(0.01, 10, ()), GO).counts[0] for one in (now, late)]
    first = [run_batch(one, SEED, 0, 1, Metrics(0.01, 10, ()), GO).counts[0]
             for one in settings_of(robots=8, rounds=5, link_success=0.5)]  # fmt: skip
    assert (counts[0][SENT] == counts[1][SENT]).all()
    assert (counts[0][HEARD] - counts[1][HEARD] == first[0][HEARD]).all()


@pytest.mark.parametrize(
    ("topology", "robots"),
    [
        pytest.param("ring", 6, marks=pytest.mark.interpreted),
        pytest.param("full", 7, marks=pytest.mark.interpreted),
        pytest.param("full", 33_000, marks=pytest.mark.long),
    ],
)
def test_sums_are_mixed_with_those_of_some_rounds_ago(topology, robots):
    """By hand: s(t) = D y(t) + O y(t - d), where y is what is said, and s(t) = y(t) as long as nothing is heard.

    The larger full network is one that does not pass through the cache as a whole.
    """
    delay, looks, f_b = 2, 3, 0.8
    (setting,) = settings_of(robots, str(COMMONS), f_b, rounds=5, looks=looks, topology=topology, message_delay=delay)
    fields, _, blacks = record_trial(setting, SEED, 0)
    k = 2 * f_b - 1
    said, s = [], np.zeros(robots)
    for t in range(1, 6):
        said.append(s + k * (blacks[t] - looks * (1 - f_b)))
        s = said[-1]
        if t > delay:
            old = said[-1 - delay]
            heard = old.sum() - old if topology == "full" else np.roll(old, 1) + np.roll(old, -1)
            s = (s + heard) / (robots if topology == "full" else 3)
        assert fields["s"][t] == pytest.approx(s, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("world", "tables", "said"),
    [
        (RING | {"message_delay": 1000}, {}, "world.message_delay = 1000"),
        (RING, {"case": [{"rounds": 9, "message_delay": [0, 9]}]}, "case[0].message_delay = 9"),
        (RING | {"message_delay": -1}, {}, "world.message_delay = -1"),
        (MOVING | {"message_delay": 2}, {}, "is world.body.message_delay, in ticks"),
        (RING | {"message_delay": [2, 2]}, {}, "a value is twice"),
    ],
)
def test_wrong_delays_are_named(world, tables, said):
    with pytest.raises(sc.InputError) as caught:
        sc.Study(**{"trials": 1, "swarm": {"robots": 5, "accuracy": 0.7}, "world": world} | tables)
    assert said in str(caught.value)


def test_results_say_how_late_messages_were():
    brains = ["minimalistic", "commons"]
    data = sc.run(study_of(brains, robots=6, accuracy=0.8, rounds=40, message_delay=[0, 1, 4]), jobs=1)
    assert data["message_delay"].values.tolist() == [0, 1, 4] * 2
    assert (data["messages_heard"][0, 0] == 80).all()
    assert (data["messages_heard"][2, 0] == 72).all()
    assert (data["messages_sent"] == 40).all()
    trace = sc.replay(data, 5, 2)
    assert "delay 4, C = 40" in trace.attrs["title"]
    assert (trace["estimate"].values[-1] == data["final_estimate"].values[5, 2]).all()
    with pytest.raises(sc.InputError, match="no lost messages, no delays"):
        recording(data, 2, 0)
    assert recording(data, 0, 0)[0].shape == (400, 6)
