"""A comparison tells equal contenders apart in at most 5 % of tables, unequal ones as often as theory says.

Bounds of shares are binomial quantiles: with another seed a right program would fail in less than one case of 1,000.
"""

import functools
import math

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus.analysis.comparing import pair_tests
from swarmcensus.analysis.comparing.pair_tests import ContestInput, contests, pairs_of
from swarmcensus.studies.precision import Until
from swarmcensus.support import bootstrap
from swarmcensus.support.bootstrap import intervals
from swarmcensus.support.intervals import estimate
from swarmcensus.support.significance import signed_ranks
from tests.support.tunable import study_of

TABLES = 1000
MOST = int(stats.binom.ppf(0.999, TABLES, 0.05))  # of tables with a false alarm, if the share is 5 %: 72


def table(random, kind, shape):
    """Numbers (measure, world, contender, trial) of contenders that are all alike: what they share is the trial.

    Measures and worlds of a trial are correlated, of one contender too, as where they share readings.
    """
    measures, worlds, contenders, trials = shape
    own = random.normal(size=(1, 1, contenders, trials)) + random.normal(size=shape)
    shared = random.normal(size=(measures, worlds, 1, trials)) + 2 * random.normal(size=trials)
    if kind == "continuous":
        return np.exp((own + shared) / 2)  # skewed, as errors are
    if kind == "tied":
        return np.clip(np.rint(3 * (own + shared)) / 3 + 1, 0, 3)
    heavy = own / np.abs(random.normal(size=shape)) + shared  # Cauchy's tails
    return np.where(heavy > 4, math.inf, heavy)


def told_apart(found, corrected=True):
    if corrected:
        return any(one.apart.any() or one.duels_apart.any() for one in found)
    return any((one.tests.p <= 0.05).any() for one in found)


def judged(numbers, statistic="median"):
    return contests([ContestInput(one, statistic) for one in numbers], with_intervals=False)


@pytest.mark.long(but=["continuous-(1, 1, 2, 6)"])
@pytest.mark.parametrize(("kind", "shape"), [
    ("continuous", (1, 1, 2, 6)), ("continuous", (3, 1, 2, 10)), ("continuous", (1, 2, 5, 30)),
    ("tied", (3, 2, 2, 6)), ("tied", (2, 3, 5, 10)), ("tied", (2, 1, 5, 30)), ("heavy", (1, 4, 2, 30)),
    ("heavy", (2, 1, 5, 10)), ("heavy", (1, 1, 5, 6)),
], ids=str)  # fmt: skip
def test_false_alarms_of_equal_contenders(kind, shape):
    random = np.random.default_rng(7)
    alarms = uncorrected = 0
    for _ in range(TABLES):
        found = judged(table(random, kind, shape), "mean" if kind == "tied" else "median")
        alarms += told_apart(found)
        uncorrected += told_apart(found, corrected=False)
    assert alarms <= MOST
    if math.prod(shape[:2]) * shape[2] > 2 and shape[3] > 6:
        assert uncorrected > MOST  # the test would notice if nothing were corrected


@pytest.mark.long
def test_false_alarms_of_equal_contenders_next_to_a_different_one():
    random, alarms, seen = np.random.default_rng(8), 0, 0
    for _ in range(TABLES):
        numbers = table(random, "continuous", (1, 2, 4, 12))
        numbers[:, :, 0] *= 9
        [one] = judged(numbers)
        alarms += bool(one.apart[:, 3:].any() or one.duels_apart[3:].any())  # pairs without the first
        seen += bool(one.apart[:, :3].any())
    assert alarms <= MOST
    assert seen > 0.9 * TABLES


def power(off, trials, tables=20_000):
    """The share of tables of two contenders in one world, and one measure, in which they are told apart.

    A table of one test is not corrected, so that all are tested at once; of some, it is asked whether that is so.
    """
    random = np.random.default_rng(9)
    trial = 5 * random.normal(size=(tables, 1, trials))
    numbers = trial + random.normal(scale=math.sqrt(0.5), size=(tables, 2, trials))  # differences have variance 1
    numbers[:, 0] += off
    [every] = judged(numbers[np.newaxis])
    told = every.tests.p[:, 0] <= 0.05
    assert [told_apart(judged(one[np.newaxis, np.newaxis])) for one in numbers[:50]] == told[:50].tolist()
    return told.mean()


def within(share, expected, tries=20_000):
    return abs(share - expected) < 3.3 * math.sqrt(expected * (1 - expected) / tries)


@pytest.mark.long(only=["0.9-15"])
@pytest.mark.parametrize(("off", "trials"), [(0.5, 30), (0.9, 15)])
def test_power_is_near_that_of_the_paired_t_test(off, trials):
    """Ranks are worth 3 / pi of normal trials, for many of them; the number of trials ahead costs at most 10 points."""
    freedom = trials - 1
    beyond = stats.t.ppf(0.975, freedom)
    centre = off * math.sqrt(trials * 3 / math.pi)
    expected = stats.nct.sf(beyond, freedom, centre) + stats.nct.cdf(-beyond, freedom, centre)
    found = np.random.default_rng(9).normal(off, 1, (20_000, trials))
    assert (signed_ranks(found).p <= 0.05).mean() == pytest.approx(expected, abs=0.03)
    assert expected - 0.1 < power(off, trials) < expected


@pytest.mark.long(but=["30-exponential", "30-normal"])
@pytest.mark.parametrize("kind", ["normal", "exponential", "log-normal", "two slopes"])
@pytest.mark.parametrize("trials", [10, 30, 200])
def test_false_verdicts_where_each_is_as_often_ahead(kind, trials):
    """About 5 % of 2,000 studies of differences with median 0, symmetric or skewed; ranks alone find up to 73 %."""
    random, shape = np.random.default_rng(21), (2000, trials)
    off = {
        "normal": lambda: random.normal(size=shape),
        "exponential": lambda: random.exponential(size=shape) - math.log(2),
        "log-normal": lambda: np.exp(random.normal(size=shape)) - 1,
        "two slopes": lambda: random.exponential(size=shape) * random.choice([-1.0, 1.5], shape),
    }[kind]()
    [found] = judged(np.stack([off, np.zeros(shape)], axis=1)[np.newaxis])
    assert (found.tests.p <= 0.05).mean() <= 0.06
    if kind in ("exponential", "log-normal") and trials >= 30:
        assert (signed_ranks(off).p <= 0.05).mean() > 0.1  # the test would notice if ranks were asked alone


def test_false_verdicts_over_worlds_where_each_is_as_often_ahead():
    """In a tenth of trials the first is ahead in all of 12 worlds, in others in 4 of 9: on average in half of them."""
    random, alarms, by_ranks, studies = np.random.default_rng(23), 0, 0, 150
    for _ in range(studies):
        ahead = (random.random(100) < 0.1) | (random.random((12, 100)) < 4 / 9)
        [found] = judged(np.stack([1.0 - ahead, np.full(ahead.shape, 0.5)], axis=1)[np.newaxis])
        alarms += found.duels_apart.item()
        by_ranks += signed_ranks(2 * ahead.mean(axis=0) - 1).p <= 0.05
    assert alarms <= stats.binom.ppf(0.999, studies, 0.05) < by_ranks


@pytest.mark.long
@pytest.mark.parametrize(("kind", "paired"), [("normal", True), ("skewed", False), ("mean", False)])
def test_levels_that_differ_by_the_margin_are_called_equal_in_few_studies(kind, paired, monkeypatch):
    """Eight levels, of which one is off by the margin: at most 5 % of studies call any pair with it equal."""
    for costly in ("friedman", "_better_ends"):  # of which equality knows nothing
        monkeypatch.setattr(pair_tests, costly, lambda *_: (math.nan, math.nan))
    monkeypatch.setattr(bootstrap, "resample", functools.cache(bootstrap.resample))
    random, alarms, uncorrected, seen, studies = np.random.default_rng(22), 0, 0, 0.0, 200
    differ = (np.array(pairs_of(8)) == 0).any(axis=1)
    for _ in range(studies):
        drawn = random.exponential(size=(8, 60)) if kind == "mean" else random.normal(size=(8, 60))
        numbers = (np.exp(drawn) if kind == "skewed" else drawn) + random.normal(size=60) * paired
        numbers[0] += 1.0
        one = ContestInput(numbers[np.newaxis], "mean" if kind == "mean" else "median", margin=1.0)
        [found] = contests([one], paired=np.full((1, 28), paired))
        low, high = found.difference_ends
        uncorrected += bool(((low >= -1.0) & (high <= 1.0))[0, differ].any())
        alarms += bool((found.equality <= 0.05)[0, differ].any())
        seen += (found.equality <= 0.05)[0, ~differ].mean() / studies
    most = stats.binom.ppf(0.999, studies, 0.05)
    assert alarms <= most
    assert uncorrected > most or not paired  # the test would notice if nothing were corrected
    assert seen > 0.5  # of the 21 other pairs


DRAWN = {
    "normal": lambda random, shape: random.normal(size=shape),
    "skewed": lambda random, shape: random.exponential(size=shape),
    "heavy": lambda random, shape: random.standard_t(3, size=shape),
    "rounds": lambda random, shape: np.rint(np.exp(random.normal(4, 0.5, shape))),
}
TRUTH = {
    "median": {"normal": 0, "skewed": math.log(2), "heavy": 0, "rounds": round(math.exp(4))},
    "mean": {"normal": 0, "skewed": 1, "heavy": 0, "rounds": math.exp(4.125)},
}


@pytest.mark.long(but_every=3)
@pytest.mark.long(but=["normal-6-mean", "heavy-30-median", "skewed-10-mean", "rounds-6-median", "rounds-30-mean"])
@pytest.mark.parametrize("statistic", ["median", "mean"])
@pytest.mark.parametrize("trials", [6, 10, 30])
@pytest.mark.parametrize("kind", DRAWN)
def test_intervals_hold_the_truth(kind, trials, statistic):
    rows = 2000
    low, high = intervals(DRAWN[kind](np.random.default_rng(11), (rows, trials)), statistic)
    truth = TRUTH[statistic][kind]
    held = ((low <= truth) & (truth <= high)).mean()
    least = 0.95 if statistic == "median" else 0.94 if kind in ("normal", "heavy") else 0.9  # of skewed ones the least
    assert held > least - 3.3 * math.sqrt(least * (1 - least) / rows)
    assert held < 0.99


@pytest.mark.long(but=["shares-6"])
@pytest.mark.parametrize("trials", [6, 20])
@pytest.mark.parametrize("kind", ["skewed", "shares"])
def test_independent_samples_that_do_not_differ(kind, trials):
    random, shape = np.random.default_rng(11), (TABLES, 2, trials)
    shares = kind == "shares"
    numbers = random.binomial(12, 0.8, shape) / 12 if shares else np.exp(random.normal(size=shape))
    one = ContestInput(numbers, "mean" if shares else "median", share=shares)
    (found,) = contests([one], paired=np.zeros((TABLES, 1), np.bool_))
    assert (found.tests.p <= 0.05).sum() <= MOST
    least = stats.binom.ppf(0.001, TABLES, 0.94)
    low, high = found.difference_ends
    assert ((low <= 0) & (high >= 0)).sum() >= least
    low, high = found.better_ends
    assert ((low <= 0.5) & (high >= 0.5)).sum() >= least


@pytest.mark.long(but=["(8, 40)"])
@pytest.mark.parametrize("sizes", [(20, 20), (20, 60), (8, 40)], ids=str)
def test_independent_samples_of_unequal_spread(sizes):
    numbers = np.full((TABLES, 2, max(sizes)), np.nan)
    for who, (size, spread) in enumerate(zip(sizes, (5.0, 1.0), strict=True)):
        numbers[:, who, :size] = np.random.default_rng([13, who]).normal(0, spread, (TABLES, size))
    (found,) = contests([ContestInput(numbers, "median")], paired=np.zeros((TABLES, 1), np.bool_))
    assert (found.tests.p <= 0.05).sum() <= stats.binom.ppf(0.999, TABLES, 0.065)  # Brunner and Munzel's of 8 trials
    least = stats.binom.ppf(0.001, TABLES, 0.95)
    for (low, high), truth in ((found.difference_ends, 0.0), (found.better_ends, 0.5)):
        assert ((low <= truth) & (high >= truth)).sum() >= least


# ---- intervals hold the truth as often as they say, also where a rule ends
def right(share):
    """Trials in which all robots are right, or none."""
    return lambda rng, trials: (rng.random((trials, 1)) < share).astype(float)


def correlated(share):
    """Twenty robots, of a chance to be right that differs between trials: correlation 0.1."""
    return lambda rng, trials: rng.binomial(20, rng.beta(9 * share, 9 * (1 - share), (trials, 1))) / 20


def errors(rng, trials):
    """Log-normal, five robots, of a common part and one of their own; the median is 1, the mean exp(1 / 8)."""
    return np.exp(0.5 * (rng.normal(size=(trials, 1)) + rng.normal(size=(trials, 5))) / np.sqrt(2))


def normals(rng, trials):
    return rng.normal(size=(trials, 1))


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize(("rule", "draw", "truth", "at_least", "times"), [
    ("correct@9 mean +- 0.05", right(0.95), 0.95, 30, 1000),
    ("correct@9 mean +- 0.02", right(0.99), 0.99, 30, 1000),
    ("correct@9 mean +- 0.09", right(0.5), 0.5, 30, 1000),
    ("correct@9 mean +- 0.02", correlated(0.95), 0.95, 30, 1000),
    ("final_estimate mean +- 0.47", normals, 0.0, 6, 4000),
    ("convergence_error mean +- 0.12", errors, np.exp(1 / 8), 30, 1000),
    ("convergence_error median +- 0.13", errors, 1.0, 30, 200),
])  # fmt: skip
def test_the_interval_at_which_a_rule_ends(rule, draw, truth, at_least, times):
    """At least 95 % hold the truth: a rule that is so good fails in one of 10,000 seeds, one of 90 % hardly passes."""
    rng = np.random.default_rng(8)
    until = Until(until=rule, at_least=at_least, at_most=at_least * 10)
    hits, ends = 0, []
    for _ in range(times):
        values = draw(rng, until.at_most)
        ends.append(next(n for n in until.stages() if until.holds(until.half_width(values[:n])) or n == until.at_most))
        low, high = until.interval(values[: ends[-1]])
        hits += low <= truth <= high
    assert at_least < np.median(ends) < until.at_most  # it was looked at more than once, and found narrow
    assert hits >= stats.binom.ppf(1e-4, times, 0.95)


@pytest.mark.long(but_every=2)
@pytest.mark.parametrize("trials", [6, 30])
@pytest.mark.parametrize(("draw", "statistic", "truth"), [
    (right(0.9), "share", 0.9), (errors, "median", 1.0), (normals, "mean", 0.0),
])  # fmt: skip
def test_the_interval_of_so_many_trials(draw, statistic, truth, trials):
    rng = np.random.default_rng(9)
    hits = 0
    for _ in range(1000):
        share = statistic == "share"
        _, low, high = estimate(draw(rng, trials), "mean" if share else statistic, share)
        hits += low <= truth <= high
    assert hits >= stats.binom.ppf(1e-4, 1000, 0.95)


# ---- noise does not fool the evidence of a tuned brain
@pytest.mark.long
def test_false_alarms_of_tuning(tmp_path):
    """A parameter makes other errors of the same distribution: called better in 13 of 100 studies at the most.

    More are so with a chance of 0.1 % if 5 % are, and far less if 2.5 % are.
    """
    studies = (study_of(tmp_path, "noise = 1.0, shift = 0.5", seed=seed, robots=1) for seed in range(100))
    found = [sc.tune(one, ["shift=0:1"], budget=25, trials=20, jobs=1) for one in studies]
    assert all(one.brain != one.before for one in found)
    assert sum(one.verdict == "better" for one in found) <= stats.binom.ppf(0.999, 100, 0.05)
