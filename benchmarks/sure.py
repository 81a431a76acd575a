"""Whether robots with the brain `sure` stop too early: python benchmarks/sure.py [QUESTION] [--quick].

`coarse`, which is answered without a name, is of robots that move over all kinds of floor. It takes an hour on two
cores, and some minutes with `--quick`, where ten robots and fewer still have all trials. `few` is of one or two robots
there, `fine` of pictures that are dithered, `stops` of all networks of studies/beyond.toml, `coverage` of intervals on
networks, and `seen` of what nobody can know: the ground that robots never walk on.
"""

import tempfile
import tomllib
from pathlib import Path

import harness
import numpy as np
from PIL import Image

import swarmcensus as sc
from swarmcensus import theory
from swarmcensus.support.intervals import estimate

WORLDS = Path(__file__).parents[1] / "studies" / "beyond.toml"
SENSORS = [0.525, 0.875, 1.0, "U(0.525, 0.975)"]


def cell(results, i):
    """What a setting is, in a line."""
    names = ("robots", "topology", "accuracy", "fill_ratio", "link_success")
    return " ".join(str(results[name].values[i]) for name in names)


@harness.question(unasked=False)
def coverage():
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


LEAVES = str(WORLDS.parent / "example" / "leaves.png")
PATTERNS = ("random", "stripe", "block", "off-diagonal", "star", "band", "bandwidth", "bandwidth-r", "band-stripe")
FLOORS = [
    *({"stripes": m} for m in (0.2, 0.3, 0.5, 1.0, 2.0, 5.0)),
    *({"clusters": m} for m in (0.05, 0.2, 0.5, 1.0, 2.0)),
    *({"benchmark": name} for name in PATTERNS),
    *({"image": LEAVES, "mode": mode} for mode in ("threshold", "dither")),
    "half",
    "tiles",
]
FEW = 10  # robots of which all trials are quick
HEADS = "robots density floor                accuracy  % wrong   95 %      % of f  % stopped  mean tick  % that hold"


@harness.question
def coarse(brain="sure", fill=0.55, within=0.05, ticks=4088, seed=6203, accuracies="0.7 0.9"):
    """Shares of robots that stop on a wrong answer, and that stop at all; shares of intervals that hold at the end.

    An answer is wrong if it is not `within` of the floor's own share of black; "of f": of the nominal one.
    """
    print(HEADS)
    worlds = [(6, 5), (10, 3), (10, 10), (5, 1), (5, 10), (6, 10), (7, 10)]
    worlds += [(20, 1), (20, 10), (50, 2), (100, 1), (100, 10)]
    worst = [walk(*world, FLOORS, brain, fill, within, ticks, seed, accuracies) for world in worlds]
    print(f"most wrong: {100 * max(worst):.1f} %, of all robots of a world; the worst with twice the `within`:")
    for world in ((5, 10), (6, 10), (20, 1), (50, 2), (100, 1)):
        floor = {"image": LEAVES, "mode": "dither"} if world[0] > FEW else {"benchmark": "block"}
        walk(*world, [floor], brain, fill, 2.0 * within, ticks, seed, accuracies)


@harness.question(unasked=False)
def few(brain="sure", fill=0.55, within=0.05, ticks=4088, seed=401):
    """The same of one or two robots."""
    print(HEADS)
    for robots, density in ((1, 1), (1, 10), (2, 1), (2, 10)):
        walk(robots, density, FLOORS, brain, fill, within, ticks, seed)


@harness.question(unasked=False)
def fine(brain="sure", fill=0.55, within=0.05, ticks=4088, seed=6207):
    """The same on pictures whose grey changes from wall to wall, finely mixed: a tenth to nine tenths, and less."""
    print(HEADS)
    with tempfile.TemporaryDirectory() as folder:
        floors = []
        for name, least in (("all.png", 0.1), ("some.png", 0.35)):
            shades = np.linspace(255 * least, 255 * (1 - least), 256).astype(np.uint8)
            Image.fromarray(np.tile(shades, (256, 1))).save(Path(folder) / name)
            floors.append({"image": f"{folder}/{name}", "mode": "dither"})
        for robots, density in ((5, 1), (20, 1), (50, 2), (10, 5), (20, 10)):
            walk(robots, density, floors, brain, fill, within, ticks, seed)


def walk(robots, density, floors, brain, fill, within, ticks, seed, accuracies="0.7 0.9"):
    """A line for each floor and accuracy, all on the same walks; returns the largest share that stops wrong."""
    study = sc.Study(
        trials=200 if robots <= FEW else harness.trials(200),
        seed=seed,
        swarm={
            "brain": {"file": brain, "within": within},
            "robots": robots,
            "accuracy": [*map(float, accuracies.split())],
        },
        world={"topology": "moving", "density": density, "fill_ratio": fill, "floor": floors},
        schedule={"ticks": ticks},
        measure={"truth": "floor", "checkpoints": [ticks]},
    )
    results = sc.run(study, jobs=2, cautions=False)
    worst = 0.0
    for i in range(results.sizes["setting"]):
        said, at = results["done_estimate"].values[i], results["done_round"].values[i]
        truth = results["true_fill_ratio"].values[i][:, np.newaxis]
        wrong, low, high = 100 * np.array(estimate((np.abs(said - truth) > within).astype(float), "mean", share=True))
        of_f, stopped, hold = (
            100 * np.mean(x) for x in (np.abs(said - fill) > within, np.isfinite(said), results["coverage"].values[i])
        )
        when = np.mean(np.where(np.isfinite(said), at, ticks))
        floor, accuracy = (
            results["floor"].values[i].replace(f"{Path(LEAVES).parent}/", ""),
            results["accuracy"].values[i],
        )
        print(
            f"{robots:6} {density:7} {floor:20.20} {accuracy:8} {wrong:8.1f}   {low:4.1f}, {high:4.1f} {of_f:8.1f} "
            f"{stopped:10.1f} {when:10.0f} {hold:12.1f}",
            flush=True,
        )
        worst = max(worst, wrong / 100)
    return worst


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
