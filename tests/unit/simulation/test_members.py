"""Mixed swarms: who is who, what members have of their own, and of whom the results are."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus.simulation import sampling
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.support.errors import InputError
from tests.support.long import in_two_sizes
from tests.support.second import MEANS, STEER, brain, changed, fixed, moving
from tests.support.small import FAULTS, RING, SEED, settings_of, study_of
from tests.support.trials import record_ride, record_trial

LIAR = changed(("return (estimate(me),)", "return (1.0 - estimate(me),)"))
LISTENS = changed(
    ("MEMORY = {", 'MEMORY = {"x": 0.5, '),
    ("return (estimate(me),)", "return (me.x,)"),
    ("def receive(me, message):\n    pass", "def receive(me, message):\n    me.x += 0.25 * (message[0] - me.x)"),
    ("def fuse(me):\n    pass", "def fuse(me):\n    me.x = 0.75 * me.x + 0.25 * me.n / max(me.t, 1.0)"),
    ("return me.n / me.t if me.t > 0.0 else 0.5", "return me.x"),
)
DECIDES = LISTENS + "\n\ndef decide(me):\n    return -1 if me.t < 20.0 else 0 if me.x < 0.5 else 1\n"


def liars(robots):
    return [{"robots": robots, "brain": brain(LIAR, "liar.py"), "honest": False}]


def who(robots=20, members=(), trials=40, **world):
    (setting,) = fixed(brain(MEANS), robots=robots, members=members, **world)
    return sampling.groups(setting, SEED, 0, trials)


@pytest.mark.parametrize(("share", "count"), [(1, 1), (3, 3), (0.1, 2), (0.29, 6), (1.0, 20)])
def test_there_are_as_many_as_the_study_says_in_each_trial(share, count):
    assert (who(members=[{"robots": share, "accuracy": 0.9}]).sum(axis=1) == count).all()
    if count < 20:
        (setting,) = fixed(brain(MEANS), robots=20, members=liars(share))
        assert setting.honest == 20 - count


def test_a_larger_share_holds_the_robots_of_a_smaller_one():
    for small, large in pairwise([who(members=liars(share)) == 1 for share in (0.1, 0.2, 5, 0.7)]):
        assert (small <= large).all()
        assert (small.sum(axis=1) < large.sum(axis=1)).all()


def test_tables_share_the_swarm_out_and_nobody_is_of_two():
    found = who(members=[{"robots": 0.2, "accuracy": 0.9}, {"robots": 5, "accuracy": 0.8}, *liars(0.3)])
    assert all(np.bincount(row).tolist() == [5, 4, 5, 6] for row in found)
    assert ((found == 1) == (who(members=[{"robots": 0.2, "accuracy": 0.9}]) == 1)).all()


def test_they_are_the_same_robots_whatever_else_differs():
    one = who(members=liars(6))
    assert (one == who(members=[{"robots": 6, "accuracy": 0.9}])).all()
    assert (one == who(members=liars(6), topology="full", link_success=0.5, faults=FAULTS, accuracy=0.9)).all()
    setting = moving(brain(LISTENS), robots=20, members=liars(6), density=2)
    assert (sampling.groups(setting, SEED, 0, 40) == one).all()
    assert (sampling.groups(setting, SEED, 7, 3) == one[7:10]).all()
    assert (one != sampling.groups(setting, SEED + 1, 0, 40)).any()


def test_each_robot_is_as_likely_in_each_trial():
    """4,000 trials of 2 in 8: each robot a quarter of the time, each pair once in 28; chi-square, error rate 0.1 %."""
    found = who(robots=8, members=liars(2), trials=4000) == 1
    pairs = np.bincount(found @ (2 ** np.arange(8)), minlength=256)
    of_two = [2**i + 2**j for i in range(8) for j in range(i)]
    assert pairs.sum() == pairs[of_two].sum() == 4000
    assert stats.chisquare(pairs[of_two]).pvalue > 1e-3
    both = (found[1:] & found[:-1]).sum(axis=1)  # of two trials in a row: hypergeometric
    law = stats.hypergeom(8, 2, 2).pmf([0, 1, 2])
    assert stats.chisquare(np.bincount(both, minlength=3), law * len(both)).pvalue > 1e-3


BELIEVES = changed(
    ("MEMORY = {", 'MEMORY = {"p": 0.0, "q": 0.0, '),
    ("def fuse(me):\n    pass", "def fuse(me):\n    me.p = me.b\n    me.q = me.w"),
)


@pytest.mark.interpreted
def test_members_see_as_well_as_they_are_said_to():
    """On a black floor readings are right with the member's accuracy: counts of 60 looks, chi-square, 0.1 % each."""
    members = [{"robots": 0.4, "accuracy": 0.8}, {"robots": 60, "accuracy": {"black": 0.7, "white": 0.9}}]
    (setting,) = settings_of(300, brain(BELIEVES), 0.6, 60, rounds=10, fill_ratio=1.0, topology="line", members=members)
    fields, _, blacks = record_trial(setting, SEED, 0)
    group = sampling.groups(setting, SEED, 0, 1)[0]
    for number, b, w in ((0, 0.6, 0.6), (1, 0.8, 0.8), (2, 0.7, 0.9)):
        assert (fields["p"][-1][group == number] == b).all()  # and they know it
        assert (fields["q"][-1][group == number] == w).all()
        found = np.bincount(blacks[1:, group == number].astype(int).ravel(), minlength=61)
        law = stats.binom(60, b).pmf(np.arange(61)) * found.sum()
        some = law >= 5
        pooled = [np.append(v[some], v[~some].sum()) for v in (found, law)]
        assert stats.chisquare(pooled[0], pooled[1] * pooled[0].sum() / pooled[1].sum()).pvalue > 1e-3


def test_drawn_accuracies_of_members_have_their_law():
    """Uniform of the swarm and of the members, each in its own range, and independent; error rate 0.3 %."""
    plain = {"used": brain(MEANS), "robots": 400, "accuracy": "U(0.5, 0.7)"}
    (setting,) = fixed(**plain, members=[{"robots": 0.5, "accuracy": "U(0.8, 1.0)"}])
    given, group = inputs_of(setting, SEED, 0, 5), sampling.groups(setting, SEED, 0, 5)
    assert (given.sensors[0] == given.beliefs[0]).all()
    ours, theirs = given.sensors[0][group == 0], given.sensors[0][group == 1]
    assert stats.kstest((ours - 0.5) / 0.2, "uniform").pvalue > 1e-3
    assert stats.kstest((theirs - 0.8) / 0.2, "uniform").pvalue > 1e-3
    assert abs(np.corrcoef(ours, theirs)[0, 1]) < 3.3 / np.sqrt(len(ours))
    without = sampling.accuracies(fixed(**plain)[0], SEED, 0, 5)[0]
    assert (given.sensors[0][group == 0] == without[group == 0]).all()


@pytest.mark.interpreted
@pytest.mark.parametrize(("swarm", "member", "ours", "theirs"), [
    ({}, {"assumed_accuracy": 0.99}, (0.7, 0.7), (0.7, 0.99)),
    ({"assumed_accuracy": 0.6}, {"accuracy": 0.9}, (0.7, 0.6), (0.9, 0.6)),
    ({"assumed_accuracy": 0.6}, {"accuracy": 0.9, "assumed_accuracy": 0.8}, (0.7, 0.6), (0.9, 0.8)),
    ({"assumed_accuracy": {"error": -0.1}}, {"accuracy": 0.9}, (0.7, 0.6), (0.9, 0.8)),
    ({}, {"accuracy": 0.9, "assumed_accuracy": {"error": -0.2}}, (0.7, 0.7), (0.9, 0.7)),
])  # fmt: skip
def test_what_members_believe_of_their_sensors(swarm, member, ours, theirs):
    (setting,) = settings_of(6, brain(BELIEVES), rounds=2, members=[{"robots": 2} | member], **swarm)
    given, group = inputs_of(setting, SEED, 0), sampling.groups(setting, SEED, 0, 1)[0]
    fields, *_ = record_trial(setting, SEED, 0)
    for number, (true, assumed) in enumerate((ours, theirs)):
        assert given.sensors[0][0][group == number] == pytest.approx(true)
        assert fields["p"][-1][group == number] == pytest.approx(assumed)


@pytest.mark.long(only=["False-quick"])
@pytest.mark.interpreted
@in_two_sizes("ticks", 120, 300)
@pytest.mark.parametrize("steers", [False, True])
def test_members_are_as_fast_as_they_are_said_to_be(steers, ticks):
    """A robot that goes straight on does its speed in a tick, and nobody is faster, but who is pushed."""
    source = MEANS + ("\n\ndef steer(me):\n    return 9.0, 0.0\n" if steers else "")
    members = [{"robots": 3, "speed": 0.05}, {"robots": 2, "speed": 0.4}, {"robots": 1, "speed": 0.0}]
    setting = moving(brain(source), robots=10, ticks=ticks, density=0.5, members=members)
    ride, group = record_ride(setting, SEED, 0), sampling.groups(setting, SEED, 0, 1)[0]
    steps = np.linalg.norm(np.diff(ride.poses[..., :2], axis=0), axis=2)
    for number, speed in enumerate((setting.body.speed, 0.05, 0.4, 0.0)):
        mine = steps[:, group == number]
        pace = speed * setting.body.tick
        assert np.quantile(mine, 0.97) <= pace + 1e-12
        assert (abs(mine - pace) < 1e-9).mean() > 0.2


OTHERS = {
    "four.py": changed(("MEMORY =", "OPTIONS = 4\nMEMORY ="), source=DECIDES),
    "other.py": changed(('("x",)', '("x", "n")'), ("return (estimate(me),)", "return estimate(me), me.n")),
}


@pytest.mark.parametrize(("member", "said"), [
    ({"robots": 6, "accuracy": 0.9}, "members[0].robots = 6"),
    ({"robots": 1.5, "accuracy": 0.9}, "members[0].robots = 1.5"),
    ({"robots": -1, "accuracy": 0.9}, "members[0].robots = -1"),
    ({"robots": True, "accuracy": 0.9}, "members[0].robots = true"),
    ({"robots": [0.1, "all"], "accuracy": 0.9}, "members[0].robots[1]"),
    ({"robots": [], "accuracy": 0.9}, "members[0].robots"),
    ({"robots": [0, 0.0], "accuracy": 0.9}, "members[0].robots = 0"),
    ({"robots": 0.04, "accuracy": 0.9}, "members[0].robots = 0.04"),
    ({"accuracy": 0.9}, "members[0].robots is missing"),
    ({"robots": 2}, "members[0] differs in nothing"),
    ({"robots": 1.0, "honest": False}, "members: of 5 robots none is honest"),
    ({"robots": 2, "speed": 0.1}, "members[0].speed"),
    ({"robots": 2, "honest": [True]}, "members[0].honest"),
    ({"robots": 2, "accuracy": 1.2}, "members[0].accuracy = 1.2"),
    ({"robots": 2, "brains": "voter"}, "unknown key members[0].brains: did you mean 'brain'"),
    ({"robots": 2, "brain": "none.py"}, "members[0].brain"),
    ({"robots": 2, "brain": "other.py"}, "members[0].brain = 'other.py': its MESSAGE"),
    ({"robots": 2, "brain": "four.py"}, "members[0].brain = 'four.py'"),
    ({"robots": 2, "brain": "slow-liar"}, "members[0].brain = 'slow-liar'"),
    ({"robots": 2, "brain": "allways-black", "honest": False}, "did you mean 'always-black'?"),
    ({"robots": 2, "brain": {"file": "voter", "much": 1}}, "the brain 'voter' has no parameter 'much'"),
    ({"robots": 2, "brain": {"file": "jammer", "much": 1}, "honest": False}, "'jammer' has no parameter 'much'"),
])  # fmt: skip
def test_wrong_members_are_named(member, said):
    if member.get("brain") in [*OTHERS]:
        member = member | {"brain": brain(OTHERS[member["brain"]], member["brain"])}
    with pytest.raises(InputError, match=re.escape(said)):
        study_of(brain(DECIDES), members=[member])


def test_wrong_tables_of_members_are_named():
    two = [{"robots": 0.6, "accuracy": 0.9}, {"robots": 0.7, "accuracy": 0.8}]
    with pytest.raises(InputError, match=r"members\[0\].robots = 0.6 and members\[1\].robots = 0.7"):
        study_of(members=two)
    with pytest.raises(InputError, match="members = 3"):
        sc.Study(trials=1, swarm={"robots": 5, "accuracy": 0.7}, world=RING, members=3)


FAULTY = {
    "fails": ("blacks / (me.n * 0)", r"brain 'mine.py' or 'liar.py' fails in .*(ZeroDiv|divide by z).*liar.py, line 9"),
    "does not compile": ("'a' + blacks", r"brain 'liar.py' fails in .*swarmcensus brains --check .*liar.py says why"),
}


@pytest.mark.long(only=["does not compile"])
@pytest.mark.parametrize("what", [pytest.param("fails", marks=pytest.mark.interpreted), "does not compile"])
def test_it_is_the_brain_that_fails_that_is_named(here, what):
    new, said = FAULTY[what]
    Path("mine.py").write_text(DECIDES)
    Path("liar.py").write_text(changed(("me.n += blacks", f"me.n += {new}"), source=LIAR))
    study = study_of("mine.py", robots=[5, 8], rounds=3, trials=1, members=[{"robots": 2, "brain": "liar.py"}])
    with pytest.raises(sc.InputError, match=said):
        sc.run(study, jobs=1)


@pytest.mark.long
def test_the_line_that_fails_is_found_whatever_brains_use(here):
    """Luck, names, silence and ends are those of the trial: the very robot fails in the very round."""
    fuse = "def fuse(me):\n    if me.luck < 0.05 and me.name == 2.0 and me.t == 20.0:\n        me.n = 1.0 / (me.t - 20)"
    bad = changed(
        ("return (estimate(me),)", "if me.t > 15.0:\n        return (estimate(me),)"),
        ("def receive(me, message):\n    pass", "def receive(me, message):\n    me.n += 0.0 * message[0]"),
        ("def fuse(me):\n    pass", fuse),
    )
    Path("mine.py").write_text(f"{bad}\n\ndef done(me):\n    return me.t >= 20.0\n{STEER}")
    with pytest.raises(sc.InputError, match=r"ZeroDivisionError: division by zero, at .*mine.py, line 23: me.n = 1.0"):
        sc.run(study_of("mine.py", robots=[5, 8], rounds=100, trials=1), jobs=1)
