"""Random inputs, valid and broken, to every command and public function: no traceback, no hang, never half a file.

Some 250 cases, and 6,000 in the long tests, the same in every run. SWARMCENSUS_FUZZ=20 runs twenty times as many,
other ones each time; a case that fails is printed as hypothesis has shrunk it.
"""

import contextlib
import faulthandler
import functools
import io
import json
import math
import os
import shutil
import sys
import tempfile
import tomllib
import warnings
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings, strategies as st

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.results import merging, shards, store as results
from swarmcensus.results.values import VARIABLES
from swarmcensus.simulation import inferring, rows_of
from swarmcensus.studies import addresses
from swarmcensus.summaries import recordings, replaying
from swarmcensus.summaries.selecting import where
from swarmcensus.support.toml_text import to_toml
from swarmcensus.worlds import read_links
from swarmcensus.worlds.bodies import Body
from tests.support.drawn import drawn, tables_of

pytestmark = pytest.mark.usefixtures("untraced", "copies")

# values of every kind that TOML knows, and those that are most likely to hurt
ODD = st.sampled_from(
    [0, 1, -1, 2, 2**31 - 1, 2**31, 2**63, -(2**63), 10**30, 10**400, 0.0, -0.0, 1e308, -1e308, 5e-324, 1e-300,
     math.inf, -math.inf, math.nan, 0.5, 1.0, True, False, "", " ", "ring", "moving", "full", "a\nb", "a\x00b", "\x7f",
     "ü", "名", "../x", "/", "/dev/null", "C:\\x", "U(0, 1)", "U(1, 0)", "N(nan, 1)", "U(1e999, 2)", [], {}, [[]], [{}],
     {"error": 1}, {"black": 1}, {"until": "correct@10 mean +- 0.1"}, {"until": "x"}, {"networkx": "x_graph"}]
)  # fmt: skip
TEXT = st.text(max_size=12)
SCALAR = ODD | st.integers() | st.floats() | TEXT | st.booleans() | st.dates() | st.datetimes()
ANY = st.recursive(SCALAR, lambda v: st.lists(v, max_size=3) | st.dictionaries(TEXT, v, max_size=3), max_leaves=6)


# what means something at some key of a study, and is mostly wrong at another one
TABLES = st.sampled_from(
    [{"image": "x.png"}, {"benchmark": "star", "cells": 0}, {"file": "x.py", "a": 1}, {"file": "x.net", "renumber": 1},
     {"name": "small-world", "neighbours": 2}, {"name": "grid", "columns": 2}, {"name": "x", "edges": [[0, 1]]},
     {"networkx": "random_k_out_graph", "k": 1, "alpha": 0.5, "seed": "x"},
     {"networkx": "path_graph", "directed": True},
     {"black": "U(0.5, 0.9)", "white": 0.7}, {"until": "convergence_error median +- 0.01", "at_most": 40},
     "x.py(0.1, 0.2)", "torus", "x.gml", "minimalistic", "0.2 s", "0.005 min", "1e99 h",
     [{"robots": [1, 2], "side": 2.0}], ["talking"]]
)  # fmt: skip
KEYS = st.sampled_from(["case", "side", "density", "ticks", "rounds", "radius", "label", *Body.model_fields]) | TEXT


@st.composite
def tables(draw):
    """The tables of a study that is right, with up to three values in the place of others, or keys of other names."""
    made = deepcopy(tables_of(np.random.default_rng(draw(st.integers(0, 2**32))), "minimalistic", longest=9))
    for _ in range(draw(st.integers(0, 3))):
        level = made
        while (inner := [v for v in level.values() if isinstance(v, dict) and v]) and draw(st.integers(0, 3)):
            level = draw(st.sampled_from(inner))
        value = deepcopy(draw(ANY | TABLES))
        level[draw(st.sampled_from(sorted(level)) | KEYS)] = [value, 1] if draw(st.integers(0, 4)) == 0 else value
    return made


@st.composite
def spoiled(draw, originals):
    """A text or bytes with some places cut out, doubled, exchanged or written over."""
    data = draw(st.sampled_from(originals))
    for _ in range(draw(st.integers(1, 4))):
        lines = draw(st.booleans())
        parts = data.splitlines(keepends=True) if lines else data
        if not parts:
            continue
        a, b = sorted((draw(st.integers(0, len(parts))), draw(st.integers(0, len(parts)))))
        b = b if lines else min(b, a + draw(st.integers(0, 20)))
        new = parts[:0]
        if draw(st.booleans()):
            noise = draw(st.text(max_size=5) if isinstance(data, str) else st.binary(max_size=5))
            new = [noise] if lines else noise
        kept = draw(st.sampled_from([parts[:a] + new + parts[b:], parts[:b] + new + parts[a:], parts[:a] + new]))
        data = data[:0].join(kept) if lines else kept
    return data


TIMES = int(os.environ.get("SWARMCENSUS_FUZZ", "1"))
QUICK, LONG = 0.025, 0.7  # of the cases that each test is worth
HANGS = 300.0  # seconds of one case after which the process is ended and says where it was
STUDIES = sorted(Path("studies").resolve().rglob("*.toml"))
BRAIN = brains.load("minimalistic").source


def fuzz(cases, *strategies):
    """Run a test for so many cases, each of which may warn and must end; beside it stands a long one, of more cases."""

    def decorate(test):
        @functools.wraps(test)
        def guarded(*args, **kwargs):
            faulthandler.dump_traceback_later(HANGS, exit=True, file=sys.__stderr__)
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    test(*args, **kwargs)
            finally:
                faulthandler.cancel_dump_traceback_later()

        def of(part):
            often = settings(
                max_examples=max(1, int(cases * TIMES * part)), derandomize=TIMES == 1, database=None, deadline=None,
                suppress_health_check=list(HealthCheck),
            )  # fmt: skip
            return often(given(*strategies)(guarded))

        globals()[f"{test.__name__}_at_length"] = pytest.mark.long(of(LONG))
        return of(QUICK)

    return decorate


def taken_or_refused(function, *args, **kwargs):
    """What a function returns, or None where it raises InputError with something to say."""
    try:
        return function(*args, **kwargs)
    except sc.InputError as error:
        if not str(error).strip():
            raise AssertionError("refused without a word") from error
        return None


def command(*words):
    """Run a command; its exit code is 0, 1 or 2, and 2 comes with one clear line and no new file but whole ones."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), contextlib.suppress(SystemExit):
        code = 2
        code = main([str(word) for word in words])
    said = [line for line in err.getvalue().splitlines() if not line.startswith("warning: ")]
    assert "internal error" not in err.getvalue(), err.getvalue()
    assert code in (0, 1, 2)
    if code == 2:
        assert len([line for line in said if line.startswith("swarmcensus")]) == 1, err.getvalue()
    return code


@contextlib.contextmanager
def folder():
    """An empty folder to work in, in which no file is left half-written."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        try:
            yield Path(name)
            assert not list(Path(name).rglob(".*")), "something was left half-written"
        finally:
            os.chdir(before)


# ---- study files
def _prints(study):
    return [addresses.fingerprint(setting, study.seed) for setting in study.settings()]


def _check_study(study):
    again = sc.Study.parse(study.text, context=study.context)
    assert _prints(again) == _prints(study)
    assert again.checkpoints == study.checkpoints
    assert again.measure == study.measure


@fuzz(800, tables())
def test_study_tables_and_texts(tables):
    study = taken_or_refused(lambda: sc.Study(**{k if k.isidentifier() else "x": v for k, v in tables.items()}))
    if study is not None:
        _check_study(study)
    with contextlib.suppress(UnicodeEncodeError):
        text = to_toml(tables)
        text.encode()
        written = taken_or_refused(sc.Study.parse, text)
        if written is not None:
            assert repr(tomllib.loads(to_toml(tomllib.loads(text)))) == repr(tomllib.loads(text))
            _check_study(written)


@fuzz(1500, spoiled([path.read_text() for path in STUDIES]))
def test_spoiled_study_files(text):
    study = taken_or_refused(sc.Study.parse, text, context={"base": Path("studies/example").resolve()})
    if study is not None:
        assert study.settings()


@fuzz(7, st.integers(0, 2**32), st.sampled_from(["minimalistic", "legacy"]))
def test_tiny_studies_live_their_whole_life(number, brain):
    with folder() as here:
        (here / "s.toml").write_text(drawn(np.random.default_rng(number), brain, ("shouter",), longest=5).text)
        assert command("run", "s.toml", "--jobs", 1) == command("status", "s.nc") == 0
        assert command("verify", "s.nc", "--all", "--jobs", 1) == command("export", "s.nc") == 0
        assert command("replay", "s.nc", "--setting", 0, "--trial", 0, "--out", "t.nc") == 0
        assert command("merge", "s.nc", "s.nc", "--out", "m.nc") == 0
        one, both = sc.load("s.nc"), sc.load("m.nc")
        assert all(one[name].identical(both[name]) for name in VARIABLES)
        assert command("run", "s.toml", "--jobs", 1) == 0  # nothing is left to do
        assert sorted(p.name for p in here.iterdir()) == ["m.nc", "s.csv", "s.nc", "s.toml", "t.nc"]


# ---- brains
LEAVES = st.sampled_from(
    ["0", "1.5", "10", "9**9", "'a'", "None", "...", "x", "me", "math", "math.pi", "canary", "b'x'", "1j", "1e400",
     "me.t", "message[0]", "()", "[]", "{}", "0x" + "f" * 5000]
)  # fmt: skip
BINARY = ["+", "-", "*", "/", "//", "%", "**", "<<", ">>", "@", "&", "and", "or", "<", "==", "in", "is"]
UNARY = ["-", "+", "~", "not ", "*", "lambda: ", "await ", "yield "]
CALLED = ["canary", "math.exp", "min", "open", "x", "range", "__import__"]
EXPRESSION = st.recursive(LEAVES, lambda e: st.one_of(
    st.builds("({} {} {})".format, e, st.sampled_from(BINARY), e),
    st.builds("({}{})".format, st.sampled_from(UNARY), e),
    st.builds("{}({})".format, st.sampled_from(CALLED), e),
    *(st.builds(form.format, e, e) for form in ("({}, {})", "{{{}: {}}}", "[{} for x in {}]", "{}[{}]")),
    st.builds("({} if {} else {})".format, e, e, e), st.builds("(x := {})".format, e),
), max_leaves=6)  # fmt: skip
FORMS = [
    "{name} = {one}", "def {function}({given}):\n    return {one}", "def f(x={one}):\n    pass",
    "def f(x: {one}) -> {two}:\n    pass", "def f(me):\n    while True:\n        x = {one}",
    "@{one}\ndef f(me):\n    pass", "class C({one}):\n    y = {two}", "for x in {one}:\n    pass", "{one}",
    "import {module}", "from {module} import pi", "from {module} import *", "from {module} import x as y",
]  # fmt: skip
STATEMENT = st.builds(
    lambda form, **parts: form.format(**parts), st.sampled_from(FORMS), one=EXPRESSION, two=EXPRESSION,
    name=st.sampled_from(["x", "MEMORY", "MESSAGE", "SUMS", "math.pi", "x, y", "x[0]"]),
    function=st.sampled_from(["observe", "fuse", "estimate", "f"]),
    given=st.sampled_from(["me", "me, message", "me, blacks, looks", "*x", "**x", "me, /", ""]),
    module=st.sampled_from(["math", "os", "math as m", ".", "canary", "math, os"]),
)  # fmt: skip


@pytest.fixture(scope="module")
def canary():
    """Something in every program's reach that nothing may call: whether it still sings."""
    import builtins

    called = []
    builtins.canary = lambda *_: called.append(1)
    yield called
    del builtins.canary


def _read_brain(source, canary):
    brain = taken_or_refused(brains.parse, source, "mine.py", Path("mine.py"))
    assert not canary
    assert math.pi == 3.141592653589793
    if brain is not None:
        assert all(math.isfinite(value) for value in brain.memory.values())


@fuzz(2200, spoiled([BRAIN, brains.load("legacy").source]))
def test_spoiled_brains(canary, source):
    _read_brain(source, canary)


@fuzz(1500, st.lists(STATEMENT, max_size=4), st.booleans())
@example(["X = 2**1000"] + ["X = X * X"] * 40, False)
@example(["X = ('a',)"] + ["X = (*X, *X)"] * 60, False)
@example(["OPTIONS = " + "(" * 9 + "1,)" + " * 10000,)" * 8 + " * 10000"], False)
@example(["X = " + "(" * 5000 + ")" * 5000], False)
@example(["X = " + "-" * 50_000 + "1"], False)
@example(["X = " + "1+" * 50_000 + "1"], False)
def test_random_brains(canary, lines, before):
    _read_brain("\n".join([*lines, BRAIN] if before else [BRAIN, *lines]), canary)


# ---- results
@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A folder with a small study, its results, and a shard of it; all that a run can leave."""
    here = tmp_path_factory.mktemp("small")
    tables = {
        "name": "small", "trials": 2, "swarm": {"robots": [2, 3], "accuracy": [0.7, "U(0.5, 0.9)"]},
        "world": {"topology": ["ring", {"name": "pair", "edges": [[0, 1]]}], "fill_ratio": 0.55},
        "schedule": {"rounds": 3},
    }  # fmt: skip
    (here / "s.toml").write_text(to_toml(tables))
    study = sc.Study.load(here / "s.toml")
    sc.save(sc.run(study, jobs=1), here / "s.nc")
    with pytest.MonkeyPatch.context() as patch:  # a run that is cut off just before it writes its results
        patch.setattr(results, "save", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            sc.run(study, jobs=1, out=here / "cut.nc")
    assert shards.shard_files(here / "cut.nc.parts")
    return here


@pytest.fixture(scope="module")
def loaded(small):
    return sc.load(small / "s.nc")


def _use(path):
    """What can be done with a results file: none of it may go wrong but in one sentence."""
    data = taken_or_refused(sc.load, path)
    if data is None:
        return
    taken_or_refused(where, data, 'robots == 3 or topology == "ring" and accuracy < 0.8')
    taken_or_refused(results.export, data, path.with_suffix(".csv"), "csv")
    taken_or_refused(replaying.replay, data, int(data["setting"].values[-1]), int(data["trial"].values[0]))
    taken_or_refused(merging.merge, [data, data])


def _use_all(small, path, kind):
    shutil.copy(small / "s.toml", path.parent)
    if kind == 3:
        before = path.read_bytes()
        if command("run", "s.toml", "--out", path, "--jobs", 1):
            assert path.read_bytes() == before
    elif words := {
        0: ("status", path), 1: ("verify", path, "--jobs", 1, "--seed", 1), 2: ("merge", path, path, "--out", "m.nc"),
    }.get(kind):  # fmt: skip
        command(*words)
    else:
        _use(path)


@fuzz(60, st.data())
def test_results_with_bytes_changed(small, data):
    whole = (small / "s.nc").read_bytes()
    spoilt = bytearray(whole)
    for place in data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=4)):
        spoilt[place] = data.draw(st.integers(0, 255))
    if data.draw(st.booleans()):
        del spoilt[data.draw(st.integers(0, len(whole))) :]
    with folder() as here:
        (here / "x.nc").write_bytes(spoilt)
        _use_all(small, here / "x.nc", data.draw(st.sampled_from([0, 1, 2, 3] + [5] * 8)))


@fuzz(40, st.data())
def test_shards_changed(small, data):
    original = shards.shard_files(small / "cut.nc.parts")[0]
    bytes_ = data.draw(spoiled([original.read_bytes()]) | st.binary(max_size=60))
    kind = data.draw(st.sampled_from(["bytes", "hash too", "array", "about", "items"]))
    if kind not in ("bytes", "hash too"):  # a shard that is whole, and says something else
        with np.load(original) as arrays:
            held = dict(arrays)
        if kind == "array":
            other = [np.zeros(0), np.zeros((2, 2)), np.array([-1]), np.array("x")]
            held[data.draw(st.sampled_from(sorted(held)))] = data.draw(st.sampled_from(other))
        elif kind == "about":
            about = json.loads(held["about"].tobytes())
            other = st.none() | st.integers(-1, 9) | TEXT | st.just([1])
            about[data.draw(st.sampled_from(sorted(about)))] = data.draw(other)
            held["about"] = np.frombuffer(json.dumps(about).encode(), np.uint8)
        else:
            field = data.draw(st.sampled_from(["first", "trials", "robots", "setting", "local"]))
            held["items"][field][0] = data.draw(st.sampled_from([0, 1, -1, 5, 2**31 - 1]))
        out = io.BytesIO()
        np.savez(out, **held)
        bytes_ = out.getvalue()
    with folder() as here:
        shutil.copy(small / "s.toml", here)
        shutil.copytree(small / "cut.nc.parts", here / "cut.nc.parts", ignore=shutil.ignore_patterns("*.npz"))
        name = original.name if kind == "bytes" else f"000001-{shards.HASH(bytes_).hexdigest()}.npz"
        (here / "cut.nc.parts" / name).write_bytes(bytes_)
        taken_or_refused(shards.read, here / "cut.nc.parts" / name)
        command("status", "cut.nc")
        if command("run", "s.toml", "--out", "cut.nc", "--jobs", 1) == 0:
            assert sc.load("cut.nc")["final_estimate"].shape == (8, 2, 3)


# ---- expressions and recordings
WORDS = st.sampled_from(
    ["robots", "topology", "accuracy", "fill_ratio", "brain", "setting", "==", "!=", "<", ">=", "in", "not", "and", "or",  # noqa: E501
     "(", ")", "[", "]", ",", "'ring'", '"', "3", "0.7", "-1", "1e999", "None", "True", "canary()", "__import__('os')",
     "9**9**9", "is", "lambda:", "0x" + "f" * 300, "0x" + "f" * 9000, ".", ":=", "\n", "\x00", "ü", "b'x'", "1j", "not " * 5000]  # noqa: E501
)  # fmt: skip


@fuzz(1600, st.lists(WORDS, max_size=9).map(" ".join) | st.text(max_size=20))
@example(f"accuracy == 0x{'f' * 300}")
def test_where(loaded, canary, text):
    chosen = taken_or_refused(where, loaded, text)
    assert not canary
    assert chosen is None or chosen.sizes["setting"] > 0


CELL = st.sampled_from(
    ["0", "1", "", "nan", "2", "-1", "0.5", " 1", "1.0", "x", "b", "w", "inf", "9" * 30, "9" * 5000, '"', "²", "\x00",
     "True", "0,5", "#", "{}", "step", "i", "j", "robot", "robot 0", "r1", "weight", "value", "\r"]
)  # fmt: skip
ROWS = st.integers(1, 3).flatmap(lambda wide: st.lists(st.lists(CELL, min_size=wide, max_size=wide), max_size=5))
ROWS |= st.lists(st.lists(CELL, max_size=4), max_size=5)
CSV = st.builds(lambda rows, between: "\n".join(map(between.join, rows)), ROWS, st.sampled_from([",", ";", "\t", " "]))


@fuzz(500, CSV | st.text(max_size=20), CSV, CSV | SCALAR.map(str))
def test_recordings(observations, links, accuracy):
    with folder() as here:
        for name, text in (("o.csv", observations), ("l.csv", links), ("a.csv", accuracy)):
            (here / name).write_text(text, encoding="utf-8", errors="replace")
        before = set(here.iterdir())
        seen = taken_or_refused(recordings.read_observations, here / "o.csv")
        heard = taken_or_refused(lambda: rows_of(read_links(here / "l.csv"), seen or recordings.NUMBERED))
        sure = taken_or_refused(recordings.read_accuracy, str(here / "a.csv"))
        if seen is not None:
            for used in (sure, 0.8):
                trace = taken_or_refused(inferring.infer, seen, heard, used)
                assert trace is None or np.isfinite(trace["estimate"].values).all()
        if command("infer", "o.csv", "--links", "l.csv", "--accuracy=a.csv", "--out", "t.nc"):
            assert set(here.iterdir()) == before
        taken_or_refused(recordings.read_accuracy, accuracy.replace("\0", ""))
