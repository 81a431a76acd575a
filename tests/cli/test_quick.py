"""What makes it quick to try something: what is not imported, not compiled again, and done beside something else."""

import subprocess
import sys
import textwrap
from itertools import accumulate
from types import SimpleNamespace

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.engine import codegen, compiler, python_errors
from swarmcensus.engine.constants import BLOCK, PHASES
from swarmcensus.simulation.trials import Metrics, run_batch
from tests.support.small import GO, SEED, settings_of, study_of
from tests.support.trials import record_trial


def python(code, *words, **more):
    words = [sys.executable, "-c", textwrap.dedent(code), *words]
    return subprocess.run(words, capture_output=True, text=True, check=False, **more)


HEAVY = {"numba", "xarray", "pandas", "matplotlib", "networkx", "h5py", "scipy", "jinja2"}
USES = [  # and what each needs no more than those before it
    ("main(['--help'])", HEAVY | {"numpy", "pydantic"}),
    ("main(['plot', '--help'])", HEAVY | {"numpy", "pydantic"}),
    ("main(['show', 'nothing.nc'])", HEAVY),
    ("import swarmcensus.studies.study", HEAVY),
    ("main(['run', 'wrong.toml'])", HEAVY),
    ("main(['doctor'])", {"numba", "xarray", "matplotlib"}),
    ("import swarmcensus as sc; sc.Study; sc.run; sc.plot; dir(sc.plot)", {"matplotlib", "jinja2"}),
    ("from swarmcensus.figures.plot import lines", {"matplotlib.pyplot"}),
]


def test_slow_libraries_are_imported_where_they_are_needed(here):
    (here / "wrong.toml").write_text("trial = 3")
    lines = [f"{code}\nfor name in {unused} & sys.modules.keys():\n    found.append(name)" for code, unused in USES]
    code = ["import sys", "from swarmcensus.cli.commands import main", "found = []", *lines]
    done = python("\n".join([*code, "print(*found, file=sys.stderr)"]))
    assert (done.returncode, done.stderr.splitlines()[-1]) == (0, "")


def test_program_runs_exit_handlers_and_joins_threads():
    code = """
        import atexit, sys, threading, time
        from swarmcensus.cli import commands, program
        def late():
            time.sleep(0.3)
            print("thread")
        def main():
            if sys.argv[1] == "thread":
                threading.Thread(target=late).start()
            return 7
        commands.main = main
        atexit.register(lambda: print("end"))
        program.program()
    """
    for word, said in (("none", ["end"]), ("thread", ["thread", "end"])):
        done = python(code, word)
        assert (done.returncode, done.stdout.split()) == (7, said)


# ---- what a brain's machine code depends on
SOURCE = brains.load("minimalistic").source


def brain_of(source):
    return brains.parse(source, "mine", brains.load("minimalistic").path)


@pytest.mark.parametrize("other", [
    SOURCE + "\n# more\n",
    SOURCE.replace('"""The informed estimate."""', '"""What it thinks."""'),
    SOURCE.replace("    return me.x\n", "\n\n    return (me.x)  # so\n"),
    SOURCE.replace('"x": 0.5', '"x": 0.25'),
])  # fmt: skip
def test_brains_that_differ_in_words_alone_share_machine_code(other):
    assert other != SOURCE
    assert codegen.essence(other) == codegen.essence(SOURCE)
    assert compiler._brain_files(brain_of(other)) == compiler._brain_files(brain_of(SOURCE))
    assert compiler.compile_brain(brain_of(other)).tolist() == compiler.compile_brain(brain_of(SOURCE)).tolist()


@pytest.mark.parametrize("other", [
    SOURCE.replace("1e-12", "1e-11"),
    SOURCE.replace('"heard", "heard_alpha"', '"heard_alpha", "heard"'),
    SOURCE.replace('"beta": 0.0', '"beta_": 0.0').replace("me.beta", "me.beta_"),
])  # fmt: skip
def test_brains_that_differ_otherwise_do_not(other):
    assert compiler._brain_files(brain_of(other)) != compiler._brain_files(brain_of(SOURCE))


def test_initial_memory_is_not_compiled_in(tmp_path):
    (tmp_path / "mine.py").write_text(SOURCE.replace('"x": 0.5', '"x": 0.25'))
    readings = np.full((1, 2), np.nan)
    for name, first in (("minimalistic", 0.5), (str(tmp_path / "mine.py"), 0.25)):
        for compiled in (True, False):
            trace = sc.infer(readings, None, 0.7, 1, name, compiled=compiled)
            assert trace["estimate"].values.tolist() == [[first] * 2] * 2


def test_machine_code_is_of_the_essence_of_a_file():
    reads = SOURCE.replace("def broadcast", 'FIRST = MEMORY["x"]\n\n\ndef broadcast')
    assert "MEMORY" in codegen.essence(reads)
    assert "MEMORY" not in codegen.essence(SOURCE)
    assert '"""' not in codegen.essence(SOURCE)
    source = SOURCE.replace("def share", 'def nothing(me):\n    """Do nothing."""\n\n\ndef share')
    assert "pass" in codegen.essence(source)
    compile(codegen.essence(source), "mine", "exec")
    deep = SOURCE.replace("    return me.x\n", "    return me.x + " + " + ".join(["0.0"] * 600) + "\n")
    assert codegen.essence(deep) == deep


@pytest.mark.parametrize("use", ["network", "moving", "alone", "recorded"])
def test_only_what_a_use_calls_is_compiled(use):
    brain = brains.load("minimalistic")
    there = {name for name, where in zip(PHASES, compiler.compile_brain(brain, use), strict=True) if where}
    assert there == compiler.needs(brain, use)
    uses = {"hear_all": ("network",), "hear_sums": ("network", "moving"), "go_alone": ("alone",), "ask": ()}
    assert {phase for phase in uses if phase in there} == {phase for phase, where in uses.items() if use in where}


FAILS_IN = {
    "observe": "me.x = 1.0 / (me.t - me.t)", "broadcast": "return 1.0 / (me.t - me.t), 0.0",
    "receive": "me.heard += 1.0 / (me.t - me.t)", "fuse": "me.x = 1.0 / (me.t - me.t)",
    "estimate": "return 1.0 / (me.t - me.t)",
}  # fmt: skip


@pytest.mark.parametrize("function", FAILS_IN)
def test_error_inside_a_call_names_the_brain(function, tmp_path):
    """It reaches Python as what it was, and the next run is sound. One machine code for all: a parameter says where."""
    lines = SOURCE.replace("SUMS = ", 'PARAMETERS = {"fails_in": -1.0}\nNOTHING = ').split("\n")
    for k, (name, does) in enumerate(FAILS_IN.items()):
        at = next(k for k, line in enumerate(lines) if line.startswith(f"def {name}("))
        lines.insert(at + 2, f"    if me.fails_in == {k}.0 and me.t >= 20.0:\n        {does}")
    (tmp_path / "mine.py").write_text("\n".join(lines))
    used = {"file": str(tmp_path / "mine.py"), "fails_in": float([*FAILS_IN].index(function))}
    (setting,) = settings_of(brain=used, rounds=8, looks=5)
    with pytest.raises(sc.InputError, match=r"ZeroDivisionError: division by zero$"):
        run_batch(setting, SEED, 0, 1, Metrics(0.01, 10, ()), GO)
    (setting,) = settings_of(rounds=8, looks=5)
    assert np.isfinite(run_batch(setting, SEED, 0, 1, Metrics(0.01, 10, ()), GO).error).all()


def test_uncompiled_functions_are_not_called(monkeypatch):
    (setting,) = settings_of(rounds=8, looks=5, link_success=0.5)
    monkeypatch.setattr(type(setting), "use", "in sums")
    with pytest.raises(sc.InputError, match="SystemError: a function is called that was not compiled for this use"):
        run_batch(setting, SEED, 0, 1, Metrics(0.01, 10, ()), GO)


def sums_of_others(terms):
    """For each robot, the sum over the robots before it and the sum over those after it, block by block."""
    blocks = [terms[k : k + BLOCK].tolist() for k in range(0, len(terms), BLOCK)]
    sums = [list(accumulate(block, initial=0.0))[-1] for block in blocks]
    before, after = accumulate(sums, initial=0.0), list(accumulate(sums[::-1], initial=0.0))[-2::-1]
    first = [x for block, b in zip(blocks, before, strict=False) for x in accumulate(block[:-1], initial=b)]
    last = [x for block, a in zip(blocks, after, strict=True) for x in [*accumulate(block[:0:-1], initial=a)][::-1]]
    return np.array(first) + np.array(last)


@pytest.mark.parametrize("robots", [256, 300, 5000])
def test_large_full_networks_add_messages_in_blocks(robots):
    """To the bit, in the order that `hear_all` says; up to 256 robots, it is that of the robots."""
    (setting,) = settings_of(robots=robots, rounds=3, looks=10, topology="full", accuracy="U(0.6, 0.9)")
    states, _, _ = record_trial(setting, SEED, 1)
    for k in (1, 3):
        beta = sums_of_others(states["alpha"][k])
        assert np.array_equal(states["beta"][k], beta)
        assert np.array_equal(states["x_bar"][k], sums_of_others(states["alpha"][k] * states["x_hat"][k]) / beta)
    assert np.array_equal(run_batch(setting, SEED, 1, 1, Metrics(0.01, 10, ()), GO).final[0], states["x"][3])


@pytest.mark.long(but_every=2)
@pytest.mark.parametrize(("sound", "broken", "where"), [
    ("return me.x_hat, me.alpha", "return me.x", ""), ("me.heard += 1.0", "me.heard += 'one'", ", at mine.py, line"),
])  # fmt: skip
def test_a_brain_that_does_not_compile_is_named_with_its_line(sound, broken, where, here, capsys):
    assert SOURCE.count(sound) == 1
    (here / "mine.py").write_text(SOURCE.replace(sound, broken))
    for more in ({"rounds": 3}, {"ticks": 3, "density": 1.0}):
        (here / "s.toml").write_text(study_of("mine.py", robots=3, trials=1, fill_ratio=0.5, **more).text)
        assert main(["run", "s.toml"]) == 2
        said = capsys.readouterr().err.splitlines()[-1]
        assert "brain 'mine.py' fails in trial 0" in said
        assert f"cannot be compiled: swarmcensus brains --check mine.py says why{where}" in said


# ---- work in a copy of the process
def test_background_work_returns_its_result():
    """Nor is a copy made in a worker of somebody's pool, beside other threads, or where the system refuses one."""
    code = """
        import multiprocessing, os, threading
        from swarmcensus.support.fork import in_background
        here = os.getpid()
        def fails():
            raise ValueError("no")
        assert in_background(os.getpid)() not in (here, None)
        try:
            in_background(fails)()
        except ValueError as error:
            print(error)
        print(in_background(lambda: os._exit(1) if os.getpid() != here else "here")())  # a copy that dies
        def same(_):
            return in_background(os.getpid)() == os.getpid()
        with multiprocessing.get_context("fork").Pool(1) as pool:
            print(pool.map(same, [0])[0])
        other, done = threading.Event(), []
        threading.Thread(target=other.wait).start()
        ended = in_background(lambda: done.append(os.getpid()))
        print(done == [] and ended() is None and done == [here])
        other.set()
        def refused():
            raise OSError("no more processes")
        os.fork = refused
        print(same(0))
    """
    done = python(code)
    assert (done.returncode, done.stdout.split()) == (0, ["no", "here", "True", "True", "True"]), done.stderr


def test_powers_raise_as_in_cpython_and_their_operands_are_worked_out_once():
    source = """STEP = 2.0 ** -20
def writes(me):
    me.x = me.x + 1.0
    return me.x
def fuse(me):
    me.x **= 2
    return writes(me) ** 2 + writes(me) ** -1 + me.x ** 0.5
"""
    power = python_errors._power
    space = {python_errors.POWER: power, python_errors.RAISED: lambda x, y: power(x**y, x, y)}
    exec(codegen.essence(source), space)
    me = SimpleNamespace(x=2.0)
    assert space["fuse"](me) == 5.0**2 + 1.0 / 6.0 + 6.0**0.5
    assert me.x == 6.0
    me.x = np.float64(1e200)
    with np.errstate(all="ignore"), pytest.raises(OverflowError):
        space["fuse"](me)
