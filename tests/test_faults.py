"""Robots that fail, on fixed networks and in motion."""

import numpy as np
import pytest

import swarmcensus as sc

STUDY = """
seed = 3
trials = 3
faults = [{at = 20, robots = 3, stop = "STOP"}]
[swarm]
brain = ["minimalistic", "legacy"]
robots = 8
accuracy = 0.7
[world]
topology = ["full", "ring", "scale-free"]
fill_ratio = 0.55
[schedule]
rounds = 40
"""
MOVING = (
    STUDY.replace('["full", "ring", "scale-free"]', '"moving"\ndensity = 6')
    .replace("rounds", "ticks")
    .replace("[swarm]", "[world.body]\nmessage_delay = 1\n[swarm]")
)


def traces(text, stop):
    whole = sc.Study.parse(text.replace('"STOP"', stop))
    sound = sc.Study.parse(text.replace('faults = [{at = 20, robots = 3, stop = "STOP"}]', ""))
    one, other = sc.run(whole), sc.run(sound)
    for k, setting in enumerate(whole.settings()):
        failed = np.flatnonzero((setting.stops(3, 1) == 20).any(axis=0))
        assert len(failed) == 3
        yield setting, failed, sc.replay(one, k, 1, links=True), sc.replay(other, k, 1, links=True)


@pytest.mark.parametrize("text", [STUDY, MOVING], ids=["fixed", "moving"])
def test_robots_that_stop_sensing_observe_no_more(text):
    for _, failed, trace, sound in traces(text, '"sensing"'):
        t = trace["t"].values
        assert (t[20:, failed] == t[19, failed]).all()
        others = np.setdiff1d(np.arange(8), failed)
        assert (t[:, others] == sound["t"].values[:, others]).all()
        assert (trace["estimate"].values[:20] == sound["estimate"].values[:20]).all()


def test_robots_that_stop_sensing_are_heard_as_ever():
    text = STUDY.replace('"STOP"', '"sensing"')
    heard = sc.run(sc.Study.parse(text))["messages_heard"]
    sound = sc.run(sc.Study.parse(text.replace("faults", "#")))["messages_heard"]
    assert (heard.values == sound.values).all()
    assert (heard.values[0] == 40 * 7).all()


def test_robots_that_stop_talking_are_heard_no_more():
    for setting, failed, trace, sound in traces(STUDY, '["talking"]'):
        assert trace["estimate"].values[:20] == pytest.approx(sound["estimate"].values[:20], abs=1e-12)
        assert (trace["alpha"].values == sound["alpha"].values).all()
        if setting.topology.name == "full" and setting.brain.name == "minimalistic":
            alpha = trace["alpha"].values[20:]
            speakers = np.setdiff1d(np.arange(8), failed)
            said = alpha[:, speakers].sum(axis=1, keepdims=True)
            own = np.where(np.isin(np.arange(8), speakers), alpha, 0.0)
            assert trace["beta"].values[20:] == pytest.approx(said - own, rel=1e-9)


def test_moving_robots_that_stop_talking_are_heard_until_their_last_message_arrives():
    for setting, failed, trace, _ in traces(MOVING, '["talking"]'):
        if setting.brain.name != "minimalistic":
            continue
        alpha, expected = trace["alpha"].values, np.zeros_like(trace["alpha"].values)
        heard = np.zeros(expected.shape, bool)
        for tick, *ends in trace["link"].values:
            for receiver, sender in (ends, ends[::-1]):
                if sender not in failed or tick - 1 < 20:
                    expected[tick, receiver] += alpha[tick - 1, sender]
                    heard[tick, receiver] = True
        assert trace["beta"].values[heard] == pytest.approx(expected[heard], rel=1e-12)


def test_robots_that_stop_moving_stand_still():
    for _, failed, trace, sound in traces(MOVING, '"moving"'):
        place = trace["position"].values
        assert (place[:20] == sound["position"].values[:20]).all()
        # the wheels' lag and others' pushes are all that moves them: a tenth of a tick's way, and contact
        assert np.abs(place[21:, failed] - place[20, failed]).max() < 0.05
        assert (trace["looked"].values[20:, failed] == 1).all()


def test_who_fails_differs_between_trials_and_faults():
    study = sc.Study.parse(
        STUDY.replace(
            '[{at = 20, robots = 3, stop = "STOP"}]',
            '[{at = 5, robots = 0.5, stop = "sensing"}, {at = 9, robots = 0.5, stop = ["talking", "sensing"]}]',
        )
    )
    setting = study.settings()[0]
    picked = [tuple(map(tuple, setting.stops(3, trial))) for trial in range(6)]
    assert len(set(picked)) == 6
    stops = setting.stops(3, 0)
    assert (stops[2] == 9).sum() == 4
    assert set(stops[1]) <= {5, 9, 1 << 62}
    assert (stops[1] == 5).sum() == 4


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ('{at = 0, robots = 3, stop = "sensing"}', "faults[0].at = 0: should be greater"),
        ('{at = 5, robots = 9, stop = "sensing"}', "faults[0].robots = 9: there are 8 robots"),
        ('{at = 5, robots = 1.5, stop = "sensing"}', "a whole number, or a fraction in [0, 1]"),
        ('{at = 5, robots = true, stop = "sensing"}', "faults[0].robots = true: robots of a fault are a whole number"),
        ('{at = 5, robots = "3", stop = "sensing"}', 'faults[0].robots = "3": robots of a fault are a whole number'),
        ('{at = 5, robots = 3, stop = "smiling"}', "faults[0].stop = \"smiling\": should be 'moving', 'sensing' or"),
        ("{at = 5, robots = 3, stop = []}", "faults[0].stop = []"),
        ('{at = 5, robots = 3, stop = "moving"}', "these robots never move"),
        ('{at = 5, robots = 3, stops = "sensing"}', "unknown key faults[0].stops"),
    ],
)
def test_what_is_wrong_is_named(fault, said):
    with pytest.raises(sc.InputError) as caught:
        sc.Study.parse(STUDY.replace('{at = 20, robots = 3, stop = "STOP"}', fault))
    assert said in str(caught.value)
