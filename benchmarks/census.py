"""Is `census` near the best brain in every honest world, and what do liars cost `steadfast`? Both are judged by tails.

Errors are |final estimate - f| of all honest robots of all trials. Tables have their root mean square (RMS), and ratios
of RMS with 95 % intervals: trials are drawn again, the same ones for all brains, because they share their readings.
`worst` is the ratio of the RMS of each trial's worst robot; `q95` and `largest` are those of the 95 % quantile and of
the largest error. Other brains are tried on SEED + 1 to choose the best. No constant was chosen on these seeds.

All questions take half an hour to an hour on two cores, five to ten minutes with `--quick`. Without it, tables are also
written to benchmarks/census-*.csv. `honest --figure FILE` draws the ratios of all honest worlds.
"""

import csv
import itertools
import warnings
from pathlib import Path

import harness
import numpy as np

import swarmcensus as sc
from swarmcensus.figures.styles import halo
from swarmcensus.support.intervals import interval, means, resample

HERE = Path(__file__).parent
EXAMPLE = HERE.parent / "studies" / "example"
SEED = 7349
RIVALS = ("commons", "swift", "tracking", "consensus-innovations")
SIMPLE = ("minimalistic", "alone")
FORGETFUL = {"file": str(EXAMPLE / "forgetful.py"), "half": 30}
INSIDER = str(EXAMPLE / "insider.py")
TRIALS = (400, 200)  # of networks, of robots that move
NEAR, FAR, EARLY, CHANGED, WORST = 1.15, 1.3, 1.1, 1.3, 1.5  # bars of ratios
LYING = {0.2: 1.15, 0.4: 1.3}  # shares of liars, and the bars of ratios to `alone`

# Worlds are grids of keys of a study. A floor that changes is (from, to, at) or (from, to, at, until).
GRAPHS = {
    "tree": {"networkx": "barabasi_albert_graph", "m": 1},
    "small world": {"networkx": "watts_strogatz_graph", "k": 4, "p": 0.1},
}
HUBS = {"star": 1, "two hubs": 2}  # whom all others hear, each one of them
MEMBERS = {"two good": [{"robots": 2, "accuracy": 0.95}], "half useless": [{"robots": 0.5, "accuracy": 0.505}]}
FAILS = {"stop": ["sensing", "talking"]}
FAULTS = {
    "half join at 201": [{"at": 1, "until": 201, "robots": 0.5} | FAILS],
    "half fail at 101": [{"at": 101, "robots": 0.5} | FAILS],
    "half fail at 251": [{"at": 251, "robots": 0.5} | FAILS],
    "a tenth fails at 251": [{"at": 251, "robots": 0.1} | FAILS],
    "half pause at 101": [{"at": 101, "until": 201, "robots": 0.5, "stop": "talking"}],
    "the hub pauses at 101": [{"at": 101, "until": 201, "robots": {"named": [0]}, "stop": "talking"}],
    "a third is silent from 301": [{"at": 301, "robots": 1 / 3, "stop": "talking"}],
}
WORDS = {
    "robots": "N = ", "accuracy": "b = ", "fill_ratio": "f = ", "link_success": "links ", "message_delay": "late ",
    "density": "D = ", "share": "share ", "rounds": "rounds ",
}  # fmt: skip
MAIN = ["ring", "scale-free", "full"]
SPARSE = ["ring", "tree", "small world"]
MIXED = ["ring", "tree", "full"]
SPREAD = "U(0.525, 0.975)"
SLOW = {"topology": "moving", "robots": 100, "ticks": 10000, "density": [1, 10]}
FIXED = (
    {"topology": [*MAIN, "tree", "small world"]},
    {"topology": MAIN, "accuracy": [0.525, SPREAD], "fill_ratio": [0.55, 0.95]},
    {"topology": MAIN, "robots": 10},
    {"topology": [*SPARSE, "full"], "link_success": 0.1},
    {"topology": [*SPARSE, "full"], "message_delay": 10},
    SLOW | {"accuracy": [0.525, 0.875]},
    SLOW | {"accuracy": 0.875, "floor": [{"clusters": 0.4}, {"stripes": 0.5}]},
    {"topology": ["torus", "small-world"], "accuracy": 0.7, "fill_ratio": 0.35},
    {"topology": "random-geometric", "robots": [60, 100], "accuracy": 0.75},
    {"topology": ["ring", "full"], "robots": [5, 200], "accuracy": 0.7},
    {"topology": ["line", "tree", "grid"], "robots": 30, "accuracy": 0.7},
    {"topology": ["ring", "tree", "scale-free", "torus"], "robots": 300, "accuracy": 0.7},
    {"topology": MIXED, "robots": 50, "accuracy": 0.75, "fill_ratio": [0.02, 0.2, 0.98]},
    {"topology": MAIN[:2], "robots": 50, "accuracy": [{"black": 0.9, "white": 0.6}, {"black": 0.2, "white": 0.3}]},
    {"topology": "scale-free", "accuracy": 0.7, "link_success": 0.5},
    {"topology": ["scale-free", "full"], "accuracy": 0.7, "message_delay": 20},
    {"topology": MIXED, "faults": "half join at 201"},
    {"topology": "ring", "faults": "half fail at 101"},
    {"topology": MAIN[:2], "faults": ["half fail at 251", "a tenth fails at 251"]},
    {"topology": ["ring", "torus", "grid"], "robots": 25, "accuracy": 0.75, "faults": "half pause at 101"},
    {"topology": "star", "robots": 20, "accuracy": 0.75, "faults": "the hub pauses at 101"},
    {"topology": "star", "robots": [20, 100]},
    {"topology": "two hubs", "robots": 50},
    {"topology": MAIN, "message": ["ratio16", "ratio8"]},
    {"topology": MIXED, "robots": 30, "accuracy": 0.55, "members": "two good"},
    {"topology": ["ring", "full"], "robots": 50, "accuracy": 0.75, "members": "half useless"},
)
FIFTY = {"robots": 50, "accuracy": 0.75}
SOON = {"accuracy": 0.7, "fill_ratio": (0.75, 0.55, 101), "rounds": 300}
FALL = {"fill_ratio": (0.75, 0.45, 301)}
MOVING = {"topology": "moving", "ticks": 4000}
STRIPES = MOVING | {"density": 5, "floor": {"stripes": 0.5}}
JUMPS = [(0.75, 0.55, 301), (0.65, 0.55, 301), (0.6, 0.55, 301), (0.8, 0.2, 301, 900)]
CHANGING = (
    {"topology": MAIN, "fill_ratio": JUMPS},
    {"topology": "full", "robots": [10, 20], "fill_ratio": (0.6, 0.55, 301)},
    {"topology": "scale-free", "robots": [20, 100], "fill_ratio": (0.55, 0.45, 301)},
    {"topology": "star", "robots": [10, 20]} | SOON,
    {"topology": "full", "robots": 3} | SOON,
    {"topology": "ring", "robots": 5} | SOON,
    {"topology": ["ring", "small world"], "robots": 30, "link_success": 0.5} | SOON,
    {"topology": "full", "robots": 20, "accuracy": {"start": 0.6, "drift": 0.001, "most": 0.9}, "rounds": 300},
    {"topology": MAIN[:2], "fill_ratio": (0.75, 0.35, 301), "link_success": 0.2},
    MOVING | {"density": [1, 10], "fill_ratio": [(0.85, 0.25, 1201), (0.65, 0.55, 1201)]},
    {"topology": MAIN[:2], "message_delay": 10} | FALL,
    {"topology": "scale-free", "accuracy": SPREAD} | FALL,
    {"topology": "ring", "faults": "a third is silent from 301"} | FALL,
    STRIPES | {"fill_ratio": (0.75, 0.45, 1501)},
)
LIED_TO = (  # a fifth lies
    {"topology": MAIN[1:], "liars": ["always-black", "opposite", "creeper"]} | FALL,
    {"topology": "ring", "link_success": 0.2, "liars": "opposite"},
    {"topology": "ring", "message_delay": 10, "liars": "opposite"},
    {"topology": "scale-free", "faults": "a third is silent from 301", "liars": "opposite"},
    STRIPES | {"liars": "opposite"},
    MOVING | {"density": 5, "fill_ratio": (0.75, 0.45, 1501), "liars": "opposite"},
)
SHIPPED = "always-black always-white opposite random shouter slow-liar creeper noisy-mirror forger jammer"
INSIDERS = {
    "step 0.05 from 200 on": {"sleeps": 200.0, "step": 0.05},
    "all steps 0.05 from 200 on": {"sleeps": 200.0, "step": 0.05, "own": 0.05},
    "own step 0.02": {"own": 0.02},
    "own step 0.05": {"own": 0.05},
    "r + E": {"from_r": 1.0},
    "r + 2 E": {"from_r": 2.0},
    "r + 3 E": {"from_r": 3.0},
    "own readings 2 errors off, r + 3 E": {"lean": 2.0, "from_r": 3.0},
    "little evidence": {"weight": 1e-3, "step": 0.05},
    "much evidence": {"weight": 1e3, "step": 0.05},
    "repeats round 20": {"repeats": 20.0},
}
LIARS = {name: {"file": name} for name in SHIPPED.split()}
LIARS |= {f"creeper of {step}": {"file": "creeper", "step": step} for step in (0.002, 0.005, 0.02, 0.05)}
LIARS |= {f"insider, {name}": {"file": INSIDER} | lie for name, lie in INSIDERS.items()}
PARTS = {"no momentum": {"momentum": 0.0}, "no change found": {"z": 1e6, "lone": 1e6, "confirm": 1e6}}


def worlds(grids, **same):
    """The name and the keys of each world; names leave out what is the same in all."""
    for grid in grids:
        values = [value if isinstance(value, list) else [value] for value in grid.values()]
        for each in itertools.product(*values):
            world = dict(zip(grid, each, strict=True))
            yield ", ".join(word(key, value) for key, value in world.items() if key != "ticks"), same | world


def word(key, value):
    """What the name of a world says of a key."""
    if isinstance(value, tuple):
        value = f"{value[0]} to {value[1]}" + ", slowly" * (len(value) > 3)
    if isinstance(value, dict):
        value = " ".join(f"{name} {number}" for name, number in value.items())
    return f"{WORDS.get(key, '')}{value}"


def errors_of(world, brains, trials, points=(), seed=SEED):
    """By brain: errors of honest robots at points or the last round (point, trial, robot), and means of all rounds."""
    keys = {"robots": 100, "accuracy": 0.625, "fill_ratio": 0.55, "ticks": None, "rounds": 1000} | world
    swarm = {"robots": keys.pop("robots"), "accuracy": keys.pop("accuracy"), "brain": list(brains.values())}
    ticks, rounds, faults = keys.pop("ticks"), keys.pop("rounds"), FAULTS.get(keys.pop("faults", None), [])
    members, share = MEMBERS.get(keys.pop("members", None), []), keys.pop("share", 0.2)
    if "liars" in keys:
        members = [{"robots": share, "brain": LIARS[keys.pop("liars")], "honest": False}]
    if keys["topology"] in HUBS:
        hubs = HUBS[keys["topology"]]
        edges = [[k % hubs, k] for k in range(hubs, swarm["robots"])] + [[k - 1, k] for k in range(1, hubs)]
        keys["topology"] = {"name": keys["topology"], "edges": edges}
    else:
        keys["topology"] = GRAPHS.get(keys["topology"], keys["topology"])
    if isinstance(keys["fill_ratio"], tuple):
        keys["fill_ratio"] = dict(zip(("from", "to", "at", "until"), keys["fill_ratio"], strict=False))
    schedule = {"ticks": ticks} if ticks else {"rounds": rounds, "observations_per_round": 10}
    measure = {"estimates": True, "checkpoints": [*points] or [ticks or rounds], "metrics": ["mean-error"], "bins": 2}
    tables = {"swarm": swarm, "members": members, "world": keys, "faults": faults, "schedule": schedule}
    study = sc.Study(trials=trials, seed=seed, **tables, measure=measure)
    with warnings.catch_warnings(action="ignore"):  # where a shouter leaves no number
        results = sc.run(study, progress=False, cautions=False)
    found = {}
    for k, name in enumerate(brains):
        one = results.isel(setting=k)
        honest = int(one.get("honest", one.sizes["robot"]))
        errors = abs(one["estimates"].values[..., :honest] - float(one["fill_ratio"]))
        both = errors, one["mean_error"].values[:, :honest]
        found[name] = tuple(np.where(np.isnan(values), np.inf, values.astype(float)) for values in both)
    return found


def trials_of(world, quick):
    """How many trials; fewer where robots move."""
    return TRIALS["ticks" in world] // (8 if quick else 1)


def rms(values):
    """The root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def ratio(key, ours, theirs):
    """The cells of a ratio of RMS, of (trial, robot) each, and of the ends of its interval over trials."""
    counts = resample(len(ours))
    with np.errstate(invalid="ignore"):
        squares = means((ours**2).mean(1), counts) / means((theirs**2).mean(1), counts)
        return dict(zip((key, f"{key} low", f"{key} high"), interval(np.sqrt(squares)), strict=True))


def tails(ours, theirs):
    """The cells of the ratios of each trial's worst robot, of the 95 % quantiles and of the largest errors."""
    worst = ratio("worst", ours.max(1, keepdims=True), theirs.max(1, keepdims=True))
    return worst | {"q95": np.quantile(ours, 0.95) / np.quantile(theirs, 0.95), "largest": ours.max() / theirs.max()}


def table(name, title, rows):
    """Print rows as they come, and return them; without --quick also write them to a file."""
    print(f"\n{title}")
    found, lines = [], []
    for row in rows:
        cells = [cell if isinstance(cell, str) else f"{cell:.3g}" for cell in row.values()]
        widths = [68, *(max(len(key), 21 if "best" in key else 9) + 2 for key in list(row)[1:])]
        new = [cells] if found else [list(row), cells]
        for line in new:
            print("".join(map(str.ljust, line, widths)), flush=True)
        found.append(row)
        lines += new
    if not harness.IS_QUICK:
        with (HERE / f"census-{name}.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows(lines)
    return found


def within(what, rows, key, bar):
    """Say in how many worlds a ratio is within a bar, and name the others."""
    beyond = sorted((row for row in rows if not row[key] <= bar), key=lambda row: -row[key])
    clearly = sum(row[f"{key} low"] > bar for row in beyond)
    print(f"{what} at most {bar} in {len(rows) - len(beyond)} of {len(rows)}; above it with the interval in {clearly}")
    for row in beyond:
        print(f"    {row['world']}: {row[key]:.2f} [{row[f'{key} low']:.2f}, {row[f'{key} high']:.2f}]")


@harness.question
def honest(figure=None, quick=False):
    """Fixed floors: census, the best of other brains, and the simple brains at first."""
    rows = table("honest", "Honest robots, fixed floors", (judged(*each, quick) for each in worlds(FIXED)))
    for bar in (NEAR, FAR):
        within("census, RMS to the best of commons, swift, tracking and consensus-innovations:", rows, "ratio", bar)
    within("census, each trial's worst robot, to the same brain:", rows, "worst", WORST)
    within("census, RMS to the better of minimalistic and alone, the worst checkpoint:", rows, "early", EARLY)
    if figure:
        draw(rows, figure)


def judged(name, world, quick):
    """The row of a world of honest robots."""
    points = [20, 60, 200, 1000] if "ticks" not in world else [200, 600, 2000, world["ticks"]]
    found = errors_of(world, {brain: brain for brain in ("census", *RIVALS, *SIMPLE)}, trials_of(world, quick), points)
    errors = {brain: values for brain, (values, _) in found.items()}
    final = {brain: values[-1] for brain, values in errors.items()}
    chosen = errors_of(world, {brain: brain for brain in RIVALS}, trials_of(world, quick), points, SEED + 1)
    best = min(RIVALS, key=lambda brain: rms(chosen[brain][0][-1]))
    early = []
    for k, point in enumerate(points):
        better = min((errors[brain][k] for brain in SIMPLE), key=rms)
        early.append(ratio("early", errors["census"][k], better) | {"at": str(point)})
    row = {"world": name} | {brain: rms(values) for brain, values in final.items()} | {"best": best}
    row |= ratio("ratio", final["census"], final[best]) | tails(final["census"], final[best])
    return row | max(early, key=lambda cells: cells["early"])


@harness.question
def changes(quick=False):
    """Floors that change, with other difficulties too; and a fifth of liars with another difficulty, for steadfast."""
    for ours, grids, title in (("census", CHANGING, "Honest robots"), ("steadfast", LIED_TO, "A fifth lies")):
        title += ", floors that change and other difficulties, N = 50, b = 0.75"
        rows = table(f"changes-{ours}", title, (changed(ours, *each, quick) for each in worlds(grids, **FIFTY)))
        within(f"{ours}, final RMS to the best other:", rows, "ratio", CHANGED)
        within(f"{ours}, each trial's worst robot, to the same brain:", rows, "worst", WORST)
        within(f"{ours}, RMS of mean errors to the best other:", rows, "mean ratio", CHANGED)


def changed(ours, name, world, quick):
    """The row of a world: final errors, and the means of a robot's errors over all rounds."""
    brains = {ours: ours, "tracking": "tracking", "commons": "commons", "forgetful": FORGETFUL, "alone": "alone"}
    found, chosen = (errors_of(world, brains, trials_of(world, quick), seed=seed) for seed in (SEED, SEED + 1))
    row = {"world": name}
    for prefix, k in (("", 0), ("mean ", 1)):
        values = {brain: of_one[k].reshape(-1, of_one[k].shape[-1]) for brain, of_one in found.items()}
        row |= {prefix + brain: rms(each) for brain, each in values.items()}
        best = min((brain for brain in brains if brain != ours), key=lambda brain: rms(chosen[brain][k]))
        row |= {f"{prefix}best": best} | ratio(f"{prefix}ratio", values[ours], values[best])
        if not prefix:
            row |= tails(values[ours], values[best])
    return row


@harness.question
def liars(quick=False):
    """Liars and insiders: the RMS of honest robots to that of robots alone."""
    places = {"topology": MAIN}, MOVING | {"density": [1, 10]}
    grids = [place | {"liars": list(LIARS), "share": list(LYING)} for place in places]
    title = "Liars, 20 robots, b = 0.75: RMS, and ratios to that alone"
    rows = table("liars", title, (lied_to(*each, quick) for each in worlds(grids, robots=20, accuracy=0.75)))
    for share, bar in LYING.items():
        some = [row for row in rows if row["world"].endswith(f"{share}")]
        within(f"steadfast, RMS to that alone among {share:.0%} liars:", some, "steadfast", bar)


def lied_to(name, world, quick):
    """The row of a world with liars; insiders know steadfast alone."""
    others = ("census", "commons", "minimalistic")
    brains = ("steadfast", "alone", *(() if "insider" in name else others))
    found = errors_of(world, {brain: brain for brain in brains}, trials_of(world, quick))
    final = {brain: errors[-1] for brain, (errors, _) in found.items()}
    alone = final["alone"]
    row = {"world": name, "alone": rms(alone)}
    row |= ratio("steadfast", final["steadfast"], alone) | tails(final["steadfast"], alone)
    return row | {brain: rms(final[brain]) / rms(alone) if brain in final else np.nan for brain in others}


@harness.question
def parts(quick=False):
    """What a part of census costs and buys: RMS without it, to that with all."""
    table("parts", "Census without a part, N = 100, b = 0.75: RMS, and ratios to that of census", without(quick))


def without(quick):
    """A row for each part and world."""
    brains = {"all": "census"} | {part: {"file": "census"} | values for part, values in PARTS.items()}
    for name, world in worlds([{"topology": MAIN, "fill_ratio": [0.55, (0.65, 0.55, 301)]}], accuracy=0.75):
        found = errors_of(world, brains, trials_of(world, quick))
        for part in PARTS:
            ours, theirs = found[part], found["all"]
            row = {"world": f"{name}: {part}", "final": rms(ours[0]), "mean": rms(ours[1])}
            yield row | ratio("ratio", ours[0][-1], theirs[0][-1]) | ratio("mean ratio", ours[1], theirs[1])


def draw(rows, path):
    """A point a world in a row a brain: its RMS to that of the best of four brains."""
    figure, (axes,) = harness.panels(1, 1, 7.2, 3.4)
    random, labels = np.random.default_rng(1), []
    brains = "census", *RIVALS, "minimalistic"
    for k, (brain, look) in enumerate(zip(brains, harness.looks(brains), strict=True)):
        ratios = np.array([row[brain] / row[row["best"]] for row in rows])
        heights = k + random.uniform(-0.3, 0.3, len(rows))
        axes.plot(ratios, heights, look.marker, color=look.colour, ms=5, alpha=0.6, mec="white", mew=0.4)
        worst = ratios.argmax()
        axes.text(1.1 * ratios[worst], heights[worst], rows[worst]["world"], va="center", size=8, path_effects=halo(2))
        labels.append(f"{look.name}\n{np.sum(ratios <= NEAR)} of {len(rows)} within {NEAR}")
    for bar in (1.0, NEAR, FAR):
        axes.axvline(bar, color="0.6", lw=0.8, ls=":" if bar > 1.0 else "-", zorder=0)
    axes.set(
        xscale="log",
        xlabel="RMS error to the best of commons, swift, tracking and consensus-innovations; a point is a world",
    )
    axes.set_xticks([0.5, 1.0, NEAR, FAR, 2.0, 5.0, 10.0, 20.0, 50.0], [0.5, 1, "", FAR, 2, 5, 10, 20, 50])
    axes.minorticks_off()
    axes.set_yticks(range(len(labels)), labels)
    axes.invert_yaxis()
    harness.write_small(figure, path)


if __name__ == "__main__":
    harness.answer(globals())
