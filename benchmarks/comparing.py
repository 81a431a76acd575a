"""What a comparison is worth: python benchmarks/comparing.py [--tables N] [--seed N].

Prints, of tables of equal contenders whose trials are drawn anew, the share in which any two are told apart, which
should be at most 5 %; how often those are that differ, beside the power of the paired t-test; how often intervals hold
the truth; and the time that a comparison of 20,000 settings takes. Seeds are fixed; the error of the shares is stated.
"""

import argparse
import math
import time

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy import stats

from swarmcensus.comparing.pair_tests import ContestInput, contests
from swarmcensus.statistics.bootstrap import intervals
from swarmcensus.statistics.intervals import share_interval
from swarmcensus.statistics.significance import signed_ranks

TRIALS = (6, 10, 30)
KINDS = {"continuous": "median", "tied": "mean", "heavy tails, some infinite": "median"}
TABLES = ((2, 1, 1), (2, 3, 3), (5, 1, 1), (5, 3, 3))  # contenders, worlds, measures
ROWS = 20_000  # of power and coverage


def numbers(random, kind, measures, worlds, contenders, trials):
    """Of contenders that are alike: measures and worlds of a trial are correlated, those of one contender too."""
    shape = measures, worlds, contenders, trials
    own = random.normal(size=(1, 1, contenders, trials)) + random.normal(size=shape)
    shared = random.normal(size=(measures, worlds, 1, trials)) + 2 * random.normal(size=trials)
    if kind == "continuous":
        return np.exp((own + shared) / 2)
    if kind == "tied":
        return np.clip(np.rint(3 * (own + shared)) / 3 + 1, 0, 3)
    heavy = own / np.abs(random.normal(size=shape)) + shared
    return np.where(heavy > 4, math.inf, heavy)


def alarms(console, tables, seed):
    """Tables in which anything is told apart where nothing differs."""
    out = Table("contenders, worlds, measures", "tests", *(f"{n} trials" for n in TRIALS), title="false alarms, in %")
    for kind, statistic in KINDS.items():
        for contenders, worlds, measures in TABLES:
            cells = []
            for trials in TRIALS:
                random, hits = np.random.default_rng([seed, trials]), 0
                for _ in range(tables):
                    drawn = numbers(random, kind, measures, worlds, contenders, trials)
                    found = contests([ContestInput(one, statistic) for one in drawn], with_intervals=False)
                    hits += any(one.apart.any() or one.duels_apart.any() for one in found)
                share, low, high = share_interval(hits, tables)
                cells.append(f"{100 * share:.1f} [{100 * low:.1f}, {100 * high:.1f}]")
            pairs = contenders * (contenders - 1) // 2
            tests = measures * pairs * (worlds + (worlds > 1))
            out.add_row(f"{kind}: {contenders}, {worlds}, {measures}", str(tests), *cells)
    console.print(out)


def power(console, seed):
    """One test of two contenders: how often it tells them apart that differ by so many standard deviations."""
    out = Table("difference", *(f"{n} trials" for n in TRIALS), title="told apart, in % (paired t-test)")
    for off in (0.0, 0.25, 0.5, 1.0):
        cells = []
        for trials in TRIALS:
            drawn = np.random.default_rng([seed, trials]).normal(off, 1, (ROWS, trials))
            beyond, freedom = stats.t.ppf(0.975, trials - 1), trials - 1
            centre = off * math.sqrt(trials)
            theory = stats.nct.sf(beyond, freedom, centre) + stats.nct.cdf(-beyond, freedom, centre)
            cells.append(f"{100 * (signed_ranks(drawn).p <= 0.05).mean():.1f} ({100 * theory:.1f})")
        out.add_row(f"{off:g}", *cells)
    console.print(out)


def unlike(console, seed):
    """Contenders whose medians are equal, and whose distributions are not."""
    out = Table("trials are", *(f"{n} trials" for n in TRIALS), title="told apart though medians are equal, in %")
    drawn = {
        "normal, one spread threefold": lambda r, shape: (r.normal(size=shape), 3 * r.normal(size=shape)),
        "one normal, one exponential": lambda r, shape: (
            r.normal(size=shape), r.exponential(size=shape) - math.log(2)
        ),
    }  # fmt: skip
    for name, draw in drawn.items():
        cells = []
        for trials in TRIALS:
            one, other = draw(np.random.default_rng([seed, trials]), (ROWS, trials))
            cells.append(f"{100 * (signed_ranks(one - other).p <= 0.05).mean():.1f}")
        out.add_row(name, *cells)
    console.print(out)


def coverage(console, seed):
    """How often the intervals of a median and a mean hold the true one."""
    kinds = {
        "normal": (lambda r, shape: r.normal(size=shape), 0.0, 0.0),
        "exponential": (lambda r, shape: r.exponential(size=shape), math.log(2), 1.0),
        "Student's t of 3": (lambda r, shape: r.standard_t(3, size=shape), 0.0, 0.0),
        "a share of 20 robots, 0.95": (lambda r, shape: r.binomial(20, 0.95, shape) / 20, None, 0.95),
    }
    out = Table("trials are", *(f"{s}, {n}" for s in ("median", "mean") for n in TRIALS), title="intervals hold, in %")
    for name, (draw, *truths) in kinds.items():
        cells = []
        for statistic, truth in zip(("median", "mean"), truths, strict=True):
            for trials in TRIALS:
                if truth is None:
                    cells.append("")
                    continue
                low, high = intervals(draw(np.random.default_rng([seed, trials]), (ROWS // 4, trials)), statistic)
                known = ~np.isnan(low)
                cells.append(f"{100 * ((low <= truth) & (truth <= high))[known].mean():.1f}")
        out.add_row(name, *cells)
    console.print(out)


def speed(console, seed):
    """4,000 worlds of 5 contenders, 30 trials, three measures: errors, rounds and shares."""
    random = np.random.default_rng(seed)
    shape = 4000, 5, 30
    drawn = [
        ContestInput(random.normal(size=shape), "median"),
        ContestInput(np.rint(np.exp(random.normal(5, 0.5, shape)) * 2) / 2, "median"),
        ContestInput(random.binomial(100, 0.95, shape) / 100, "mean", False, True),
    ]
    begun = time.perf_counter()
    found = contests(drawn)
    tests = sum(one.corrected.size + one.duels_corrected.size for one in found)
    console.print(f"20,000 settings of 30 trials, 3 measures, {tests:,} tests: {time.perf_counter() - begun:.1f} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--tables", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    console = Console(width=110)
    console.print(f"{options.tables:,} tables a cell, [95 % interval]")
    alarms(console, options.tables, options.seed)
    for part in (power, unlike, coverage, speed):
        part(console, options.seed)


if __name__ == "__main__":
    main()
