"""A swarm of processes: python benchmarks/swarm.py [--runs 200] [--write] [--minds]. Needs SciPy, of the extra `test`.

A first table tells what processes cost and hear. A second one compares swarms over sockets with the simulator, in four
worlds: 20 robots at 100 ticks a second, 200 rounds, the errors and the shares of right robots at the end, in trials of
other seeds. Two-sample tests are Mann and Whitney's, and Kolmogorov and Smirnov's. With --write both go into
docs/a-swarm-on-your-desk.md. Ten minutes on two cores, of which the first two are for the first table.

With --minds it prints another table alone, in a good minute: whether the minds of 100 robots are lived again to the
bit from their logs (minds.py).
"""

import argparse
import itertools
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import minds
import numpy as np

from swarmcensus.basics.bins import right_bin
from swarmcensus.reliving.logs import read_log
from swarmcensus.simulation.trials import record_estimates
from swarmcensus.studies.study import Study
from swarmcensus.swarm.plans import Air, plan_of
from swarmcensus.swarm.running import run

try:
    from scipy.stats import ks_2samp, mannwhitneyu
except ImportError:
    sys.exit("benchmarks/swarm.py needs SciPy: pip install 'swarmcensus[test]'")

PAGE = Path(__file__).parents[1] / "docs" / "a-swarm-on-your-desk.md"
COSTS = (  # robots, Hz, rounds, topology, loss, delay in ms
    (20, 10.0, 300, "ring", 0.3, 0),
    (100, 10.0, 300, "ring", 0.3, 0),
    (100, 10.0, 300, "ring", 0.3, 50),
    (50, 10.0, 300, "full", 0.3, 0),
    (20, 100.0, 1500, "ring", 0.3, 0),
    (20, 100.0, 1500, "scale-free", 0.0, 0),
)
WORLDS = tuple(itertools.product(("ring", "scale-free"), (0.0, 0.3)))
ROBOTS, HZ, ROUNDS = 20, 100.0, 200
AT_ONCE = 2  # swarms
SIMULATED = 2000  # trials of the simulator
SEEDS = 0, 1  # of sockets, and of the simulator
LEVEL = 0.001


def study(robots, rounds, topology, loss, trials=1):
    return Study(
        name="desk", trials=trials, swarm={"brain": "commons", "robots": robots, "accuracy": 0.8},
        world={"topology": topology, "fill_ratio": 0.55, "link_success": 1.0 - loss, "message": "ratio16"},
        schedule={"rounds": rounds, "observations_per_round": 1},
    )  # fmt: skip


def lived(plan, ages=False):
    """The outcome of a swarm, and with `ages` how many messages are of the hearer's tick, the one before, and older."""
    with tempfile.TemporaryDirectory() as folder:
        outcome = run(plan, [], Path(folder) / "swarm")
        counts = np.zeros(3, np.int64)
        for path in Path(folder, "swarm").glob("robot-*.log") if ages else ():
            for tick in read_log(path).ticks:
                for message in tick.heard:
                    counts[min(max(tick.tick - message.tick, 0), 2)] += 1
    return outcome, counts


def costs():
    yield "| robots | ticks a second | network | loss | delay, ms | cores | memory, MB | heard | missed ticks |"
    yield "|---:|---:|---|---:|---:|---:|---:|---:|---:|"
    for robots, hz, rounds, topology, loss, delay in COSTS:
        plan = plan_of(study(robots, rounds, topology, loss), 0, 0, 0, Air(hz=hz, delay=delay))
        o, _ = lived(plan)
        yield (
            f"| {robots} | {hz:g} | {topology} | {loss:g} | {delay} | {o.cores:.2f} | {o.memory / 1e6:,.0f} "
            f"| {100 * o.heard:.2f} % | {o.missed:,} of {robots * rounds:,} |"
        )


def simulated(setting, seed, trial):
    """The mean error of a trial at its end, and the share of robots that are right."""
    return measured(record_estimates(setting, seed, trial)[-1])


def measured(estimates):
    low, high = right_bin(0.55)
    return np.abs(estimates - 0.55).mean(), ((estimates >= low) & (estimates < high)).mean()


def against(runs):
    each = runs // len(WORLDS)
    heads = (f"sockets, {each} runs", f"simulator, {SIMULATED:,} trials", "effect", "p (MW)", "p (KS)", "paired")
    yield f"| network | loss | at the end | {' | '.join(heads)} |"
    yield "|---|---:|---|---:|---:|---:|---:|---:|---:|"
    ages = np.zeros(3, np.int64)
    for topology, loss in WORLDS:
        world = study(ROBOTS, ROUNDS, topology, loss, trials=each)
        [setting] = world.settings()
        plans = [plan_of(world, 0, SEEDS[0], trial, Air(hz=HZ)) for trial in range(each)]
        with ThreadPoolExecutor(AT_ONCE) as pool:
            ends = list(pool.map(lambda plan: lived(plan, ages=True), plans))
        ages += sum(counts for _, counts in ends)
        over = np.array([measured(np.array(outcome.estimates)) for outcome, _ in ends])
        twins = np.array([simulated(setting, SEEDS[0], trial) for trial in range(each)])
        within = np.array([simulated(setting, SEEDS[1], trial) for trial in range(SIMULATED)])
        for k, what in enumerate(("mean error", "share right")):
            test = mannwhitneyu(over[:, k], within[:, k])
            effect = 2.0 * test.statistic / (each * SIMULATED) - 1.0
            p = ks_2samp(over[:, k], within[:, k]).pvalue
            apart = over[:, k] - twins[:, k]
            error = apart.std(ddof=1) / np.sqrt(each)
            yield (
                f"| {topology} | {loss:g} | {what} | {over[:, k].mean():.4f} | {within[:, k].mean():.4f} "
                f"| {effect:+.2f} | {test.pvalue:.3f} | {p:.3f} | {apart.mean():+.4f} ± {error:.4f} |"
            )
    same, before, older = 100 * ages / ages.sum()
    yield ""
    yield (
        f"Of the messages heard, {same:.0f} % are of the same tick as the hearer's, {before:.0f} % of the one before, "
        f"and {older:.1f} % are older."
    )


def put(name, lines, page):
    begin, end = f"<!-- {name}: python benchmarks/swarm.py --write -->", f"<!-- end of {name} -->"
    before, _, rest = page.partition(begin)
    return before + begin + "\n\n" + "\n".join(lines) + "\n\n" + end + rest.partition(end)[2]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=200, help="swarms over sockets, 0 for the first table alone")
    parser.add_argument("--write", action="store_true", help="put the tables into the page")
    parser.add_argument("--minds", action="store_true", help="only tell whether minds are lived again to the bit")
    options = parser.parse_args()
    if options.minds:
        with tempfile.TemporaryDirectory() as folder:
            for line in minds.table(Path(folder)):
                print(line, flush=True)
        return
    tables = {}
    for name, lines in (("costs", costs()), ("simulator", against(options.runs) if options.runs else ())):
        tables[name] = []
        for line in lines:
            tables[name].append(line)
            print(line, flush=True)
        print()
    if options.write:
        page = PAGE.read_text(encoding="utf-8")
        for name, lines in tables.items():
            page = put(name, lines, page) if lines else page
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
