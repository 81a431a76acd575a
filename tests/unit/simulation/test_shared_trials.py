"""A trial of a large swarm that several threads share gives the bits of one thread, in every kind of world."""

import threading
import time

import numpy as np
import pytest

from swarmcensus.engine.constants import AHEAD, BLOCK, WRONG_IN
from swarmcensus.runs import tasks
from swarmcensus.runs.tasks import ThreadBudget
from swarmcensus.simulation import trials
from swarmcensus.simulation.trials import Metrics, run_batch
from tests.support.second import ADDS, ALL, TALKS
from tests.support.small import FAULTS, GO, PASSING, SEED, settings_of

LIARS = [{"robots": 0.3, "brain": "shouter", "honest": False}]
JAMMERS = [{"robots": 0.01, "brain": {"file": "jammer", "often": 0.5}, "honest": False}]
MIXED = [{"robots": 0.4, "brain": "talks.py", "accuracy": 0.9, "honest": False}]
DRIFT = {"start": "U(0.7, 0.9)", "drift": -0.02, "least": 0.6}
SLOW = {"from": 0.9, "to": 0.2, "at": 2, "until": 4}
MANY = 520  # robots: three blocks, the last of which is not full
WORLDS = {
    "ring": {},
    "full": {"topology": "full", "accuracy": "U(0.6, 0.9)"},
    "scale-free": {"topology": "scale-free", "message_delay": 2, "fill_ratio": SLOW, "accuracy": DRIFT},
    "late in full": {"topology": "full", "message_delay": 1, "looks": 17},
    "losses": {"link_success": 0.6, "faults": FAULTS},
    "pairs": {"topology": "full", "link_success": 0.6, "faults": PASSING[:1], "robots": 258, "rounds": 1},
    "liars": {"brain": "steadfast", "members": LIARS, "rounds": 3},
    "jammers": {"brain": "steadfast", "members": JAMMERS, "rounds": 3},
    "drawing and deciding": {"brain": "all.py", "members": MIXED, "rounds": 4},
    "silent sums": {"brain": "adds.py", "topology": "full"},
    "intervals": {"brain": "sure", "rounds": 3},
}
WAYS = [  # threads, rounds kept at a time, whether alone, world
    *(way for name in WORLDS for way in ((2, 9, False, name), (3, 2, False, name))),
    *((3, 2, True, name) for name in ("ring", "scale-free", "drawing and deciding")),
]


@pytest.fixture(autouse=True)
def here(here, monkeypatch):
    for name, source in {"all": ALL, "adds": ADDS, "talks": TALKS}.items():
        (here / f"{name}.py").write_text(source)
    monkeypatch.setattr(trials, "LARGE", 257)
    return here


def measured(batch):
    """All arrays of a batch; in which round a decision was wrong is left open where none was."""
    arrays = {name: value for name, value in vars(batch).items() if isinstance(value, np.ndarray)}
    return arrays | {"verdicts": batch.verdicts[..., :WRONG_IN]}


QUICK = ("2-9-False-full", "2-9-False-silent sums")


@pytest.mark.interpreted
@pytest.mark.long(but=[*QUICK, "3-2-True-ring"])
@pytest.mark.parametrize(("count", "rows", "local", "name"), WAYS)
def test_threads_that_share_a_trial_give_its_bits(count, rows, local, name, monkeypatch):
    """However many they are, where rounds run again for their curves, and where estimates of others were before."""
    given = {"robots": MANY, "rounds": 5, "looks": 2} | WORLDS[name]
    (setting,) = settings_of(**given)
    monkeypatch.setattr(trials, "segment_length", lambda *_: rows * (given["looks"] if local else 1))
    runs = 1 if name == "pairs" else 2
    measure, spare = Metrics(0.3, 7, (1, 2, given["rounds"]), estimates=True), {}
    alone, shared = (run_batch(setting, SEED, 1, runs, measure, GO, local, spare, lambda n=n: n) for n in (1, count))
    for variable, values in measured(alone).items():
        assert np.array_equal(values, measured(shared)[variable], equal_nan=True), variable


@pytest.mark.parametrize(("topology", "delay"), [("ring", 2), ("line", 0)])
def test_blocks_that_go_ahead_give_the_bits_of_single_rounds(topology, delay, monkeypatch):
    """In one thread, and in three with as few blocks as may go ahead; where one round is kept at a time, none does."""
    robots, rounds = 3 * 2 * AHEAD * BLOCK - 9, 2 * AHEAD + 3
    (setting,) = settings_of(robots=robots, rounds=rounds, topology=topology, message_delay=delay)
    found = []
    for rows, count in ((1, 1), (rounds, 1), (rounds, 3)):
        monkeypatch.setattr(trials, "segment_length", lambda *_, rows=rows: rows)
        batch = run_batch(setting, SEED, 0, 1, Metrics(0.3, 7, (AHEAD,), estimates=True), GO, idle=lambda n=count: n)
        found.append(measured(batch))
    for name, values in found[0].items():
        assert all(np.array_equal(values, other[name], equal_nan=True) for other in found[1:]), name


@pytest.mark.interpreted
def test_ctrl_c_ends_all_threads_of_a_trial():
    (setting,) = settings_of(robots=MANY, rounds=10_000)
    stop, begun = np.zeros(1, np.uint8), time.monotonic()
    timer = threading.Timer(0.3, stop.fill, (1,))
    timer.start()
    assert run_batch(setting, SEED, 0, 1, Metrics(0.01, 10, ()), stop, idle=lambda: 3) is None
    assert time.monotonic() - begun < 3.0
    timer.join()
    assert not [thread for thread in threading.enumerate() if thread.name == "swarmcensus"]


def test_threads_without_work_help_those_that_have_some():
    assert [ThreadBudget(16, set(range(bundles))).idle() for bundles in (0, 1, 3, 16, 64)] == [16, 16, 5, 1, 1]


@pytest.mark.parametrize(
    ("robots", "rounds", "crowd"), [(10**6, 100, True), (10**6, 30, False), (3 * 10**5, 500, False)]
)
def test_trials_that_take_much_memory_run_one_at_a_time(robots, rounds, crowd, monkeypatch):
    seen = []
    monkeypatch.setattr(tasks, "run_batch", lambda *given: seen.append((tasks.CROWDS.locked(), given[-1]())))
    settings = settings_of(robots=robots, rounds=rounds)
    tasks.run_bundle(settings, SEED, (tasks.Task("batch", (0,), 0, 1, 1.0),), None, GO, ThreadBudget(4, {1, 2}))
    assert seen == [(crowd, 4 if crowd else 2)]
