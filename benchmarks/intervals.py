"""How often intervals hold the truth: python benchmarks/intervals.py [QUESTION] [--quick].

`rules` draws trials whose truth is known and says how often 95 % intervals hold it, also where a rule ends that asks
for an interval of some width; `looks` what such a rule costs.
"""

import resource
import time

import harness
import numpy as np

from swarmcensus import Study, run
from swarmcensus.studies.precision import Until
from swarmcensus.support.intervals import estimate

STARTS = (6, 10, 30, 100)  # trials at the first look
LATER = 4  # times as many trials as at the first look are needed, in the median
AT_MOST = 16  # times as many are run at most
TIMES = 800
ROBOTS = 100  # of a share
FEWER = 5  # of a median or mean
SHARES = (0.5, 0.8, 0.95, 0.98, 0.99, 0.999)
BIG = """
trials = 2000
[swarm]
robots = 1000
accuracy = 0.7
[world]
topology = "ring"
fill_ratio = 0.55
[schedule]
rounds = 100
"""
SMALL = """
trials = 5000
[swarm]
robots = 10
accuracy = 0.7
[world]
topology = "ring"
fill_ratio = 0.55
[schedule]
rounds = 50
[measure]
checkpoints = [20]
"""


def shares(share, correlation):
    """The share of right robots by trial, (trial, 1): independent (0) to all alike (1), beta-binomial between."""

    def draw(rng, trials):
        if correlation == 1:
            return (rng.random((trials, 1)) < share).astype(float)
        chance = share
        if correlation:
            spread = (1 - correlation) / correlation
            chance = rng.beta(share * spread, (1 - share) * spread, (trials, 1))
        return rng.binomial(ROBOTS, chance, (trials, 1)) / ROBOTS

    return draw


def rare(share):
    """Trials of which few go wrong: half the robots err in these, and one in a thousand in the others."""

    def draw(rng, trials):
        bad = rng.random((trials, 1)) < (0.999 - share) / 0.499
        return rng.binomial(ROBOTS, np.where(bad, 0.5, 0.999)) / ROBOTS

    return draw


def normals(correlation, robots=FEWER):
    """Standard normal values of the robots of a trial, correlated."""

    def draw(rng, trials):
        common, own = rng.normal(size=(trials, 1)), rng.normal(size=(trials, robots))
        return np.sqrt(correlation) * common + np.sqrt(1 - correlation) * own

    return draw


def skewed(sigma, correlation, robots=FEWER):
    """Log-normal values: errors."""
    draw = normals(correlation, robots)
    return lambda rng, trials: np.exp(sigma * draw(rng, trials))


def rounds(last):
    """Whole rounds of convergence, about log-normal; a share `last` of the trials converges in the last one."""
    draw = skewed(0.5, 0.5)
    return lambda rng, trials: np.where(rng.random((trials, 1)) < last, 1000.0, np.floor(100 * draw(rng, trials)))


def cases():
    """Each as: a name, "median" or "mean", whether of a share, what draws trials, the truth (None: from very many)."""
    for correlation, name in ((0, "independent"), (0.1, "correlated 0.1"), (0.3, "correlated 0.3"), (1, "all alike")):
        for share in SHARES:
            yield f"share {share}, robots {name}", "mean", True, shares(share, correlation), share
    for share in (0.95, 0.98, 0.99):
        yield f"share {share}, by few bad trials", "mean", True, rare(share), share
    yield "median, log-normal(1), one robot", "median", False, skewed(1, 0, 1), 1.0
    for correlation in (0, 0.5):
        yield f"median, log-normal(1), correlated {correlation}", "median", False, skewed(1, correlation), 1.0
    for last in (0.1, 0.45):
        yield f"median, rounds, {last:.0%} of trials at the last", "median", False, rounds(last), None
    yield "mean, normal, correlated 0.5", "mean", False, normals(0.5), 0.0
    for sigma in (0.5, 1):
        yield f"mean, log-normal({sigma}), correlated 0.5", "mean", False, skewed(sigma, 0.5), np.exp(sigma**2 / 2)
        yield f"mean, log-normal({sigma}), one robot", "mean", False, skewed(sigma, 0, 1), np.exp(sigma**2 / 2)
    for last in (0.02, 0.1):
        yield f"mean, rounds, {last:.0%} of trials at the last", "mean", False, rounds(last), None
    pool = run(Study.parse(SMALL), 1)
    for what, statistic in (("convergence_error", "median"), ("convergence_round", "mean"), ("correct", "mean")):
        trials = pool[what].values[0].astype(float)
        trials = trials.T if what == "correct" else trials
        yield f"{statistic}, {what} of a swarm on a ring", statistic, what == "correct", again(trials), None


def again(trials):
    """Trials of a large study (trial, robot), drawn with return: what is true of them all is known."""
    return lambda rng, count: trials[rng.integers(len(trials), size=count)]


def rule(statistic, share, width, start):
    """The rule that ends at this half-width."""
    variable = "correct@1" if share else "final_estimate"
    return Until(until=f"{variable} {statistic} +- {width:g}", at_least=start, at_most=AT_MOST * start)


def held(rng, draw, truth, statistic, share, trials, times):
    """How often the interval after so many trials holds the truth; and half its width, in the median."""
    found = np.array([estimate(draw(rng, trials), statistic, share)[1:] for _ in range(times)])
    return ((found[:, 0] <= truth) & (truth <= found[:, 1])).mean(), np.median(found[:, 1] - found[:, 0]) / 2


def held_at_the_end(rng, draw, truth, statistic, share, until, times):
    """How often the interval at which a rule ends holds the truth; and after how many trials, in the mean."""
    hits = spent = 0
    for _ in range(times):
        values = draw(rng, until.at_most)
        for trials in until.stages():
            low, high = until.interval(values[:trials])
            if until.holds((high - low) / 2):
                break
        hits += low <= truth <= high
        spent += trials
    return hits / times, spent / times


@harness.question
def rules(seed=1, times=TIMES, write=False, quick=False):
    """How often the interval holds the truth where a rule ends, and after so many trials without a rule.

    With `write` the numbers go into benchmarks/tables/intervals.csv, those that hold most seldom first.
    """
    times = 8 if quick else times
    heads = [*map(str, STARTS), f"just {STARTS[0]}", *map(str, STARTS[1:])]
    table = harness.table(
        f"% of intervals that hold the truth, of {times:,}: 95.0 would be right", "rule that starts with", *heads
    )
    found = []
    for number, (name, statistic, share, draw, truth) in enumerate(cases()):
        rng = np.random.default_rng([seed, number])
        if truth is None:
            many = draw(rng, 200_000)
            truth = np.median(many) if statistic == "median" else many.mean()
        plain, ended = [], []
        for start in STARTS:
            plain.append(held(rng, draw, truth, statistic, share, start, times)[0])
            width = held(rng, draw, truth, statistic, share, LATER * start, 25)[1]
            ended.append(
                held_at_the_end(rng, draw, truth, statistic, share, rule(statistic, share, width, start), times)[0]
            )
        found.append((name, *[f"{100 * x:.1f}" for x in ended + plain]))
        table.add_row(*found[-1])
    harness.show(table, 130)
    if write:
        heads = [f"rule from {start}" for start in STARTS] + [f"just {start}" for start in STARTS]
        found.sort(key=lambda row: min(map(float, row[1:])))
        harness.write_csv("intervals", ["trials", *heads], found)
    error = 100 * np.sqrt(0.95 * 0.05 / times)
    harness.show(f"Monte-Carlo standard error of 95.0: {error:.1f}")


@harness.question
def looks():
    """What the looks of rules cost beside the simulation."""
    run(Study.parse(BIG).with_(trials=1), 1)  # compiles
    begun = time.perf_counter()
    data = run(Study.parse(BIG), 1)
    simulating = time.perf_counter() - begun
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    harness.show(
        f"simulating {data.sizes['trial']:,} trials of {data.sizes['robot']:,} robots: {simulating:.1f} s, one thread"
    )
    for text in ("convergence_error median", "convergence_round median", "final_estimate mean"):
        values = data[text.split()[0]].values[0]
        until = Until(until=f"{text} +- 1e-9", at_least=30, at_most=len(values))
        begun, looks = time.perf_counter(), 0
        for trials in until.stages():
            until.half_width(values[:trials].astype(float))
            looks += 1
        spent = time.perf_counter() - begun
        harness.show(f"  {text}: {looks} looks, the last one at all: {spent:.2f} s, {spent / simulating:.0%} of it")
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    harness.show(f"peak of memory: {after / 1024:.0f} MiB, of which the looks need {(after - before) / 1024:.0f} MiB")


if __name__ == "__main__":
    harness.answer(globals())
