"""Single precision over a day: where it leaves double precision, and that brains that remember what it took stay."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains.float32 import rounded_to_single
from swarmcensus.brains.packing import Numbers
from swarmcensus.checks.lives_in_single import single_lives
from tests.support.second import changed
from tests.support.small import study_of

LONG_LIVED = ("commons", "swift", "tracking", "steadfast", "sure")
KEPT = (
    ("    return larger, more - (larger - total)\n", "    return larger, 0.0\n"),
    ("    return ((heard - mean * messages) + (own - mean)) / (1.0 + messages)\n", "    return 0.0\n"),
)


def forgetful(name, folder):
    """A shipped brain that does not remember what rounding took."""
    file = folder / f"forgetful_{name}.py"
    file.write_text(changed(*KEPT, source=brains.load(name).source))
    return brains.load(file)


def lived(brain, rounds, readings, begin=0.0):
    """Estimates of four robots on a ring, of which the second has a poor sensor, after `begin` readings at once."""
    draws = np.random.default_rng(5)
    swarm = [brain.robot(b, b) for b in (0.8, 0.6, 0.9, 0.8)]
    for k, me in enumerate(swarm):
        if brain.uses.name:
            me.name = float(k)
        brain.functions.observe(me, 0.5 * begin, begin)
    curve = []
    for _ in range(rounds):
        for me in swarm:
            brain.functions.observe(me, float(draws.binomial(readings, 0.5)), float(readings))
        said = [brain.functions.broadcast(me) for me in swarm]
        for k, me in enumerate(swarm):
            for message in (said[k - 1], said[(k + 1) % 4]):
                brain.functions.receive(me, message)
            brain.functions.fuse(me)
        curve.append([brain.functions.estimate(me) for me in swarm])
    return np.array(curve)


@pytest.mark.parametrize("name", LONG_LIVED)
def test_short_lives_are_those_of_the_plain_rule_to_the_bit(name, tmp_path):
    assert (lived(brains.load(name), 800, 10) == lived(forgetful(name, tmp_path), 800, 10)).all()


@pytest.mark.parametrize("name", LONG_LIVED)
def test_long_lives_are_in_double_precision_up_to_rounding(name, tmp_path):
    """Sums are so large from the first round on, or with swift soon, that what rounding takes is remembered."""
    begin, rounds = (0.0, 3000) if name == "swift" else (1e6, 300)
    one, other = (lived(brain, rounds, 1, begin) for brain in (brains.load(name), forgetful(name, tmp_path)))
    assert one == pytest.approx(other, abs=1e-9)
    assert (one != other).any()


DAY = 864_000  # readings at 10 Hz


def test_nothing_of_a_reading_is_lost_in_single_precision(tmp_path):
    """Of 1000 readings of evidence 0.36, float32 adds 0.375 each to a sum of a million."""
    for brain, added in ((brains.load("commons"), 360.0), (forgetful("commons", tmp_path), 375.0)):
        single = brain.with_numbers(Numbers("single"))
        me = single.robot(rounded_to_single(0.8), rounded_to_single(0.8))
        me.v = 1e6
        for _ in range(1000):
            single.functions.observe(me, 1.0, 1.0)
        assert me.v + me.v_rest == pytest.approx(1e6 + added, abs=1e-3)


def median_error(name, loss):
    """The median error of 20 robots after a day, on a ring with two neighbours on each side."""
    ring = {"name": "small-world", "neighbours": 4, "rewired": 0.0}
    study = study_of(name, robots=20, accuracy=0.8, rounds=DAY, looks=1, trials=1, topology=ring, precision="single",
                     link_success=1.0 - loss)  # fmt: skip
    return np.median(np.abs(sc.run(study)["final_estimate"].values - 0.55))


@pytest.mark.long
@pytest.mark.parametrize("name", [*LONG_LIVED, "self-taught"])
def test_a_swarm_runs_for_a_day_in_single_precision(name):
    loss = 0.0 if name == "swift" else 0.2
    brain = {"file": name, "within": 1e-9} if name == "sure" else name  # else it is done in the first hour
    assert median_error(brain, loss) < 0.001


@pytest.mark.long
@pytest.mark.parametrize(("name", "least"), [("swift", 0.01), ("commons", 0.002)])
def test_it_would_not_without_the_rests(name, least, tmp_path):
    loss = 0.0 if name == "swift" else 0.2
    assert median_error(str(forgetful(name, tmp_path).path), loss) > least


@pytest.mark.long
@pytest.mark.parametrize("name", brains.shipped())
def test_the_table_is_what_is_found(name, benchmark):
    assert benchmark("brains").first_apart(name) == single_lives()[name]


def test_the_table_has_all():
    assert [*single_lives()] == brains.shipped()
    assert 2**24 < single_lives()["minimalistic"] < 2**24 + 250_000  # where counts end
    assert all(single_lives()[name] is None or single_lives()[name] > DAY for name in LONG_LIVED)
