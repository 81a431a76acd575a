"""Figures and tables of docs/beyond.md: python benchmarks/beyond.py QUESTION [--figure FILE.png] [--write].

Brains that go beyond the paper's beside it: where they share everything, where the floor changes, and where robots do
not know their sensors.
"""

import harness
import numpy as np

import swarmcensus as sc
from swarmcensus import theory

TRIALS = 100
BRAINS = ["minimalistic", "commons", "swift"]
ROUNDS, CHANGE = 1000, 301
FORGETFUL = "studies/example/forgetful.py"
STUDIES = harness.ROOT / "studies" / "beyond"
CHANGE_BRAINS = {
    "tracking": "tracking",
    "commons": "commons",
    "minimalistic": "minimalistic",
    "forgetful, half = 30": {"file": FORGETFUL, "half": 30},
    "changing-floor, detect = 1": {"file": "changing-floor", "detect": 1, "debiased": 1, "every": 1},
    "bayes-cpf": {"file": "bayes-cpf", "drift": 0},
}
SHOWN = [300, 310, 320, 350, 400, 600, 1000]
UNKNOWN_BRAINS = ["self-taught", "commons", "minimalistic", "asdf", "oracle"]
TOLD = [0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95]
FLOORS = [0.55, 0.75]


# ---- shared evidence


def ring(accuracy, topology="ring", rounds=1000):
    """A study of 100 robots that hold still."""
    return sc.Study(
        trials=harness.trials(TRIALS),
        seed=13,
        swarm={"brain": list(BRAINS), "robots": 100, "accuracy": accuracy},
        world={"topology": topology, "fill_ratio": 0.55},
        schedule={"rounds": rounds, "observations_per_round": 10},
    )


def moving(accuracy, density):
    """A study of 100 robots that move for 1,000 s."""
    return sc.Study(
        trials=harness.trials(TRIALS),
        seed=13,
        swarm={"brain": list(BRAINS), "robots": 100, "accuracy": accuracy},
        world={"topology": "moving", "density": density, "fill_ratio": 0.55},
        schedule={"ticks": 10000},
    )


def tell(name, results):
    """A line a brain: median final error, median K."""
    errors = np.abs(results["final_estimate"] - 0.55).median(("trial", "robot")).values
    settled = results["convergence_round"].median(("trial", "robot")).values
    for brain, error, k in zip(results["brain"].values, errors, settled, strict=True):
        print(f"{name:34} {brain:14} error {error:.4f}   K {k:6.0f}", flush=True)


def tell_early():
    """In how many cells the mean error at round 10 is above the paper's, and which."""
    study = sc.Study(
        trials=harness.trials(60),
        seed=13,
        swarm={"brain": list(BRAINS), "robots": 100, "accuracy": [0.525, 0.575]},
        world={
            "topology": ["full", "ring", "scale-free"],
            "fill_ratio": [0.55, 0.75, 0.95],
            "link_success": [1.0, 0.5, 0.1],
        },
        schedule={"rounds": 10, "observations_per_round": 10},
    )
    results = sc.run(study)
    errors = np.abs(results["final_estimate"] - results["fill_ratio"]).mean(("trial", "robot")).values
    cells = [
        results[name].values.reshape(len(BRAINS), -1)[0]
        for name in ("topology", "accuracy", "fill_ratio", "link_success")
    ]
    paper, *others = errors.reshape(len(BRAINS), -1)
    for brain, other in zip(list(BRAINS)[1:], others, strict=True):
        worse = np.flatnonzero(other > paper)
        print(f"round 10: the mean error of {brain} is above the paper's in {worse.size} of {paper.size} cells")
        for i in worse:
            print("  ", *(cell[i] for cell in cells), f"by {other[i] / paper[i] - 1:.1%}")


def tell_weights():
    """What weights of k^2 leave of the information, where sensors are U(0.525, 0.975)."""
    b = np.linspace(0.525, 0.975, 10_001)
    weight = (2.0 * b - 1.0) ** 2
    for f in (0.55, 0.75, 0.95, 0.99):
        variance = np.sum(weight**2 * theory.reading_variance(f, b)) / np.sum(weight) ** 2
        print(f"weights of k^2, f = {f}: {1.0 / variance / np.sum(theory.information(f, b)):.3f} of the information")


def draw_sharing(results, path):
    """The median error of all robots and trials after each round, and what theory allows."""
    figure, (axes,) = harness.panels(1, 1, 6.4, 4.0)
    rounds = np.arange(1, 1001)
    for setting, look in enumerate(harness.looks(BRAINS)):
        lives = [
            sc.replay(results, setting=setting, trial=trial)["estimate"].values[1:]
            for trial in range(results.sizes["trial"])
        ]
        errors = np.median(np.abs(np.stack(lives) - 0.55), axis=(0, 2))
        axes.plot(rounds, errors, color=look.colour, lw=2.0, label=look.name)
    accuracy = 0.525
    bounds = {
        "a robot alone, unbiased": theory.swarm_bound(10 * rounds, 0.55, accuracy),
        "three robots": theory.swarm_bound(30 * rounds, 0.55, accuracy),
        "all readings at once": theory.swarm_bound(10 * rounds, 0.55, np.full(100, accuracy)),
    }
    for dashes, (name, variance) in zip((":", "--", "-."), bounds.items(), strict=True):
        axes.plot(rounds, theory.median_error(variance), color="0.35", lw=1.0, ls=dashes, label=f"theory: {name}")
    axes.set(xscale="log", yscale="log", xlim=(1, 1000), ylim=(0.004, 0.5))
    axes.set(xlabel="round of communication", ylabel="error $|x - f|$, median")
    harness.decimals(axes.xaxis)
    harness.decimals(axes.yaxis, (1.0, 2.0, 5.0))
    axes.legend(frameon=False, loc="lower left")
    harness.write_small(figure, path)


@harness.question
def sharing(figure=None):
    """Brains that share everything: two minutes on two cores."""
    poor = sc.run(ring(0.525))
    tell("ring, 0.525", poor)
    tell("ring, 0.625", sc.run(ring(0.625)))
    tell("ring, U(0.525, 0.975)", sc.run(ring("U(0.525, 0.975)")))
    tell("scale-free, U(0.525, 0.975)", sc.run(ring("U(0.525, 0.975)", "scale-free")))
    tell("moving, D = 10, 0.875", sc.run(moving(0.875, 10)))
    tell("moving, D = 1, 0.525", sc.run(moving(0.525, 1)))
    tell_early()
    tell_weights()
    if figure:
        draw_sharing(poor, figure)


# ---- floors that change


def after_each_round(floor):
    """The median error of each brain after each round, (brain, round)."""
    study = sc.Study(
        trials=harness.trials(20),
        seed=5,
        swarm={"brain": list(CHANGE_BRAINS.values()), "robots": 50, "accuracy": 0.75},
        world={"topology": "ring", "fill_ratio": floor},
        schedule={"rounds": ROUNDS, "observations_per_round": 10},
    )
    results = sc.run(study)
    truth = np.where(np.arange(1, ROUNDS + 1) < CHANGE, floor["from"], floor["to"])[:, np.newaxis]
    found = []
    for setting in range(len(CHANGE_BRAINS)):
        lives = [
            sc.replay(results, setting=setting, trial=trial, brain_file=[FORGETFUL])["estimate"].values[1:]
            for trial in range(results.sizes["trial"])
        ]
        found.append(np.median(np.abs(np.stack(lives) - truth), axis=(0, 2)))
    return np.array(found)


@harness.question
def changing(figure=None):
    """A large change of the floor and a small one: the median error after some rounds. A minute on two cores."""
    floors = {
        "0.85 to 0.25": {"from": 0.85, "to": 0.25, "at": CHANGE},
        "0.65 to 0.55": {"from": 0.65, "to": 0.55, "at": CHANGE},
    }
    found = {name: after_each_round(floor) for name, floor in floors.items()}
    print("median error after round".ljust(42), *(f"{r:>6}" for r in SHOWN))
    for name, errors in found.items():
        for brain, row in zip(CHANGE_BRAINS, errors, strict=True):
            print(f"{name}  {brain}".ljust(42), *(f"{row[r - 1]:.4f}" for r in SHOWN))
    if figure:
        draw_changing(found, figure)


def draw_changing(found, path):
    """Round by round, a panel a change."""
    figure, axes = harness.panels(1, 2, 7.2, 3.9)
    looks = harness.looks([brain.partition(",")[0] for brain in CHANGE_BRAINS])
    k = list(CHANGE_BRAINS).index("forgetful, half = 30")
    looks[k] = looks[k]._replace(colour="#808080", marker="s")  # an example, no shipped brain
    rounds = np.arange(1, ROUNDS + 1)
    for letter, one, (name, errors) in zip("ab", axes, found.items(), strict=True):
        handles = []
        for brain, row, look in zip(CHANGE_BRAINS, errors, looks, strict=True):
            # commons covers others, and they are to be seen
            more = {"ls": "--", "zorder": 5} if brain == "commons" else {"ls": "-"}
            handles += one.plot(rounds, row, markevery=(40, 130), **harness.line_of(look), **more)
        one.axvline(CHANGE, color="0.6", lw=0.8, ls=":")
        one.set_title(f"({letter}) from {name}")
        one.set(yscale="log", xlim=(1, ROUNDS), ylim=(0.001, 1.0), xlabel="round of communication")
        harness.decimals(one.yaxis)
    axes[0].set_ylabel("error $|x - f|$, median")
    values = [brain.partition(",")[1:] for brain in CHANGE_BRAINS]
    harness.save(figure, path, [look.name + "".join(more) for look, more in zip(looks, values, strict=True)], handles)


def share(values):
    return [f"{value:.2f}" for value in values]


def errors(values):
    return [f"{value:.4f}" for value in values]


def measured_changes():
    """The tables of studies/beyond/changing.toml: floors that change, decisions, and sensors that change."""
    results = sc.run(sc.Study.load(STUDIES / "changing.toml"))
    over = ["trial", "robot"]
    brain = results["brain"].to_series().str.split("/").str[-1].str.removesuffix(".py")
    for key in ("half", "detect"):
        brain += [f" {key}={value:g}" if value == value else "" for value in results[key].values]
    recovery, error = results["recovery_time"], abs(results["final_estimate"] - results["fill_ratio"])
    table = results[["fill_ratio_change", "fill_ratio", "topology", "density", "accuracy"]].to_dataframe()
    table["world"] = table["topology"] + table["density"].map(lambda d: "" if d != d else f" D={d:g}")
    table["f"] = table["fill_ratio_change"].where(table["fill_ratio_change"] != "", table["fill_ratio"].astype(str))
    table["brain"] = brain
    table["recovery"] = recovery.quantile(0.5, over, method="lower").values.astype(str)
    table["recovery"] = table["recovery"].str.removesuffix(".0")
    table["never"] = share((np.isinf(recovery).sum(over) / recovery.notnull().sum(over)).values)
    table["mean error"] = errors(results["mean_error"].median(over).values)
    table["last error"] = errors(error.median(over).values)
    right = results["correct"].mean("trial").to_pandas()
    for tick, name in {4000: "before", 4100: "after 10 s", 4500: "after 50 s", 8000: "after 400 s"}.items():
        table[name] = share(right[tick])
    table = table.rename(columns={"accuracy": "sensor"}).sort_values(["world", "f"], kind="stable")
    mostly, perfect = table["sensor"] == "0.75", table["sensor"] == "1.0"
    tables = {
        "floors-that-change": table[mostly][["world", "f", "brain", "recovery", "never", "mean error", "last error"]],
        "floors-decisions": table[perfect].loc[:, ["f", "brain", "recovery", "never", *table.columns[-4:]]],
        "sensors-that-change": table[~mostly & ~perfect][["sensor", "f", "brain", "mean error", "last error"]],
    }
    return {name: ([*one.columns], one.values.tolist()) for name, one in tables.items()}


@harness.question
def floors(write=False):
    """What studies/beyond/changing.toml measures, in benchmarks/tables with `write`. A minute on two cores."""
    tell_tables(measured_changes(), write)


def tell_tables(tables, write):
    for name, (heads, rows) in tables.items():
        print(f"{name}\n{harness.markdown(heads, rows)}")
        if write:
            harness.write_csv(name, heads, rows)


# ---- sensors that are not known


def measured_sensors():
    """The tables of studies/beyond/unknown-sensors.toml: means over all cells, and each cell."""
    results = sc.run(sc.Study.load(STUDIES / "unknown-sensors.toml"))
    over = ["trial", "robot"]
    error = abs(results["final_estimate"] - results["fill_ratio"])
    table = results[["brain", "accuracy", "fill_ratio"]].to_dataframe()
    told = results["members"].to_series().str.split()
    table["assumed"] = told.str[-1]
    table["flawed"] = told.str[0].astype(int).where(table["assumed"] != table["accuracy"], 0)
    table["error"] = error.median(over).values
    table["right"] = (error < 0.05).mean(over).values
    means = table.pivot_table(["error", "right"], "flawed", "brain", sort=False).sort_index()
    keys = ["accuracy", "assumed", "fill_ratio", "flawed"]
    cells = table[table["flawed"] > 0].pivot_table("error", keys, "brain", sort=False)
    heads = [f"{what}: {brain}" for what in ("error", "right") for brain in UNKNOWN_BRAINS]
    rows = [
        [str(flawed), *(f"{means.loc[flawed, tuple(head.split(': '))]:.3f}" for head in heads)]
        for flawed in means.index
    ]
    every = [[*map(str, key), *(f"{row[brain]:.3f}" for brain in UNKNOWN_BRAINS)] for key, row in cells.iterrows()]
    return {
        "unknown-sensors": (["flawed", *heads], rows),
        "unknown-sensors-cells": (["accuracy", "assumed", "f", "flawed", *UNKNOWN_BRAINS], every),
    }


@harness.question
def sensors(write=False):
    """What studies/beyond/unknown-sensors.toml measures, in benchmarks/tables with `write`. Half a minute."""
    tell_tables(measured_sensors(), write)


@harness.question
def unknown(figure=None):
    """Robots whose sensors are not what they assume: the median error by what they assume. A minute on two cores."""
    study = sc.Study(
        trials=harness.trials(40),
        seed=3,
        swarm={
            "brain": [UNKNOWN_BRAINS[0], *UNKNOWN_BRAINS[1:3], {"file": "asdf", "every": 1000}, "oracle"],
            "robots": 20,
            "accuracy": 0.75,
        },
        members=[{"robots": 6, "assumed_accuracy": TOLD}],
        world={"topology": "moving", "density": 10, "fill_ratio": FLOORS},
        schedule={"ticks": 3000},
    )
    results = sc.run(study)
    table = results[["brain", "fill_ratio"]].to_dataframe()
    table["told"] = results["members"].to_series().str.split().str[-1].astype(float)
    error = abs(results["final_estimate"] - results["true_fill_ratio"])
    table["error"] = error.median(["trial", "robot"]).values
    found = table.pivot_table("error", ["fill_ratio", "told"], "brain", sort=False)[UNKNOWN_BRAINS]
    print(found.round(4).to_string())
    if figure:
        draw_unknown(found, figure)


def draw_unknown(found, path):
    """Against what the six were told, a panel a floor."""
    figure, axes = harness.panels(1, 2, 7.2, 3.9)
    looks = harness.looks(UNKNOWN_BRAINS)
    for letter, one, floor in zip("ab", axes, FLOORS, strict=True):
        handles = []
        for brain, look in zip(UNKNOWN_BRAINS, looks, strict=True):
            row = np.maximum(found.loc[floor, brain], 1e-4)
            line = harness.line_of(look)
            if brain == UNKNOWN_BRAINS[0]:  # what the figure is about
                line |= {"lw": 3.0, "ms": 7, "zorder": 5}
            handles += one.plot(row.index, row, **line)
        one.axvline(0.75, color="0.6", lw=0.8, ls=":")
        one.set_title(f"({letter}) f = {floor}")
        one.set(yscale="log", ylim=(0.002, 0.1), xlabel="accuracy that six of twenty assume")
        harness.decimals(one.yaxis, (1.0, 2.0, 5.0))
    axes[0].set_ylabel("error $|x - f|$, median")
    harness.save(figure, path, [look.name for look in looks], handles)


if __name__ == "__main__":
    harness.answer(globals())
