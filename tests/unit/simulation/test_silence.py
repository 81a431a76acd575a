"""Silence: `broadcast` may return None, and what is sent and heard is counted, robot by robot."""

import pytest

from swarmcensus.engine.constants import HEARD, SENT
from swarmcensus.simulation.trials import Metrics, record_trial, run_batch
from tests.support.second import brain, changed, fixed
from tests.support.small import GO, SEED

EARS = (
    ("MEMORY = {", 'MEMORY = {"ears": 0.0, '),
    ("def receive(me, message):\n    pass", "def receive(me, message):\n    me.ears += 1.0 + message[0] - message[0]"),
)
ODD = changed(
    ("return (estimate(me),)", "if me.t % 2.0 == 1.0:\n        return (estimate(me),)"), *EARS
)  # or else None
ADDS = changed(('MESSAGE = ("x",)', 'MESSAGE = ("x",)\nSUMS = ("ears",)'), source=ODD)
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
