"""The Bayesian rivals: posteriors against SciPy and brute force, rules by hand, CPython and machine code."""

import inspect

import numpy as np
import pytest
from scipy.special import betainc

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import SEED, settings_of
from tests.support.trials import record_trial

pytestmark = pytest.mark.interpreted
BAYES, CHANGING = brains.load("bayes-bots"), brains.load("changing-floor")
SHARING, INDEXED = brains.load("belief-sharing"), brains.load("belief-sharing-indexed")
H = (np.arange(10) + 0.5) / 10


def robot(brain, b=0.8, w=0.8, name=0.0, **parameters):
    brain = brain.with_parameters(parameters)
    return brain.robot(b, w, name), brain.functions


def one_round(me, functions, blacks=None, looks=1.0, heard=()):
    """Readings, if there are any, messages, and what follows."""
    if blacks is not None:
        functions.observe(me, blacks, looks)
    for message in heard:
        functions.receive(me, message)
    functions.fuse(me)


def life(brain, trial=0, robots=8, rounds=30, looks=1):
    """The fields and black readings of a trial in the engine, each (round, robot)."""
    (setting,) = settings_of(robots, brain, 0.9, looks, rounds=rounds, trials=2, topology="full", fill_ratio=0.6)
    fields, _, blacks = record_trial(setting, SEED, trial)
    return fields, blacks


class TestBeta:
    def test_both_brains_have_the_same(self):
        for name in ("beta_below", "log_above_one", "beyond", "fraction", "below_half"):
            one, other = (inspect.getsource(getattr(brain.functions, name)) for brain in (BAYES, CHANGING))
            assert one == other

    @pytest.mark.parametrize("x", [0.5, 0.1, 0.35, 0.8])
    def test_scipy(self, x):
        """1,000 pairs from 1 to a million, half of them where the function is neither 0 nor 1."""
        random = np.random.default_rng(SEED)
        a, b = 10.0 ** random.uniform(0.0, 6.0, (2, 1000))
        near = a[::2] * (1.0 - x) / x + 2.0 * np.sqrt(a[::2]) * random.normal(size=500)
        b[::2] = np.clip(near, 1.0, 1e6)
        found = np.array([BAYES.functions.beta_below(x, p, q) for p, q in zip(a.tolist(), b.tolist(), strict=True)])
        assert np.abs(found - betainc(a, b, x)).max() < 1e-12
        assert ((found > 0.01) & (found < 0.99)).sum() > 250


class TestBayesBots:
    @pytest.mark.long(but_every=2)
    @pytest.mark.parametrize("looks", [1, 5])
    @pytest.mark.parametrize("brain", [BAYES, CHANGING], ids=["bayes-bots", "changing-floor"])
    def test_on_a_full_network_all_hold_the_pooled_posterior(self, brain, looks):
        """Without feedback p is I_0.5 of all readings of all robots so far, in the engine and in CPython."""
        switched_off = {} if brain is BAYES else {"limit": 2.0, "doubt": 0.0}
        used = brain.with_parameters({"every": 1, "threshold": 1.0, **switched_off})
        fields, blacks = life(used, looks=looks)
        black = np.cumsum(blacks.sum(axis=1))[1:, None]
        white = np.arange(1, len(blacks))[:, None] * looks * blacks.shape[1] - black
        exact = betainc(black + 10.0, white + 10.0, 0.5)
        assert np.abs(fields["p"][1:] - exact).max() < 1e-12
        assert exact.min() < 0.3
        if looks == 1:
            everyone = [(i, j) for i in range(8) for j in range(i)]
            slow = sc.infer(blacks[1:], everyone, 0.9, 1, used, compiled=False)
            assert np.abs(slow["p"].values[1:] - exact).max() < 1e-12
            assert slow["estimate"].values[-1] == pytest.approx((black[-1, 0] + 10.0) / (8 * 30 + 20.0), abs=1e-12)

    def test_a_number_counts_once_for_each_sender(self):
        me, functions = robot(BAYES)
        one_round(me, functions, heard=[(1.0, 1.0, 5.0), (1.0, 1.0, 6.0)])
        for message in ((1.0, 1.0, 5.0), (1.0, 2.0, 6.0), (0.0, 1.0, 6.0), (1.0, 1.0, 133.0)):
            functions.receive(me, message)
        assert (me.black, me.white, me.heard) == (3.0, 0.0, 3.0)  # 133 shares the place of 5, which is held

    @pytest.mark.parametrize(("seen", "size"), [(1.0, 1.0), (0.0, 1.0), (7.0, 10.0)])
    def test_the_probability_of_soft_feedback(self, seen, size):
        """d (1 - p) + (1 - d) C by hand, against the mean over all lots of what is told."""
        me, functions = robot(BAYES, feedback=2.0, prior=1.0, every=1.0)
        one_round(me, functions, 400.0, 900.0)
        functions.observe(me, seen, size)
        a, b = 401.0, 501.0
        p = betainc(a, b, 0.5)
        variance = a * b / ((a + b) ** 2 * (a + b + 1.0))
        d = np.exp(-1250.0 * variance) * (0.5 - p) ** 2
        lots = (np.arange(20_000) + 0.5) / 20_000
        told = []
        for me.lot in lots.tolist():
            told.append(functions.broadcast(me)[0])
        assert np.multiply(told, size) == pytest.approx(np.round(np.multiply(told, size)))
        assert np.mean(told) == pytest.approx(d * (1.0 - p) + (1.0 - d) * seen / size, abs=1e-4)
        assert d > 0.1

    @pytest.mark.parametrize(("b", "w"), [(0.9, 0.6), (0.6, 0.95), (0.2, 0.4), (1.0, 1.0)])
    @pytest.mark.parametrize("brain", [BAYES, CHANGING], ids=["bayes-bots", "changing-floor"])
    def test_debiased(self, brain, b, w):
        """The probability that f < 0.5, by summing the Beta density of black readings over all shares that mean it."""
        me, functions = robot(brain, b, w, debiased=1.0, every=1.0)
        one_round(me, functions, 33.0, 70.0)
        share = (np.arange(400_000) + 0.5) / 400_000
        weight = np.exp((42.0 * np.log(share / 0.5)) + 46.0 * np.log((1.0 - share) / 0.5))
        below = weight[(share + w - 1.0) / (b + w - 1.0) < 0.5].sum() / weight.sum()
        assert me.p == pytest.approx(below, abs=1e-4)
        assert functions.estimate(me) == pytest.approx(np.clip((43.0 / 90.0 + w - 1.0) / (b + w - 1.0), 0.0, 1.0))


class TestChangingFloor:
    @pytest.mark.parametrize("side", [0.0, 1.0])
    @pytest.mark.parametrize("threshold", [0.95, 0.7])
    def test_decides_for_the_side_that_is_believed_enough(self, side, threshold):
        """One reading after the other, by I_0.5 of the counts themselves: none before, and the right one then."""
        me, functions = robot(CHANGING, every=1.0, threshold=threshold)
        enough = next(k for k in range(60) if betainc(10.0, 10.0 + k, 0.5) > threshold)
        decisions = []
        for _ in range(enough):
            one_round(me, functions, side)
            decisions.append(functions.decide(me))
        assert decisions == [-1.0] * (enough - 1) + [side]
        assert enough > 2

    @pytest.mark.parametrize("side", [0, 1])
    def test_doubt_resets(self, side):
        """Decided by 16 readings of a side; 15 others later I_0.5(25, 26) = 0.556, one more 0.5."""
        me, functions = robot(CHANGING, every=1.0, limit=2.0)
        for others, looks, decision in ((0, 16, side), (15, 15, side), (1, 1, -1)):
            functions.observe(me, float(others if side == 0 else looks - others), float(looks))
            black, white = me.black, me.white
            functions.fuse(me)
            assert functions.decide(me) == decision
        assert (black, white) == (16.0, 16.0)
        assert betainc(25.0, 26.0, 0.5) > 0.55 > betainc(26.0, 26.0, 0.5)
        assert (me.black, me.white, me.p) == (0.0, 0.0, 0.5)

    @pytest.mark.parametrize(("side", "b"), [(0.0, 0.9), (1.0, 0.9), (0.0, 0.1), (1.0, 0.1)])
    def test_the_limit_holds_back_the_winning_side_alone(self, side, b):
        """By I_0.5 of the counts themselves; a de-biased liar's white readings speak for black."""
        me, functions = robot(CHANGING, b, b, every=1.0, doubt=0.0, debiased=1.0)
        wins, loses = ("black", "white") if side == 1.0 else ("white", "black")
        most = 0.0
        for _ in range(60):
            one_round(me, functions, side)
            most = getattr(me, wins)
        enough = next(k for k in range(60) if betainc(10.0, 10.0 + k, 0.5) >= 0.99)
        assert (most, getattr(me, loses)) == (enough, 0.0)
        functions.receive(me, (side, 1.0, 4.0, 0.0))
        assert getattr(me, wins) == most
        one_round(me, functions, heard=[(1.0 - side, 1.0, 5.0, 0.0)])
        assert getattr(me, loses) == 1.0
        functions.observe(me, side, 1.0)  # believed less than the limit again
        assert getattr(me, wins) == most + 1.0
        assert functions.decide(me) == (side if b > 0.5 else 1.0 - side)

    @pytest.mark.parametrize(("before", "rises", "other"), [(0.0, "up", "down"), (1.0, "down", "up")])
    def test_the_detector(self, before, rises, other):
        """Twelve observations of a side, then of the other: 0.9 the first time, less as the mean moves; by hand."""
        me, functions = robot(CHANGING, every=1.0, detect=1.0, alarm=2.0, doubt=0.0)
        sums, alarms = [], []
        for z in (before,) * 12 + (1.0 - before,) * 3:
            one_round(me, functions, z)
            sums.append(getattr(me, rises))
            alarms.append(me.telling > 0.0)
            assert getattr(me, other) == 0.0
        assert sums[:12] == [0.0] * 12
        assert sums[12:14] == pytest.approx([1.0 - 0.1, 0.9 + 1.0 - 1.0 / 13.0 - 0.1])
        assert alarms == [False] * 14 + [True]  # 1.723 + 1 - 2/14 - 0.1 > 2
        assert (me.t, me.n, me.up, me.down) == (0.0, 0.0, 0.0, 0.0)
        assert (me.black, me.white, functions.decide(me)) == (0.0, 0.0, -1.0)

    def test_three_tellers_reset_and_two_do_not(self):
        """The same one again is no other; afterwards the robot is deaf to them, and does not tell."""
        me, functions = robot(CHANGING, every=1.0, detect=1.0, tell=4.0)
        me.black = 50.0
        for names in ((7.0, 9.0), (9.0, 7.0)):
            one_round(me, functions, heard=[(1.0, 1.0, name, 1.0) for name in names])
            assert me.black > 0.0
        one_round(me, functions, heard=[(1.0, 1.0, 8.0, 1.0)])
        assert (me.black, me.decision, me.telling) == (0.0, -1.0, 0.0)
        for _ in range(4):
            one_round(me, functions, heard=[(1.0, 9.0, name, 1.0) for name in (7.0, 8.0, 9.0)])
        assert me.black > 0.0
        one_round(me, functions, heard=[(1.0, 10.0, name, 1.0) for name in (7.0, 8.0, 9.0)])
        assert me.black == 0.0


class TestBeliefSharing:
    def test_one_exchange_of_two_gives_the_joint_posterior(self):
        """With lambda = mu = 1 and no floor; later exchanges would count the first again."""
        used = SHARING.with_parameters({"forget": 1.0, "mu": 1.0, "every": 1.0, "least": 0.0})
        for fields, blacks in (life(used, robots=2, rounds=2, looks=7), life(used, 1, robots=2, rounds=2, looks=7)):
            for me, other in ((0, 1), (1, 0)):
                black = blacks[1, 0] + blacks[1, 1] + blacks[2, me]
                joint = H**black * (1.0 - H) ** (21.0 - black)
                both = fields["s"][2, me] * fields["n"][2, me]
                assert np.abs(both / both.sum() - joint / joint.sum()).max() < 1e-12
                assert fields["x"][2, me] == pytest.approx((joint * H).sum() / joint.sum(), abs=1e-12)
                told = H ** blacks[1, other] * (1.0 - H) ** (7.0 - blacks[1, other])
                assert np.abs(fields["belief"][1, other] - told / told.sum()).max() < 1e-12

    @pytest.mark.parametrize(("b", "w"), [(0.9, 0.6), (0.2, 0.3), (1.0, 1.0)])
    @pytest.mark.parametrize("brain", [SHARING, INDEXED], ids=["whole", "indexed"])
    def test_noise_aware(self, brain, b, w):
        """The posterior of seven readings by brute force: over what was under the sensor at each of them."""
        me, functions = robot(brain, b, w, debiased=1.0, every=1.0)
        for reading in (1.0, 1.0, 0.0, 1.0, 0.0, 1.0, 1.0):
            functions.observe(me, reading, 1.0)
        functions.fuse(me)
        exact = np.zeros(10)
        for k, h in enumerate(H):
            for tiles in np.ndindex((2,) * 7):
                chance = 1.0
                for tile, reading in zip(tiles, (1, 1, 0, 1, 0, 1, 1), strict=True):
                    right = (b if reading else 1.0 - b) if tile else (1.0 - w if reading else w)
                    chance *= (h if tile else 1.0 - h) * right
                exact[k] += chance
        exact = np.maximum(exact / exact.sum(), 0.0001)
        assert np.abs(np.array(me.s) - exact).max() < 1e-12
        assert functions.decide(me) == exact.argmax()

    def test_a_message_by_hand(self):
        """n^0.8 s_j n_j^0.4, twice in a row, with the floor of 0.0001 under s."""
        me, functions = robot(SHARING, every=1.0)
        random = np.random.default_rng(SEED)
        n = np.full(10, 0.1)
        for _ in range(2):
            told = tuple(random.random(10).tolist())
            functions.observe(me, 3.0, 30.0)
            me.luck = 0.999
            functions.receive(me, (told,))
            functions.receive(me, (tuple(random.random(10).tolist()),))  # by this luck it is not the one
            functions.fuse(me)
            n = n**0.8 * told
            n /= n.sum()
            assert np.array(me.n) == pytest.approx(n, rel=1e-12)
        s = H**3 * (1.0 - H) ** 27
        s = np.maximum(s / s.sum(), 0.0001)
        s = s * H**3 * (1.0 - H) ** 27
        s = np.maximum(s / s.sum(), 0.0001)
        assert np.array(me.s) == pytest.approx(s, rel=1e-9)
        said = s * n**0.4
        assert functions.broadcast(me)[0] == pytest.approx(said / said.sum(), rel=1e-9)


# ---- bayes-bots and changing-floor, rule by rule
def test_an_observation_is_sent_until_the_next_is_due():
    me, functions = robot(BAYES, every=2.0, name=3.0)
    assert functions.broadcast(me) is None
    functions.observe(me, 1.0, 1.0)
    for said in ((1.0, 1.0, 3.0), (1.0, 1.0, 3.0), None, None):
        assert functions.broadcast(me) == said
        functions.fuse(me)


@pytest.mark.parametrize("order", [(133.0, 261.0), (261.0, 133.0)])
def test_a_place_that_is_free_is_for_the_lowest_name_of_the_round(order):
    """It is free `every` rounds after its observation counted, and then held for as long, also from lower names."""
    me, functions = robot(BAYES, every=2.0)
    one_round(me, functions, heard=[(1.0, 1.0, 5.0)])
    functions.receive(me, (0.0, 1.0, 133.0))
    assert me.heard == 1.0
    functions.fuse(me)
    for name in order:
        functions.receive(me, (0.0 if name == 133.0 else 1.0, 1.0, name))
    assert (me.black, me.white, me.heard, me.who[5]) == (1.0, 1.0, 2.0, 133.0)
    functions.fuse(me)
    for message in ((1.0, 2.0, 133.0), (0.0, 1.0, 5.0)):
        functions.receive(me, message)
    assert (me.black, me.white, me.who[5]) == (2.0, 1.0, 133.0)


def test_patience_feedback_and_a_blind_sensor():
    """It hears two observations before it decides, tells the decision, and never decides if readings mean nothing."""
    me, functions = robot(BAYES, every=1.0, patience=2.0, feedback=1.0)
    for heard in (0.0, 1.0, 2.0):
        functions.observe(me, 0.0, 30.0)
        assert functions.broadcast(me)[0] == 0.0
        functions.fuse(me)
        assert functions.decide(me) == (0.0 if heard == 2.0 else -1.0)
        functions.receive(me, (1.0, heard, 4.0 + heard))
    for feedback, told in ((1.0, 0.0), (0.0, 1.0)):
        me.feedback = feedback
        functions.observe(me, 1.0, 1.0)
        assert functions.broadcast(me)[0] == told
        functions.fuse(me)
    me, functions = robot(BAYES, 0.7, 0.3, debiased=1.0, every=1.0)
    one_round(me, functions, 1000.0, 1000.0)
    assert (me.p, functions.decide(me), functions.estimate(me)) == (0.5, -1.0, 0.5)


def test_changes_are_announced_and_their_senders_remembered():
    me, functions = robot(CHANGING, every=1.0, detect=1.0, tell=3.0)
    me.t, me.up = 100.0, 3.9
    told = []
    for _ in range(6):
        functions.observe(me, 1.0, 1.0)
        told.append(functions.broadcast(me)[3])
        functions.fuse(me)
    assert told == [0.0, 1.0, 1.0, 1.0, 0.0, 0.0]
    me, functions = robot(CHANGING, every=1.0, detect=1.0, tell=4.0)
    for name in (7.0, 8.0, None, None, None, 9.0):  # the first is too old when the third speaks
        one_round(me, functions, heard=[(1.0, 1.0, name, 1.0)] if name else [])
    assert (me.black, list(me.tellers)) == (3.0, [9.0, 1e30, 1e30])
    me, functions = robot(CHANGING, every=1.0, alarm=0.0)  # without a detector
    one_round(me, functions, 0.0, heard=[(0.0, 1.0, name, 1.0) for name in (1.0, 2.0, 3.0)])
    assert (me.white, me.telling) == (4.0, 0.0)


def test_beliefs_are_sent_once_a_step_and_blind_sensors_send_nothing():
    for brain in (SHARING, INDEXED):
        me, functions = robot(brain, every=3.0)
        functions.observe(me, 1.0, 1.0)
        said = []
        for _ in range(9):
            functions.fuse(me)
            said.append(functions.broadcast(me) is not None)
        assert said == [False, False, True] * 3
    for debiased, choice in ((0.0, 9.0), (1.0, -1.0)):
        me, functions = robot(SHARING, 0.5, 0.5, debiased=debiased, every=1.0)
        one_round(me, functions, 40.0, 40.0)
        assert functions.decide(me) == choice
