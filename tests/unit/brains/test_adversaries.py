"""Adversaries: what each says by hand, whatever it wears, and composed brains held against the engine."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains import adversary
from swarmcensus.brains.adversary_source import HELPERS, VALUES
from swarmcensus.cli.commands import main
from swarmcensus.engine.constants import HEARD, SENT
from swarmcensus.simulation import sampling
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import run_batch
from swarmcensus.support.errors import InputError
from tests.reference import walks as reference_walks
from tests.support.lives import MEASURE, lived
from tests.support.lying import RICH, adversary_of, liars, robot, wrapped
from tests.support.second import brain, changed, fixed, moving
from tests.support.small import FAULTS, GO, SEED, failing, study_of
from tests.support.trials import record_ride

NAMES = adversary.PLUGINS.shipped


def rounds(used, me, draws):
    """One round after the other, in which nobody is heard, with this luck."""
    said = []
    for one in draws:
        said.append(used.functions.broadcast(me))
        if used.uses.luck:
            me.luck = one
        used.functions.fuse(me)
    return said


@pytest.mark.interpreted
@pytest.mark.long(but=["commons"])
@pytest.mark.parametrize("name", [name for name in brains.shipped() if not brains.load(name).is_oracle])
def test_estimates_stay_numbers_among_shouters_that_exaggerate_without_end(name):
    """Shouters raise one another's confidence beyond the largest float; no other adversary changes it."""
    if not {*brains.load(name).roles.values()} & {*VALUES}:
        pytest.skip("it says nothing about which to lie")
    study = study_of(name, 10, 0.8, rounds=200, looks=1, trials=1, topology="full", fill_ratio=0.7,
                     members=[{"robots": 0.2, "brain": "shouter", "honest": False}])  # fmt: skip
    results = sc.run(study, jobs=1, cautions=False)
    assert results["final_estimate"].sel(robot=slice(7)).values.min() >= 0.0


# ---- by hand, as CPython runs them
@pytest.mark.parametrize(("name", "given", "told"), [
    ("always-black", {}, lambda x, alpha: (1.0, alpha)),
    ("always-white", {}, lambda x, alpha: (0.0, alpha)),
    ("opposite", {}, lambda x, alpha: (1.0 - x, alpha)),
    ("shouter", {}, lambda x, alpha: (0.0 if x >= 0.5 else 1.0, 1000.0 * (alpha + 1.0))),
    ("shouter", {"loud": 3.0}, lambda x, alpha: (0.0 if x >= 0.5 else 1.0, 3.0 * (alpha + 1.0))),
    ("forger", {"value": 0.25}, lambda x, alpha: (0.25, alpha)),
    ("jammer", {}, lambda x, alpha: (x, alpha)),
    ("random", {}, lambda x, alpha: (x, alpha)),  # before the first toss
    ("noisy-mirror", {}, lambda x, alpha: (x, alpha)),  # it has heard nothing
    ("slow-liar", {}, lambda x, alpha: (x, alpha)),  # not yet
    ("creeper", {}, lambda x, alpha: (min(x + 0.01, 1.0), alpha)),
    ("creeper", {"step": 0.25, "goal": 0.5}, lambda x, alpha: (x + min(max(0.5 - x, -0.25), 0.25), alpha)),
])  # fmt: skip
@pytest.mark.parametrize("blacks", [0, 3, 7, 10])
def test_what_is_said_in_the_first_round(name, given, told, blacks):
    """Estimate and confidence by the formulas: x = (n/t + w - 1)/(b + w - 1), alpha = q t^3 / (n (t - n))."""
    used, honest = wrapped(name, **given), brains.load("minimalistic")
    x, alpha = honest.functions.broadcast(robot(honest, blacks, 10))
    if 3 <= blacks <= 7:
        assert x == pytest.approx((blacks / 10 + 0.8 - 1) / 0.7)
        assert alpha == pytest.approx(0.49 * 1000 / (blacks * (10 - blacks)))
    assert used.functions.broadcast(robot(used, blacks, 10)) == pytest.approx(told(x, alpha))


def own(draws):
    """What an adversary sees of luck: all but its 20 highest bits."""
    return draws * 2**20 % 1.0


def test_a_coin_is_tossed_each_round():
    draws = [0.1 + 0.3 / 2**20, 0.9 + 0.8 / 2**20, 0.5 + 1 / 2**53, (7 + 0.49) / 2**20, (8 + 0.51) / 2**20]
    used, even = wrapped("random"), wrapped("random", uniform=1.0)
    x = (0.7 + 0.8 - 1) / 0.7
    said = [one[0] for one in rounds(used, robot(used, 7, 10), [*draws, 0.5])]
    assert said == [pytest.approx(x), *(1.0 if own(u) >= 0.5 else 0.0 for u in draws)]
    said = [one[0] for one in rounds(even, robot(even, 7, 10), [*draws, 0.5])]
    assert said == [pytest.approx(x), *(own(u) for u in draws)]


def test_mirror_repeats_the_mean_it_heard():
    used = wrapped("noisy-mirror", noise=0.1)
    me = robot(used, 7, 10)
    for x in (0.2, 0.3, 0.7):
        used.functions.receive(me, (x, 5.0))
    me.luck = 0.75
    used.functions.fuse(me)
    mean = 0.4 + 0.1 * (2.0 * own(0.75) - 1.0)
    assert used.functions.broadcast(me)[0] == pytest.approx(mean)
    used.functions.fuse(me)
    assert used.functions.broadcast(me)[0] == pytest.approx(mean)


def test_a_forger_has_another_name_each_round():
    used = wrapped("forger", by=brain(RICH), names=50.0)
    me = robot(used, 6, 8)
    draws = [(k + own_draws) / 2**20 for k, own_draws in enumerate((0.1, 0.5, 0.99, 0.0001))]
    assert [one[0] for one in rounds(used, me, [*draws, 0.5])] == [3.0, 5.0, 25.0, 49.0, 0.0]


def test_a_jammer_jams_as_often_as_its_parameter_says():
    used = wrapped("jammer", often=0.3)
    me, honest = robot(used, 7, 10), brains.load("minimalistic")
    assert used.functions.jam(me)  # in the first round, if ever
    for draws in ((7 + 0.29) / 2**20, (8 + 0.31) / 2**20):
        me.luck = draws
        used.functions.fuse(me)
        assert used.functions.jam(me) == (own(draws) < 0.3)
    assert used.functions.broadcast(me) == honest.functions.broadcast(robot(honest, 7, 10))
    assert not wrapped("jammer", often=0.0).functions.jam(me)


def test_each_field_is_lied_about_by_what_it_means():
    """3 of 4 are black: x = 0.75, vote 1, bin 3, belief on bin 2, confidence 2, information 1.5; t is said as it is."""
    spare = 1e-6 / 3
    first, last = (1.0 - 1e-6, spare, spare, spare), (spare, spare, spare, 1.0 - 1e-6)
    expected = {
        "always-black": (3.0, 1.0, 1.0, 3.0, last, 2.0, 2.0, 4.0),
        "always-white": (3.0, 0.0, 0.0, 0.0, first, 2.0, 0.0, 4.0),
        "opposite": (3.0, 0.25, 0.0, 0.0, (spare, first[0], spare, spare), 2.0, 0.5, 4.0),
        "shouter": (3.0, 0.0, 0.0, 0.0, first, 3000.0, 0.0, 4.0),
        "forger": (own(0.25) * 1e6, 1.0, 1.0, 3.0, last, 2.0, 2.0, 4.0),
        "jammer": (3.0, 0.75, 1.0, 3.0, (spare, spare, first[0], spare), 2.0, 1.5, 4.0),
    }
    for name, told in expected.items():
        used = wrapped(name, by=brain(RICH))
        me = robot(used, 3, 4)
        me.luck = 0.25
        used.functions.fuse(me)
        found = used.functions.broadcast(me)
        assert len(found) == 8
        for one, other in zip(found, told, strict=True):
            assert one == pytest.approx(other, abs=1e-12), name


# ---- one source of two
@pytest.mark.parametrize(("source", "said"), [
    ("def boast(me, c):\n    return c\n", "the function lie is missing"),
    ("def lie(me):\n    return 1.0\n", "lie: the number of its arguments should be 2, not 1"),
    ("def lie(me, x):\n    me.y = 1.0\n    return x\n", "line 2: lie uses me.y"),
    ("def lie(me, x):\n    return me.luck\n", "lie reads me.luck, which is new only in hear and plot"),
    ("def lie(me, x):\n    return x\n\n\ndef jam(me):\n    pass\n", "jam may end without returning anything"),
    ("def lie(me, x):\n    return x\n\n\ndef boasts(me, c):\n    return c\n", "did you mean 'boast'?"),
    ('MESSAGE = ("x",)\n\n\ndef lie(me, x):\n    return x', "MESSAGE belongs to the brain that the adversary"),
    ('PARAMETERS = {"p": 1.0}\n\n\ndef lie(me, x):\n    me.p = 2.0\n    return x\n', "lie sets me.p: parameters"),
    ("import os\n\n\ndef lie(me, x):\n    return x\n", "an adversary may import only math"),
    ("def lie(me, x):\n    pow = eval\n    return pow(x, 2)", "line 2: lie uses eval: an adversary may call its"),
    ("def lie(me, x):\n    return lie(me, x)\n", "line 2: lie calls itself: functions of an adversary may not"),
])  # fmt: skip
def test_what_is_no_adversary_is_refused(source, said):
    with pytest.raises(InputError, match=r"^adversary file liar\.py") as error:
        adversary_of(source)
    assert said in str(error.value)


# ---- names of one, that the other, Python or what is written between them has too
@pytest.mark.parametrize("name", [*HELPERS, "tell"])
def test_a_helper_may_be_called_as_a_written_function_is(name):
    """3 of 4 are black, and a quarter is told of 0.75, of a vote for 1, and of the last of four bins, 0.875."""
    lies = adversary_of(f"def {name}(x):\n    return x * 0.25\n\n\ndef lie(me, x):\n    return {name}(x)\n")
    used = brains.lying_brain(lies, brain(RICH))
    _, x, vote, chosen, belief, sure, known, _ = used.functions.broadcast(robot(used, 3, 4))
    assert (x, vote, chosen, sure, known) == (0.1875, 0.0, 0.0, 2.0, 0.375)
    assert belief[0] == pytest.approx(1.0 - 1e-6)  # of a belief that is even


@pytest.mark.parametrize(("own", "use", "lie", "told"), [
    ("def abs(x):\n    return 0.125\n", "abs(1.0)", "abs(x - 1.0)", 0.25),
    ("from math import floor as int\n", "int(-0.5)", "0.5 + 0.25 * int(x - 1.0)", 0.5),
    ("from math import pow\n", "pow(2, 70)", "pow(2, 70) % 2 + (pow(2, 70) + 1) % 2 * 0.5", 0.5),
    ("math = 0.25\n", "math", "math.sqrt(0.25) * x", 0.375),
], ids=["abs", "int", "pow", "math"])  # fmt: skip
def test_a_brain_may_have_names_of_its_own_that_python_has(own, use, lie, told):
    """3 of 4 are black: 0.75, of which Python's function is told; the brain goes on using its own."""
    fuse = "def fuse(me):\n    "
    memory = "MEMORY = {"
    source = changed((memory, own + memory + '"own": 0.0, '), (fuse + "pass", f"{fuse}me.own = {use}"))
    lies = adversary_of(f"import math\n\n\ndef lie(me, x):\n    return {lie}\n")
    used, honest = brains.lying_brain(lies, brain(source)), brain(source)
    me, other = robot(used, 3, 4), robot(honest, 3, 4)
    for one, state in ((used, me), (honest, other)):
        one.functions.fuse(state)
    assert used.functions.broadcast(me) == (told,)
    assert (me.own, type(me.own)) == (other.own, type(other.own))


SILENT = {  # the end of a `broadcast` that is silent unless it has seen more than one black
    "a number": "return maybe(me.n)\n\n\ndef maybe(n):\n    return None if n <= 1.0 else (0.75,)",
    "a number, and the record": "return maybe(me.n, me)\n\n\ndef maybe(n, me):\n    if n <= 1.0:\n"
    "        return None\n    return (estimate(me),)",
    "set by turns": "said = None\n    if me.n > 1.0:\n        said = (estimate(me),)\n    return said",
    "no end": "if me.n > 1.0:\n        return (estimate(me),)",
}


@pytest.mark.parametrize("ends", SILENT.values(), ids=SILENT)
def test_however_silence_is_said_it_is_kept(ends):
    heard = ("    pass\n\n\ndef fuse", "    me.heard += message[0]\n\n\ndef fuse")
    source = changed(("return (estimate(me),)", ends), heard, ('"n": 0.0}', '"n": 0.0, "heard": 0.0}'))
    used = wrapped("forger", by=brain(source), value=0.25)
    assert used.uses.silence
    assert used.functions.broadcast(robot(used, 1, 4)) is None
    assert used.functions.broadcast(robot(used, 3, 4)) == (0.25,)


@pytest.mark.interpreted
@pytest.mark.long(but=["minimalistic", "commons", "voter", "w-msr"])
@pytest.mark.parametrize("by", [name for name in brains.shipped() if name != "oracle"])
def test_each_wears_every_shipped_brain(by):
    """It sees, hears and keeps silent as its honest twin does, who hears the same three; what is told is in range. Of
    every brain, because each has words of its own about which adversaries lie."""
    honest = brains.load(by)
    for name in NAMES:
        used = wrapped(name, by=by)
        random = np.random.default_rng(SEED)
        brain_of = [honest, honest, honest, honest, used]
        states = [one.robot(0.9, 0.8, float(min(k, 3))) for k, one in enumerate(brain_of)]
        for _ in range(30):
            blacks, draws = random.integers(0, 6, 4).tolist(), random.random((4, 5)).tolist()
            said = [one.functions.broadcast(me) for one, me in zip(brain_of, states, strict=True)]
            assert (said[3] is None) == (said[4] is None)
            for part, field in zip(said[4] or (), honest.message if said[4] else (), strict=True):
                whole = list(part) if honest.message[field] else [part]
                assert np.isfinite(whole).all()
                if name.startswith("always") and honest.roles.get(field) in ("estimate", "opinion"):
                    assert whole == [float(name == "always-black")]
            for k, (one, me) in enumerate(zip(brain_of, states, strict=True)):
                lot = iter(draws[min(k, 3)])
                give(one, me, lot).observe(me, float(blacks[min(k, 3)]), 5.0)
                for j in range(3):
                    if j != k and said[j] is not None:
                        give(one, me, lot).receive(me, said[j])
                give(one, me, lot).fuse(me)
            assert used.functions.estimate(states[4]) == honest.functions.estimate(states[3])


def give(one, me, lot):
    """The functions of a brain, whose robot is given luck if it asks for any."""
    draws = next(lot)
    if one.uses.luck:
        me.luck = draws
    return one.functions


def test_nobody_wears_an_oracle(capsys):
    said = "brain 'oracle': an oracle hears no liars, so no adversary can wrap it"
    assert main(["brains", "--check", "always-black", "--wrapping", "oracle"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err.splitlines()[-1]


# ---- held against the suite, the engine and brute force
@pytest.mark.long(but_every=3)
@pytest.mark.interpreted
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("topology", ["ring", "full"])
def test_swarms_with_liars_live_as_by_brute_force(name, topology):
    for used in ("minimalistic", brain(RICH)):
        (setting,) = fixed(used, robots=7, rounds=10, looks=2, members=liars(name), topology=topology)
        lived(setting)


@pytest.mark.parametrize("topology", ["ring", "full", "scale-free"])
@pytest.mark.parametrize(("often", "delay"), [(1.0, 0), (0.4, 0), (0.4, 3)])
def test_who_hears_a_jammer_hears_nothing(topology, often, delay):
    """With lost messages and parts that fail, one of them a jammer's radio; noise is as late as messages."""
    heard = []
    for robots in (0, 2):
        (setting,) = fixed("minimalistic", robots=9, rounds=12, members=liars("jammer", [robots, 3], often=often)[:1],
                           topology=topology, link_success=0.8, faults=FAULTS, message_delay=delay)[:1]  # fmt: skip
        batch = lived(setting)[0] if robots else run_batch(setting, SEED, 1, 1, MEASURE, GO)
        heard.append(batch.counts[0, HEARD].sum())
    assert heard[1] < heard[0]


@pytest.mark.long(but_every=2)
@pytest.mark.parametrize(("name", "rich"), [
    ("jammer", False),
    *(pytest.param(name, True, marks=pytest.mark.interpreted) for name in ("jammer", "slow-liar", "noisy-mirror")),
])  # fmt: skip
def test_on_the_move(name, rich):
    setting = moving(brain(RICH) if rich else "minimalistic", robots=7, ticks=25, members=liars(name), link_success=0.7,
                     body={"message_delay": 2}, faults=[{"at": 12, "robots": 2, "stop": "talking"}])  # fmt: skip
    ride, (batch,) = record_ride(setting, SEED, 1), run_ride([setting], SEED, 1, MEASURE, GO)
    life = reference_walks.lives(setting, SEED, 1, failing(setting, 1))
    honest = sampling.groups(setting, SEED, 1, 1)[0] == 0
    assert ride.estimates == pytest.approx(np.array(life.states.estimates), abs=1e-12)
    assert batch.counts[0, HEARD].tolist() == np.array(life.states.heard)[honest].tolist()
    assert batch.counts[0, SENT].tolist() == np.array(life.states.sent)[honest].tolist()
    assert batch.counts[0, HEARD].sum() > 0
