"""What liars cost, and where our own brains are worse than others: python benchmarks/liars.py QUESTION.

Errors are those of honest robots after the last round, over all trials. inf: estimates are no numbers any more.
"""

from pathlib import Path

import census
import harness
import numpy as np

import swarmcensus as sc

BRAINS = ["steadfast", "commons", "minimalistic", "alone"]
KINDS = ["always-black", "opposite", "random", "shouter", "slow-liar", "forger"]
CREEPERS = [{"file": "creeper", "step": [0.005, 0.01, 0.02, 0.05]}]
ALL_KINDS = [*KINDS, "always-white", "noisy-mirror", "jammer", *CREEPERS]
SHARES = [0, 0.1, 0.2, 0.3]
TRIALS = 20
GEOMETRIC = {"networkx": "random_geometric_graph", "radius": 0.4}
FORGETFUL = {"file": str(Path(__file__).parents[1] / "studies" / "example" / "forgetful.py"), "half": 30}
FULL, RING, LATE = {"topology": "full"}, {"topology": "ring"}, {"topology": "full", "message_delay": 10}
CLUSTERS = {"topology": "moving", "side": 2.0, "floor": {"clusters": 0.4}}


def errors(results):
    """A row a setting: median and tail of the error of honest robots, the brain, the kind of liar and their share."""
    table = sc.summary(results).rename(columns={"final_error": "error", "error_90": "tail"})
    table = table.fillna({"error": np.inf, "tail": np.inf})
    table["kind"] = table["adversary"].str.split("/").str[-1]
    table["share"] = (table["liars"] / table["robots"]).round(1)
    return table


def show(table, rows, brains):
    """Print means over settings of median errors, then of their tails; return both."""
    found = [table.pivot_table(each, rows, "brain", "mean", sort=False)[brains] for each in ("error", "tail")]
    for what, part in zip(("median error", "error_90"), found, strict=True):
        print(f"{what}:\n{part.round(4).to_string()}")
    return found


@harness.question
def kinds(figure=None):
    """The final error against the share of liars, a line a brain and a panel a kind: a minute on two cores."""
    study = sc.Study(
        trials=harness.trials(TRIALS),
        seed=13,
        swarm={"robots": 20, "accuracy": 0.625, "brain": BRAINS},
        members=[{"robots": SHARES, "brain": harness.few(KINDS), "honest": False}],
        world={"topology": GEOMETRIC, "fill_ratio": 0.55},
        schedule={"rounds": 500, "observations_per_round": 10},
    )
    table = errors(sc.run(study))
    found, far = show(table, ["kind", "share"], BRAINS)
    if not figure:
        return
    drawn, axes = harness.panels(2, 3, 7.2, 5.0)
    none = table[table["liars"] == 0].groupby("brain")[["error", "tail"]].mean()
    looks = harness.looks(BRAINS)
    for letter, one, kind in zip("abcdef", axes, harness.few(KINDS), strict=False):
        handles = []
        for brain, look in zip(BRAINS, looks, strict=True):
            tails = [none["tail"][brain], *(far.loc[(kind, share), brain] for share in SHARES[1:])]
            one.plot(100 * np.array(SHARES), tails, color=look.colour, ls=":", lw=1.1)
            values = [none["error"][brain], *(found.loc[(kind, share), brain] for share in SHARES[1:])]
            handles += one.plot(100 * np.array(SHARES), values, clip_on=False, **harness.line_of(look))
        one.set_title(f"({letter}) {kind}")
        one.set(yscale="log", ylim=(0.002, 2.0), xticks=[0, 10, 20, 30])
        harness.decimals(one.yaxis)
    for one in axes[3:]:
        one.set_xlabel("liars, % of 20 robots")
    for one in axes[::3]:
        one.set_ylabel("error: median, 90 % dotted")
    harness.save(drawn, figure, [look.name for look in looks], handles)


@harness.question
def cost(write=False):
    """The RMS error among each kind of liars to that of robots alone, on the worst of three networks. A minute."""
    brains = ["steadfast", "minimalistic", "alone"]
    study = sc.Study(
        trials=harness.trials(100),
        seed=13,
        swarm={"robots": 20, "accuracy": 0.75, "brain": brains},
        members=[{"robots": [0, 0.2, 0.4], "brain": harness.few(ALL_KINDS), "honest": False}],
        world={"topology": ["ring", "scale-free", "full"], "fill_ratio": 0.55},
        schedule={"rounds": 500, "observations_per_round": 10},
    )
    results = sc.run(study)
    table = errors(results)
    table["error"] = np.sqrt(((results["final_estimate"] - 0.55) ** 2).mean(["trial", "robot"]).values)
    table["kind"] = table["adversary"].str.removeprefix("adversaries/").replace("", "nobody lies")
    found = table.pivot_table("error", ["topology", "share", "kind"], "brain", sort=False)
    found = found.div(found["alone"], axis=0)[brains[:2]].groupby(["kind", "share"], sort=False).max()
    heads = ["liars", *(f"{brain} {share:.0%}" for brain in brains[:2] for share in (0.2, 0.4))]
    rows = []
    for kind in dict.fromkeys(found.index.get_level_values("kind")):
        shares = (0.0, 0.0) if kind == "nobody lies" else (0.2, 0.4)
        rows.append([kind, *(f"{found.loc[(kind, share), brain]:.2f}" for brain in brains[:2] for share in shares)])
    print(harness.markdown(heads, rows))
    if write:
        harness.write_csv("liars-cost", heads, rows)


def liars(brain, robots):
    """Members that lie."""
    return [{"robots": robots, "brain": brain, "honest": False}]


def insider(**lie):
    """A liar that knows the source of steadfast."""
    return {"file": census.INSIDER} | lie


INSIDERS = [
    insider(corner=1.5, from_r=5.0, second=1000.0, weight=1000.0),  # pulls R as far as it can
    insider(corner=2.2, from_r=5.0, second=1000.0, weight=1000.0, sides=1),
    insider(lean=1.5, from_r=3.5, second=2.5, sides=1),
    insider(lean=3.0, from_r=3.5, second=2.5, sides=1),
    insider(lean=3.1, from_r=4.5, second=2.5, sides=1, weight=10.7),
    insider(own=-0.057, lean=0.71, from_r=-3.8, second=-3.9, weight=958.0, sleeps=66.0),  # `tune`: studies/insider.toml
    insider(lean=2.0, from_r=3.5, second=2.5, weight=1000.0),
    insider(corner=1.0, from_r=3.9, second=2.5, weight=10.0),
    "opposite",
    {"file": "creeper", "step": 0.02},
]
BARS = {0.25: 1.05, 0.4: 1.2}  # shares of liars, and the bars of ratios to `alone`
MOVING = {"topology": "moving", "density": [1, 10]}
LOSSES = {"topology": ["full", "ring", "torus"], "robots": 25, "link_success": [0.3, 0.6]}
PLACES = [
    {"topology": ["full", "ring"], "robots": [4, 5, 10, 20, 50]},
    {"topology": "torus", "robots": [9, 25, 49]},
    {"topology": "scale-free", "robots": [4, 5, 10, 20, 50]},
    {"topology": "line", "robots": 8},
    LOSSES,
    MOVING | {"robots": [10, 20], "ticks": 3000},
]


@harness.question(unasked=False)
def insiders():
    """Liars that know steadfast, to robots alone: RMS with 95 % intervals, 95 % quantile, worst robot. Ten minutes."""
    rows = {bar: [] for bar in BARS.values()}
    for name, place in harness.few([*census.worlds(PLACES)]):
        keys = {"fill_ratio": 0.55} | place
        robots, ticks = keys.pop("robots"), keys.pop("ticks", None)
        study = sc.Study(
            trials=harness.trials(max(40, 1200 // robots)),
            seed=9173,
            swarm={"robots": robots, "accuracy": 0.75, "brain": ["steadfast", "alone"]},
            members=liars(INSIDERS, sorted({robots // 4, 2 * robots // 5})),
            world=keys,
            schedule={"ticks": ticks} if ticks else {"rounds": 300, "observations_per_round": 10},
        )
        results = sc.run(study, progress=False, cautions=False)
        off = abs(results["final_estimate"].values - 0.55)
        table = results[["brain", "adversary", "liars"]].to_dataframe().reset_index(drop=True)
        for (lie, lying), same in table.groupby(["adversary", "liars"], sort=False):
            honest = robots - lying
            mine, alone = (off[same.index[same["brain"] == each][0], :, :honest] for each in ("steadfast", "alone"))
            row = {"world": f"{name}, {lying} liars, {lie.rpartition('/')[2]}"} | census.ratio("RMS", mine, alone)
            row |= census.tails(mine, alone)
            rows[next(bar for share, bar in BARS.items() if lying <= share * robots)].append(row)
            print("  ".join(f"{cell:.2f}" if key != "world" else f"{cell:80}" for key, cell in row.items()), flush=True)
    for share, bar in BARS.items():
        census.within(f"steadfast, RMS to that alone among at most {share:.0%} liars:", rows[bar], "RMS", bar)


WORLDS = {  # what it is: our brain, one more, accuracy, world, members
    "2 of 20 say that all is black, full": ("commons", "steadfast", 0.625, FULL, liars("always-black", 2)),
    "messages 10 rounds late, full": ("commons", "swift", 0.625, LATE, []),
    "2 of 20 creep, full": ("steadfast", "commons", 0.625, FULL, liars("creeper", 2)),
    "black in clusters, moving": ("steadfast", "commons", 0.7, CLUSTERS, []),
    "6 of 20 told 0.55 for 0.75, full": (
        "self-taught", "commons", 0.75, FULL, [{"robots": 6, "assumed_accuracy": 0.55}]
    ),
    "f from 0.8 to 0.2 in rounds 301 to 1000, ring": (
        "tracking", FORGETFUL, 0.75, RING | {"fill_ratio": {"from": 0.8, "to": 0.2, "at": 301, "until": 1000}}, []
    ),
}  # fmt: skip


def errors_of(brains, accuracy, world, members):
    """The median error of each brain after the last round."""
    moving = world["topology"] == "moving"
    change = world.get("fill_ratio")
    length = 1000 if change else 500
    study = sc.Study(
        trials=harness.trials(100),
        seed=17,
        swarm={"robots": 20, "accuracy": accuracy, "brain": brains},
        members=members,
        world={"fill_ratio": 0.55} | world,
        schedule={"ticks": 3000} if moving else {"rounds": length, "observations_per_round": 10},
        measure={"truth": "floor"} if moving else {},
    )
    results = sc.run(study)
    truth = results["true_fill_ratio"] if moving else change["to"] if change else 0.55
    return abs(results["final_estimate"] - truth).median(["trial", "robot"]).values


def slow():
    """The share of robots more than 0.05 off, 700 rounds after f fell from 0.75 to 0.35, with poor sensors."""
    study = sc.Study(
        trials=harness.trials(100),
        seed=17,
        swarm={"robots": 20, "accuracy": 0.55, "brain": ["tracking", FORGETFUL]},
        world=RING | {"fill_ratio": {"from": 0.75, "to": 0.35, "at": 301}},
        schedule={"rounds": 1000, "observations_per_round": 10},
    )
    off = abs(sc.run(study)["final_estimate"] - 0.35) > 0.05
    ours, forgetful = off.mean(["trial", "robot"]).values
    print("700 rounds after f fell from 0.75 to 0.35, ring, accuracy 0.55, robots more than 0.05 off:", end=" ")
    print(f"tracking {ours:.0%}; forgetful, half = 30 {forgetful:.0%}")


@harness.question
def worse():
    """Worlds in which our brains are worse than the paper's, than a robot alone or than another. A minute."""
    np.seterr(invalid="ignore")
    print(f"{'world':46}{'brain':12}{'error':>8}{'minimalistic':>14}{'alone':>8}  another")
    for world, (ours, other, *rest) in WORLDS.items():
        mine, paper, alone, more = errors_of([ours, "minimalistic", "alone", other], *rest)
        name = other if isinstance(other, str) else "forgetful, half = 30"
        found = " ".join(f"{x:{width}.4f}" for x, width in ((mine, 8), (paper, 13), (alone, 7)))
        print(f"{world:46}{ours:12}{found}  {more:.4f} {name}".replace("nan", "inf"))
    slow()


if __name__ == "__main__":
    harness.answer(globals())
