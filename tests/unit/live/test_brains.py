"""Parameters of brains that are watched, when a trial settles, and the links of a chosen robot."""

import json

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.live.choices import check_moment, offer_of, wanted
from swarmcensus.live.frames import Show
from swarmcensus.live.robots import robot_of
from swarmcensus.live.sessions import Session
from swarmcensus.live.settling import Settling
from swarmcensus.simulation import Stepped
from swarmcensus.support.errors import InputError
from tests.support.small import study_of

CENSUS = {"brain": "census", "topology": "ring", "robots": "6"}


def ask(session, **words):
    while True:
        [*_, answer] = session.answer(json.dumps(words))
        if not answer.get("going"):
            return answer


@pytest.mark.interpreted
def test_parameters_are_set_and_shown():
    found = wanted(offer_of(None), CENSUS | {"brain.momentum": "0.5", "beside": "census", "beside.z": "2"})
    first, beside = (setting.brain.parameters for setting in found.settings)
    assert (first["momentum"], first["z"]) == (0.5, brains.load("census").parameters["z"])
    assert (beside["momentum"], beside["z"]) == (0.9, 2.0)
    begun = ask(Session(offer_of(None)), do="begin", ask=CENSUS | {"brain.momentum": "0.5"})
    assert begun["form"]["now"]["brain"] == "census"
    momentum = {"key": "brain.momentum", "name": "momentum", "brain": "census", "now": "0.5"}
    assert begun["form"]["parameters"][0] == momentum


@pytest.mark.parametrize(("asked", "said"), [
    ({"brain.momentun": "0.5"}, "no parameter 'momentun': did you mean 'momentum'?"),
    ({"beside": "census", "beside.z": "nan"}, "z = nan: not a number"),
    ({"brain.momentum": "[[1, 2]]"}, "momentum = [1, 2]: "),
    ({"beside.z": "1"}, "beside.z: no second brain is selected"),
    ({"brain": "minimalistic", "brain.momentum": "0.5"}, "the brain 'minimalistic' has no parameter 'momentum'"),
    ({"momentum": "0.5"}, "unknown key momentum"),
])  # fmt: skip
def test_a_wrong_parameter_is_named(asked, said):
    with pytest.raises(InputError) as told:
        wanted(offer_of(None), CENSUS | asked)
    assert said in str(told.value)


@pytest.mark.interpreted
def test_the_command_takes_parameters(here, refused):
    ring = ["--set", "brain=census", "--set", "topology=ring", "--set", "rounds=20"]
    words = ["watch", *ring, "--out", "run.html", "--set"]
    assert main([*words, "brain.momentum=0.5"]) == 0
    assert "momentum = 0.5" in (here / "run.html").read_text()
    for wrong, said in (
        (["brain.trust=0.9"], "the brain 'census' has no parameter 'trust'"),
        (["brain.z=7", "--set", "robots=many"], 'a small swarm: swarm.robots = "many": should be'),
        (["brain.z=7", "--set", "brain.z=5"], "--set brain.z: the name is given twice"),
        (["trial=3"], "--set trial: is no key of a study: --view trial=... is for it"),
        (["seed=3", "--view", "robots=3"], "--view robots: did you mean 'robot'?"),
        (["brain.z=7", "--set", "=1"], "--set =1: should"),
    ):
        assert said in refused(*words, *wrong)


@pytest.mark.parametrize(("played", "said"), [
    ({"zoom": "0.5"}, "zoom = 0.5: should be a number from 1 to 40"),
    ({"centre": "2,0"}, "centre = 2,0: should be two numbers from 0 to 1, such as 0.25,0.5"),
    ({"log": "yes"}, "log = yes: should be 0 or 1"),
    ({"speed": "0"}, "speed = 0: should be a number from 1 to 10000, or Infinity"),
])  # fmt: skip
def test_a_wrong_view_is_refused(played, said):
    found = wanted(offer_of(None), {})
    check_moment(found, {"zoom": "3", "centre": "0.25,1", "follow": "1", "log": "1", "full": "0", "speed": "20"})
    check_moment(found, {"speed": "Infinity"})  # what the page calls as fast as possible
    with pytest.raises(InputError) as told:
        check_moment(found, played)
    assert str(told.value) == said


@pytest.mark.interpreted
def test_a_trial_settles_when_its_results_say_so():
    study = study_of(robots=11, accuracy=0.8, rounds=150, trials=2, seed=3, fill_ratio=0.6)
    session = Session(offer_of(study))
    ask(session, do="begin", ask={"trial": "1"})
    data = sc.run(study, jobs=1)
    assert ask(session, do="settled")["settled"] == [float(np.median(data["convergence_round"].values[0, 1]))]


def test_what_never_settles_or_is_too_large_has_no_k(monkeypatch):
    found = wanted(offer_of(None), {"topology": "ring", "robots": "5", "rounds": "30"})
    show = Show(Stepped(found.settings[0], 1, 0), found.study.measure)
    for most, delta in ((1000, 1e-12), (100, 1.0)):
        monkeypatch.setattr("swarmcensus.live.settling.MOST_VALUES", most)
        show.delta = delta
        settling = Settling(show)
        while not settling.on():
            pass
        assert settling.median() is None


@pytest.mark.parametrize("asked", [{"topology": "full", "robots": "150"}, {"topology": "ring", "robots": "10001"}])
def test_links_of_a_chosen_robot(asked):
    found = wanted(offer_of(None), asked | {"link_success": "0.5", "rounds": "3"})
    show = Show(Stepped(found.settings[0], 1, 0), found.study.measure)
    assert not show.edges.size
    assert show.trace.reach(2)
    told = robot_of(show, 2, 7)
    assert told["hears"] == ([i for i in range(150) if i != 7] if asked["topology"] == "full" else [6, 8])
    carried = [sender for sender, here in zip(told["hears"], told["carried"], strict=True) if here]
    if told["heard_at"] == 2:
        assert [one["from"] for one in told["heard"]] == carried
    else:
        assert carried == []
