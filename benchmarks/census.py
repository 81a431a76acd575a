"""How near `census` is to the best brain in each kind of world: python benchmarks/census.py [RESULTS] [--trials T].

RESULTS is what `swarmcensus run studies/census.toml --out census.nc` writes; without it the study is run. Every line is
a world: what `census` reaches, the best of the other brains that robots can run, and their ratio. Error is the median
error after the last round, K the median round of convergence, recovery the median number of rounds after a change until
the error stays below 0.05, mean the median over trials of the mean error over all rounds. Then the same among liars and
with wrong accuracies, what leaving out a part costs, and K of flooding, which is the limit of any brain. With a
processor of two cores it takes a quarter of an hour.
"""

import argparse
import tempfile
import warnings
from pathlib import Path

import networkx as nx
import numpy as np

import swarmcensus as sc
from swarmcensus.studies.study import Study

ROOT = Path(__file__).parents[1]
STUDY = ROOT / "studies" / "census.toml"
BOUNDS = ("oracle",)  # no robot can run them
LIARS = ("always-black", "opposite", "shouter", "slow-liar", "creeper")
LIMIT_TRIALS = 10
PARTS = {  # what is left out: parameters that do so
    "no momentum": {"momentum": 0.0},
    "no change found": {"z": 1e6, "confirm": 1e6},
    "a change found without confirming": {"confirm": 1e6},
}
FLOODED = {  # a graph of 100 robots, messages that arrive, rounds that they take
    "ring": (lambda seed: nx.cycle_graph(100), 1.0, 0),
    "ring, a tenth of the messages": (lambda seed: nx.cycle_graph(100), 0.1, 0),
    "ring, 10 rounds late": (lambda seed: nx.cycle_graph(100), 1.0, 10),
    "tree": (lambda seed: nx.barabasi_albert_graph(100, 1, seed), 1.0, 0),
    "tree, a tenth of the messages": (lambda seed: nx.barabasi_albert_graph(100, 1, seed), 0.1, 0),
    "tree, 10 rounds late": (lambda seed: nx.barabasi_albert_graph(100, 1, seed), 1.0, 10),
    "small world": (lambda seed: nx.connected_watts_strogatz_graph(100, 4, 0.1, seed=seed), 1.0, 0),
    "small world, a tenth of the messages": (
        lambda seed: nx.connected_watts_strogatz_graph(100, 4, 0.1, seed=seed), 0.1, 0
    ),
    "small world, 10 rounds late": (lambda seed: nx.connected_watts_strogatz_graph(100, 4, 0.1, seed=seed), 1.0, 10),
}  # fmt: skip


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


def among(name, trials, brains, members, topologies):
    """Errors of honest robots among members that lie or are wrong, a line a network."""
    study = sc.Study(
        trials=trials,
        seed=32,
        swarm={"robots": 20, "accuracy": 0.75, "brain": brains},
        members=members,
        world={"topology": topologies, "fill_ratio": 0.55},
        schedule={"rounds": 1000, "observations_per_round": 10},
    )
    with warnings.catch_warnings(action="ignore"):  # where a shouter leaves no number
        results = sc.run(study)
    for topology in topologies:
        chosen = results.isel(setting=np.flatnonzero(results["topology"].values == topology))
        errors = []
        for brain, estimates in zip(chosen["brain"].values, chosen["final_estimate"].values, strict=True):
            known = estimates[~np.isnan(estimates)]  # liars have none
            errors.append(f"{brain} {np.median(abs(known - 0.55)):.4f}" if known.size else f"{brain} none")
        print(f"{name + ', ' + topology:36}", *errors, sep="  ")


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


def main(path, trials):
    """All tables."""
    study = Study.load(STUDY)
    if path is None:
        path = Path(tempfile.mkdtemp()) / "census.nc"
        results = sc.run(study if trials is None else study.with_trials(trials), out=path)
    else:
        results = sc.load(path)
    tell(worlds(results))
    print()
    brains = ["census", "commons", "steadfast", "minimalistic", "alone"]
    for kind in LIARS:
        for share in (2, 6):
            among(f"{share} of 20 {kind}", trials or 100, brains, [{"robots": share, "brain": kind, "honest": False}],
                  ["full", "ring"])  # fmt: skip
    among("6 of 20 told 0.55 for 0.75", trials or 100, ["census", "commons", "self-taught", "minimalistic", "alone"],
          [{"robots": 6, "assumed_accuracy": 0.55}], ["full", "ring"])  # fmt: skip
    print()
    ablation(trials or 100)
    print()
    for name, (graph, success, delay) in FLOODED.items():
        rounds = [flooded(graph(seed), success, delay, seed) for seed in range(LIMIT_TRIALS)]
        print(f"flooding, b = 0.625, N = 100: {name:40} K {np.median(rounds):.0f}")


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
    given = parser.parse_args()
    main(given.results, given.trials)
