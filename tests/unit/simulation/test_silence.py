"""Silence: `broadcast` may return None, and what is sent and heard is counted, robot by robot."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.engine.constants import HEARD, SENT
from swarmcensus.simulation.rides import record_ride, run_ride
from swarmcensus.simulation.trials import Metrics, record_trial, run_batch
from tests.support.second import brain, changed, fixed, moving
from tests.support.small import GO, SEED, study_of

EARS = (
    ("MEMORY = {", 'MEMORY = {"ears": 0.0, '),
    ("def receive(me, message):\n    pass", "def receive(me, message):\n    me.ears += 1.0 + message[0] - message[0]"),
)
ODD = changed(
    ("return (estimate(me),)", "if me.t % 2.0 == 1.0:\n        return (estimate(me),)"), *EARS
)  # or else None
ADDS = changed(('MESSAGE = ("x",)', 'MESSAGE = ("x",)\nSUMS = ("ears",)'), source=ODD)
MUTE = changed(("return (estimate(me),)", "return None"), *EARS)
LOUD = changed(*EARS)
NAMED = changed(("me.t % 2.0 == 1.0", "me.name == 1.0 or me.t == 3.0"), source=ODD)
MEASURE = Metrics(0.01, 10, ())


def counts(source, trial=0, **world):
    """Sent and heard of each robot, by a batch; what the robots counted themselves, in their traces, is the same."""
    (setting,) = fixed(brain(source), **world)
    batch = run_batch(setting, SEED, trial, 1, MEASURE, GO)
    assert (record_trial(setting, SEED, trial)[0]["ears"][-1] == batch.counts[0, HEARD]).all()
    return batch.counts[0, SENT].tolist(), batch.counts[0, HEARD].tolist()


@pytest.mark.interpreted
@pytest.mark.parametrize("source", [ODD, ADDS], ids=["each", "sums"])
@pytest.mark.parametrize(
    ("world", "sent", "heard"),
    [
        ({"topology": "line", "robots": 3}, [2, 2, 2], [2, 4, 2]),
        ({"topology": "ring", "robots": 4}, [2] * 4, [4] * 4),
        ({"topology": "full", "robots": 5}, [2] * 5, [8] * 5),
        ({"topology": "ring", "robots": 1}, [2], [0]),
        ({"topology": {"name": "way", "edges": [[0, 1], [2, 1]], "directed": True}, "robots": 3}, [2] * 3, [0, 4, 0]),
        ({"topology": "line", "robots": 3, "faults": [{"at": 3, "robots": 3, "stop": "talking"}]}, [1] * 3, [1, 2, 1]),
        ({"topology": "full", "robots": 3, "faults": [{"at": 1, "robots": 3, "stop": "talking"}]}, [0] * 3, [0] * 3),
        ({"topology": "line", "robots": 3, "faults": [{"at": 2, "robots": 3, "stop": "sensing"}]}, [4] * 3, [4, 8, 4]),
    ],
)
def test_who_speaks_in_odd_rounds_by_hand(source, world, sent, heard):
    """Four rounds of one look each: a robot speaks after its first and its third; where it sees no more, it goes on."""
    assert counts(source, rounds=4, **world) == (sent, heard)


@pytest.mark.interpreted
def test_who_speaks_by_its_name_by_hand():
    """Robot 1 of a line of four speaks in each of four rounds, the others in the third."""
    assert counts(NAMED, rounds=4, robots=4, topology="line") == ([1, 4, 1, 1], [4, 2, 5, 1])
    assert counts(NAMED, rounds=4, robots=4, topology="full") == ([1, 4, 1, 1], [6, 3, 6, 6])


@pytest.mark.interpreted
def test_nothing_is_heard_of_what_was_not_said():
    """A message of zeros would count as one: what is summed up is what was said, of who spoke in that very round."""
    speaks = changed(("me.ears += 1.0 + message[0] - message[0]", "me.ears += 1.0 + message[0]"), source=ODD)
    adds = changed(('MESSAGE = ("x",)', 'MESSAGE = ("x",)\nSUMS = ("ears",)'), source=speaks)
    for topology in ("ring", "full"):
        ears = []
        for source in (speaks, adds):
            (setting,) = fixed(brain(source), topology=topology, rounds=4)
            fields, estimates, _ = record_trial(setting, SEED, 0)
            ears.append(fields["ears"])
        neighbours = 2 if topology == "ring" else 4
        for k in (1, 3):
            said = 1.0 + estimates[k]
            ring = np.roll(said, 1) + np.roll(said, -1) if topology == "ring" else said.sum() - said
            grown = ears[0][k] - ears[0][k - 1]
            assert grown == pytest.approx(ring)
            assert grown.min() >= neighbours
            assert (ears[0][k + 1] == ears[0][k]).all()
        assert ears[0] == pytest.approx(ears[1], rel=1e-12)


@pytest.mark.long(but_every=3)
@pytest.mark.interpreted
@pytest.mark.parametrize("source", [ODD, ADDS, LOUD], ids=["each", "sums", "loud"])
@pytest.mark.parametrize("delay", [0, 2])
def test_on_the_move(source, delay):
    """What is heard was said `delay` ticks before, by robots in reach now."""
    setting = moving(brain(source), ticks=30, body={"message_delay": delay})
    ride, (batch,) = record_ride(setting, SEED, 1), run_ride([setting], SEED, 1, MEASURE, GO)
    made = np.vstack([np.zeros(6), np.cumsum(~np.isnan(ride.readings[1:]), axis=0)])
    speaks = np.ones((31, 6), bool) if source == LOUD else made % 2 == 1
    assert batch.counts[0, SENT].tolist() == speaks[1:].sum(axis=0).tolist()
    heard = np.zeros(6)
    for tick, one, other in ride.links:
        for me, by in ((one, other), (other, one)):
            heard[me] += tick >= delay and speaks[tick - delay, by]
    assert heard.sum() > 0
    assert batch.counts[0, HEARD].tolist() == heard.tolist()
    assert (ride.fields["ears"][-1] == heard).all()


@pytest.mark.interpreted
def test_message_counts_are_missing_without_a_robot():
    study = study_of(brain(ODD), robots=[2, 4], accuracy=0.7, rounds=5, looks=1, trials=2, seed=3, fill_ratio=0.5)
    once = sc.run(study, jobs=1)
    nobody = np.nan
    for name, counts in (
        ("messages_sent", [[3, 3, nobody, nobody], [3, 3, 3, 3]]),
        ("messages_heard", [[3, 3, nobody, nobody], [6, 6, 6, 6]]),
    ):
        assert np.array_equal(once[name].values[:, 1], counts, equal_nan=True)
