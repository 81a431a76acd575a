"""Brains say what they need of a study, and a study that does not give it is warned of in a line for each brain."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.studies import unmet_needs
from tests.support.small import study_of

W_MSR = "w-msr says nothing before round 1,351; this study has 300 (phase = 450, run = 0, silent = 3)"
ONE_WAY = {"name": "round", "edges": [[k, (k + 1) % 5] for k in range(5)], "directed": True}
VALUES = ((0.7, 0.35, 300), (0.9, 0.2, 100), (0.7, 0.85, 1000), (0.9, 0.65, 100))  # accuracy, fill ratio, rounds


def unmet(brain, bins=2, **given):
    return unmet_needs(study_of(brain, **{"accuracy": 1.0, "rounds": 300} | given).settings(), bins)


@pytest.mark.parametrize(("brain", "given", "said"), [
    ("w-msr", {"topology": "full", "robots": 6}, [W_MSR]),
    ("w-msr", {"rounds": 1351, "robots": 6, "topology": "full"}, []),
    ("w-msr", {"rounds": 2000}, ["w-msr needs 5 neighbours; most robots of ring have 2 or fewer (drop = 2)"]),
    ({"file": "gated-mean", "run": 300, "debiased": [0, 1]}, {"accuracy": 0.7},
     ["gated-mean takes readings for the truth, so an accuracy of 0.7 biases its estimates (debiased = 0)"]),
    ("three-state", {"rounds": 2500}, ["three-state needs 50 robots; this study has 5"]),
    ("bayes-bots", {}, ["bayes-bots needs 4,000 rounds; this study has 300 (every = 200, prior = 10)"]),
    ("recurrent", {}, ["recurrent is made for an answer after round 100; this study has 300 (run = 0)"]),
    ("voter", {"bins": 10}, ["voter answers whether f is above one half; this study asks for one of 10 bins"]),
    ("voter", {}, []),
    ({"file": "w-msr", "run": 300, "drop": [1, 2]}, {},
     ["w-msr needs 3 neighbours; most robots of ring have 2 or fewer (drop = 1)"]),
    ("belief-sharing", {"fill_ratio": [0.35, 0.3]},
     ["belief-sharing chooses among the middles of 10 steps, and f = 0.35 is one: it errs less than at other f"]),
    ("commons", {"accuracy": 0.6, "bins": 10}, []),
    ("sure", {"robots": 4}, ["sure needs 5 robots; this study has 4"]),
    ("swift", {"topology": ONE_WAY},
     ["swift needs robots that hear each other; some links of round go one way only"]),
    ("commons", {"topology": ONE_WAY}, []),
    ("swift", {"topology": ["ring", "full", "scale-free"]}, []),
])  # fmt: skip
def test_each_need_is_compared_with_the_study(brain, given, said):
    assert unmet(brain, **given) == said


def test_a_brain_is_named_once_with_its_fewest_rounds():
    [line] = unmet(["gated-mean", "minimalistic"], rounds=[400, 300, 500], accuracy=[0.7, 0.9])
    assert line.startswith("gated-mean says nothing before round 451; this study has 300 (phase = 450, run = 0). It ta")


def test_ticks_and_the_brains_of_members_count():
    members = [{"robots": 2, "brain": "gated-mean"}]
    said = "gated-mean says nothing before tick 451; this study has 90 (phase = 450, run = 0)"
    assert unmet({"file": "linear-consensus", "phase": 1}, members=members, ticks=90) == [said]


@pytest.mark.interpreted
@pytest.mark.filterwarnings("default:.*says nothing before:UserWarning")
def test_run_warns_in_one_line(here, accepted):
    (here / "late.toml").write_text(study_of("gated-mean", rounds=10, trials=1).text)
    [line] = [line for line in accepted("run", "late.toml").err.splitlines() if line.startswith("warning: gated-mean")]
    assert "gated-mean says nothing before round 451; this study has 10 (phase = 450, run = 0). It takes" in line


@pytest.mark.interpreted
@pytest.mark.parametrize("name", ["linear-consensus", "w-msr", "gated-mean", "recurrent"])
def test_published_run_is_the_default(name):
    brain = [{"file": name, "phase": 450 * 40 / 10_000}, {"file": name, "run": 40}]
    if name == "recurrent":
        brain = [name, {"file": name, "run": 100}]
    first, second = sc.run(study_of(brain, rounds=40, trials=1), 1, cautions=False)["final_estimate"].values
    assert np.array_equal(first, second)


@pytest.mark.interpreted
@pytest.mark.parametrize("name", ["linear-consensus", "w-msr", "gated-mean"])
def test_unclipped_shares_are_right_on_average(name):
    """With a poor sensor on a black floor, clipped shares are too low, because only their excess is cut."""
    brain = [{"file": name, "run": 60, "debiased": debiased} for debiased in (1, 2)]
    data = sc.run(study_of(brain, robots=12, accuracy=0.6, rounds=60, trials=2, fill_ratio=0.95), 1, cautions=False)
    clipped, unclipped = data["final_estimate"].mean(["trial", "robot"]).values
    assert abs(unclipped - 0.95) < abs(clipped - 0.95)


@pytest.mark.long
@pytest.mark.parametrize("topology", ["ring", "scale-free", "full"])
@pytest.mark.parametrize(("accuracy", "fill_ratio", "rounds"), VALUES)
def test_every_brain_beats_a_half_or_warns_in_twelve_studies(topology, accuracy, fill_ratio, rounds):
    """Each brain that estimates, published and corrected, is nearer than a half or is warned of."""
    estimating = {name: brains.load(name) for name in brains.shipped() if not brains.load(name).is_opinion}
    corrected = {"debiased": 1, "run": rounds, "every": 1}
    every = [
        variant
        for name, brain in estimating.items()
        for variant in (name, {"file": name} | {k: v for k, v in corrected.items() if k in brain.parameters})
        if variant != {"file": name}
    ]
    study = study_of(every, 12, accuracy, rounds, topology=topology, fill_ratio=fill_ratio)
    errors = abs(sc.run(study, 1, cautions=False)["final_estimate"] - fill_ratio).mean("robot").median("trial")
    pairs = zip(study.settings(), errors.values, strict=True)
    far = [setting for setting, error in pairs if error >= abs(fill_ratio - 0.5)]
    assert not [setting.brain.label for setting in far if not unmet_needs([setting], study.measure.bins)]
    assert len(errors) > len(estimating) > 25
