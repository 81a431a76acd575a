"""ARGoS 3 against our moving robots: python benchmarks/argos.py [--argos PREFIX] [--quick].

Deploys brains for ARGoS and builds them with cmake. `errors` runs 25 robots at D = 1 and 10 with each seed, two runs at
a time; the error of a trial is the median over robots of how far the final estimate is from the floor's black share.
`logs` runs 20 robots for 2,000 ticks, and then their brains again from the logs. `speed` times 25 robots.
"""

import json
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import harness
import numpy as np

from swarmcensus import Study, deploy, run
from swarmcensus.engine.addresses import address
from swarmcensus.robots import read_recording, relive_all
from swarmcensus.robots.targets.argos import name_of
from swarmcensus.simulation.walking import Walk
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body

BRAINS = ("minimalistic", "commons", "alone")
DENSITIES = (1, 10)
ROBOTS = 25
OURS = 300  # trials; they cost little
LOGGED = ("commons", "direct-switching", "sure", "leaver")  # with luck, names, silence, done, steer
RESAMPLES = 10_000
FOOT_BOT = {"radius": 0.085, "wheel_distance": 0.14, "sensor": [0.063, 0.0116], "proximity_range": 0.083}
# the range from which on its ring's mean reading of a wall is an obstacle


def study(density, ticks, trials=1, brains=BRAINS, robots=ROBOTS, body=FOOT_BOT):
    return Study(
        trials=trials,
        swarm={"robots": robots, "accuracy": 0.8, "brain": list(brains)},
        world={"topology": "moving", "density": density, "fill_ratio": 0.55, "body": body},
        schedule={"ticks": ticks},
    )


def build(folder, prefix, brains, studies, precision=None):
    """The texts of experiments by brain and place in `studies`; all brains are in one library."""
    if not Path(prefix, "bin", "argos3").is_file():
        sys.exit(f"benchmarks/argos.py: {prefix} has no bin/argos3; --argos names where ARGoS is installed")
    texts = {}
    for brain in brains:
        for k, one in enumerate(studies):
            deploy(brain, folder, "argos", study=one, precision=precision)
            texts[brain, k] = (folder / f"{name_of(Path(brain))}.argos").read_text()
    for words in (["-B", "build", f"-DARGOS={prefix}"], ["--build", "build"]):
        subprocess.run(["cmake", *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return texts


def simulate(folder, prefix, text, name):
    """What a run in ARGoS writes as its result; `name` is that of its files."""
    result = folder / f"{name}.json"
    text = text.replace('result=""', f'result="{result}"')
    (folder / f"{name}.argos").write_text(text)
    libraries = f"{prefix}/lib/argos3"
    ended = subprocess.run(
        [f"{prefix}/bin/argos3", "-c", f"{name}.argos"], cwd=folder, capture_output=True, text=True,
        env={"LD_LIBRARY_PATH": libraries, "ARGOS_PLUGIN_PATH": libraries},
    )  # fmt: skip
    if ended.returncode:
        sys.exit(ended.stderr)
    return json.loads(result.read_text())


def in_argos(prefix, seeds, ticks):
    """By brain and density: the results of all these seeds."""
    with tempfile.TemporaryDirectory() as made, ThreadPoolExecutor(2) as pool:
        folder = Path(made) / "argos"
        texts = build(folder, prefix, BRAINS, [study(density, ticks) for density in DENSITIES])
        runs = {
            (*key, seed): pool.submit(
                simulate, folder, prefix, re.sub('random_seed="[0-9]*"', f'random_seed="{seed}"', text),
                f"{key[0]}-{key[1]}-{seed}",
            )
            for key, text in texts.items() for seed in seeds
        }  # fmt: skip
        return {key: [runs[*key, seed].result() for seed in seeds] for key in texts}


def ours(density, ticks, body):
    """The errors (brain, trial) of our moving robots."""
    results = run(study(density, ticks, trials=min(OURS, harness.trials(OURS)), body=body), jobs=2)
    floors = results["true_fill_ratio"].values[:, :, np.newaxis]
    return np.median(np.abs(results["final_estimate"].values - floors), axis=2)


def walked(density, ticks, body, trials=4):
    """The share of ticks of avoiding, and the neighbours of a robot, of our moving robots."""
    body, avoided, heard = Body(**body), [], []
    for trial in range(trials):
        walk = Walk(ROBOTS, arena.side(ROBOTS, density, body), body, address(1, "walk"), trial, harness.GO)
        for chunk in walk.chunks(ticks):
            avoided.append(1.0 - chunk.looked.mean())
            heard.append(chunk.heard[chunk.looked.size] / chunk.looked.size)
    return np.mean(avoided), np.mean(heard)


def ratio(one, other):
    """The ratio of two medians over trials, and its 95 % interval by bootstrap over trials of both."""
    chance = np.random.default_rng(1)
    drawn = [
        np.median(errors[chance.integers(errors.size, size=(RESAMPLES, errors.size))], axis=1)
        for errors in (one, other)
    ]
    return np.median(one) / np.median(other), *np.quantile(drawn[0] / drawn[1], [0.025, 0.975])


@harness.question
def errors(argos="/usr/local", first=1, seeds=30, ticks=10_000, khepera=False, quick=False):
    """Errors in ARGoS as a multiple of ours, with the share of ticks of avoiding and the neighbours of both.

    With `khepera`, ours have the usual body, that of a Khepera IV.
    """
    seeds, ticks = (3, 1000) if quick else (seeds, ticks)
    body = {} if khepera else FOOT_BOT
    found = in_argos(argos, range(first, first + seeds), ticks)
    table = harness.table(
        f"25 robots, {ticks:,} ticks, {seeds} seeds in ARGoS", "brain", "D", "error in ARGoS", "error here",
        "ratio, 95 % interval", "avoiding in ARGoS, here", "neighbours in ARGoS, here",
    )  # fmt: skip
    for k, density in enumerate(DENSITIES):
        here, (avoided, heard) = ours(density, ticks, body), walked(density, ticks, body)
        for brain, mine in zip(BRAINS, here, strict=True):
            runs = found[brain, k]
            estimates = np.array([[robot["estimate"] for robot in one["robots"]] for one in runs])
            theirs = np.median(np.abs(estimates - [[one["floor"]] for one in runs]), axis=1)
            middle, low, high = ratio(theirs, mine)
            looks, messages = (
                np.mean([robot[key] for one in runs for robot in one["robots"]]) / ticks for key in ("read", "heard")
            )
            table.add_row(
                brain, str(density), f"{np.median(theirs):.5f}", f"{np.median(mine):.5f}",
                f"{middle:.2f} [{low:.2f}, {high:.2f}]", f"{1.0 - looks:.3f}, {avoided:.3f}",
                f"{messages:.2f}, {heard:.2f}",
            )  # fmt: skip
    harness.show(table, width=130)


@harness.question
def speed(argos="/usr/local", ticks=10_000, quick=False):
    """What a robot and tick takes in ARGoS, in one thread without pictures, and here."""
    ticks = 1000 if quick else ticks
    table = harness.table(f"25 robots, {ticks:,} ticks, commons", "D", "ARGoS, ns", "here, ns", "times as fast")
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made) / "argos"
        studies = [study(density, ticks, brains=["commons"]) for density in DENSITIES]
        texts = build(folder, argos, ["commons"], studies)
        for k, (density, one) in enumerate(zip(DENSITIES, studies, strict=True)):
            run(one, jobs=1)
            both = [lambda k=k: simulate(folder, argos, texts["commons", k], "timed"), lambda one=one: run(one, jobs=1)]
            theirs, here = (1e9 * seconds / (ROBOTS * ticks) for seconds in harness.least(both, 3))
            table.add_row(str(density), f"{theirs:,.0f}", f"{here:,.0f}", f"{theirs / here:,.0f}")
    harness.show(table)


@harness.question
def logs(argos="/usr/local", ticks=2000, quick=False):
    """Whether robots' brains are run again to the bit from what ARGoS logged."""
    brains, ticks = harness.few(LOGGED), 200 if quick else ticks
    for precision in ("double", "single"):
        with tempfile.TemporaryDirectory() as made:
            folder = Path(made) / "argos"
            texts = build(folder, argos, brains, [study(1, ticks, brains=brains, robots=20)], precision)
            for brain in brains:
                day = folder / f"day-{brain}"
                simulate(
                    folder, argos, texts[brain, 0].replace('logs=""', f'logs="{day}"'), f"{name_of(Path(brain))}-day"
                )
                recording = read_recording(day)
                lives = relive_all(recording)
                messages = sum(len(tick.heard) for member in recording.members for tick in member.log.ticks)
                relived, whole = sum(life.relived for life in lives), sum(life.ticks for life in lives)
                harness.show(
                    f"{brain}, {precision}: {len(lives)} robots, {messages:,} messages heard, {relived:,} of {whole:,} "
                    "ticks run again to the bit"
                )


if __name__ == "__main__":
    harness.answer(globals())
