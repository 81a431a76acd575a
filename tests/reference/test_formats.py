"""Robots' number formats: single precision, and messages in few bits, against the reference, to the bit."""

import math
import struct
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains.float32 import codec_source, rounded_to_single
from swarmcensus.brains.packing import Format, Numbers, Precision
from swarmcensus.engine.constants import CHANGED, DECIDED_IN, DECISION, DONE_ESTIMATE, DONE_IN, HEARD, SENT
from swarmcensus.runtime import codec
from swarmcensus.simulation import metrics, sampling, trials
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics, record_readings, run_batch
from swarmcensus.studies import addresses
from tests.reference import formats as reference_formats, rounds as reference, walks as reference_walks
from tests.support.lives import local_curves
from tests.support.pages import cells_of
from tests.support.second import ADDS, ALL, STEER, TALKS, agreed, brain, changed, first, fixed, moving
from tests.support.small import FAMILIES, FAULTS, GO, PASSING, SEED, failing, heard_in, moving_of, settings_of, study_of
from tests.support.trials import record_ride, record_trial

EVERY = [
    Numbers("single", "double"), Numbers("single", "ratio16"), Numbers("single", "ratio8", False),
    Numbers("single", "float32"), Numbers("double", "float16"), Numbers("double", "ratio8"),
    Numbers("double", "float32"), Numbers("single", "float16"),
]  # fmt: skip


ROUGH = ("recurrent", "belief-sharing")  # machine code has a tanh and a power of its own


def keys_of(numbers):
    feedback = {} if numbers.message == "double" else {"feedback": numbers.feedback}
    return {"precision": numbers.precision, "message": numbers.message} | feedback


def lives_as_the_reference(settings):
    for setting in settings:
        _, estimates, blacks = record_trial(setting, SEED, 0)
        states = reference.fixed(setting, SEED, 0, failing(setting, 0), heard_in(setting, 0), blacks)
        loose = 1e-6 if setting.brain.name in ROUGH else 0.0
        assert np.abs(estimates - np.array(states.estimates)).max() <= loose, str(setting)


def test_machine_code_of_number_formats():
    more = {"link_success": 0.8, "accuracy": "U(0.6, 0.9)"} | keys_of(EVERY[1])
    lives_as_the_reference(settings_of(brain="self-taught", rounds=40, **more))


@pytest.mark.long(but_every=4)
@pytest.mark.interpreted
@pytest.mark.parametrize("numbers", EVERY, ids=str)
def test_number_formats_against_the_reference(numbers):
    world = {"link_success": 0.8, "accuracy": "U(0.6, 0.9)"} | keys_of(numbers)
    lives_as_the_reference(settings_of(robots=4, brain=[*FAMILIES], rounds=10, **world))


@pytest.mark.long
@pytest.mark.parametrize("which", range(5), ids=lambda which: str(EVERY[which]))
def test_compiled_number_formats_against_the_reference(which):
    numbers, every = EVERY[which], [name for name in brains.shipped() if name not in ("oracle", "leaver")]
    # in CPython all are tried; as machine code each brain in single precision, and an eighth in double precision
    every = every[which::4] if numbers.precision == "single" else every[::8]
    more = {"link_success": 0.8, "accuracy": "U(0.6, 0.9)"} | keys_of(numbers)
    lives_as_the_reference(settings_of(robots=6, brain=every, rounds=60, **more))


@pytest.mark.interpreted
def test_formats_with_late_messages_and_faults():
    world = {"link_success": 0.8, "message_delay": [0, 2], **keys_of(EVERY[1])}
    lives_as_the_reference(settings_of(robots=6, brain=["commons", "sure"], rounds=12, faults=FAULTS, **world))


@pytest.mark.interpreted
@pytest.mark.parametrize("brain", ["commons", "leaver"])
def test_robots_that_move_and_steer_round_as_the_reference(brain):
    setting = moving_of(brain=brain, ticks=25, link_success=0.8, **keys_of(EVERY[1]))
    life = reference_walks.lives(setting, SEED, 0, failing(setting, 0))
    assert (record_ride(setting, SEED, 0).estimates == np.array(life.estimates)).all()


@pytest.mark.interpreted
@pytest.mark.parametrize("adversary", ["jammer", "opposite"])
def test_liars_talk_in_the_same_format(adversary):
    members = [{"robots": 2, "brain": adversary, "honest": False}]
    world = {"rounds": 10, "members": members, "precision": "single", "message": "ratio16"}
    lives_as_the_reference(settings_of(6, "commons", 0.8, looks=10, **world))


# ---- the codec
def test_half_precision_is_that_of_ieee():
    numbers = [*np.random.default_rng(1).normal(size=2000) * 2.0 ** np.linspace(-30, 16, 2000), 0.0, 65519.9]
    every = np.arange(65536, dtype=np.uint16).view(np.float16)
    finite = every[np.isfinite(every)].astype(np.float64)
    middles = (finite[1:] + finite[:-1]) / 2
    for x in [*finite, *middles[np.isfinite(middles)][::7], *numbers]:
        code = codec.half_code(float(x))
        packed = struct.pack("<e", x) if abs(x) < 65520 else struct.pack("<e", np.copysign(65504.0, x))
        assert code == struct.unpack("<H", packed)[0] or x == 0.0
        assert codec.half_value(code) == struct.unpack("<e", packed)[0]


def test_codes_stand_for_the_nearest_numbers():
    random = np.random.default_rng(2)
    for bits, steps in ((16, 32768.0), (8, 128.0)):
        every = reference_formats.RATIOS[bits]
        values = [codec.ratio_value(float(k), steps) for k in range(len(every))]
        assert [codec.ratio_code(value, steps) for value in values] == [*range(len(every))]
        for x in random.uniform(-1.0, 2.0, 200):
            assert abs(codec.read_share(x, steps) - x) == pytest.approx(np.abs(every - x).min(), abs=1e-12)
    assert [codec.log_code(codec.log_value(float(k))) for k in range(256)] == [*range(256)]
    for x in 2.0 ** random.uniform(-16, 47, 500):
        assert codec.read_log(x) == pytest.approx(reference_formats.log(x), rel=1e-15)
    assert [codec.read_log(x) for x in (-1.0, 0.0, 1e-9, np.nan)] == [0.0] * 4
    assert codec.read_log(np.inf) == codec.read_log(1e30) == pytest.approx(2.0**47.5)
    assert [codec.whole_code(x, 255.0) for x in (-1.0, 3.0, 300.0, np.nan)] == [0.0, 3.0, 255.0, 0.0]


def test_the_codec_in_single_precision_has_the_bits_of_float32():
    namespace = {}
    exec(codec_source("single"), namespace)
    random, f4 = np.random.default_rng(3), np.float32
    for x in map(float, random.uniform(-0.6, 1.6, 500).astype(f4)):
        with np.errstate(all="ignore"):
            scaled = (f4(x) + f4(0.5)) * f4(32768.0)
        assert namespace["ratio_code"](x, 32768.0) == np.clip(np.rint(scaled), 0, 65535)
        information, confidence = x * 100, abs(x) * 37 + 1
        found = namespace["ratio_of"](rounded_to_single(information), rounded_to_single(confidence))
        assert found == f4(information) / f4(confidence)


# ---- what users see
@pytest.mark.interpreted
def test_results_say_formats_sizes_and_what_was_too_large(tmp_path):
    formats = {"precision": [*get_args(Precision)], "message": [*get_args(Format)]}
    study = study_of(["commons", "three-state"], robots=5, accuracy=0.8, rounds=5, trials=2, **formats)
    data = sc.run(study, jobs=1)
    assert data["message"].values[:5].tolist() == ["double", "float32", "float16", "ratio16", "ratio8"]
    assert set(data["precision"].values) == {"single", "double"}
    assert data["message_bytes"].values[:5].tolist() == [8, 8, 4, 3, 2]
    plain = data["memory_bytes"].values[0]
    assert data["memory_bytes"].values[:5].tolist() == [plain, *[plain + 8] * 4]  # what two numbers owe
    assert (data["messages_clipped"].values == 0.0).all()
    for setting, size in zip(study.settings(), data["message_bytes"].values, strict=True):
        if setting.message != "double":
            assert size == reference_formats.size(setting.brain)
    assert sc.replay(data, 3, 1)["estimate"].values[-1].tolist() == data["final_estimate"].values[3, 1].tolist()


@pytest.mark.interpreted
def test_overflowing_numbers_are_counted_and_clipped(tmp_path, accepted):
    path = tmp_path / "large.py"
    changes = (
        ('"n": 0.0', '"n": 0.0, "heard": 0.0'), ('("x",)', '("n",)'), ("me.n += blacks", "me.n += 30000.0"),
        ("(estimate(me),)", "(me.n,)"), ("message):\n    pass", "message):\n    me.heard = message[0]"),
    )  # fmt: skip
    path.write_text(changed(*changes, ("me.n / me.t if me.t > 0.0 else 0.5", "0.5")))
    study = study_of(str(path), robots=2, accuracy=0.8, rounds=300, trials=1, topology="full", message="float16")
    data = sc.run(study, jobs=1, out=tmp_path / "large.nc")
    assert data["messages_clipped"].values.tolist() == [[[298.0, 298.0]]]  # more than a byte holds
    assert "setting 0: a number was too large for the message format" in accepted("show", tmp_path / "large.nc").out
    assert sc.replay(data, 0, 0, brain_file=path)["heard"].values[-1].tolist() == [65504.0, 65504.0]


@pytest.mark.parametrize(("given", "said"), [
    ({"precision": "half"}, 'swarm.precision = "half"'),
    ({"message": "bfloat16"}, "did you mean 'float16'"),
    ({"feedback": False}, "world.feedback"),
    ({"feedback": "yes"}, 'world.feedback = "yes"'),
])  # fmt: skip
def test_unknown_formats_are_named(given, said):
    with pytest.raises(sc.InputError, match=said):
        study_of(**given)


def test_table_of_formats_lists_all_brains():
    rows = cells_of("number-formats")
    assert {row["brain"] for row in rows} == set(brains.shipped()) - {"oracle", "leaver"}
    assert [row["readings"] for row in rows if row["brain"] == "commons"] == ["864000", "1000", "10000"]


def test_an_error_in_single_precision_has_the_line_of_the_file():
    source = brains.load("alone").source.replace("    me.t += looks\n", "    me.t += looks\n    me.n /= me.t - looks\n")
    used = brains.parse(source, "mine", Path("mine.py")).with_numbers(Numbers(precision="single"))
    with pytest.raises(ZeroDivisionError) as failed:
        used.functions.observe(used.robot(0.7, 0.7), 1.0, 1.0)
    assert source.splitlines()[failed.traceback[-1].lineno] == "    me.n /= me.t - looks"


# ---- small swarms on fixed networks against the reference, and batches of trials against their curves
ONE_WAY = {"name": "one way", "edges": [[0, 3], [3, 1], [1, 3], [2, 0]], "directed": True}
CASES = [
    {"robots": [1, 2, 5], "topology": ["full", "ring", "line", "scale-free"]},
    {"robots": 6, "topology": "full", "brain": ["minimalistic", "legacy"], "link_success": [1.0, 0.5], "rounds": 5},
    {"robots": 6, "topology": ["full", "scale-free"], "accuracy": "U(0.5, 0.9)", "faults": FAULTS, "looks": 3},
    {"robots": [3, 6], "topology": ["full", "ring"], "link_success": 0.4, "faults": FAULTS[:2], "brain": "legacy"},
    {"robots": 5, "topology": {"name": "odd", "edges": [[0, 3], [3, 1], [4, 0]]}, "link_success": [0.7, 1.0]},
    {"robots": 4, "topology": ONE_WAY, "link_success": [0.7, 1.0]},
    {"robots": 4, "accuracy": {"black": "N(0.8, 0.1)", "white": 0.6}, "assumed_accuracy": {"error": "U(-0.2, 0.1)"}},
    {"robots": 260, "rounds": 2, "accuracy": "U(0.6, 0.8)", "looks": 17},
    {"robots": 5, "topology": ["ring", "full"], "looks": 3, "fill_ratio": {"from": 0.9, "to": 0.2, "at": 3, "until": 6},
     "accuracy": {"start": "U(0.7, 0.9)", "drift": -0.02, "least": 0.6}},
    {"robots": 6, "topology": ["ring", "full"], "brain": ["commons", "legacy"], "looks": 3, "rounds": 9,
     "message_delay": [1, 4]},
    {"robots": 258, "topology": "line", "rounds": 3, "faults": [FAULTS[0] | {"robots": 0.5}], "link_success": 0.9},
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=range(len(CASES)))
def test_fixed_networks_against_the_reference(case):
    """Bit for bit, but to rounding where everyone hears everyone: sums are added in another order there."""
    for setting in settings_of(**case):
        for trial in (0, 2):
            history, estimates, blacks = record_trial(setting, SEED, trial)
            states = reference.fixed(setting, SEED, trial, failing(setting, trial), heard_in(setting, trial), blacks)
            if setting.topology.name == "full":
                assert estimates == pytest.approx(np.array(states.estimates), abs=1e-12)
            else:
                assert (estimates == np.array(states.estimates)).all()
            for name in setting.brain.memory:
                assert history[name][-1] == pytest.approx([getattr(me, name) for me in states.states], rel=1e-9)


@pytest.mark.parametrize("looks", [1, 3, 17])
def test_rounds_are_sums_of_single_readings(looks):
    (setting,) = settings_of(robots=3, looks=looks, rounds=3, accuracy="U(0.6, 0.9)")
    for trial in (0, 2):
        blacks = record_trial(setting, SEED, trial)[2]
        readings = record_readings(setting, SEED, trial)
        key, left = addresses.readings_key(setting, SEED, "order"), blacks.copy()
        for step, row in enumerate(readings):
            tick, to_come = 1 + step // looks, looks - step % looks
            for i in range(3):
                u = reference.unit(reference.robots_word(key, trial, step + 1, i))
                assert row[i] == (u < left[tick, i] / to_come)
                left[tick, i] -= row[i]
        assert (left[1:] == 0).all()


def test_estimates_are_kept_where_they_are_asked_for_alone():
    (setting,) = settings_of(rounds=2)
    assert run_batch(setting, SEED, 0, 1, Metrics(0.01, 10, (2,)), GO).kept is None


@pytest.mark.interpreted
@pytest.mark.parametrize("topology", ["line", "full"])
def test_losses_one_way_say_nothing_of_the_other_way(topology):
    """Two robots, 600 rounds: directions, rounds and trials are uncorrelated, within 4 standard errors."""
    source = brains.load("minimalistic").source
    source = source.replace("SUMS = ", "NOTHING = ").replace("        me.heard = 0.0\n", "")  # counts what it hears
    (setting,) = settings_of(robots=2, rounds=300, topology=topology, link_success=0.5)
    setting = replace(setting, brain=brains.parse(source, "counting", setting.brain.path))
    heard = [np.diff(record_trial(setting, SEED, trial)[0]["heard"], axis=0) for trial in (0, 1)]
    assert set(np.unique(heard)) == {0.0, 1.0}
    one, other = np.concatenate(heard).T
    for x, y in (one, other), (one[1:], one[:-1]), (one[1:], other[:-1]), (heard[0].ravel(), heard[1].ravel()):
        assert abs(np.corrcoef(x, y)[0, 1]) < 4 / math.sqrt(len(x))


def test_length_of_segments():
    """Few robots' estimates are all kept; of many, what is kept grows with the square root of the rounds."""
    for given, length in (
        ((10, 50, 96, 1), 50), ((100_000, 5000, 96, 1), 244),  # the root of 5000 96 / 8
        ((100_000, 5000, 96, 10), 250), ((10**9, 50, 8, 1), 7), ((10**10, 1, 8, 1), 1),
        ((10**6, 120, 8, 1), 100), ((10**5, 120, 8, 1), 100),  # of a crowd, a hundred
    ):  # fmt: skip
        assert trials.segment_length(*given) == length
    assert trials.segment_length(10**6, 10**9, 8, 7) % 7 == 0


# ---- swarms that use all of the contract's optional functions live the life of the reference, in every kind of world
SOME = [{"robots": 0.4, "brain": brain(TALKS, "talks.py"), "honest": False}]
TWO, LOSSY = ["full", "ring"], {"topology": ["full", "line"], "link_success": 0.6}
FUNCTIONS = {
    "all": (ALL, {"robots": [1, 5], "topology": ["full", "ring", "line", "scale-free"]}),
    "all, lossy": (ALL, {"robots": 6, "topology": ["full", "scale-free"], "link_success": 0.6, "faults": FAULTS}),
    "all, 260": (ALL, {"robots": 260, "rounds": 3, "looks": 4, "topology": ["ring", "full"]}),
    "adds": (ADDS, {"robots": [1, 6], "topology": ["full", "ring", "scale-free"], "looks": 3}),
    "adds, lossy": (ADDS, {"robots": 6, "topology": ["full", "line"], "link_success": 0.6}),
    "adds, failing": (ADDS, {"robots": 6, "topology": ["full", "ring"], "faults": FAULTS}),
    "all, passing": (ALL, {"robots": 6, "topology": ["full", "line"], "link_success": [1.0, 0.6], "faults": PASSING}),
    "adds, passing and late": (ADDS, {"robots": 6, "topology": TWO, "faults": PASSING, "message_delay": [0, 2]}),
    "all, late": (ALL, {"topology": ["full", "ring"], "message_delay": [1, 3]}),
    "all, late and lossy": (ALL, LOSSY | {"message_delay": 2, "faults": FAULTS}),
    "adds, late": (ADDS, {"robots": [1, 6], "topology": ["full", "scale-free"], "message_delay": [2, 7]}),
    "adds, late, 260": (ADDS, {"robots": 260, "rounds": 5, "topology": ["full", "ring"], "message_delay": 2}),
    "adds, late and lossy": (ADDS, LOSSY | {"robots": 6, "message_delay": 3}),
    "adds, late and failing": (ADDS, {"robots": 6, "topology": ["full", "ring"], "faults": FAULTS, "message_delay": 1}),
    "mixed, late": (ALL, {"robots": 7, "topology": ["full", "ring"], "members": SOME, "message_delay": 2}),
    "mixed": (ALL, {"robots": 7, "topology": ["full", "ring", "scale-free"], "members": SOME}),
    "mixed, lossy": (ALL, {"robots": 7, "topology": ["full", "ring"], "members": SOME, "link_success": 0.6}),
    "mixed, 300": (ALL, {"robots": 300, "rounds": 3, "topology": "line", "members": SOME, "faults": FAULTS[::2]}),
}  # fmt: skip
RIDES = {
    "all": (ALL, {}),
    "all, late and lossy": (ALL, {"body": {"message_delay": 3}, "link_success": 0.7, "faults": FAULTS}),
    "all, steering": (ALL + STEER, {}),
    "all, passing": (ALL, {"faults": [*PASSING, {"at": 2, "robots": 3, "stop": "moving", "until": 9}]}),
    "all, steering, passing": (ALL + STEER, {"faults": [{"at": 2, "robots": 3, "stop": "moving", "until": 9}]}),
    "adds": (ADDS, {"body": {"message_delay": 1}}),
    "adds, failing": (ADDS, {"faults": FAULTS}),
    "mixed": (ALL, {"members": SOME, "body": {"message_delay": 2}}),
}
MEASURE = Metrics(0.01, 10, (2, 3))


def check(setting, trial, states, fields, estimates, batch, close):
    """What a trial shows and what a batch counts is what the reference's states have come to."""
    assert estimates == pytest.approx(np.array(states.estimates), rel=close, abs=close)
    for i, (own, me) in enumerate(zip(states.brains, states.states, strict=True)):
        for name in own.memory:
            here = fields[name][-1, i]
            if here.ndim:  # longer, where another brain's is
                assert np.isnan(here[own.lengths[name] :]).all()
                here = here[: own.lengths[name]]
            assert here == pytest.approx(getattr(me, name), rel=1e-9, abs=close)
    honest = np.array([not setting.members or k == 0 for k in sampling.groups(setting, SEED, trial, 1)[0]])
    assert batch.counts[0, SENT].tolist() == np.array(states.sent)[honest].tolist()
    assert batch.counts[0, HEARD].tolist() == np.array(states.heard)[honest].tolist()
    decisions, done = np.array(states.decisions), np.array(states.done)
    own, curves = decisions[:, honest], np.array(states.estimates)[:, honest]
    before = np.vstack([np.full(own.shape[1], -1.0), own])
    told = batch.verdicts[0]
    assert told[:, DECISION].tolist() == own[-1].tolist()
    assert told[:, DECIDED_IN].tolist() == first(own, lambda one: one >= 0).tolist()
    last = len(own) - first((before[1:] != before[:-1])[::-1], bool) + 1.0
    assert told[:, CHANGED].tolist() == np.where(np.isfinite(last), last, np.inf).tolist()
    ends = first(done[:, honest], bool)
    assert told[:, DONE_IN].tolist() == ends.tolist()
    for i, end in enumerate(ends):
        now = told[i, DONE_ESTIMATE]
        assert np.isnan(now) if np.isinf(end) else now == pytest.approx(curves[int(end), i], abs=close)
    assert tuple(batch.consensus[0, :2]) == agreed(own)
    assert (fields["decided"][1:] == decisions).all()
    assert (fields["is_done"][1:] == done).all()
    ends = np.array(states.intervals)
    for name, due in zip(("interval_low", "interval_high"), np.moveaxis(ends, -1, 0), strict=True):
        assert fields[name] == pytest.approx(due, rel=close, abs=close, nan_ok=True)
    low, high = np.moveaxis(ends[list(MEASURE.checkpoints)][:, honest], -1, 0)
    held = (low <= setting.fill_ratio) & (setting.fill_ratio <= high)
    assert batch.intervals[0, :, 0].tolist() == held.mean(axis=1).tolist()
    assert batch.intervals[1, :, 0] == pytest.approx((high - low).mean(axis=1), rel=1e-12)


@pytest.mark.long(
    only=["adds", "adds, late, 260", "adds, lossy", "mixed, 300", "all, 260", "mixed, late",
          "adds, passing and late", "all, late and lossy", "adds, late and failing"]
)  # fmt: skip
@pytest.mark.parametrize("name", FUNCTIONS)
def test_on_fixed_networks(name):
    source, case = FUNCTIONS[name]
    for setting in fixed(brain(source), **case):
        fields, estimates, blacks = record_trial(setting, SEED, 1)
        states = reference.fixed(setting, SEED, 1, failing(setting, 1), heard_in(setting, 1), blacks)
        batch = run_batch(setting, SEED, 1, 1, MEASURE, GO)
        reordered = setting.topology.name == "full" and setting.additive
        check(setting, 1, states, fields, estimates, batch, 1e-12 if reordered else 0.0)


@pytest.mark.long(only=["all, steering", "all, steering, passing"])
@pytest.mark.parametrize("name", RIDES)
def test_on_the_move(name):
    source, case = RIDES[name]
    setting = moving(brain(source), **case)
    ride, (batch,) = record_ride(setting, SEED, 1), run_ride([setting], SEED, 1, MEASURE, GO)
    life = reference_walks.lives(setting, SEED, 1, failing(setting, 1))
    made = np.array(life.readings)
    if "is_done" in ride.fields:
        made[ride.fields["is_done"][:-1] == 1.0] = np.nan
        assert not (ride.looked[1:] & (ride.fields["is_done"][:-1] == 1.0)).any()
    assert np.array(ride.readings[1:]) == pytest.approx(made, nan_ok=True)
    check(setting, 1, life.states, ride.fields, ride.estimates, batch, 0.0)


@pytest.mark.parametrize("source", [ALL, ADDS], ids=["all", "adds"])
def test_alone(source):
    """The local estimate, observation by observation: nobody is heard, whoever is done looks no more."""
    for setting in fixed(brain(source), robots=5, rounds=4, looks=3, members=SOME if source == ALL else ()):
        curves = local_curves(setting, 1)
        batch = run_batch(setting, SEED, 1, 1, Metrics(0.01, 10, ()), GO, local=True)
        honest = [not setting.members or k == 0 for k in sampling.groups(setting, SEED, 1, 1)[0]]
        assert (batch.final[0] == curves[-1][honest]).all()
        assert (batch.convergence[0] == metrics.convergence(curves)[honest]).all()
