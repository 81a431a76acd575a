"""census: ripe sums weigh readings by age, coins tell the noise, and a change is found and passed on."""

import math

import numpy as np
import pytest
from scipy.stats import f as f_ratio, norm

import swarmcensus as sc
from swarmcensus import brains
from tests.support.places import EXAMPLE
from tests.support.small import study_of

CENSUS = brains.load("census")
DO = CENSUS.functions
INSIDER = str(EXAMPLE / "insider.py")
NEVER = {"file": "census", "z": 1e6, "confirm": 1e6}  # finds no change


def robots(number, b=0.8, w=0.8, finds=True):
    """Robots that hear nobody yet; `finds` is whether they look for changes."""
    made = [CENSUS.robot(b, w) for _ in range(number)]
    for name, me in enumerate(made):
        me.name, me.luck = float(name), 0.3
        if not finds:
            me.z = me.confirm = NEVER["z"]
    return made


def round_of(swarm, readings, heard, draws=None):
    """One round: readings are (blacks, looks) a robot, `heard` has for each robot those that it hears."""
    for me, (blacks, looks) in zip(swarm, readings, strict=True):
        DO.observe(me, blacks, looks)
    said = [DO.broadcast(me) for me in swarm]
    for k, me in enumerate(swarm):
        for j in heard[k]:
            DO.receive(me, said[j])
        me.luck = 0.3 if draws is None else draws[k]
        DO.fuse(me)


def ring(number):
    return [[(k - 1) % number, (k + 1) % number] for k in range(number)]


@pytest.mark.parametrize("r", [5, 50, 120, 190])
def test_a_reading_of_round_r_weighs_as_the_formula_says(r):
    """1 - (r / t)^2 of the mean weight 2 / 3, up to 1 / t; by changing that reading alone."""
    ratios = []
    for black in (0.0, 10.0):
        (me,) = robots(1, 1.0, 1.0, finds=False)
        for t in range(1, 201):
            round_of([me], [(black if t == r else 5.0, 10.0)], [[]])
        ratios.append(me.ripe_s / me.ripe_v)
    assert (ratios[1] - ratios[0]) * 200 == pytest.approx((1 - (r / 200) ** 2) * 3 / 2, abs=0.03)


def test_nothing_is_biased_by_losses_lateness_and_late_joiners():
    """Readings that are what is expected of f leave every ratio at f, whatever is heard, and when."""
    random = np.random.default_rng(1)
    swarm, f = robots(6, 0.9, 0.7), 0.3
    old = []
    for t in range(60):
        looks = random.integers(0, 5, 6) * (np.arange(6) < 4 + (t > 20) * 2)
        readings = [(n * (0.9 * f + 0.3 * (1 - f)), float(n)) for n in looks]
        for me, (blacks, n) in zip(swarm, readings, strict=True):
            DO.observe(me, blacks, n)
        old.append([DO.broadcast(me) for me in swarm])
        for k, me in enumerate(swarm):
            for j in np.flatnonzero(random.random(6) < 0.3):
                if j != k:
                    DO.receive(me, old[-1 - int(random.integers(0, min(len(old), 4)))][j])
            me.luck = random.random()
            DO.fuse(me)
            for s, v in ((me.s, me.v), (me.ripe_s, me.ripe_v), (me.short_s, me.short_v)):
                assert s == pytest.approx(f * v, abs=1e-9 * max(v, 1.0))


def test_coins_vary_as_the_short_ratio_does():
    """300 swarms of six on a ring: an F test of two variances at 0.1 %. With f = 1/2 they should be equal."""
    random = np.random.default_rng(2)
    coins, ratios = [], []
    for _ in range(300):
        swarm = robots(6, finds=False)
        for _ in range(25):
            blacks = random.binomial(4, 0.5, 6)
            round_of(swarm, [(float(n), 4.0) for n in blacks], ring(6), random.random(6))
        coins.append(swarm[0].coins)
        ratios.append(swarm[0].short_s - 0.5 * swarm[0].short_v)
    statistic = np.mean(np.square(coins)) / np.mean(np.square(ratios))
    low, high = f_ratio.ppf([0.0005, 0.9995], 300, 300)
    assert low < statistic < high


@pytest.mark.parametrize("topology", ["ring", "full"])
def test_robots_hardly_ever_restart_where_nothing_changes(topology):
    """Then estimates are those of a brain that finds no change, to the bit: in 18 of 20 trials or more."""
    study = study_of(["census", NEVER], robots=30, accuracy=0.75, rounds=400, trials=20, seed=4, topology=topology)
    found, never = sc.run(study)["final_estimate"].values
    assert (found == never).all(axis=-1).sum() >= 18


def test_robots_that_one_round_mixes_all_of_know_the_same():
    swarm = robots(5)
    everybody = [[j for j in range(5) if j != k] for k in range(5)]
    for t in range(4):
        round_of(swarm, [(2.0 + 0.1 * k, 4.0) for k in range(5)], everybody)
        assert len({(round(me.s, 9), round(me.v, 9)) for me in swarm}) == 1
        assert all(me.company == -2.0 for me in swarm) == (t > 0)
    everybody[0] = everybody[0][1:]  # a message is lost
    round_of(swarm, [(1.0, 4.0)] * 5, everybody)
    assert [me.company for me in swarm] == [-1.0, -2.0, -2.0, -2.0, -2.0]
    round_of(swarm, [(1.0, 4.0)] * 5, [[j for j in range(5) if j != k] for k in range(5)])
    assert all(me.company == -1.0 for me in swarm)  # they hear of it


def settled():
    """Two robots that agree on f = 0.5 after 400 rounds."""
    swarm = robots(2)
    random = np.random.default_rng(3)
    for _ in range(400):
        round_of(swarm, [(2.0, 4.0)] * 2, [[1], [0]], random.random(2))
    return swarm


def test_restarted_robot_ignores_old_sums():
    first, other = settled()
    assert first.anew == other.anew == 0.0
    for _ in range(60):
        if first.anew:
            break
        round_of([first], [(4.0, 4.0)], [[]])
    assert first.anew == 1.0
    assert first.v < 3.0
    begun = first.x
    assert begun > 0.55
    DO.receive(first, DO.broadcast(other))
    DO.fuse(first)
    assert first.v < 3.0
    assert first.x == pytest.approx(begun, abs=0.01)  # the prior counts more now


@pytest.mark.parametrize(
    ("voices", "begun", "least"),
    [(3, 1, 1.5**2), (8, 1, 1.5**2), (21, 1, 1.5**2 + 1.9302), (84, 2, 1.5**2 + 3.3165), (9001, 1, 3.5**2)],
)
def test_few_restarted_robots_need_more_confirmation(voices, begun, least):
    """2 ln(n / 8 m) by hand: 2 ln 2.625 and 2 ln 5.25; never more than for a change of its own."""
    for times, begins in ((0.98, 0.0), (1.02, 1.0)):
        me, _ = settled()
        me.begun, me.fresh, me.coin, me.alone, me.noise = float(begun), 0.0, 0.0, 0.0, voices
        noise = 0.25 / voices  # never more
        off = math.sqrt(times * least * noise / 50.0)
        me.short_v = 50.0 * voices  # with those of others, which are 0 here, a mean of 50
        me.short_s = me.short_v * (me.ripe_s / me.ripe_v + off)
        DO.compare(me, 1000.0, float(voices))
        assert me.anew == begins


def met(readings, rounds=1, talk=True):
    """Robots with `readings` (blacks, looks) in each round, that all hear each other."""
    swarm = robots(len(readings), finds=False)
    heard = [[j for j in range(len(swarm)) if j != k and talk] for k in range(len(swarm))]
    for _ in range(rounds):
        round_of(swarm, readings, heard)
    return swarm


def test_r_is_a_capped_weighted_mean():
    """By hand: k = 0.6, so v = 0.36 a reading and o / p = (black share - 0.2) / 0.6."""
    first, second, _ = met([(5.0, 10.0), (12.0, 20.0), (6.0, 10.0)])
    f = [(share - 0.2) / 0.6 for share in (0.5, 0.6, 0.6)]
    assert first.near == pytest.approx((f[0] + f[1] + f[2]) / 3)  # the 20 readings count as 10, as many as its own
    assert second.near == pytest.approx((2 * f[1] + f[0] + f[2]) / 4)
    assert first.error == pytest.approx(0.5 / (0.36 * 10 * 3) ** 0.5)
    assert second.error == pytest.approx(0.5 / (0.36 * 20 * 2) ** 0.5)


def test_sums_far_from_r_are_not_counted():
    (me,) = met([(50.0, 100.0)], rounds=10)
    for far, counts in ((4.9, True), (5.1, False)):
        said = list(DO.broadcast(me))
        fields = dict(zip(CENSUS.message, range(len(said)), strict=True))
        claim = me.near + far * me.error
        said[fields["ripe_s"]], said[fields["s"]] = claim * me.ripe_v, claim * me.v
        DO.receive(me, tuple(said))
        assert me.counted == counts
        DO.clear(me)


@pytest.mark.parametrize(
    ("off", "told"), [(1.7, 1.7), (-1.9, -1.75 * 0.6 / 0.75), (2.2, 1.75 * 0.3 / 0.75), (2.6, 0.0), (4.0, 0.0)]
)
def test_estimate_is_drawn_to_nearby_readings(off, told):
    (me,) = met([(50.0, 100.0)], rounds=10)
    me.x = me.near + off * me.error
    DO.cut(me)
    assert me.x == pytest.approx(me.near + told * me.error)
    assert me.guard == 0.0


@pytest.mark.parametrize("value", [math.nan, -math.inf, 1e30])
@pytest.mark.parametrize(
    "field", ["s", "v", "ripe_s", "ripe_v", "short_s", "short_v", "coins", "noise", "seen", "own_s", "own_v"]
)
def test_no_message_spoils_a_robot(field, value):
    first, second = met([(50.0, 100.0), (51.0, 100.0)], rounds=10)
    said = [value if name == field else x for name, x in zip(CENSUS.message, DO.broadcast(second), strict=True)]
    DO.receive(first, tuple(said))
    for _ in range(50):
        round_of([first, second], [(50.0, 100.0)] * 2, [[1], [0]])
    known = [getattr(me, name) for me in (first, second) for name in CENSUS.memory]
    assert all(map(math.isfinite, known))
    assert max(abs(me.x - 0.5) for me in (first, second)) < 0.05
    assert max(me.noise for me in (first, second)) < 1.0


def test_own_readings_decide_whether_a_change_is_one():
    """Logarithms of likelihoods of normal readings, whose variance is 1 / (4 v)."""
    for truth, changed in ((0.2, True), (0.5, False)):
        (me,) = met([(50.0, 100.0)], rounds=10)
        me.short_s, me.short_v = 0.2 * me.short_v, me.short_v
        DO.begin_anew(me)
        assert me.trial == 4.0
        before, readings = me.trial, (0.6 * truth + 0.2) * 10.0
        DO.observe(me, readings, 10.0)
        own, others = me.own_s / me.own_v, 0.3
        me.guess = others  # of the round before, which those readings are not in
        DO.fuse(me)
        if me.trial > 0.0:
            gained = norm.logpdf(truth, others, 0.5 / 3.6**0.5) - norm.logpdf(truth, own, 0.5 / 3.6**0.5)
            assert me.trial - before == pytest.approx(gained)
        for _ in range(200):
            if me.trial == 0.0:
                break
            me.ripe_s, me.s = 0.2 * me.ripe_v, 0.2 * me.v  # what others say
            DO.observe(me, readings, 10.0)
            DO.fuse(me)
        assert me.trial == 0.0
        assert (me.own_s / me.own_v == pytest.approx(0.2)) == changed
        assert (me.guard > 0.0) != changed


@pytest.mark.long
@pytest.mark.parametrize(
    "liar",
    [
        "always-black", "opposite", "shouter", "noisy-mirror", "creeper",
        {"file": INSIDER, "anew": 3.0, "step": 0.3, "short": 0.3, "own": 0.0},
        {"file": INSIDER, "anew": 0.0, "step": 0.0, "short": 0.3, "own": 0.0},
    ],
)  # fmt: skip
def test_it_is_better_than_alone_among_liars(liar):
    study = study_of(
        ["census", "alone"], robots=20, accuracy=0.75, rounds=600, trials=50, seed=8,
        members=[{"robots": 6, "brain": liar, "honest": False}], topology=["full", "ring"],
    )  # fmt: skip
    results = sc.run(study)
    errors = np.nanmedian(abs(results["final_estimate"] - 0.55), axis=(1, 2))
    is_ours = results["brain"].values == "census"
    assert (errors[is_ours] < errors[~is_ours]).all()


# ---- what the limits are made of


@pytest.mark.parametrize("repeats", [0.0, 0.7])
@pytest.mark.parametrize("q", [0.1, 0.5])
def test_correlation_of_successive_readings(q, repeats):
    """Each reading is the one before with this probability; over 20,000 rounds."""
    random = np.random.default_rng(8)
    (me,) = robots(1, 1.0, 1.0)
    me.near, me.rounds, me.fresh, me.last = q, 2.0, 1.0, 0.0
    known = []
    for same in random.random(20000) < repeats:
        me.fresh_s = me.last if same else float(random.random() < q)
        DO.walk(me)
        known.append(me.alike)
    assert np.mean(known[5000:]) == pytest.approx(repeats, abs=0.05)


@pytest.mark.parametrize(("times", "begins"), [(0.98, 0.0), (1.02, 1.0)])
def test_noise_of_a_mixed_network_is_at_least_half_of_the_most(times, begins):
    """(1.02 z)^2 times half of 0.25 / n is a change, (0.98 z)^2 is none, though the coins tell of no noise."""
    (me,) = robots(1)
    for _ in range(100):
        round_of([me], [(5.0, 10.0)], [[]])
    me.company, me.noise, me.coin, me.fresh, me.alone, me.coins = -2.0, 0.0, 0.0, 0.0, 0.0, 0.0
    me.short_v = 50.0 * 20.0
    off = times * 3.5 * math.sqrt(0.5 * 0.25 / 20.0 / 50.0)
    me.short_s = me.short_v * (me.ripe_s / me.ripe_v + off)
    DO.compare(me, 1000.0, 20.0)
    assert me.anew == begins


# ---- whom it hears


def test_a_neighbour_with_other_readings_is_not_heard():
    honest = met([(50.0, 100.0), (50.0, 100.0), (86.0, 100.0)])  # apart by 5.1 standard errors
    pair = met([(50.0, 100.0), (50.0, 100.0)])
    for me, other in zip(honest, pair, strict=False):
        assert (me.ripe_s, me.ripe_v, me.near) == (other.ripe_s, other.ripe_v, other.near)


@pytest.mark.parametrize(("blacks", "counted"), [(50.0, "whole"), (54.0, "clipped"), (80.0, "not")])
def test_far_readings_are_clipped(blacks, counted):
    """Of two robots with v = 36: 0.6 standard errors of a reading and r, and none from 2.5 on."""
    (me,), (other,) = met([(50.0, 100.0)], rounds=10), met([(blacks, 100.0)], rounds=10)
    f, error = (blacks / 100 - 0.2) / 0.6, math.sqrt(0.25 / 360 + me.error**2)
    DO.receive(me, DO.broadcast(other))
    assert (me.near_heard_v == 0.0) == (counted == "not")
    if counted != "not":
        due = f if counted == "whole" else me.near + 0.6 * error
        assert me.near_heard_s / me.near_heard_v == pytest.approx(due)


@pytest.mark.parametrize(
    ("own_trial", "its_trial", "looks", "heard"),
    [(0.0, 4.0, 100.0, 1.0), (4.0, 4.0, 100.0, 0.0), (0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 0.0, 1.0)],
)
def test_who_tries_a_change_need_not_agree(own_trial, its_trial, looks, heard):
    """Its readings are old; but two that both try hear each other only if they agree, and who reads nothing hears."""
    me, other = met([(50.0, 100.0)] * 2, rounds=10)
    other.own_s, other.trial, me.trial = 0.9 * other.own_v, its_trial, own_trial
    if looks:
        DO.observe(me, looks / 2.0, looks)
    DO.receive(me, DO.broadcast(other))
    assert me.voices == heard


def test_a_robot_that_started_again_hears_all_again():
    """Once it has seen enough, or where it reads nothing."""
    for v, looks in ((31.0, 10.0), (1.0, 0.0)):
        me, other = met([(50.0, 100.0)] * 2, rounds=10)
        DO.begin_anew(me)
        me.s = me.v = v
        for _ in range(2):
            round_of([me, other], [(looks / 2.0, looks), (50.0, 100.0)], [[1], [0]])
        assert me.anew == 0.0
        assert me.v > v + 10.0


def test_a_robot_on_guard_leans_on_what_was_read_near_it():
    (me,) = met([(50.0, 100.0)], rounds=10)
    me.ripe_s += 8.0 * me.error * me.ripe_v
    DO.fuse(me)
    assert me.x == me.near
    assert me.s / me.v == me.ripe_s / me.ripe_v == pytest.approx(me.near)
    assert me.guard == me.rounds == 11.0
    me.s, before = me.v, me.near
    DO.observe(me, 50.0, 100.0)
    me.company = -1.0
    DO.doubt(me)
    lean = 3.0 * 100.0 / 1100.0
    assert me.s / me.v == pytest.approx(1.0 - lean * (1.0 - before), rel=0.1)


def test_refuted_changes_cost_trust_and_one_that_holds_restores_it():
    (me,) = met([(50.0, 100.0)], rounds=50)
    for trust, pause in ((2.0, 8.0), (1.0, 16.0)):
        DO.begin_anew(me)
        while me.trial > 0.0:
            me.ripe_s, me.s = 0.2 * me.ripe_v, 0.2 * me.v  # what others say
            DO.observe(me, 5.0, 10.0)
            DO.fuse(me)
        assert (me.trust, me.pause) == (trust, pause)
    DO.begin_anew(me)
    assert me.trial == 1.0
    DO.observe(me, 2.0, 10.0)
    me.ripe_s = me.s = me.guess = 0.0
    DO.fuse(me)
    trial = me.trial
    assert trial > 1.0
    DO.begin_anew(me)
    assert me.trial == trial  # it goes on
    while me.trial > 0.0:
        DO.observe(me, 2.0, 10.0)
        me.ripe_s = me.s = 0.0
        DO.fuse(me)
    assert me.trust == 4.0
