"""How often intervals hold the truth: python benchmarks/intervals.py [QUESTION] [--quick].

`rules` draws trials whose truth is known and says how often 95 % intervals hold it, also where a rule ends that asks
for an interval of some width; `looks` what such a rule costs. The others are of the brain `sure`: how often its
intervals hold, and how many robots stop on a wrong answer, in all worlds of studies/beyond.toml and among robots that
move. Those take forty minutes on two cores together.
"""

import resource
import time
import tomllib
from pathlib import Path

import harness
import numpy as np

import swarmcensus as sc
from swarmcensus import Study, run, theory
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
def rules(seed=1, times=TIMES, quick=False):
    """How often the interval holds the truth where a rule ends, and after so many trials without a rule."""
    times = 8 if quick else times
    heads = [*map(str, STARTS), f"just {STARTS[0]}", *map(str, STARTS[1:])]
    table = harness.table(
        f"% of intervals that hold the truth, of {times:,}: 95.0 would be right", "rule that starts with", *heads
    )
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
        table.add_row(name, *[f"{100 * x:.1f}" for x in ended + plain])
    harness.show(table, 130)
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


# ---- the brain sure


WORLDS = Path(__file__).parents[1] / "studies" / "beyond.toml"
SENSORS = [0.525, 0.875, 1.0, "U(0.525, 0.975)"]


def cell(results, i):
    """What a setting is, in a line."""
    names = ("robots", "topology", "accuracy", "fill_ratio", "link_success")
    return " ".join(str(results[name].values[i]) for name in names)


@harness.question(unasked=False)
def sure():
    """Shares of robots whose interval holds f, cell by cell and at each checkpoint."""
    brain = {"file": "sure", "within": 1e-9, "alpha": [0.05, 0.2]}
    study = sc.Study(
        trials=harness.trials(400),
        seed=13,
        swarm={"brain": brain, "robots": [10, 40], "accuracy": SENSORS},
        world={"topology": ["full", "ring", "scale-free"], "fill_ratio": [0.55, 0.95], "link_success": [1.0, 0.3]},
        schedule={"rounds": 248, "observations_per_round": 10},
        measure={"checkpoints": [20, 56, 120, 248]},
    )
    results = sc.run(study)
    shares = results["coverage"].values
    mean, error = shares.mean(axis=2), shares.std(axis=2, ddof=1) / shares.shape[2] ** 0.5
    for alpha in (0.05, 0.2):
        rows = results["alpha"].values == alpha
        off, sd = mean[rows] - (1 - alpha), error[rows]
        low, high, middle = mean[rows].min(), mean[rows].max(), mean[rows].mean()
        print(f"alpha = {alpha}: {off.size} shares from {low:.3f} to {high:.3f}, mean {middle:.4f}")
        beyond = np.abs(off) > 0.015 + 1.96 * sd
        below = (beyond & (off < 0)).sum()
        print(f"  beyond 1.5 points by more than its 95 % interval: {beyond.sum()}, of them below: {below}")
        row, at = np.unravel_index(mean[rows].argmin(), off.shape)
        print(f"  lowest: {cell(results, np.flatnonzero(rows)[row])} at round {results['checkpoint'].values[at]}")


@harness.question(unasked=False)
def stops():
    """Shares of robots that stop on a wrong answer, and when they do, beside who knew all readings."""
    alpha, within, rounds = 0.05, 0.05, 1016
    tables = tomllib.loads(WORLDS.read_text(encoding="utf-8"))
    tables["trials"] = harness.trials(50)
    tables["swarm"]["brain"] = {"file": "sure", "within": within, "alpha": alpha}
    tables["schedule"]["rounds"] = rounds
    tables["measure"]["checkpoints"] = [rounds]
    results = sc.run(sc.Study(**tables))
    at, said = results["done_round"].values, results["done_estimate"].values
    there, done = np.isfinite(results["final_estimate"].values), np.isfinite(said)
    truth = results["fill_ratio"].values
    off = np.abs(said - truth[:, None, None]) > within
    wrong = np.where(there, off, np.nan)
    wrong = np.nansum(wrong, axis=2) / there.sum(axis=2)
    mean, error = wrong.mean(axis=1), wrong.std(axis=1, ddof=1) / wrong.shape[1] ** 0.5
    print(f"stopped: {done.sum() / there.sum():.1%} of robots, {off[there].mean():.2%} of all on a wrong answer;")
    print(f"  above {alpha} in {(mean > alpha).sum()} of {mean.size:,} cells, surely so in", end=" ")
    print(f"{(mean - 1.96 * error > alpha).sum()}; most in")
    for i in np.argsort(-mean)[:5]:
        print(f"  {cell(results, i)}: {mean[i]:.1%} +- {1.96 * error[i]:.1%}")
    variance = float(theory.reading_variance(0.55, 0.625))
    for i in range(mean.size):
        robots = int(results["robots"].values[i])
        if cell(results, i).endswith(" 0.625 0.55 1.0") and robots == 100:
            needed = (1.96 / within) ** 2 * variance / 10 / robots
            when = f"round {np.median(at[i][done[i]]):.0f}" if done[i].any() else "nobody"
            print(f"  {cell(results, i)}: {when}, oracle {max(needed, 1.0):.1f}")


@harness.question(unasked=False)
def patches():
    """The same among robots that move, held against the floor's own share: stops within 0.05, and coverage if none."""
    print("moving; wrong: % of robots that stop on a wrong answer; cover: % at ticks 248, 1016, 4088, without stops")
    print("robots density floor          accuracy          wrong  stopped at tick  cover")
    for robots in (1, 2, 5, 10, 20, 50, 100):
        for density in (1, 10):
            walk(robots, density)


def walk(robots, density, trials=400, seed=401, brain="sure"):
    """A line a floor and accuracy, all on the same walks."""
    study = sc.Study(
        trials=harness.trials(trials),
        seed=seed,
        swarm={"brain": {"file": brain, "within": [0.05, 1e-9]}, "robots": robots, "accuracy": [0.7, 0.875, 0.95]},
        world={
            "topology": "moving",
            "density": density,
            "fill_ratio": 0.55,
            "floor": ["tiles", {"clusters": 0.4}, {"stripes": 0.5}],
        },
        schedule={"ticks": 4088},
        measure={"truth": "floor", "checkpoints": [248, 1016, 4088]},
    )
    results = sc.run(study)
    settings = results[["within", "floor", "accuracy"]].to_dataframe()
    for (floor, accuracy), rows in settings.groupby(["floor", "accuracy"], sort=False):
        stops, none = (rows.index[rows["within"] == within].item() for within in (0.05, 1e-9))
        said, at = results["done_estimate"].values[stops], results["done_round"].values[stops]
        done = np.isfinite(said)
        wrong = (done & (np.abs(said - results["true_fill_ratio"].values[stops][:, None]) > 0.05)).mean(axis=1)
        error = 196 * wrong.std(ddof=1) / len(wrong) ** 0.5
        when = np.median(np.where(done, at, np.inf))
        cover = " ".join(f"{100 * share:5.1f}" for share in results["coverage"].values[none].mean(axis=1))
        print(
            f"{robots:6} {density:7} {floor:14} {accuracy:8} {100 * wrong.mean():6.1f} +- {error:4.1f} "
            f"{100 * done.mean():7.1f}% {when:7.0f}  {cover}",
            flush=True,
        )


@harness.question(unasked=False)
def seen():
    """How far the share of black under robots that walk for long is from the floor's own share."""
    for robots in (1, 2, 5, 10, 20, 50):
        for density in (1, 10):
            study = sc.Study(
                trials=harness.trials(30),
                seed=301,
                swarm={"brain": "commons", "robots": robots, "accuracy": 1.0},
                world={
                    "topology": "moving",
                    "density": density,
                    "fill_ratio": 0.55,
                    "floor": ["tiles", {"clusters": 0.4}, {"stripes": 0.5}],
                },
                schedule={"ticks": 400_000 // robots},
                measure={"truth": "floor"},
            )
            results = sc.run(study)
            off = results["final_estimate"].mean("robot") - results["true_fill_ratio"]
            root = ((off**2).mean("trial") ** 0.5).values
            found = ", ".join(f"{floor} {x:.3f}" for floor, x in zip(results["floor"].values, root, strict=True))
            print(f"{robots} robots, density {density}: the ground seen differs from the floor by {found}")


if __name__ == "__main__":
    harness.answer(globals())
