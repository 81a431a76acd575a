"""Whether comparing, planning and tuning are right: python benchmarks/methods.py [QUESTION] [--quick].

Comparing: how often equal contenders are told apart, which should be at most 5 %, how often those that differ are,
next to the power of the paired t-test, and how often intervals hold the truth. Planning: plans that are run again.
Tuning: how far from the best values a search ends. Seeds are fixed; the error of shares is stated.
"""

import itertools
import math
import time
from pathlib import Path
from typing import NamedTuple

import harness
import numpy as np
from scipy import stats

import swarmcensus as sc
from swarmcensus.analysis.comparing.interactions import _difference
from swarmcensus.analysis.comparing.pair_tests import ContestInput, contests
from swarmcensus.brains import parse
from swarmcensus.runs import Hardware
from swarmcensus.search.planning.simulating import Case, curves, study_of
from swarmcensus.search.tuning import generations
from swarmcensus.search.tuning.logs import Log
from swarmcensus.search.tuning.plans import COMPANIONS, plan_of
from swarmcensus.search.tuning.training import Training
from swarmcensus.support.bootstrap import intervals
from swarmcensus.support.intervals import share_interval
from swarmcensus.support.significance import mean_tests, paired_tests, signed_ranks

# ---- comparing


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


@harness.question
def alarms(tables=1000, seed=1, quick=False):
    """Tables in which anything is told apart where nothing differs."""
    tables = 20 if quick else tables
    out = harness.table("false alarms, in %", "contenders, worlds, measures", "tests", *(f"{n} trials" for n in TRIALS))
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
    harness.show(out)


@harness.question
def power(seed=1):
    """One test of two contenders: how often it tells them apart that differ by so many standard deviations."""
    out = harness.table("told apart, in % (paired t-test)", "difference", *(f"{n} trials" for n in TRIALS))
    for off in (0.0, 0.25, 0.5, 1.0):
        cells = []
        for trials in TRIALS:
            drawn = np.random.default_rng([seed, trials]).normal(off, 1, (ROWS, trials))
            beyond, freedom = stats.t.ppf(0.975, trials - 1), trials - 1
            centre = off * math.sqrt(trials)
            theory = stats.nct.sf(beyond, freedom, centre) + stats.nct.cdf(-beyond, freedom, centre)
            cells.append(f"{100 * (paired_tests(drawn).p <= 0.05).mean():.1f} ({100 * theory:.1f})")
        out.add_row(f"{off:g}", *cells)
    harness.show(out)


OFF = {  # differences with median 0
    "normal": lambda random, shape: random.normal(size=shape),
    "Student's t of 3": lambda random, shape: random.standard_t(3, shape),
    "exponential": lambda random, shape: random.exponential(size=shape) - math.log(2),
    "log-normal": lambda random, shape: np.exp(random.normal(size=shape)) - 1,
    "log-normal, 2": lambda random, shape: np.exp(2 * random.normal(size=shape)) - 1,
}


def ahead(random, worlds, shape):
    """The share of worlds in which one is ahead, minus that behind: in a tenth of trials all; 0 in the mean."""
    return np.where(random.random(shape) < 0.1, 1.0, 2 * random.binomial(worlds, 4 / 9, shape) / worlds - 1)


MEANS = {  # numbers with mean 0: of trials over all worlds, and differences of effects
    "over 12 worlds": lambda random, shape: ahead(random, 12, shape),
    "over 36 worlds": lambda random, shape: ahead(random, 36, shape),
    "normal": OFF["normal"],
    "exponential": lambda random, shape: random.exponential(size=shape) - 1,
    "log-normal": lambda random, shape: np.exp(random.normal(size=shape)) - math.exp(0.5),
    "one in ten far off": lambda random, shape: (
        np.where(random.random(shape) < 0.1, 9, -1) + random.normal(0, 0.2, shape)
    ),
}


def effects(off):
    """The p-values of differences of effects, from the differences of trials."""
    four = np.zeros((2, 2, *off.shape))
    four[0, 0] = off
    return np.array([_difference(four[:, :, study], True, True)[1].p for study in range(len(off))])


def share(p, level=0.05):
    """How often, in percent, p is small enough."""
    return 100 * (p <= level).mean()


@harness.question
def verdicts(seed=1, quick=False):
    """Differences that are 0 in the median, or mean: false verdicts; and the power that tests next to ranks cost."""
    rows, trials = ROWS // 20 if quick else ROWS, (15, 20, 30, 40, 100, 200)
    for kinds, of in ((OFF, "medians"), (MEANS, "means")):
        head = f"false verdicts where {of} are 0, in % (by ranks alone)"
        out = harness.table(head, "differences", *(f"{n} trials" for n in trials))
        for name, draw in kinds.items():
            cells = []
            for n in trials:
                drawn = draw(np.random.default_rng([seed, n]), (rows if kinds is OFF else rows // 20, n))
                over = paired_tests if kinds is OFF else mean_tests
                p = over(drawn).p if kinds is OFF or name.startswith("over") else effects(drawn)
                cells.append(f"{share(p):.1f} ({share(signed_ranks(drawn).p):.1f})")
            out.add_row(name, *cells)
        harness.show(out)
    title = "most power lost, in points (mean over effects, in % of that of ranks alone)"
    out = harness.table(title, "tests", "next to ranks", *(f"{n} trials" for n in trials))
    further = {
        "number of trials": lambda off, level: share(paired_tests(off).p, level),
        "best for any skew": lambda off, level: 100 * sign_test(off, level).mean(),
        "mean": lambda off, level: share(mean_tests(off).p, level),
    }
    for tests, (name, power) in itertools.product((1, 36), further.items()):
        cells = []
        for n in trials:
            drawn = [np.random.default_rng([seed, n]).normal(off, 1, (rows // 10, n)) for off in np.arange(0.1, 2, 0.1)]
            alone = np.array([share(signed_ranks(off).p, 0.05 / tests) for off in drawn])
            lost = alone - [power(off, 0.05 / tests) for off in drawn]
            cells.append(f"{lost.max():.1f} ({100 * lost.sum() / max(alone.sum(), 1):.1f})")
        out.add_row(str(tests), name, *cells)
    harness.show(out)


def sign_test(off, level):
    """The chance to find each row by the most powerful test of this level for any skew: one-sided, of signs alone."""
    ahead, tossed = (off > 0).sum(axis=1), stats.binom(off.shape[1], 0.5)
    beyond = int(tossed.isf(level))
    return (ahead > beyond) + (ahead == beyond) * (level - tossed.sf(beyond)) / tossed.pmf(beyond)


@harness.question
def coverage(seed=1):
    """How often the intervals of a median and a mean hold the true one."""
    kinds = {
        "normal": (lambda r, shape: r.normal(size=shape), 0.0, 0.0),
        "exponential": (lambda r, shape: r.exponential(size=shape), math.log(2), 1.0),
        "Student's t of 3": (lambda r, shape: r.standard_t(3, size=shape), 0.0, 0.0),
        "a share of 20 robots, 0.95": (lambda r, shape: r.binomial(20, 0.95, shape) / 20, None, 0.95),
    }
    out = harness.table(
        "intervals hold, in %", "trials are", *(f"{s}, {n}" for s in ("median", "mean") for n in TRIALS)
    )
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
    harness.show(out)


STUDIES = 400
GRAPHS = [{"networkx": name, "p": 0.3} for name in ("gnp_random_graph", "erdos_renyi_graph")]  # one distribution
ALIKE = {  # factors without effect: the graphs of both levels, and the errors on both sides of one half
    "paired: topology": ("topology", {"topology": GRAPHS, "fill_ratio": 0.35}),
    "not paired: fill_ratio": ("fill_ratio", {"topology": "ring", "fill_ratio": [0.35, 0.65]}),
}
MEASURES = ("final_error", "convergence_round", "correct")


def alike(name, studies, trials, seed):
    """A comparison of each of so many studies of a factor without effect, by one measure each."""
    factor, world = ALIKE[name]
    swarm, schedule = {"robots": 20, "accuracy": 0.7}, {"rounds": 200, "observations_per_round": 5}
    results = sc.run(sc.Study(trials=studies * trials, seed=seed, swarm=swarm, world=world, schedule=schedule))
    for first in range(0, studies * trials, trials):
        part = results.isel(trial=slice(first, first + trials))
        yield [sc.compare(part, measure, factor=factor).contests[0] for measure in MEASURES]


@harness.question
def factors(seed=1, quick=False):
    """Simulated studies of a factor without effect: how often levels are told apart, and how often intervals hold."""
    studies, trials = 20 if quick else STUDIES, 20
    out = harness.table(f"{studies} studies of {trials} trials, in %", "factor", "measure", *FOUND)
    for name in ALIKE:
        found = zip(*alike(name, studies, trials, seed), strict=True)
        for measure, contests_of in zip(MEASURES, found, strict=True):
            shares = (
                share_interval(int(sum(hits)), len(hits)) for hits in zip(*map(outcome, contests_of), strict=True)
            )
            out.add_row(
                name, measure, *(f"{100 * s:.1f} [{100 * low:.1f}, {100 * high:.1f}]" for s, low, high in shares)
            )
    harness.show(out)


FOUND = ("told apart", "difference's interval holds 0", "probability's interval holds 1/2")


def outcome(contest):
    """Whether one contest of two levels without a difference told them apart, and whether its intervals hold."""
    differs, chance = contest.difference_ends, contest.better_ends
    low, high = (float(end[0, 0]) for end in differs)
    holds = low <= 0.0 <= high if low == low else float(contest.difference[0, 0]) == 0.0
    return bool(contest.apart[0, 0]), holds, bool(chance[0][0, 0] <= 0.5 <= chance[1][0, 0])


@harness.question
def speed(seed=1):
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
    harness.show(f"20,000 settings of 30 trials, 3 measures, {tests:,} tests: {time.perf_counter() - begun:.1f} s")


# ---- planning


AGAIN = 2000  # trials
OTHER = 1_000_003  # from a mission's seed to that of the trials which run it again
SKEWED = {"black": 0.9, "white": 0.6}
SMALL_WORLD = {"networkx": "watts_strogatz_graph", "k": 4, "p": 0.2}


def on(topology, brain="commons", robots=10, probability=0.95, *, f=0.55, near=0.05, lying=None, **more):
    """A mission, as values by key: robots that make a reading a round on a network, or that move."""
    values = {"topology": topology, "brain": brain, "robots": robots, "accuracy": 0.7, "probability": probability}
    values |= {"fill_ratio": {"worst": f} if isinstance(f, list) else f} | more
    values |= {} if "right" in more else {"error": near}
    values |= {} if topology == "moving" else {"observations_per_round": 1}
    if lying:
        values["members"] = [{"robots": lying, "brain": values.pop("lie"), "honest": False}]
    return {key: value for key, value in values.items() if value is not None}


def failing(share):
    """Robots that fail before the mission begins."""
    return [{"at": 1, "robots": share, "stop": ["moving", "sensing", "talking"]}]


MISSIONS = {
    "networks": [
        on("ring"),
        on("ring", "minimalistic", probability=0.9),
        on("ring", robots=30, probability=0.8, f=[0.2, 0.8]),
        on("ring", accuracy=SKEWED, f=[0.1, 0.9]),
        on("ring", "minimalistic", accuracy=SKEWED, f=[0.1, 0.9]),
        on("full", robots=20),
        on("full", robots=20, probability=0.9, accuracy=SKEWED),
        on("full", "minimalistic", robots=12, probability=0.975),
        on("full", robots=8, probability=0.99, near=0.1),
        on("full", robots=15, right="majority", margin=0.1, f=[0, 1]),
        on("line", robots=8, probability=0.9),
        on("line", accuracy=SKEWED, f=0.3),
        on("scale-free", robots=20, probability=0.9),
        on("scale-free", accuracy="U(0.6,0.9)", probability=0.975),
        on(SMALL_WORLD, robots=16),
        on(SMALL_WORLD, "minimalistic", robots=16, accuracy=0.8, right=10, margin=0.03, f=[0.2, 0.6]),
    ],
    "moving": [
        on("moving", side=1.5, robots=4),
        on("moving", side=1.5, robots=6, probability=0.9, accuracy=SKEWED),
        on("moving", "minimalistic", side=2, robots=8, near=0.08),
        on("moving", side=2, robots=8, accuracy=0.8, f=[0.3, 0.7]),
        on("moving", density=5, robots=6, probability=0.8),
        on("moving", density=10, robots=10, near=0.08, probability=0.975),
        on("moving", side=2, robots=6, accuracy=SKEWED, near=0.08),
        on("moving", side=2, robots=5, faults=failing(0.2), near=0.1, probability=0.9),
    ],
    "smallest swarm": [
        on("full", robots=None, minutes=0.2),
        on("full", robots=None, minutes=0.1, probability=0.9),
        on("full", robots=None, minutes=0.2, accuracy=SKEWED, f=[0.1, 0.9]),
        on("full", robots=None, minutes=0.1, accuracy=0.8, probability=0.975),
        on("ring", robots=None, minutes=0.3, probability=0.9),
        on("ring", robots=None, minutes=0.2, probability=0.8),
        on("moving", robots={"choose": [2, 80]}, minutes=0.2, side=2, accuracy=0.8, near=0.08),
        on("moving", robots={"choose": [2, 80]}, minutes=0.3, side=2, accuracy=SKEWED, probability=0.9),
    ],
    "liars": [
        on("full", "steadfast", lying=0.1, lie="opposite"),
        on("full", "steadfast", lying=0.1, lie="shouter", robots=20, probability=0.9),
        on("full", "steadfast", lying=0.2, lie="opposite", accuracy=SKEWED, near=0.08),
        on("full", "steadfast", lying=0.2, lie="jammer", accuracy=0.8, probability=0.9),
        on("ring", "steadfast", lying=0.1, lie="opposite", accuracy=0.8, near=0.08),
        on("scale-free", "steadfast", lying=0.1, lie="shouter", robots=16, near=0.08),
        on("moving", "steadfast", lying=0.1, lie="opposite", robots=8, side=2, near=0.1),
        on("full", "steadfast", {"choose": [4, 90]}, 0.9, lying=0.1, lie="opposite", minutes=0.2, near=0.08),
    ],
}  # fmt: skip


class Again(NamedTuple):
    """An answer run again: shares of right robots, (value, low, high), and at the ends of the plan's interval."""

    at: tuple[float, float, float]
    below: float  # at the lower end, where the promise should not be kept yet
    above: float | None  # at the upper end, where there is one
    fewer: float | None  # with a robot less than the smallest swarm


def again(mission, row, trials, jobs):
    """Run it again."""
    brain = next(one for one in mission.study.swarm.brain if one.label == row.brain)
    lie = next((one for one in mission.lies if one.label == row.lie), None)
    case = Case(row.fill_ratio, lie)

    def shares(robots, minutes):
        times = [max(1, round(one / mission.round_minutes)) for one in minutes]
        study = study_of(mission, robots, [brain], [case], sorted(set(times)), trials, mission.study.seed + OTHER)
        [curve] = curves(mission, study, Hardware(jobs), lambda _: None)
        return [curve.at(curve.rounds.index(one)) for one in times]

    if row.robots_low is None:
        ends = [row.minutes_low, row.minutes] + ([row.minutes_high] if row.minutes_high else [])
        below, at, *above = shares(row.robots, ends)
        return Again(tuple(at), below.value, above[0].value if above else None, None)
    [at] = shares(row.robots, [row.minutes])
    below, above, fewer = (
        shares(robots, [row.minutes])[0].value if robots else None
        for robots in (row.robots_low - 1, row.robots_high, row.robots - 1)
    )
    if mission.robots and row.robots_low == mission.robots[0]:
        below = 0.0  # no smaller one was allowed
    return Again(tuple(at), below or 0.0, above, fewer)


def told(values):
    """A mission in a few words."""
    topology = values["topology"] if isinstance(values["topology"], str) else "small world"
    asked = f"{values['robots']} robots" if isinstance(values.get("robots"), int) else f"{values['minutes']} min"
    accuracy = "skewed" if values["accuracy"] == SKEWED else values["accuracy"]
    lies = "".join(f", {100 * one['robots']:g} % {one['brain']}" for one in values.get("members", ()))
    goal = values.get("error") or values["right"]
    return f"{topology}, {values['brain']}, {asked}, {accuracy}, {goal}{lies}"


def percent(shares):
    """A share with its interval."""
    value, low, high = (100 * one for one in shares)
    return f"{value:.1f} [{low:.1f}, {high:.1f}]"


@harness.question
def planning(seed=1, trials=200, jobs=1, quick=False):
    """Plans of small missions run again in 2,000 trials of another seed, of which no planner knew.

    Prints what was promised, what the plan said, and the share of robots that are right in the new trials; then by kind
    of mission the mean difference from the promise with its standard error, and how many intervals hold what was
    measured. Some minutes on one core. The numbers depend on the seed alone.
    """
    table = harness.table(
        None,
        *(
            "mission",
            "promised",
            "answer",
            "plan: right %",
            "new: right %",
            "share inside",
            "answer inside",
            "one robot fewer",
        ),
    )
    sums = harness.table(
        None, *("", "plans", "new - promised", "standard error", "new - plan", "share inside", "answer inside")
    )
    found = {}
    for kind, missions in MISSIONS.items():
        for number, values in enumerate(missions[:2] if quick else missions):
            plan = sc.plan({"trials": trials, "seed": 100 * seed + number}, jobs, lambda _: None, set=values)
            mission, [row] = plan.mission, plan.needs
            new, promised = again(mission, row, 100 if quick else AGAIN, jobs), mission.wanted.probability
            holds = row.share.low <= new.at[0] <= row.share.high
            within = new.below <= promised and (new.above is None or new.above >= promised)
            fewer = np.nan if new.fewer is None else new.fewer
            figures = (new.at[0] - promised, new.at[0] - row.share.value, fewer - promised, holds, within)
            found.setdefault(kind, []).append(figures)
            answer = f"{row.minutes:.3g} min" if row.robots_low is None else f"{row.robots} robots"
            table.add_row(
                told(values), f"{100 * promised:g}", answer, percent(row.share), percent(new.at),
                "yes" if holds else "NO", "yes" if within else "NO",
                "" if new.fewer is None else f"{100 * new.fewer:.1f}",
            )  # fmt: skip
    harness.show(table, 170)
    found["all"] = [one for kind in found.values() for one in kind]
    for kind, each in found.items():
        short, told_short, fewer, holds, within = np.array(each, float).T
        error = short.std(ddof=1) / np.sqrt(len(each))
        sums.add_row(
            kind, f"{len(each)}", f"{100 * short.mean():+.2f}", f"{100 * error:.2f}", f"{100 * told_short.mean():+.2f}",
            f"{holds.sum():.0f}", f"{within.sum():.0f}",
        )  # fmt: skip
    harness.show(sums)
    harness.show(
        f"smallest swarms with one robot fewer: new - promised {100 * np.nanmean(fewer):+.2f}\n"
        "new: share of robots that are right in new trials; "
        "one robot fewer: the same with one robot fewer than planned\n"
        "share inside: the plan's interval of right % holds the new share\n"
        "answer inside: the plan's interval of the time or size holds the one at which new trials keep the promise"
    )


# ---- tuning


BEST = (0.6, 0.4)
REPEATS = 5
BRAIN = f"""
PARAMETERS = {{"a": 0.3, "c": 0.7}}
MEMORY = {{"z": 0.0}}
MESSAGE = ("z",)


def observe(me, blacks, looks):
    me.z = me.luck - 0.5


def broadcast(me):
    return (me.z,)


def receive(me, message):
    pass


def fuse(me):
    pass


def estimate(me):
    off = (me.a - {BEST[0]}) * (me.a - {BEST[0]}) + (me.c - {BEST[1]}) * (me.c - {BEST[1]})
    return 0.5 + 0.5 * off + 0.1 * me.z
"""
SWARM = {"robots": 20, "accuracy": 0.9}
VOTERS = """
trials = 100
[swarm]
brain = {file = "voter", explore = 500, listen = 900}
robots = 20
accuracy = 0.9
[world]
topology = "full"
fill_ratio = 0.8
[schedule]
rounds = 300
observations_per_round = 1
"""


def known(seed, robots=5, rounds=1):
    """A study of a brain whose best values are known."""
    return sc.Study(
        seed=seed,
        trials=10,
        swarm={"brain": parse(BRAIN, "known.py", Path("known.py")), "robots": robots, "accuracy": 0.8},
        world={"topology": "ring", "fill_ratio": 0.5},
        schedule={"rounds": rounds},
    )


def search(study, budget=200, trials=10, jobs=1):
    plan = plan_of(study, ["a=0:1", "c=0:1"], None, "final_error", budget, trials)
    with Log(None, plan) as log:
        return generations.run_search(
            plan, generations.new_search(plan), log, Training(plan, Hardware(jobs)), lambda _: None
        )


@harness.question
def worth(studies=40, quick=False):
    """How far from the best values searches end."""
    studies = 3 if quick else studies
    seed_for = generations.seed_for
    out = harness.table("how far from the best values", "training trials", "winner", "median distance", "90 %")
    for fresh in (True, False):
        if not fresh:
            generations.seed_for = lambda seed, purpose, number=0: seed_for(seed, purpose)
        ended = [search(known(seed)) for seed in range(studies)]
        winners = {
            "the middle of the last": [one.values for one in ended],
            "the luckiest": [min(one.evaluations, key=lambda e: e.loss).values for one in ended],
        }
        generations.seed_for = seed_for
        for winner, values in winners.items():
            far = np.hypot(*(np.array(values) - BEST).T)
            kind = "fresh in each generation" if fresh else "the same in all"
            out.add_row(kind, winner, f"{np.median(far):.3f}", f"{np.quantile(far, 0.9):.3f}")
    harness.show(out)


@harness.question
def flat(studies=20, quick=False):
    """How good the winners are of searches that begin where no swarm ever agrees."""
    studies = 2 if quick else studies
    out = harness.table(
        f"consensus_right of {studies} winners, from explore = 500, listen = 900: 0 %",
        "evaluations",
        "ties",
        "mean share of right trials",
        "winners that are never right",
    )
    study = sc.Study.parse(VOTERS)
    kept = dict(COMPANIONS)
    for budget in (60, 200):
        for companion in (True, False):
            COMPANIONS.clear()
            COMPANIONS.update(kept if companion else {})
            right = []
            for seed in range(studies):
                asked = ["explore=1:1000", "listen=1:1000"]
                plan = plan_of(study.with_(seed=seed), asked, None, "consensus_right", budget, 10)
                with Log(None, plan) as log:
                    new, training = generations.new_search(plan), Training(plan, Hardware(1))
                    ended = generations.run_search(plan, new, log, training, lambda _: None)
                data = sc.run(plan.study.with_(swarm={**SWARM, "brain": plan.candidate(ended.values)}), jobs=1)
                right.append(float(data["consensus_right"].mean()))
            ties = "decided_right" if companion else "not broken"
            out.add_row(f"{budget}", ties, f"{np.mean(right):.0%}", f"{np.sum(np.array(right) == 0)}")
    COMPANIONS.update(kept)
    harness.show(out)


@harness.question
def evaluations(quick=False):
    """What an evaluation takes next to its trials."""
    out = harness.table(
        f"microseconds, on one thread, the least of {REPEATS}",
        "robots, rounds",
        "trials",
        "a trial in one go",
        "in a search",
    )
    for robots, length in ((5, 1),) if quick else ((5, 1), (20, 100), (100, 1000)):
        study, trials = known(0, robots, length), 10
        sc.run(study)
        count = min(2000, 100_000_000 // (robots * length * 100) * 10)
        whole = study.with_(trials=max(count, 200))
        alone, searched = [], []
        for _ in range(REPEATS):
            begun = time.perf_counter()
            sc.run(whole, jobs=1)
            alone.append((time.perf_counter() - begun) / whole.trials)
            begun = time.perf_counter()
            ended = search(study, 97, trials)
            searched.append((time.perf_counter() - begun) / (len(ended.evaluations) * trials))
        out.add_row(f"{robots}, {length}", str(trials), f"{min(alone) * 1e6:,.0f}", f"{min(searched) * 1e6:,.0f}")
    harness.show(out)


if __name__ == "__main__":
    harness.answer(globals())
