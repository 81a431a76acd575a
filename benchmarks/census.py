"""How near `census` is to the best brain in each kind of world: python benchmarks/census.py [RESULTS] [--trials T]
[--plot FILE].

RESULTS is what `swarmcensus run studies/census.toml --out census.nc` writes; without it the study is run. Every line is
a world: what `census` reaches, the best of the other brains that robots can run, and their ratio. Error is the median
error after the last round, K the median round of convergence, recovery the median number of rounds after a change until
the error stays below 0.05, mean the median over trials of the mean error over all rounds.

Then errors among liars, as ratios to that of a robot alone and to that of the best other brain, also among creepers of
other steps, and among insiders, which know the source; with wrong accuracies; where robots fail or join late; where two
needs meet; in large swarms; what leaving out a part costs; and K of flooding, the limit of any brain. FILE becomes a
picture of the last.
"""

import argparse
import tempfile
import tomllib
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import networkx as nx
import numpy as np

import swarmcensus as sc
from swarmcensus.figures.looks import NAMED
from swarmcensus.studies.study import Study

ROOT = Path(__file__).parents[1]
STUDY = ROOT / "studies" / "census.toml"
BOUNDS = ("oracle",)  # no robot can run them
LIARS = (
    "always-black", "always-white", "opposite", "random", "shouter", "slow-liar", "creeper", "noisy-mirror", "forger",
    "jammer",
)  # fmt: skip
SHARES = (0.1, 0.3, 0.4)
LIED_TO = ("full", "ring", "scale-free")
COMPARED = ("census", "steadfast", "commons", "self-taught", "minimalistic", "alone")
STEPS = (0.002, 0.005, 0.02, 0.05, 0.1)  # of creepers
INSIDER = ROOT / "studies" / "example" / "insider.py"
WORST = ROOT / "docs" / "census-insider.toml"  # the values that a search has found
INSIDERS = {  # what one lie alone does
    "cries a change, all sums 0.1 off": {"anew": 3.0, "step": 0.1, "short": 0.1, "own": 0.0},
    "short sums 0.1 off": {"step": 0.0, "short": 0.1, "own": 0.0},
    "own readings 0.02 off": {"step": 0.0, "short": 0.0, "own": 0.02},
}
LIMIT_TRIALS = 10
PARTS = {  # what is left out: parameters that do so
    "no momentum": {"momentum": 0.0},
    "no change found": {"z": 1e6, "confirm": 1e6},
    "a change found without confirming": {"confirm": 1e6},
    "all believed": {"belief": 1e6},
}
GRAPHS = {  # of 100 robots, by the name of their world
    "ring": lambda seed: nx.cycle_graph(100),
    "tree": lambda seed: nx.barabasi_albert_graph(100, 1, seed),
    "small world": lambda seed: nx.connected_watts_strogatz_graph(100, 4, 0.1, seed=seed),
}
CHANNELS = {"": (1.0, 0), ", links 0.1": (0.1, 0), ", 10 rounds late": (1.0, 10)}  # what arrives, rounds that it takes
DRAWN = {"census": "census", "swift": "swift", "commons": "commons", "minimalistic": "minimalistic (the paper's)"}


def world(results, setting):
    """The words of a setting, without its brain."""
    one = results.isel(setting=setting)
    name = str(one["topology"].values)
    for long, short in (
        ("barabasi_albert_graph(m=1)", "tree"), ("watts_strogatz_graph(k=4,p=0.1)", "small world"),
    ):  # fmt: skip
        name = name.replace(long, short)
    words = [name]
    if name == "moving":
        words.append(f"D = {float(one['density']):g}")
        if str(one["floor"].values) != "tiles":
            words.append(str(one["floor"].values))
    change = str(one["fill_ratio_change"].values)
    words += [f"N = {int(one['robots'])}", f"b = {one['accuracy'].values}", f"f = {change or one['fill_ratio'].values}"]
    if float(one["link_success"]) < 1.0:
        words.append(f"links {float(one['link_success']):g}")
    if "message_delay" in results.coords and int(one["message_delay"]) > 0:
        words.append(f"{int(one['message_delay'])} rounds late")
    return ", ".join(words)


def measured(results, setting):
    """Error and K of a setting, or error, recovery and mean error where the floor changes."""
    one = results.isel(setting=setting)
    robots = slice(int(one["robots"]))  # smaller swarms are padded
    error = float(np.median(abs(one["final_estimate"].values[:, robots] - float(one["fill_ratio"]))))
    if "fill_ratio_change" in results.coords and str(one["fill_ratio_change"].values):
        recovery = median(one["recovery_time"].values[:, robots])
        return {"error": error, "recovery": recovery, "mean": float(np.nanmedian(one["mean_error"].values))}
    return {"error": error, "K": median(one["convergence_round"].values[:, robots])}


def median(rounds):
    """The median of rounds; those that never came, below 0 or not a number, are infinite."""
    rounds = rounds.astype(float)
    return float(np.median(np.where(np.isnan(rounds) | (rounds < 0), np.inf, rounds)))


def worlds(results):
    """Of each world, what each brain reaches."""
    found = {}
    labels = results["brain"].values
    for setting, label in enumerate(labels):
        name = Path(str(label)).stem
        found.setdefault(world(results, setting), {})[name] = measured(results, setting)
    return found


def tell(found):
    """A line a world, and how often the best is nearly reached."""
    print(f"{'world':66}{'':>9}{'census':>9}  {'best of the others':30}{'ratio':>6}")
    ratios = {}
    for name, brains in found.items():
        others = {b: values for b, values in brains.items() if b not in ("census", *BOUNDS)}
        for k, (quantity, ours) in enumerate(brains["census"].items()):
            best = min(others, key=lambda b, q=quantity: others[b][q])
            least = others[best][quantity]
            if least > 0.0:  # a change that some robot never notices takes it no time
                ratios.setdefault(quantity, []).append(ours / least)
            told, value = (f"{x:.4f}" if quantity in ("error", "mean") else f"{x:.0f}" for x in (ours, least))
            ratio = f"{ours / least:6.2f}" if least > 0.0 else f"{'-':>6}"
            print(f"{name if k == 0 else '':66}{quantity:>9}{told:>9}  {f'{value} {best}':30}{ratio}")
    for quantity, values in ratios.items():
        near = 1.1 if quantity in ("error", "mean") else 1.3
        values = np.array(values)
        print(
            f"{quantity}: {np.sum(values < 1)} of {len(values)} worlds below every other, "
            f"{np.sum(values <= near)} within {near} of the best, median ratio {np.median(values):.2f}, "
            f"largest {values.max():.2f}"
        )


def errors(trials, members, topologies, f=0.55, brains=COMPARED):
    """The median error of honest robots of each topology and brain."""
    study = sc.Study(
        trials=trials,
        seed=32,
        swarm={"robots": 20, "accuracy": 0.75, "brain": list(brains)},
        members=members,
        world={"topology": topologies, "fill_ratio": f},
        schedule={"rounds": 1000, "observations_per_round": 10},
    )
    with warnings.catch_warnings(action="ignore"):  # where a shouter leaves no number
        results = sc.run(study)
    found = {}
    for topology, brain, estimates in zip(
        results["topology"].values, results["brain"].values, results["final_estimate"].values, strict=True
    ):
        known = estimates[~np.isnan(estimates)]  # liars have none
        found.setdefault(str(topology), {})[str(brain)] = np.median(abs(known - f)) if known.size else np.inf
    return found


def among_liars(trials):
    """Errors among liars as ratios, a line a liar."""
    head = "".join(f"{share:.0%} {topology}".rjust(15) for share in SHARES for topology in LIED_TO)
    print(f"{'to alone, to the best other':28}{head}")
    cells = []
    kinds = {kind: kind for kind in LIARS} | {f"creeper of {step}": {"file": "creeper", "step": step} for step in STEPS}
    for name, kind in kinds.items():
        line = f"{name:28}"
        for share in SHARES:
            found = errors(trials, [{"robots": share, "brain": kind, "honest": False}], list(LIED_TO))
            for topology in LIED_TO:
                of = found[topology]
                alone, best = of["alone"], min(value for brain, value in of.items() if brain != "census")
                line += f"{of['census'] / alone:.2f}, {of['census'] / best:.2f}".rjust(15)
                if name in LIARS:
                    cells.append((share, of["census"] / alone, of["census"] / best))
        print(line)
    for share in SHARES:
        alone, best = np.array([ratios for at, *ratios in cells if at == share]).T
        print(
            f"{share:.0%} of ten liars: at most 1.05 times the error alone in {np.sum(alone <= 1.05)} of {len(alone)} "
            f"cells, largest {alone.max():.2f}; within 1.5 of the best in {np.sum(best <= 1.5)}, "
            f"largest {best.max():.2f}"
        )


def among_insiders(trials):
    """Errors among liars that know the source, as ratios to that of a robot alone, a line a liar."""
    worst = tomllib.loads(WORST.read_text())["members"][0]["brain"][0]
    worst = {name: value for name, value in worst.items() if name != "file"}
    kinds = INSIDERS | {"as searched": worst, "as searched, from the first round": worst | {"sleeps": 0.0}}
    print(f"{'to alone':34}{''.join(f'{share:.0%} {topology}'.rjust(15) for share in SHARES for topology in LIED_TO)}")
    for name, values in kinds.items():
        line = f"{name:34}"
        for share in SHARES:
            liars = {"robots": share, "brain": {"file": str(INSIDER)} | values, "honest": False}
            found = errors(trials, [liars], list(LIED_TO), brains=["census", "alone"])
            line += "".join(f"{found[t]['census'] / found[t]['alone']:.2f}".rjust(15) for t in LIED_TO)
        print(line)


def wrong_accuracies(trials):
    """Errors where some robots are told a wrong accuracy, a line each."""
    for told in (0.55, 0.6, 0.9, 0.95):
        for share in (0.1, 0.3):
            found = errors(trials, [{"robots": share, "assumed_accuracy": told}], ["full", "ring"], f=0.65)
            for topology, of in found.items():
                name = f"{share:.0%} told {told} for 0.75, {topology}"
                print(f"{name:34}", *(f"{brain} {value:.4f}" for brain, value in of.items()), sep="  ")


def failing(trials):
    """Error and K where half of the robots, the root of a tree often among them, fail for good or join late."""
    brains = ["census", "swift", "commons", "minimalistic", "alone"]
    fails = {
        "half fail in round 101": {"at": 101, "robots": 0.5, "stop": ["sensing", "talking"]},
        "half join in round 201": {"at": 1, "until": 201, "robots": 0.5, "stop": ["sensing", "talking"]},
    }
    topologies = ["ring", {"networkx": "barabasi_albert_graph", "m": 1}, "full"]
    for name, fault in fails.items():
        study = sc.Study(
            trials=trials, seed=36, swarm={"robots": 100, "accuracy": 0.625, "brain": brains},
            world={"topology": topologies, "fill_ratio": 0.55}, faults=[fault],
            schedule={"rounds": 1000, "observations_per_round": 10}, measure={"bins": 2},
        )  # fmt: skip
        results = sc.run(study)
        for topology in dict.fromkeys(map(str, results["topology"].values)):
            settings = np.flatnonzero(results["topology"].values == topology)
            cells = [(str(results["brain"].values[k]), measured(results, k)) for k in settings]
            short = {"ring": "ring", "full": "full"}.get(topology, "tree")
            print(f"{name}, {short}:".ljust(30), *(f"{b} {v['error']:.4f} K {v['K']:.0f}" for b, v in cells), sep="  ")


def crossings(trials):
    """Where two needs meet: the last error, the mean error over all rounds, and the ranks of census in them."""
    brains = ["census", "commons", "swift", "tracking", "steadfast", "self-taught", "minimalistic", "alone"]
    change, wrong = {"from": 0.75, "to": 0.45, "at": 301}, [{"robots": 0.3, "assumed_accuracy": 0.95}]
    ramp = {"from": 0.8, "to": 0.4, "at": 301, "until": 900}
    fails = [{"at": 301, "robots": 0.3, "stop": ["sensing", "talking"]}]

    def lied(kind, **world):
        return {"members": [{"robots": 0.2, "brain": kind, "honest": False}], "world": world}

    moving = {"topology": "moving", "density": 5}
    needs = {
        "a change, always-black": lied("always-black", topology="scale-free", fill_ratio=change),
        "a change, opposite": lied("opposite", topology="scale-free", fill_ratio=change),
        "a change, creeper": lied("creeper", topology="scale-free", fill_ratio=change),
        "a ramp, opposite": lied("opposite", topology="scale-free", fill_ratio=ramp),
        "links 0.2, opposite": lied("opposite", topology="ring", fill_ratio=0.55, link_success=0.2),
        "10 rounds late, always-black": lied("always-black", topology="ring", fill_ratio=0.55, message_delay=10),
        "links 0.2, told 0.95": {
            "members": wrong, "world": {"topology": "ring", "fill_ratio": 0.65, "link_success": 0.2},
        },
        "a change, links 0.2": {"world": {"topology": "ring", "fill_ratio": change, "link_success": 0.2}},
        "a change, told 0.95": {"members": wrong, "world": {"topology": "scale-free", "fill_ratio": change}},
        "robots fail, opposite": lied("opposite", topology="scale-free", fill_ratio=0.55) | {"faults": fails},
        "moving, opposite": lied("opposite", **moving, fill_ratio=0.55),
        "moving, a change, opposite": lied("opposite", **moving, fill_ratio={**change, "at": 1501}),
        "moving, stripes, always-black": lied("always-black", **moving, floor={"stripes": 0.5}, fill_ratio=0.55),
    }  # fmt: skip
    firsts = []
    print(f"{'':30}{'last error: rank, census, best':34}{'mean error: rank, census, best':34}  alone")
    for name, tables in needs.items():
        world = tables["world"]
        study = sc.Study(
            trials=trials, seed=34, swarm={"robots": 50, "accuracy": 0.75, "brain": brains}, **tables,
            schedule={"ticks": 5000} if "density" in world else {"rounds": 1000, "observations_per_round": 10},
            measure={"metrics": ["mean-error"], "bins": 2},
        )  # fmt: skip
        results = sc.run(study)
        f = world["fill_ratio"]["to"] if isinstance(world["fill_ratio"], dict) else world["fill_ratio"]
        last = [float(np.nanmedian(abs(each - f))) for each in results["final_estimate"].values]
        mean = [float(np.nanmedian(each)) for each in results["mean_error"].values]
        ranks = [sorted(values).index(values[0]) + 1 for values in (last, mean)]
        firsts.append(ranks)
        line = f"{name:30}"
        for values, rank in zip((last, mean), ranks, strict=True):
            best = int(np.argmin(values[1:])) + 1
            line += f"  {rank}: {values[0]:.4f}, {brains[best]} {values[best]:.4f}".ljust(34)
        print(f"{line}  {last[-1]:.4f} {mean[-1]:.4f}")
    for name, ranks in zip(("last", "mean"), np.array(firsts).T, strict=True):
        print(f"{name} error: first in {np.sum(ranks == 1)}, second in {np.sum(ranks == 2)} of {len(ranks)}")


def large(trials):
    """Error and K in large swarms."""
    brains = ["census", "swift", "commons", "minimalistic"]
    for robots in (100, 1000, 10000):
        study = sc.Study(
            trials=trials, seed=35, swarm={"robots": robots, "accuracy": 0.625, "brain": brains},
            world={"topology": ["ring", {"networkx": "barabasi_albert_graph", "m": 1}], "fill_ratio": 0.55},
            schedule={"rounds": 1000, "observations_per_round": 10}, measure={"bins": 2},
        )  # fmt: skip
        results = sc.run(study)
        for setting, (label, topology) in enumerate(
            zip(results["brain"].values, results["topology"].values, strict=True)
        ):
            row, name = measured(results, setting), "ring" if topology == "ring" else "tree"
            print(f"{robots:6} robots, {name}: {label:14} error {row['error']:.5f}  K {row['K']:.0f}")


def flooded(graph, success, delay, seed, rounds=1000, looks=10, accuracy=0.625, f=0.55, delta=0.01):
    """The rounds of convergence of robots that pass on all that they know of everybody (robot)."""
    random = np.random.default_rng(seed)
    robots = graph.number_of_nodes()
    edges = np.array([(b, a) for a, b in graph.edges] + [(a, b) for a, b in graph.edges])
    edges = edges[np.argsort(edges[:, 0], kind="stable")]  # hears, from
    begins = np.flatnonzero(np.diff(edges[:, 0], prepend=-1))
    q = accuracy * f + (1 - accuracy) * (1 - f)
    blacks = np.concatenate([np.zeros((1, robots)), random.binomial(looks, q, (rounds, robots)).cumsum(0)])
    known = np.zeros((robots, robots), np.int64)
    history, last = [], np.zeros(robots)
    for t in range(1, rounds + 1):
        known[np.arange(robots), np.arange(robots)] = t
        history.append(known.copy())
        if t > delay:
            heard = history[t - 1 - delay][edges[:, 1]] * (random.random(len(edges)) < success)[:, np.newaxis]
            hears = edges[begins, 0]
            known[hears] = np.maximum(known[hears], np.maximum.reduceat(heard, begins))
            history[t - 1 - delay] = None
        share = blacks[known, np.arange(robots)].sum(1) / (looks * known.sum(1))
        off = abs((share + accuracy - 1) / (2 * accuracy - 1) - f) >= delta
        last[off] = t
    return last + 1


def main(path, trials, plot):
    """All tables."""
    study = Study.load(STUDY)
    if path is None:
        path = Path(tempfile.mkdtemp()) / "census.nc"
        results = sc.run(study if trials is None else study.with_trials(trials), out=path)
    else:
        results = sc.load(path)
    found = worlds(results)
    tell(found)
    print()
    among_liars(trials or 100)
    print()
    among_insiders(trials or 100)
    print()
    wrong_accuracies(trials or 100)
    print()
    failing(trials or 100)
    print()
    crossings(trials or 100)
    print()
    large(LIMIT_TRIALS)
    print()
    ablation(trials or 100)
    print()
    limits = {}
    for graph, make in GRAPHS.items():
        for channel, (success, delay) in CHANNELS.items():
            rounds = [flooded(make(seed), success, delay, seed) for seed in range(LIMIT_TRIALS)]
            limits[graph, channel] = np.median(rounds)
            print(f"flooding, b = 0.625, N = 100: {graph + channel:30} K {limits[graph, channel]:.0f}")
    if plot:
        draw(found, limits, plot)


def draw(found, limits, path):
    """K of each brain beside that of flooding."""
    figure, axes = plt.subplots(figsize=(7.2, 3.6), layout="constrained")
    names = [graph + channel for graph, channel in limits]
    rows = np.arange(len(names))[::-1]
    axes.barh(rows, list(limits.values()), height=0.7, color="0.85", label="the limit: all pass on all they know")
    for (brain, label), colour, marker in zip(DRAWN.items(), NAMED, "oDs^", strict=False):
        rounds = [found[f"{graph}, N = 100, b = 0.625, f = 0.55{channel}"][brain]["K"] for graph, channel in limits]
        axes.plot(rounds, rows, marker, color=colour, label=label, zorder=3, ms=7 if brain == "census" else 5)
    axes.set_xscale("log")
    axes.set_xticks([20, 50, 100, 200, 500], ["20", "50", "100", "200", "500"])
    axes.minorticks_off()
    axes.set_yticks(rows, [name.replace("links 0.1", "a tenth of the messages") for name in names])
    axes.set_xlabel("rounds until estimates stay within 0.01 of the fill ratio")
    axes.grid(axis="x", color="0.92")
    axes.set_axisbelow(True)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="y", length=0)
    figure.legend(loc="outside upper center", ncols=5, frameon=False, fontsize=8, handletextpad=0.4, columnspacing=1.2)
    figure.savefig(path, dpi=200)


def ablation(trials):
    """What leaving out a part costs: error and K where nothing changes, recovery where the floor does."""
    brains = ["census", *({"file": "census"} | values for values in PARTS.values())]
    rows = {}
    for topology in ("ring", "full", "scale-free"):
        for floor in (0.55, {"from": 0.65, "to": 0.55, "at": 301}):
            study = sc.Study(
                trials=trials, seed=33, swarm={"robots": 50, "accuracy": 0.75, "brain": brains},
                world={"topology": topology, "fill_ratio": floor},
                schedule={"rounds": 1000, "observations_per_round": 10},
                measure={"metrics": ["recovery-time", "mean-error"], "bins": 2},
            )  # fmt: skip
            results = sc.run(study)
            for k, part in enumerate(("all parts", *PARTS)):
                rows.setdefault(part, []).append((topology, measured(results, k)))
    for part, cells in rows.items():
        print(part)
        for topology, values in cells:
            numbers = (f"{quantity} {x:.4f}" if x < 1 else f"{quantity} {x:.0f}" for quantity, x in values.items())
            print(f"    {topology}", *numbers)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="?", type=Path)
    parser.add_argument("--trials", type=int, help="instead of the study's own number")
    parser.add_argument("--plot", type=Path, help="the picture of K beside the limit")
    given = parser.parse_args()
    main(given.results, given.trials, given.plot)
