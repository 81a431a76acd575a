"""Replay and inference from recorded data, and one trial a stretch at a time."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.simulation import living
from swarmcensus.simulation.living import Stepped
from swarmcensus.summaries import recordings
from swarmcensus.summaries.replaying import recording
from tests.support.small import study_of

READINGS = np.array([[0, 1, 1], [1, 1, np.nan], [0, 1, 1], [1, 0, 1]])


def by_hand(readings, every, messages, b=0.8, w=0.8):
    functions = brains.load("minimalistic").functions
    states = [brains.load("minimalistic").robot(b, w) for _ in readings.T]
    out = [[functions.estimate(me) for me in states]]
    for step, row in enumerate(readings):
        for me, z in zip(states, row, strict=True):
            if not np.isnan(z):
                functions.observe(me, z, 1.0)
        said = [functions.broadcast(me) for me in states]
        for sender, receiver in messages.get(step, ()):
            functions.receive(states[receiver], said[sender])
        if (step + 1) % every == 0 or step == len(readings) - 1:
            for me in states:
                functions.fuse(me)
            out.append([functions.estimate(me) for me in states])
    return np.array(out)


BOTH = pytest.mark.parametrize("compiled", [True, False])


@BOTH
def test_edges_exchange_at_the_end_of_each_round(compiled):
    trace = sc.infer(READINGS, [[0, 1]], 0.8, 2, compiled=compiled)
    pair = [(1, 0), (0, 1)]
    assert (trace["estimate"].values == by_hand(READINGS, 2, {1: pair, 3: pair})).all()
    assert trace["round"].values.tolist() == [0, 1, 2]
    assert set(brains.load("minimalistic").memory) < set(trace.data_vars)


@BOTH
def test_steps_left_over_end_without_an_exchange(compiled):
    trace = sc.infer(READINGS, [[0, 1]], 0.8, 3, compiled=compiled)
    assert (trace["estimate"].values == by_hand(READINGS, 3, {2: [(1, 0), (0, 1)]})).all()
    assert trace["t"].values[-1].tolist() == [4, 4, 3]


@BOTH
@pytest.mark.parametrize("every", [1, 2])
def test_messages_are_heard_at_their_step(compiled, every):
    trace = sc.infer(READINGS, [[3, 0, 2], [0, 0, 1], [1, 1, 0], [1, 2, 0]], 0.8, every, compiled=compiled)
    expected = by_hand(READINGS, every, {0: [(0, 1)], 1: [(1, 0), (2, 0)], 3: [(0, 2)]})
    assert (trace["estimate"].values == expected).all()


def test_a_trial_on_directed_links_is_recorded_as_messages():
    """And both the engine and CPython make the same of them, bit for bit."""
    edges = [[0, 1], [1, 2], [2, 0], [3, 0], [0, 3]]
    study = study_of(
        ["minimalistic", "legacy"], robots=5, accuracy=0.7, rounds=7, looks=3, trials=2,
        topology={"name": "office", "edges": edges, "directed": True},
    )  # fmt: skip
    results = sc.run(study, jobs=1)
    for k, setting in enumerate(study.settings()):
        readings, messages = recording(results, k, 1)
        assert set(map(tuple, messages.tolist())) == {(3 * c + 2, u, v) for c in range(7) for u, v in edges}
        again = sc.replay(results, k, 1)
        assert again["estimate"].values[-1].tolist() == results["final_estimate"].values[k, 1].tolist()
        for compiled in (True, False):
            trace = sc.infer(readings, messages, 0.7, 3, setting.brain, compiled=compiled)
            for name in (*setting.brain.memory, "estimate"):
                assert (trace[name].values == again[name].values).all()
        alone = sc.infer(readings, None, 0.7, 3, setting.brain)["estimate"].values
        assert (alone[:, 4] == again["estimate"].values[:, 4]).all()  # nobody speaks to the last one


def test_default_length_of_a_round():
    readings = np.ones((20, 2))
    for links, rounds in (([[0, 1]], 3), ([[5, 0, 1]], 21), (None, 3)):
        assert sc.infer(readings, links, 0.8).sizes["round"] == rounds


def test_forms_of_accuracy():
    def final(accuracy):
        return sc.infer(READINGS, None, accuracy, 1)["x_hat"].values[-1]

    assert (final(0.8) == final([0.8, 0.8, 0.8])).all()
    assert (final(0.8) == final({"black": 0.8, "white": 0.8})).all()
    several = final({"black": np.array([0.9, 0.8, 0.8]), "white": 0.7})
    assert several[0] == final({"black": 0.9, "white": 0.7})[0] == pytest.approx((0.5 + 0.7 - 1) / (0.9 + 0.7 - 1))


@pytest.mark.parametrize(("arguments", "said"), [
    ({"observations": [[0, 2]]}, r"observations\[0, 1\] = 2: should be 0"),
    ({"observations": [0, 1]}, r"should be \(step, robot\)"),
    ({"observations": "hello"}, "hello is a file: give what pandas.read_csv reads, or an array"),
    ({"observations": np.zeros((0, 2))}, "one of each at least"),
    ({"links": [[0, 3]]}, r"links\[0\] = \[0, 3\] names a robot that is not there: the robots are numbered 0 to 2"),
    ({"links": [[0, 0]]}, "joins a robot to itself"),
    ({"links": [[0, 1, 2, 0]]}, r"should be \(edge, 2\)"),
    ({"links": [[0.5, 1]]}, "whole numbers"),
    ({"links": [[4, 0, 1]]}, "steps are numbered 0 to 3"),
    ({"accuracy": 1.5}, r"accuracy 1.5: should lie in \[0, 1\]"),
    ({"accuracy": [0.5, 0.6]}, "one for each of 3 robots"),
    ({"accuracy": {"black": 0.5}}, "should be black and white"),
    ({"accuracy": None}, "must be said"),
    ({"accuracy": float("nan")}, r"\[0, 1\]"),
    ({"observations_per_round": 0}, "whole number from 1"),
    ({"brain": "nobody"}, "neither a shipped brain"),
])  # fmt: skip
def test_what_is_refused(arguments, said):
    with pytest.raises(sc.InputError, match=said):
        sc.infer(**({"observations": READINGS, "links": [[0, 1]], "accuracy": 0.8} | arguments))


def test_replay_of_what_is_not_there(small_results):
    for where, said in (((99, 0), "setting=99: these results hold setting 0 to 31"),
                        ((0, 4), "trial=4: these results hold trial 0 to 3")):  # fmt: skip
        with pytest.raises(sc.InputError, match=said):
            sc.replay(small_results, *where)


def test_accuracies_as_they_are_written():
    for text in ("{black = 0.9, white = 0.6}", "black=0.9 white=0.6"):  # the latter as it is printed
        assert recordings.read_accuracy(text) == {"black": 0.9, "white": 0.6}
    for bad in ("good", "0.1,0.2", "U(0.6, 0.8)"):
        with pytest.raises(sc.InputError, match="should be"):
            recordings.read_accuracy(bad)


def test_traces_are_written_as_csv_or_netcdf(small_results, tmp_path):
    import pandas as pd
    import xarray as xr

    trace = sc.replay(small_results, 0, 0)
    recordings.write_trace(trace, tmp_path / "t.csv")
    recordings.write_trace(trace, tmp_path / "t.nc")
    frame = pd.read_csv(tmp_path / "t.csv")
    assert np.allclose(frame["estimate"].values.reshape(trace["estimate"].shape), trace["estimate"].values, atol=1e-15)
    with xr.open_dataset(tmp_path / "t.nc", engine="h5netcdf") as read:
        assert read.load().equals(trace)
    with pytest.raises(sc.InputError, match=r"\.csv or \.nc"):
        recordings.write_trace(trace, tmp_path / "t.txt")


# ---- one trial a stretch at a time; test_recorded.py compares it with what `replay` shows
NETWORK, MOVING = ({"topology": "ring", "fill_ratio": 0.6}, {"topology": "moving", "density": 3.0, "fill_ratio": 0.6})
CASES = {
    "lossy": ({}, {**NETWORK, "topology": "scale-free", "link_success": 0.5}, {}),
    "silent": ({"brain": "voter"}, {**NETWORK, "topology": "full", "link_success": 0.7}, {}),
    "moving late": ({}, {**MOVING, "body": {"message_delay": 3}}, {}),
    "moving silent": ({"brain": "voter"}, MOVING, {}),
}


def changing_study(swarm, world, more, rounds=90):
    length = {"ticks" if world["topology"] == "moving" else "rounds": rounds}
    robots = {"robots": 8, "accuracy": "U(0.6, 0.9)"}
    return sc.Study(trials=2, seed=5, swarm=robots | swarm, world=world, schedule=length, **more)


@pytest.fixture
def short(monkeypatch):
    """Stretches of twenty rounds, and room for two of them and for few copies."""
    monkeypatch.setattr(living, "MOST_ROUNDS", 20)
    monkeypatch.setattr(living, "KEPT_BYTES", 40_000)


@pytest.mark.parametrize("name", CASES)
def test_it_can_be_looked_at_in_any_order(name, short):
    study = changing_study(*CASES[name])
    life = Stepped(study.settings()[0], study.seed, 1)
    once = [life.at(k) for k in range(5)]
    for k in (3, 0, 4, 1, 1, 2, 0):
        for name, value in vars(life.at(k)).items():
            if isinstance(value, np.ndarray):
                np.testing.assert_array_equal(value, getattr(once[k], name))


def test_what_is_kept_does_not_grow(short):
    study = changing_study({}, MOVING, {}, rounds=2000)
    life = Stepped(study.settings()[0], study.seed, 1)
    for k in range(100):
        life.at(k)
    assert sum(part.bytes for part in life._kept.values()) <= living.KEPT_BYTES or len(life._kept) == 1
    assert len(life._copies) <= max(1, living.KEPT_BYTES // sum(array.nbytes for array in life._world.arrays))


def test_a_way_is_gone_step_by_step(short):
    life = Stepped(changing_study({}, NETWORK, {}).settings()[0], 5, 1)
    assert [life.approach(3) for _ in range(5)] == [False, False, False, True, True]
