"""Robots' number formats: single precision, and messages in few bits, against the reference, to the bit."""

import struct
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains.float32 import codec_source, rounded_to_single
from swarmcensus.brains.packing import Format, Numbers, Precision
from swarmcensus.cli.commands import main
from swarmcensus.runtime import codec
from tests.reference import formats as reference_formats, rounds as reference, walks as reference_walks
from tests.support.pages import cells_of
from tests.support.small import FAMILIES, FAULTS, SEED, failing, heard_in, moving_of, settings_of, study_of
from tests.support.trials import record_ride, record_trial

EVERY = [
    Numbers("single", "double"),
    Numbers("single", "ratio16"),
    Numbers("single", "ratio8", False),
    Numbers("single", "float32"),
    Numbers("double", "float16"),
    Numbers("double", "ratio8"),
    Numbers("double", "float32"),
    Numbers("single", "float16"),
]


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
    lives_as_the_reference(
        settings_of(brain="self-taught", rounds=40, link_success=0.8, accuracy="U(0.6, 0.9)", **keys_of(EVERY[1]))
    )


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
    if which != 1:  # in CPython all are tried: as machine code, all in one combination, and a fourth in each other one
        every = every[which - (which > 1) :: 4]
    lives_as_the_reference(
        settings_of(robots=6, brain=every, rounds=60, link_success=0.8, accuracy="U(0.6, 0.9)", **keys_of(numbers))
    )


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
    study = study_of(
        "commons", robots=6, accuracy=0.8, precision="single", rounds=10, trials=1,
        members=[{"robots": 2, "brain": adversary, "honest": False}], message="ratio16",
    )  # fmt: skip
    lives_as_the_reference(study.settings())


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
        assert [codec.ratio_code(codec.ratio_value(float(k), steps), steps) for k in range(len(every))] == [
            *range(len(every))
        ]
        for x in random.uniform(-1.0, 2.0, 200):
            read = codec.read_share(x, steps)
            assert abs(read - x) == pytest.approx(np.abs(every - x).min(), abs=1e-12)
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
        assert namespace["ratio_of"](rounded_to_single(information), rounded_to_single(confidence)) == f4(
            information
        ) / f4(confidence)


# ---- what users see


@pytest.mark.interpreted
def test_results_say_formats_sizes_and_what_was_too_large(tmp_path):
    study = study_of(
        ["commons", "three-state"], robots=5, accuracy=0.8, precision=[*get_args(Precision)], rounds=5, trials=2,
        message=[*get_args(Format)],
    )  # fmt: skip
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
    again = sc.replay(data, 3, 1)
    assert again["estimate"].values[-1].tolist() == data["final_estimate"].values[3, 1].tolist()


@pytest.mark.interpreted
def test_overflowing_numbers_are_counted_and_clipped(tmp_path, capsys):
    path = tmp_path / "large.py"
    path.write_text(
        "MEMORY = {'x': 0.5, 'n': 0.0, 'heard': 0.0}\nMESSAGE = ('n',)\n"
        "def observe(me, blacks, looks):\n    me.n += 30000.0\n"
        "def broadcast(me):\n    return (me.n,)\n"
        "def receive(me, message):\n    me.heard = message[0]\n"
        "def fuse(me):\n    pass\n"
        "def estimate(me):\n    return me.x\n"
    )
    study = study_of(str(path), robots=2, accuracy=0.8, rounds=5, trials=1, topology="full", message="float16")
    data = sc.run(study, jobs=1, out=tmp_path / "large.nc")
    assert data["messages_clipped"].values.tolist() == [[[3.0, 3.0]]]
    assert main(["show", str(tmp_path / "large.nc")]) == 0
    assert "setting 0: a number was too large for the message format" in capsys.readouterr().out
    assert sc.replay(data, 0, 0, brain_file=path)["heard"].values[-1].tolist() == [65504.0, 65504.0]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"precision": "half"}, 'swarm.precision = "half"'),
        ({"message": "bfloat16"}, "did you mean 'float16'"),
        ({"feedback": False}, "world.feedback"),
        ({"feedback": "yes"}, 'world.feedback = "yes"'),
    ],
)
def test_unknown_formats_are_named(given, said):
    with pytest.raises(sc.InputError) as error:
        study_of(**given)
    assert said in str(error.value)


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
