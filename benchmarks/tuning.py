"""What a search is worth and what it costs: python benchmarks/tuning.py [--studies N].

Prints how far from the best values, which are known, a search of 200 evaluations of 10 trials ends, with fresh training
trials in each generation and with the same in all, and with the middle of what was good or the luckiest candidate for
winner. Then, with half as many studies, what a search is worth that begins where its metric is flat, with the metric's
companion and without. Then what an evaluation takes beside its trials run in one go. Seeds are fixed.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import swarmcensus as sc
from swarmcensus.tuning import generations
from swarmcensus.tuning.logs import Log
from swarmcensus.tuning.plans import budget_of, plan_of
from swarmcensus.tuning.training import COMPANIONS, Training

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


def study_of(folder, seed, robots=5, rounds=1):
    (folder / "known.py").write_text(BRAIN)
    return sc.Study.parse(
        f'seed = {seed}\ntrials = 10\n[swarm]\nbrain = "known.py"\nrobots = {robots}\naccuracy = 0.8\n'
        f'[world]\ntopology = "ring"\nfill_ratio = 0.5\n[schedule]\nrounds = {rounds}\n',
        context={"base": folder},
    )


def search(study, budget=200, trials=10, jobs=1):
    plan = plan_of(study, ["a=0:1", "c=0:1"], None, "final_error", budget_of(budget), trials)
    with Log(None, {}, ["a", "c"]) as log, Training(study, plan.worlds, plan.measures, trials, jobs) as training:
        return generations.run_search(plan, generations.new_search(plan), log, training, lambda _: None)


def worth(console, folder, studies):
    """How far from the best values searches end."""
    seed_for = generations.seed_for
    out = Table("training trials", "winner", "median distance", "90 %", title="how far from the best values")
    for fresh in (True, False):
        if not fresh:
            generations.seed_for = lambda seed, purpose, number=0: seed_for(seed, purpose)
        ended = [search(study_of(folder, seed)) for seed in range(studies)]
        winners = {
            "the middle of the last": [one.values for one in ended],
            "the luckiest": [min(one.evaluations, key=lambda e: e.loss).values for one in ended],
        }
        generations.seed_for = seed_for
        for winner, values in winners.items():
            far = np.hypot(*(np.array(values) - BEST).T)
            kind = "fresh in each generation" if fresh else "the same in all"
            out.add_row(kind, winner, f"{np.median(far):.3f}", f"{np.quantile(far, 0.9):.3f}")
    console.print(out)


def flat(console, folder, studies):
    """How good the winners are of searches that begin where no swarm ever agrees."""
    out = Table(
        "evaluations", "ties", "mean share of right trials", "winners that are never right",
        title=f"consensus_right of {studies} winners, from explore = 500, listen = 900: 0 %",
    )  # fmt: skip
    study = sc.Study.parse(VOTERS, context={"base": folder})
    kept = dict(COMPANIONS)
    for budget in (60, 200):
        for companion in (True, False):
            COMPANIONS.clear()
            COMPANIONS.update(kept if companion else {})
            right = []
            for seed in range(studies):
                asked = ["explore=1:1000", "listen=1:1000"]
                plan = plan_of(study.with_(seed=seed), asked, None, "consensus_right", budget_of(budget), 10)
                with (
                    Log(None, {}, asked, plan.losses) as log,
                    Training(plan.study, plan.worlds, plan.measures, 10, 1) as training,
                ):
                    ended = generations.run_search(plan, generations.new_search(plan), log, training, lambda _: None)
                data = sc.run(plan.study.with_(swarm={**SWARM, "brain": plan.candidate(ended.values)}), jobs=1)
                right.append(float(data["consensus_right"].mean()))
            ties = "decided_right" if companion else "not broken"
            out.add_row(f"{budget}", ties, f"{np.mean(right):.0%}", f"{np.sum(np.array(right) == 0)}")
    COMPANIONS.update(kept)
    console.print(out)


def cost(console, folder):
    """What an evaluation takes beside its trials."""
    out = Table(
        "robots, rounds",
        "trials",
        "a trial in one go",
        "in a search",
        title=f"microseconds, on one thread, the least of {REPEATS}",
    )
    for robots, length in ((5, 1), (20, 100), (100, 1000)):
        study, trials = study_of(folder, 0, robots, length), 10
        sc.run(study)
        count = min(2000, 100_000_000 // (robots * length * 100) * 10)
        whole = study.with_(trials=max(count, 200))
        alone, searched = [], []
        for _ in range(REPEATS):
            begun = time.perf_counter()
            sc.run(whole, jobs=1)
            alone.append((time.perf_counter() - begun) / whole.trials)
            ended = search(study, 97, trials)
            searched.append(ended.evaluations[-1].seconds / (len(ended.evaluations) * trials))
        out.add_row(f"{robots}, {length}", str(trials), f"{min(alone) * 1e6:,.0f}", f"{min(searched) * 1e6:,.0f}")
    console.print(out)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=40)
    with tempfile.TemporaryDirectory() as temporary:
        console = Console(width=100)
        count = parser.parse_args().studies
        worth(console, Path(temporary), count)
        flat(console, Path(temporary), count // 2)
        cost(console, Path(temporary))
