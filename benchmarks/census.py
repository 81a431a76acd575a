"""How near `census` is to the best brain in each kind of world: python benchmarks/census.py [--quick].

The first table is of the worlds of studies/census.toml. Every line is a world: what `census` reaches, its rank among
the brains that robots can run, the best of the others, and the ratio to that with its 95 % interval (trials are
resampled together, since all brains have the same readings). Error is the median error after the last round, K the
median round of convergence, recovery the median number of rounds after a change until the error stays below 0.05, mean
the median of the mean error over all rounds.

Then errors among liars, as ratios to that of a robot alone and to that of the best other brain, also among creepers of
other steps, and among insiders, which know the source; with wrong accuracies; where robots fail or join late; where two
needs meet; in large swarms; beside the oracle and the paper's brain; what leaving out a part costs; and K of flooding,
the limit of any brain. `tables --figure FILE` draws K beside that limit. A quarter of an hour on two cores.
"""

import tomllib
import warnings
from pathlib import Path

import harness
import matplotlib.pyplot as plt
import networkx as nx
import numba
import numpy as np
import xarray as xr

import swarmcensus as sc
from swarmcensus.figures.looks import NAMED
from swarmcensus.studies.study import Study
from swarmcensus.support.intervals import interval, medians, resample

ROOT = Path(__file__).parents[1]
STUDY = ROOT / "studies" / "census.toml"
NEVER = xr.DataArray("")  # changes, where no floor of a study does
BOUNDS = ("oracle",)  # no robot can run them
LIARS = (
    "always-black", "always-white", "opposite", "random", "shouter", "slow-liar", "creeper", "noisy-mirror", "forger",
    "jammer",
)  # fmt: skip
SHARES = (0.1, 0.3, 0.4)
LIED_TO = ("full", "ring", "scale-free")
COMPARED = ("census", "steadfast", "commons", "self-taught", "minimalistic", "alone")
TREE = {"networkx": "barabasi_albert_graph", "m": 1}
MANY = 1e9  # times a number of rounds that may be 0
STEPS = (0.002, 0.005, 0.02, 0.05, 0.1)  # of creepers
INSIDER = ROOT / "studies" / "example" / "insider.py"
WORST = ROOT / "docs" / "census-insider.toml"  # the values that a search has found
INSIDERS = {  # what one lie alone does
    "cries a change, all sums 0.1 off": {"anew": 3.0, "step": 0.1, "short": 0.1, "own": 0.0},
    "short sums 0.1 off": {"step": 0.0, "short": 0.1, "own": 0.0},
    "own readings 0.02 off": {"step": 0.0, "short": 0.0, "own": 0.02},
}
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
    change = str(one.get("fill_ratio_change", NEVER).values)
    words += [f"N = {int(one['robots'])}", f"b = {one['accuracy'].values}", f"f = {change or one['fill_ratio'].values}"]
    if float(one["link_success"]) < 1.0:
        words.append(f"links {float(one['link_success']):g}")
    if one.get("message_delay", 0) > 0:
        words.append(f"{int(one['message_delay'])} rounds late")
    return ", ".join(words)


def measured(results, setting):
    """Error and K of honest robots, or error, recovery and mean error where the floor changes: each (trial, robot)."""
    one = results.isel(setting=setting)
    found = {"error": abs(one["final_estimate"].values - float(one["fill_ratio"]))}
    if str(one.get("fill_ratio_change", NEVER).values):
        found |= {"recovery": one["recovery_time"].values, "mean": one["mean_error"].values}
    else:
        found["K"] = one["convergence_round"].values
    return {quantity: known(values, one) for quantity, values in found.items()}


def known(values, one):
    """The values of honest robots (smaller swarms are padded); rounds that never came, and no numbers, are infinite."""
    values = values[:, : int(one.get("honest", one["robots"]))].astype(float)
    return np.where(np.isnan(values) | (values < 0), np.inf, values)


def ratio(ours, theirs):
    """The ratio of two medians and the ends of its interval over trials."""
    counts = resample(len(ours))
    with np.errstate(invalid="ignore", divide="ignore"):
        ratios = medians(ours, counts) / medians(theirs, counts)
    return interval(np.nan_to_num(ratios, nan=1.0, posinf=MANY))  # of two that are 0 or never come: equal


def shown(value, low, high):
    """A ratio and the ends of its interval, as they are printed."""
    return "{} [{}, {}]".format(*(f"{x:.2f}" if x < 1000.0 else "inf" for x in (value, low, high)))


def told(quantity, value):
    """A number as it is printed."""
    return f"{value:.4f}" if quantity in ("error", "mean") else f"{value:.0f}"


def row(name, quantity, brains, also=()):
    """Print a world; `brains` are the values of each (trial, robot). Returns the rank of census and its ratio."""
    middle = {brain: float(np.median(values)) for brain, values in brains.items() if brain not in BOUNDS}
    ours = middle.pop("census")
    best = min(middle, key=middle.__getitem__)
    rank = 1 + sum(value < ours for value in middle.values())
    least = f"{told(quantity, middle[best])} {best}"
    line = f"{name:64}{quantity:>9}{told(quantity, ours):>8}{f'{rank} of {1 + len(middle)}':>9}  {least:22}"
    found = ratio(brains["census"], brains[best]) if middle[best] > 0.0 else None  # a change that nobody notices
    line += f"  {shown(*found)}" if found else "  -"
    if also:
        line = f"{line:135}" + "  ".join(f"{brain} {told(quantity, middle[brain])}" for brain in also)
    print(line)
    return rank, found


HEAD = f"{'world':64}{'':>9}{'census':>8}{'rank':>9}  {'best of the others':22}  ratio"


def worlds(results):
    """Of each world, what each brain reaches."""
    found = {}
    labels = results["brain"].values
    for setting, label in enumerate(labels):
        name = Path(str(label)).stem
        found.setdefault(world(results, setting), {})[name] = measured(results, setting)
    return found


def tell(found):
    """A line a world and quantity, and how often the best is nearly reached."""
    print("Worlds of studies/census.toml", HEAD, sep="\n")
    ratios = {}
    for name, brains in found.items():
        for k, quantity in enumerate(brains["census"]):
            _, against = row(name if k == 0 else "", quantity, {b: values[quantity] for b, values in brains.items()})
            if against:
                ratios.setdefault(quantity, []).append(against)
    for quantity, found_ratios in ratios.items():
        near = 1.1 if quantity in ("error", "mean") else 1.3
        values, low, _ = np.array(found_ratios).T
        print(
            f"{quantity}: {np.sum(values < 1)} of {len(values)} worlds below every other, "
            f"{np.sum(values <= near)} within {near} of the best "
            f"(intervals wholly above that in {np.sum(low > near)}), "
            f"median ratio {np.median(values):.2f}, largest {values.max():.2f}"
        )


def errors(trials, members, topologies, f=0.55, brains=COMPARED):
    """The errors of honest robots of each topology and brain, each (trial, robot)."""
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
    for setting, (topology, brain) in enumerate(zip(results["topology"].values, results["brain"].values, strict=True)):
        found.setdefault(str(topology), {})[str(brain)] = measured(results, setting)["error"]
    return found


def among(kinds, trials, brains):
    """Errors among liars as ratios with their intervals, a line a liar; returns the ratios of each (kind, share)."""
    cells = {}
    ratios = min(len(brains) - 1, 2)  # to that of a robot alone, and to that of the best
    for share in SHARES:
        heads = "".join(topology.ljust(20 * ratios) for topology in LIED_TO)
        print(f"{f'{share:.0%} lie':34}{heads}".rstrip())
        for name, kind in kinds.items():
            found = errors(trials, [{"robots": share, "brain": kind, "honest": False}], list(LIED_TO), brains=brains)
            line = f"{name:34}"
            for of in found.values():
                others = {brain: np.median(values) for brain, values in of.items() if brain != "census"}
                best = min(others, key=others.__getitem__)
                against = [ratio(of["census"], of[brain]) for brain in ("alone", best)[:ratios]]
                line += "".join(shown(*each).ljust(20) for each in against)
                cells.setdefault((name, share), []).append(against)
            print(line.rstrip())
    return cells


def among_liars(trials):
    """Errors among liars: to that of a robot alone, and to that of the best other brain."""
    print("Liars: ratio of the error to that of a robot alone, and to that of the best other brain")
    kinds = {kind: kind for kind in LIARS} | {f"creeper of {step}": {"file": "creeper", "step": step} for step in STEPS}
    cells = among(kinds, trials, COMPARED)
    for share in SHARES:
        for against, bar, pairs in zip(
            ("that alone", "that of the best other"), (1.05, 1.5),
            np.swapaxes([each for kind in LIARS for each in cells[kind, share]], 0, 1), strict=True,
        ):  # fmt: skip
            values, low, _ = pairs.T
            print(
                f"{share:.0%} lie, ten kinds: error at most {bar} times {against} in {np.sum(values <= bar)} of "
                f"{len(values)} cells (intervals wholly above that in {np.sum(low > bar)}), largest {values.max():.2f}"
            )


def among_insiders(trials):
    """Errors among liars that know the source, to that of a robot alone."""
    worst = tomllib.loads(WORST.read_text())["members"][0]["brain"][0]
    worst = {name: value for name, value in worst.items() if name != "file"}
    kinds = INSIDERS | {"as searched": worst, "as searched, from the first round": worst | {"sleeps": 0.0}}
    print("Insiders: ratio of the error to that of a robot alone")
    among({name: {"file": str(INSIDER)} | values for name, values in kinds.items()}, trials, ("census", "alone"))


def wrong_accuracies(trials):
    """Errors where some robots are told a wrong accuracy, a line each."""
    print("Wrong accuracies, N = 20, f = 0.65", HEAD, sep="\n")
    for told_accuracy in (0.55, 0.6, 0.9, 0.95):
        for share in (0.1, 0.3):
            members = [{"robots": share, "assumed_accuracy": told_accuracy}]
            for topology, of in errors(trials, members, ["full", "ring"], f=0.65).items():
                row(f"{share:.0%} told {told_accuracy} for 0.75, {topology}", "error", of, ("commons", "alone"))


def failing(trials):
    """Error and K where half of the robots, the root of a tree often among them, fail for good or join late."""
    brains = ["census", "swift", "commons", "minimalistic", "alone"]
    fails = {
        "half fail in round 101": {"at": 101, "robots": 0.5, "stop": ["sensing", "talking"]},
        "half join in round 201": {"at": 1, "until": 201, "robots": 0.5, "stop": ["sensing", "talking"]},
    }
    print("Robots that fail or join late, N = 100, b = 0.625, f = 0.55", HEAD, sep="\n")
    for name, fault in fails.items():
        study = sc.Study(
            trials=trials, seed=36, swarm={"robots": 100, "accuracy": 0.625, "brain": brains},
            world={"topology": ["ring", TREE, "full"], "fill_ratio": 0.55}, faults=[fault],
            schedule={"rounds": 1000, "observations_per_round": 10}, measure={"bins": 2},
        )  # fmt: skip
        tell_worlds(sc.run(study), f"{name}, ")


def tell_worlds(results, name):
    """A line a world and quantity, with all brains."""
    for where, brains in worlds(results).items():
        for quantity in brains["census"]:
            of = {brain: values[quantity] for brain, values in brains.items()}
            row(f"{name}{where.split(', N')[0]}", quantity, of, tuple(of)[1:])


def crossings(trials):
    """Where two needs meet: the last error, the mean error over all rounds, and the ranks of census in them."""
    brains = ["census", "commons", "swift", "tracking", "steadfast", "self-taught", "minimalistic", "alone"]
    change, wrong = {"from": 0.75, "to": 0.45, "at": 301}, [{"robots": 0.3, "assumed_accuracy": 0.95}]
    small = {"from": 0.65, "to": 0.55, "at": 301}
    ramp = {"from": 0.8, "to": 0.4, "at": 301, "until": 900}
    fails = [{"at": 301, "robots": 0.3, "stop": ["sensing", "talking"]}]

    def lied(kind, **world):
        return {"members": [{"robots": 0.2, "brain": kind, "honest": False}], "world": world}

    moving = {"topology": "moving", "density": 5}
    needs = {
        "a change, always-black": lied("always-black", topology="scale-free", fill_ratio=change),
        "a change, opposite": lied("opposite", topology="scale-free", fill_ratio=change),
        "a change, creeper": lied("creeper", topology="scale-free", fill_ratio=change),
        "a change, always-black, full": lied("always-black", topology="full", fill_ratio=change),
        "a change, opposite, full": lied("opposite", topology="full", fill_ratio=change),
        "a small change, always-black, full": lied("always-black", topology="full", fill_ratio=small),
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
    ranks = {"error": [], "mean": []}
    print(
        "Two needs at once, N = 50, b = 0.75, f = 0.55, a fifth lie; scale-free, ring where messages are lost or late"
    )
    print(
        "Changes from 0.75 to 0.45, small ones from 0.65 to 0.55, ramps from 0.8 to 0.4; told 0.95: 30 % of the robots"
    )
    print(HEAD)
    for name, tables in needs.items():
        world = tables["world"]
        study = sc.Study(
            trials=trials, seed=34, swarm={"robots": 50, "accuracy": 0.75, "brain": brains}, **tables,
            schedule={"ticks": 5000} if "density" in world else {"rounds": 1000, "observations_per_round": 10},
            measure={"metrics": ["mean-error"], "bins": 2},
        )  # fmt: skip
        results = sc.run(study)
        for quantity, found in ranks.items():
            of = {}
            for setting, brain in enumerate(results["brain"].values):
                one = results.isel(setting=setting)
                values = abs(one["final_estimate"] - one["fill_ratio"]) if quantity == "error" else one["mean_error"]
                of[str(brain)] = known(values.values, one)
            found.append(row(name, quantity, of, ("alone",))[0])
    for quantity, found in ranks.items():
        first, second = (found.count(rank) for rank in (1, 2))
        print(f"{quantity}: first in {first}, second in {second} of {len(found)}")


def large(trials):
    """Error and K in large swarms."""
    print("Large swarms, b = 0.625, f = 0.55", HEAD, sep="\n")
    for robots in (100, 1000, 10000):
        study = sc.Study(
            trials=trials, seed=35,
            swarm={"robots": robots, "accuracy": 0.625, "brain": ["census", "swift", "commons", "minimalistic"]},
            world={"topology": ["ring", TREE], "fill_ratio": 0.55},
            schedule={"rounds": 1000, "observations_per_round": 10}, measure={"bins": 2},
        )  # fmt: skip
        tell_worlds(sc.run(study), f"{robots:,} robots, ")


def beside_bounds(trials):
    """Error beside that of the oracle, which knows all readings, and K beside the paper's brain."""
    print("Losses and lateness, N = 100, b = 0.625, f = 0.55: error to the oracle's, K to the paper's brain's")
    torus = {"networkx": "grid_2d_graph", "m": 10, "n": 10, "periodic": True}
    small_world = {"networkx": "watts_strogatz_graph", "k": 4, "p": 0.1}
    names = {"ring": "ring", "barabasi": "tree", "watts": "small world", "grid": "torus", "full": "full"}
    for channel, (success, delay) in CHANNELS.items():
        study = sc.Study(
            trials=trials, seed=37,
            swarm={"robots": 100, "accuracy": 0.625, "brain": ["census", "minimalistic", "oracle"]},
            world={
                "topology": ["ring", TREE, small_world, torus] + ["full"] * (delay > 0), "fill_ratio": 0.55,
                "link_success": success, "message_delay": delay,
            },
            schedule={"rounds": 1000, "observations_per_round": 10}, measure={"bins": 2},
        )  # fmt: skip
        for where, of in worlds(sc.run(study)).items():
            name = next(name for begin, name in names.items() if where.startswith((begin, name)))
            ours, oracle = of["census"], of["oracle"]["error"]
            error, rounds = ratio(ours["error"], oracle), ratio(ours["K"], of["minimalistic"]["K"])
            print(f"{name + channel:30}error {shown(*error):20}K {shown(*rounds)}")


def flooded(graph, success, delay, seed, rounds=1000, looks=10, accuracy=0.625, f=0.55, delta=0.01):
    """The rounds of convergence of robots that pass on all that they know of everybody (robot)."""
    random = np.random.default_rng(seed)
    q = accuracy * f + (1 - accuracy) * (1 - f)
    blacks = random.binomial(looks, q, (rounds, graph.number_of_nodes())).cumsum(0)
    edges = np.array([(b, a) for a, b in graph.edges] + [(a, b) for a, b in graph.edges])
    known = spread(blacks, edges, success, delay, random)
    share = known[0] / (looks * known[1])
    off = abs((share + accuracy - 1) / (2 * accuracy - 1) - f) >= delta
    return (off * np.arange(1, rounds + 1)[:, np.newaxis]).max(0) + 1


@numba.njit
def spread(blacks, edges, success, delay, random):
    """The sums of blacks and of rounds that robots know of, each (round, robot), where each edge is (hears, from)."""
    rounds, robots = blacks.shape
    known = np.zeros((robots, robots), np.int64)  # of whom each knows how many rounds
    said = np.zeros((delay + 1, robots, robots), np.int64)  # the same when the messages of the latest rounds were sent
    sums = np.zeros((2, rounds, robots))
    for t in range(1, rounds + 1):
        for k in range(robots):
            known[k, k] = t
        said[t % (delay + 1)] = known
        if t > delay:
            for hears, speaker in edges:
                if random.random() < success:
                    known[hears] = np.maximum(known[hears], said[(t - delay) % (delay + 1), speaker])
        for k in range(robots):
            for j in range(robots):
                if known[k, j] > 0:
                    sums[0, t - 1, k] += blacks[known[k, j] - 1, j]
                    sums[1, t - 1, k] += known[k, j]
    return sums


def limit(trials):
    """The median K of flooding on each network, with its interval."""
    limits = {}
    for graph, make in GRAPHS.items():
        for channel, (success, delay) in CHANNELS.items():
            rounds = np.array([flooded(make(seed), success, delay, seed) for seed in range(trials)], float)
            limits[graph, channel], low, high = interval(medians(rounds, resample(trials)))
            name = f"flooding, N = 100, b = 0.625: {graph}{channel}"
            print(f"{name:64}{'K':>9}{limits[graph, channel]:8.0f} [{low:.0f}, {high:.0f}]")
    return limits


@harness.question
def tables(trials=100, figure=None, quick=False):
    """All tables, of so many trials of each world (6 or more, so that ratios have intervals); the figure of K."""
    trials = 6 if quick else trials
    print(f"{trials} trials in each world; seeds: {Study.load(STUDY).seed}, and 32 to 37 below the first table\n")
    found = worlds(sc.run(Study.load(STUDY).with_(trials=trials)))
    tell(found)
    for part in (among_liars, among_insiders, wrong_accuracies, failing, crossings, large, beside_bounds, ablation):
        print(flush=True)
        part(trials)
    print("\nFlooding, the limit of any brain", flush=True)
    limits = limit(trials)
    if figure:
        draw(found, limits, figure)


def draw(found, limits, path):
    """K of each brain beside that of flooding."""
    figure, axes = plt.subplots(figsize=(7.2, 3.6), layout="constrained")
    names = [graph + channel for graph, channel in limits]
    rows = np.arange(len(names))[::-1]
    axes.barh(rows, list(limits.values()), height=0.7, color="0.85", label="the limit: all pass on all they know")
    for (brain, label), colour, marker in zip(DRAWN.items(), NAMED, "oDs^", strict=False):
        rounds = [found[f"{graph}, N = 100, b = 0.625, f = 0.55{channel}"][brain]["K"] for graph, channel in limits]
        rounds = [np.median(each) for each in rounds]
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
    cells = {}
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
                cells.setdefault(part, []).append((topology, measured(results, k)))
    print("Parts left out, N = 50, b = 0.75: f = 0.55, and f = 0.65 to 0.55 at 301; ratios to all parts")
    for part, of in cells.items():
        print(part)
        for (topology, values), (_, all_parts) in zip(of, cells["all parts"], strict=True):
            texts = []
            for quantity, each in values.items():
                text = f"{quantity} {told(quantity, np.median(each))}"
                if part != "all parts":
                    text += f": {shown(*ratio(each, all_parts[quantity]))}"
                texts.append(f"{text:34}")
            print(f"    {topology:12}", *texts[:-1], texts[-1].rstrip())


if __name__ == "__main__":
    harness.answer(globals())
