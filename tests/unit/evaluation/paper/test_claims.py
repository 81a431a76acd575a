"""Claims on made-up worlds in which they hold, fail, or cannot be told."""

import functools

import numpy as np
import pytest
import xarray as xr

from swarmcensus import brains
from swarmcensus.checks import minimalism
from swarmcensus.evaluation.paper import explanations, measures
from swarmcensus.evaluation.paper.evaluations import PAPER
from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, NO, OPEN, UNMEASURED, YES, Evidence, check
from swarmcensus.support import intervals

KNOWN = {claim.id: claim for claim in PAPER.claims}
CHECKPOINTS = np.array([10, 50, 100, 200, 500, 1000])
QUALITY = {accuracy: float(accuracy) for accuracy in measures.NUMBERS} | {measures.MIXED: 0.75}
SPEED = {"full": 0.2, "ring": 1.0, "line": 1.0, "scale-free": 1.1, "moving": 1.2}
ONES = {"K": 1.0, "error": 1.0, "local": 1.0, "spread": 0.0, "right": 1.0, "noise": 0.05, "wrong": 0}


@pytest.fixture(scope="module", autouse=True)
def medians_once():
    """Most settings are the same in many worlds: their medians are computed once."""
    found, medians = {}, intervals.medians

    def kept(values, counts):
        key = values.shape, values.tobytes(), counts.shape  # of so many trials, the same resamples
        if key not in found:
            found[key] = medians(values, counts)
        return found[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(intervals, "medians", kept)
        yield


def as_it_is(**setting):
    return {}


def world(*names, twist=as_it_is, trials=30):
    """Datasets of a world that is as the paper says; `twist(setting)` returns what is otherwise in a setting."""
    return {name: dataset(name, twist, trials) for name in names}


@functools.cache
def dataset(study, twist, trials):
    topologies = {"topologies": measures.TOPOLOGIES, "local": ("full",), "moving": ("moving",)}
    sizes = {"topologies": (10, 100), "moving": (25,)}
    settings = [
        {"study": study, "topology": t, "robots": n, "density": density, "accuracy": a, "f": f}
        for t in topologies.get(study, ("scale-free",))
        for n in sizes.get(study, (100,))
        for density in ((1.0, 10.0) if study == "moving" else (np.nan,))
        for a in measures.ALL
        for f in measures.FILLS
    ]
    data = {name: np.full((len(settings), trials, 100), np.nan) for name in (*VARIABLES, *LOCAL)}
    correct = np.empty((len(settings), len(CHECKPOINTS), trials))
    for i, setting in enumerate(settings):
        now = tuple((ONES | twist(**setting)).items())
        given = (setting[key] for key in ("study", "topology", "robots", "density", "accuracy", "f"))
        # settings that differ in topology alone meet the same luck
        columns, correct[i] = lived(i % 22, trials, now, *given)
        for name, column in columns.items():
            data[name][i, :, : setting["robots"]] = column
    columns = {"topology": "topology", "robots": "robots", "density": "density", "accuracy": "accuracy"}
    coords = {n: ("setting", [s[key] for s in settings]) for n, key in (columns | {"fill_ratio": "f"}).items()}
    kept = VARIABLES + (LOCAL if study == "local" else ())
    return xr.Dataset(
        {name: (("setting", "trial", "robot"), data[name]) for name in kept}
        | {"correct": (("setting", "checkpoint", "trial"), correct)},
        coords | {"checkpoint": CHECKPOINTS * (10 if study in ("moving", "same-observations") else 1)},
    )


@functools.cache
def lived(seed, trials, now, study, topology, n, density, accuracy, f):
    """What a setting's robots have, (trial, robot), and how many are right, (checkpoint, trial)."""
    now, quality = dict(now), QUALITY[accuracy]
    rng = np.random.default_rng(seed)
    draws = np.exp(now["noise"] * (rng.normal(size=(trials, 1)) + 0.2 * rng.normal(size=(trials, n))))
    easy = (0.8 if f == 0.95 else 1) * (0.9 if density == 10 else 1)
    slow = np.exp(-4 * (quality - 0.5)) * SPEED[topology] * easy
    unit = {"same-observations": 10, "same-rounds": 1.5, "moving": 10}.get(study, 1)
    error = 0.04 * np.exp(-5 * (quality - 0.5)) * easy * draws
    final = np.broadcast_to(f + now["spread"] * np.linspace(0, 1, n), (trials, n)).copy()
    final[:, : now["wrong"]] = 0.05  # in no bin of f
    wrong = np.array([0.5, 0.2, 0.1, 0.05, 0.01, 0]) * slow
    return {
        "convergence_round": 400 * slow * unit * now["K"] * draws,
        "convergence_error": error * now["error"],
        "final_estimate": final,
        "local_convergence_step": 4000 * slow * 10 * draws,
        "local_convergence_error": error * 1.5 * now["local"],
    }, now["right"] * (1 - np.round(wrong * n * draws.mean(1)[:, None]) / n).T


VARIABLES = ("convergence_round", "convergence_error", "final_estimate")
LOCAL = ("local_convergence_step", "local_convergence_error")


def verdict(name, twist=as_it_is, trials=30):
    (outcome,) = check(world(*KNOWN[name].studies, twist=twist, trials=trials), [KNOWN[name]])
    return outcome


def only(where, **changes):
    """A twist of those settings alone for which `where` is true."""
    return lambda **setting: changes if where(**setting) else {}


def quiet(where, **changes):
    """The same, in a world without chance."""
    return lambda **setting: {"noise": 0} | (changes if where(**setting) else {})


def one(topology, accuracy="0.775", f=0.55):
    return lambda **s: (s["topology"], s["accuracy"], s["f"]) == (topology, accuracy, f)


def mixed(f):
    return lambda **s: s["accuracy"] == measures.MIXED and s["f"] == f


def mover(accuracy="0.775", f=0.55, density=10.0):
    return lambda **s: (s["topology"], s["accuracy"], s["f"], s["density"]) == ("moving", accuracy, f, density)


def study(name, accuracy="0.775"):
    return lambda **s: s["study"] == name and s["accuracy"] == accuracy


def backwards(topology, accuracy, f, density, **_):
    """On the ring, and in crowds that move, better sensors converge later at f = 0.55."""
    there = topology == "ring" or density == 10
    return {"K": np.exp(8 * QUALITY[accuracy])} if there and f == 0.55 else {}


def hurts_poor(study, topology, accuracy, **_):
    """On the ring, robots with poor sensors do worse in company than alone."""
    return {"error": 5.0} if (study, topology) == ("topologies", "ring") and QUALITY[accuracy] < 0.75 else {}


FAILING = {
    "low-error-055": only(one("ring"), error=20),
    "low-error-095": only(one("scale-free", f=0.95), error=20),
    "full-agrees": only(one("full"), spread=1e-6),
    "full-first": only(one("full"), K=7),
    "ring-like-line": only(one("line"), error=1.5),
    "informed-first": only(one("ring"), K=12),
    "helps-poor": hurts_poor,
    "grows": backwards,
    "mixed-055": only(mixed(0.55), K=0.5),
    "mixed-095": only(mixed(0.95), error=1.6),
    "blacker-first-sparse": only(one("ring", f=0.95), K=2),
    "blacker-first-full": only(one("full", f=0.95), K=2),
    "same-observations": only(study("same-observations"), K=1.5),
    "same-rounds": only(study("same-rounds"), K=0.3),
    "consensus": only(one("scale-free", "0.675"), right=0.999),
    "sooner-right": only(lambda topology, f, **_: (topology, f) == ("ring", 0.55), right=0.9),
    "denser-first": only(mover(), K=1.5),
    "denser-alike": only(mover(), error=0.5),
    "blacker-first-moving": only(mover(f=0.95), K=1.5),
    "blacker-closer-moving": only(mover(f=0.95), error=1.5),
    "grows-moving": backwards,
    "impaired-moving": only(mover("0.625"), error=20),
    "consensus-moving": only(mover("0.675", density=1), right=0.999),
    "mixed-consensus-moving": only(mover(measures.MIXED, density=1), right=0.96, wrong=1),
    "mixed-sooner-moving": only(mover(measures.MIXED, density=1), right=0.5),
    "like-tree-moving": only(mover(density=1), right=0.7),
}
EXPLAINED = {"mixed-055", "mixed-095", "blacker-first-full", "denser-first", "denser-alike", "mixed-consensus-moving"}


@pytest.mark.long(but_every=4)
@pytest.mark.parametrize("name", FAILING)
def test_a_claim_holds_where_the_world_is_as_the_paper_says(name):
    outcome = verdict(name)
    assert outcome.verdict == HOLDS
    assert outcome.count(YES) == len(outcome.details) > 0
    assert outcome.worst in outcome.details
    assert not outcome.explanation


@pytest.mark.long(but_every=4)
@pytest.mark.parametrize("name", FAILING)
def test_one_wrong_setting_refutes_a_claim(name):
    outcome = verdict(name, FAILING[name])
    assert outcome.verdict == FAILS
    assert 1 <= outcome.count(NO) < len(outcome.details)
    assert outcome.worst.verdict == NO
    assert bool(outcome.explanation) == (name in EXPLAINED)


@pytest.mark.parametrize("name", sorted(set(FAILING) - {"full-agrees"}))
def test_few_trials_decide_nothing_that_is_random(name):
    trials = intervals.FEWEST - 1
    assert verdict(name, trials=trials).verdict == f"not decided by {trials} trials"


def test_explanations_have_the_numbers_of_their_settings():
    early = why("mixed-095", quiet(mixed(0.95), K=0.5))
    assert "ahead in 4 settings, by 50.0 % (convergence, full;" in early
    assert "behind in none" in early
    late = why("mixed-055", quiet(mixed(0.55), K=1.6, error=1.5))
    assert "ahead in none and behind in 8 settings, by 50.0 to 60.0 %" in late
    note = verdict("grows", only(one("ring", "0.725"), K=1.5)).note
    assert note == "Of 72 single steps of accuracy, 1 slow the swarm: ring, f = 0.55, 0.675 to 0.725."


def test_moving_robots_are_compared_after_as_many_observations():
    """Their decisions with those at R = 10, and with no others."""
    assert verdict("like-tree-moving", only(lambda study, **_: study == "same-observations", right=0.1)).holds
    assert verdict("like-tree-moving", only(lambda study, **_: study == "topologies", right=0.1)).holds is False


NEAR = {  # at the threshold, and noisy
    "full-first": only(one("full"), K=5, noise=0.3),
    "same-observations": only(study("same-observations"), error=0.8, noise=0.3),
    "denser-first": only(mover(), K=1 / 0.9, noise=0.3),
}


@pytest.mark.parametrize("name", NEAR)
def test_a_setting_near_the_threshold_leaves_a_claim_undecided(name):
    outcome = verdict(name, NEAR[name])
    assert outcome.verdict == "not decided by 30 trials"
    assert (outcome.count(OPEN) >= 1, outcome.count(NO), outcome.worst.verdict) == (True, 0, OPEN)


def test_pairs_use_trials_that_both_have_and_a_quotient_by_zero_decides_nothing():
    evidence = Evidence(world("topologies") | world("local", trials=20))
    assert evidence.trials == 20
    nothing = measures.ratio(np.ones(1001), np.zeros(1001))
    assert evidence.judge("", nothing, (-np.inf, 1.0)).verdict == OPEN


def test_one_wrong_robot_refutes_consensus():
    assert verdict("consensus", trials=29).verdict == "not decided by 29 trials"
    assert verdict("consensus", FAILING["consensus"], trials=1).verdict == FAILS
    assert verdict("consensus", only(one("scale-free", "0.625"), right=0.5)).verdict == HOLDS


def why(name, twist):
    return verdict(name, twist).explanation


def test_late_settling_on_a_black_floor_is_bias():
    poor = why("blacker-first-full", quiet(one("full", "0.575", f=0.95), K=4))
    rounds = 400 * np.exp(-0.3) * 0.2
    assert f"after a median of {rounds * 0.8 * 4:g} rounds, not {rounds:g}" in poor
    early, late = (explanations.agreed_bias(0.575, 0.95, round(10 * k)) for k in (rounds, rounds * 3.2))
    assert f"off by {early[0]:+.3f} at f = 0.95 after {round(10 * rounds):,} observations" in poor
    assert f"it is off by {late[0]:+.3f}. The swarm settles as this fades. In a sparse network" in poor


@pytest.mark.parametrize(("accuracy", "fill", "looks"), [(0.525, 0.95, 100), (0.875, 0.55, 40), (0.975, 0.95, 1)])
def test_the_bias_of_a_large_swarm_is_that_of_many_robots(accuracy, fill, looks):
    """A million robots: the estimate of the bias has a standard error below 0.0005, and a share's is no more."""
    rng = np.random.default_rng(6)
    blacks = rng.binomial(looks, accuracy * fill + (1 - accuracy) * (1 - fill), 10**6)
    brain = brains.load("minimalistic")
    table = np.empty((looks + 1, 2))
    for n in range(looks + 1):
        me = brain.robot(accuracy, accuracy)
        brain.functions.observe(me, float(n), float(looks))
        table[n] = me.x_hat, me.alpha
    x, weight = table[blacks].T
    bias, cut = explanations.agreed_bias(accuracy, fill, looks)
    assert bias == pytest.approx((x * weight).sum() / weight.sum() - fill, abs=0.002)
    assert cut == pytest.approx(np.isin(x, (0, 1)).mean(), abs=0.002)


def test_the_worth_of_a_swarm_is_its_mean_information():
    assert explanations.worth(np.array([0.7]), 0.95) == pytest.approx(0.7)
    two = explanations.worth(np.array([0.6, 0.9]), 0.8)
    black, slope = lambda b: b * 0.8 + (1 - b) * 0.2, lambda b: 2 * b - 1
    carried = [slope(b) ** 2 / (black(b) * (1 - black(b))) for b in (0.6, 0.9, two)]
    assert carried[2] == pytest.approx(np.mean(carried[:2]))


def test_all_that_is_missing_is_not_measured():
    assert {o.verdict for o in check({}, PAPER.claims) if o.claim.studies} == {UNMEASURED}
    data = world("topologies")["topologies"]
    without = {"topologies": data.isel(setting=(data.topology != "ring").values)}
    assert check(without, [KNOWN["low-error-055"]])[0].verdict == UNMEASURED
    assert check(without, [KNOWN["consensus"]])[0].verdict == HOLDS
    unfinished = data.copy(deep=True)
    unfinished["convergence_error"][{"trial": 3}] = np.nan
    assert check({"topologies": unfinished}, [KNOWN["low-error-055"]])[0].verdict == UNMEASURED
    twice = {"topologies": xr.concat([data, data], "setting")}
    assert check(twice, [KNOWN["low-error-055"]])[0].verdict == UNMEASURED


def test_growing_memory_is_found(monkeypatch, tmp_path):
    assert verdict("minimal").verdict == HOLDS
    slow = brains.load("minimalistic").source.replace(
        "    me.t += looks\n", "    me.t += looks\n    k = 1.0\n    while k < me.t:\n        k *= 2.0\n"
    )
    brain = brains.parse(slow, "slow", tmp_path / "slow.py")
    lines = [each["observe"] for each in minimalism.footprints(brain).values()]
    assert len(set(lines)) == len(minimalism.AGES)
    monkeypatch.setattr(measures.brains, "load", lambda _: brain)
    outcome = verdict("minimal")
    assert outcome.verdict == FAILS
    assert [d.setting.split(",")[0] for d in outcome.details if d.verdict == NO] == ["observe"]
