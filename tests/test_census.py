"""census: ripe sums weigh readings by age, coins tell the noise, and a change is found and passed on."""

import numpy as np
import pytest
from scipy.stats import f as f_ratio

import swarmcensus as sc
from swarmcensus import brains

CENSUS = brains.load("census")
DO = CENSUS.functions
NEVER = {"file": "census", "z": 1e6, "confirm": 1e6}  # finds no change


def robots(number, b=0.8, w=0.8):
    made = [CENSUS.robot(b, w) for _ in range(number)]
    for name, me in enumerate(made):
        me.name, me.luck = float(name), 0.3
    return made


def round_of(swarm, readings, heard, luck=None):
    """One round: readings are (blacks, looks) a robot, `heard` has for each robot those that it hears."""
    for me, (blacks, looks) in zip(swarm, readings, strict=True):
        DO.observe(me, blacks, looks)
    said = [DO.broadcast(me) for me in swarm]
    for k, me in enumerate(swarm):
        for j in heard[k]:
            DO.receive(me, said[j])
        me.luck = 0.3 if luck is None else luck[k]
        DO.fuse(me)


def ring(number):
    return [[(k - 1) % number, (k + 1) % number] for k in range(number)]


class TestRipening:
    @pytest.mark.parametrize("r", [5, 50, 120, 190])
    def test_a_reading_of_round_r_weighs_as_the_formula_says(self, r):
        """1 - (r / t)^2 of the mean weight 2 / 3, up to 1 / t; by changing that reading alone."""
        ratios = []
        for black in (0.0, 10.0):
            (me,) = robots(1, 1.0, 1.0)
            me.z = me.confirm = 1e6
            for t in range(1, 201):
                round_of([me], [(black if t == r else 5.0, 10.0)], [[]])
            ratios.append(me.ripe_s / me.ripe_v)
        assert (ratios[1] - ratios[0]) * 200 == pytest.approx((1 - (r / 200) ** 2) * 3 / 2, abs=0.03)

    def test_age_is_a_third_of_the_rounds(self):
        (me,) = robots(1)
        for _ in range(300):
            round_of([me], [(5.0, 10.0)], [[]])
        assert 3 * me.ripe_v / me.v == pytest.approx(300, rel=0.01)

    def test_nothing_is_biased_by_losses_lateness_and_late_joiners(self):
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


class TestNoise:
    def test_coins_vary_as_the_short_ratio_does(self):
        """300 swarms of six on a ring: an F test of two variances at 0.1 %. With f = 1/2 they should be equal."""
        random = np.random.default_rng(2)
        coins, ratios = [], []
        for _ in range(300):
            swarm = robots(6)
            for me in swarm:
                me.z = me.confirm = 1e6
            for _ in range(25):
                blacks = random.binomial(4, 0.5, 6)
                round_of(swarm, [(float(n), 4.0) for n in blacks], ring(6), random.random(6))
            coins.append(swarm[0].coins)
            ratios.append(swarm[0].short_s - 0.5 * swarm[0].short_v)
        statistic = np.mean(np.square(coins)) / np.mean(np.square(ratios))
        low, high = f_ratio.ppf([0.0005, 0.9995], 300, 300)
        assert low < statistic < high

    @pytest.mark.parametrize(
        "world", [{"topology": "ring"}, {"topology": "scale-free", "link_success": 0.3}, {"topology": "full"}]
    )
    def test_robots_hardly_ever_begin_anew_where_nothing_changes(self, world):
        """Then estimates are those of a brain that finds no change, to the bit: in 18 of 20 trials or more."""
        study = sc.Study(
            trials=20, seed=4, swarm={"robots": 30, "accuracy": 0.75, "brain": ["census", NEVER]},
            world=world | {"fill_ratio": 0.55}, schedule={"rounds": 400, "observations_per_round": 10},
        )  # fmt: skip
        found, never = sc.run(study)["final_estimate"].values
        assert (found == never).all(axis=-1).sum() >= 18


class TestChange:
    def settled(self):
        """Two robots that agree on f = 0.5 after 400 rounds."""
        swarm = robots(2)
        random = np.random.default_rng(3)
        for _ in range(400):
            round_of(swarm, [(2.0, 4.0)] * 2, [[1], [0]], random.random(2))
        return swarm

    def test_a_robot_begins_anew_and_then_ignores_sums_of_those_that_have_not(self):
        first, other = self.settled()
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

    def test_it_counts_all_again_once_it_has_seen_enough(self):
        first, other = self.settled()
        first.anew, first.s, first.v = 1.0, 31.0, 31.0
        DO.receive(first, DO.broadcast(other))
        DO.fuse(first)
        assert first.anew == 0.0
        assert first.v > 31.0

    def test_a_neighbour_that_has_begun_anew_is_believed_only_if_own_sums_agree(self):
        for off, begins in ((0.02, 0.0), (2.5, 1.0)):
            first, other = self.settled()
            other.anew = 1.0
            DO.receive(first, DO.broadcast(other))
            deviation = (first.noise / first.short_v) ** 0.5
            first.short_s += 2.0 * off * deviation * first.short_v  # the mean with the other halves it
            DO.fuse(first)
            assert first.anew == begins

    def test_a_small_change_is_found_sooner_than_by_tracking(self):
        study = sc.Study(
            trials=10, seed=5, swarm={"robots": 50, "accuracy": 0.75, "brain": ["census", "tracking"]},
            world={"topology": "ring", "fill_ratio": {"from": 0.65, "to": 0.55, "at": 201}},
            schedule={"rounds": 500, "observations_per_round": 10},
            measure={"metrics": ["recovery-time"], "bins": 2},
        )  # fmt: skip
        ours, tracking = sc.run(study)["recovery_time"].median(["trial", "robot"]).values
        assert ours < tracking / 2


@pytest.mark.parametrize("world", [{}, {"link_success": 0.1}, {"message_delay": 10}])
def test_it_is_sooner_than_commons(world):
    study = sc.Study(
        trials=10, seed=6, swarm={"robots": 100, "accuracy": 0.625, "brain": ["census", "commons"]},
        world=world | {"topology": "ring", "fill_ratio": 0.55},
        schedule={"rounds": 1000, "observations_per_round": 10},
    )  # fmt: skip
    rounds = sc.run(study)["convergence_round"].values
    ours, commons = np.median(np.where(rounds < 0, np.inf, rounds), axis=(1, 2))
    assert ours < commons / 2
