"""What a run says before and while it runs, in which order trials come, and what memory it takes."""

import io
import logging
import sys
import threading
import tracemalloc
import warnings

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.results import shards, values as arrays
from swarmcensus.runs import forecasts, pools, progress
from swarmcensus.runs.collect import Progress
from swarmcensus.runs.running import run
from swarmcensus.runs.tasks import plan_tasks
from swarmcensus.simulation.trials import seconds, walk_seconds
from swarmcensus.support.errors import InputError
from swarmcensus.support.readers import AS_TERMINAL
from tests.support.small import SEED, settings_of
from tests.support.trials import record_trial

ONE = {"topology": "ring", "fill_ratio": 0.55}
MOVING = {"topology": "moving", "density": 3, "fill_ratio": 0.55}
HEARD = "this takes "
FEW = """
name     = "small"
trials   = 4
swarm    = {robots = 5, accuracy = 0.8}
world    = {topology = "ring", fill_ratio = 0.55}
schedule = {rounds = 60}
"""


def study(rounds=2**31 - 1, trials=1, world=ONE, **tables):
    schedule = {"ticks" if world is MOVING else "rounds": rounds}
    swarm = {"robots": 20, "accuracy": 0.8} | tables.pop("swarm", {})
    return sc.Study(name="long", trials=trials, swarm=swarm, world=world, schedule=schedule, **tables)


def said(made, jobs, caplog):
    """What is told of a study before it begins, as lines and as warnings."""
    settings = made.settings()
    every = np.ones((len(settings), made.trials), np.bool_)
    tasks = plan_tasks(settings, every, every if made.measure.local else None, 0.1)
    caplog.clear()
    with caplog.at_level(logging.INFO), warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        forecasts.announce_length(made, settings, tasks, jobs)
    return caplog.messages, [str(one.message) for one in warned]


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr(forecasts, "cores", lambda: 2)


@pytest.mark.parametrize("world", [ONE, MOVING], ids=["ring", "moving"])
def test_a_study_of_2_to_the_31_rounds_says_so(world, caplog):
    made = study(world=world)
    (setting,) = made.settings()
    due = forecasts.duration_text(seconds(setting) + (walk_seconds(setting) if setting.body else 0.0))
    lines, warned = said(made, 2, caplog)
    said_once = [
        f"long: this takes {due} or more in 2 threads if nothing else keeps the machine busy. "
        f"A trial alone takes {due} or more: nothing of it is kept before its end"
    ]
    assert said_once in ([*lines], [*warned])


def test_a_run_of_days_is_a_warning_and_threads_share_it(caplog):
    made = study(rounds=200_000_000, trials=3000)
    (setting,) = made.settings()
    for jobs, cores in ((1, 1), (2, 2), (8, 2)):  # this machine has two cores
        lines, (warned,) = said(made, jobs, caplog)
        assert not lines
        due = forecasts.duration_text(3000 * seconds(setting) / cores)
        assert warned.startswith(f"long: this takes {due} or more in {jobs} thr")
        assert "alone" not in warned  # each is soon kept


def test_a_rule_is_a_least_time_and_a_cluster_is_counted_by_core(caplog):
    rule = {"until": "convergence_error median +- 0.02", "at_least": 10, "at_most": 20}
    made = study(rounds=100_000_000).with_(trials=rule)
    (line,), _ = said(made, None, caplog)
    due = made.trials * seconds(made.settings()[0])
    assert line == f"long: this takes {forecasts.duration_text(due)} or more of one core"


def test_short_studies_say_nothing(caplog):
    assert said(study(rounds=10_000, trials=100), 2, caplog) == ([], [])
    assert said(study(rounds=10_000, world=MOVING), 2, caplog) == ([], [])


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(300.0, "5 minutes"), (5400.0, "1.5 hours"), (9 * 86_400.0, "9 days"), (4e14, "13,000,000 years")],
)  # fmt: skip
def test_long_times(seconds, text):
    assert forecasts.duration_text(seconds) == text


def test_a_warning_comes_before_the_first_trial(here, monkeypatch, capsys):
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    (here / "small.toml").write_text(FEW)
    assert main(["run", "small.toml", "--jobs", "1"]) == 0
    assert HEARD not in capsys.readouterr().err
    for name, begin in (("LONG", "small: "), ("VERY_LONG", "warning: small: ")):
        monkeypatch.setattr(forecasts, name, 1e-9)
        assert main(["run", "small.toml", "--jobs", "1", "--fresh"]) == 0
        heard = capsys.readouterr().err
        assert heard.index(f"{begin}{HEARD}") <= heard.index("of 4 trials")


# ---- what a study's work is cut into, and the order in which it is run


LONG = {
    "trials": 40,
    "swarm": {"robots": [50, 100], "accuracy": [0.6, 0.8]},
    "world": {"topology": ["ring", "scale-free", "moving"], "density": 1, "fill_ratio": [0.55, 0.95]},
    "schedule": {"rounds": 1000, "ticks": 1000},
}


@pytest.mark.parametrize("local", [False, True])
@pytest.mark.parametrize("seconds", [0.1, 30.0], ids=["threads", "workers of a cluster"])
def test_some_trials_of_every_setting_come_before_more_of_any(seconds, local):
    tables = LONG
    if local:
        tables = LONG | {"world": {"topology": ["ring", "full"], "fill_ratio": 0.55}, "schedule": {"rounds": 1000}}
    settings = sc.Study(**tables).settings()
    wanted = np.ones((len(settings), 40), np.bool_)
    tasks = plan_tasks(settings, wanted, wanted if local else None, seconds)
    seen = np.zeros((2, *wanted.shape), np.int64)
    for task in tasks:
        of_kind = seen[int(task.kind == "local")]
        before = of_kind.any(axis=1)
        again = before[list(task.settings)].any()
        assert not again or seen[: 1 + local].any(axis=2).all(), "a second task before the first of another setting"
        of_kind[list(task.settings), task.first : task.first + task.trials] += 1
    assert (seen[: 1 + local] == 1).all(), "every trial once"


def test_trials_done_already_are_left_out():
    settings = sc.Study(**LONG).settings()
    wanted = np.random.default_rng(1).random((len(settings), 40)) < 0.3
    seen = np.zeros(wanted.shape, np.int64)
    for task in plan_tasks(settings, wanted, None, 0.1):
        seen[list(task.settings), task.first : task.first + task.trials] += 1
    assert np.array_equal(seen, wanted)


# ---- what a person sees who waits for the compiler: one line with a count, whatever the number of brains


class Terminal(io.StringIO):
    """A terminal of 100 columns, as far as a bar is concerned."""

    def isatty(self):
        return True


def waited(show, kinds=60):
    """Show how so many kinds of swarms are compiled, and then a trial that is run."""
    for k in range(kinds):
        show(Progress(0, 0, 0.0, 0.0, f"compiling {k + 1} of {kinds}: voter", steps=(k, kinds)))
    show(Progress(0, 1, 0.0, 1.0))
    show(Progress(1, 1, 1.0, 1.0))


@pytest.mark.parametrize("asked", ["", "FORCE_COLOR", "TTY_COMPATIBLE"])  # as continuous integration does
def test_compiling_many_brains_without_a_terminal(asked, monkeypatch, capsys):
    monkeypatch.delenv(AS_TERMINAL)
    monkeypatch.setenv(asked or "NOTHING", "1")
    with progress.bar_or_lines("board") as show:
        waited(show)
    assert capsys.readouterr().err.splitlines() == ["board: 0 of 1 trial, starting"]  # a log says what is compiled
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    with progress.bar_or_lines("board") as show:
        waited(show)
    assert "board: compiling 37 of 60: voter, about 0:00 left" in capsys.readouterr().err.splitlines()


def test_the_time_that_compiling_takes_is_told_from_the_first_compilations(monkeypatch):
    """What was done before takes no part in it: here some trials, in an hour."""
    now = iter([0.0, 3600.0, 3660.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(now))
    pace = progress._Pace()
    assert pace.of(Progress(0, 0, 0.0, 0.0, "compiling", steps=(0, 112))) == ("", "")
    assert pace.of(Progress(0, 0, 0.0, 0.0, "compiling", steps=(28, 112))) == ("", "about 3:00 left")


def test_compiling_bar_on_a_terminal(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv(AS_TERMINAL, "100")
    monkeypatch.setenv("TERM", "xterm")
    before = threading.active_count()
    with progress.bar_or_lines("board") as show:
        assert threading.active_count() == before  # a process with threads cannot be copied, and would compile alone
        waited(show)
    seen = terminal.getvalue()
    assert all(f"compiling {k} of 60: voter" in seen for k in range(1, 61))
    assert "60 trials" not in seen


# ---- what a study of large swarms keeps in memory while it runs, and what it does not


ROBOTS = 60_000
BYTES = 36 * ROBOTS  # of results, a setting


def crowds(settings, robots=ROBOTS, trials=1):
    return sc.Study(
        trials=trials, swarm={"robots": robots, "accuracy": [round(0.6 + 0.02 * k, 2) for k in range(settings)]},
        world={"topology": "ring", "fill_ratio": 0.55}, schedule={"rounds": 2},
    )  # fmt: skip


@pytest.fixture
def small_arrays(monkeypatch):
    """Arrays of a megabyte are large."""
    monkeypatch.setattr(arrays, "LARGE_BYTES", 1_000_000)
    monkeypatch.setattr(arrays, "FRESH_BYTES", 1_000_000)
    monkeypatch.setattr(shards, "SPOOLED_BYTES", 1_000_000)


def peak(settings, out):
    """The most bytes that a run has at once, but for what lies in files; and its dataset."""
    tracemalloc.start()
    try:
        data = run(crowds(settings), 1, progress=False, out=out)
        return tracemalloc.get_traced_memory()[1], data
    finally:
        tracemalloc.stop()


def test_the_numbers_of_large_settings_do_not_add_up_in_memory(small_arrays, tmp_path, monkeypatch):
    """Ten settings take no more than one and some that wait to be written, of which there are four at the most."""
    monkeypatch.setattr(pools, "BUNDLE_SECONDS", 0.0)
    monkeypatch.setattr(shards, "AT_LEAST", 0.0)  # as of trials that take seconds
    monkeypatch.setattr(shards, "OF_ELAPSED", 0.0)
    monkeypatch.setattr(shards, "SKETCH_AFTER", (0.0, 0.0))
    run(crowds(1, 10), 1, progress=False)  # compiles, and imports what is imported late
    one, _ = peak(1, tmp_path / "one.nc")
    ten, data = peak(10, tmp_path / "ten.nc")
    assert ten - one < 5 * BYTES
    assert {path.name for path in tmp_path.iterdir()} == {"one.nc", "ten.nc"}
    assert sc.load(tmp_path / "ten.nc").equals(data)
    assert sc.load(tmp_path / "one.nc").equals(sc.load(tmp_path / "ten.nc").sel(setting=[0]))


def test_a_folder_without_space_for_results_is_reported(small_arrays, tmp_path, monkeypatch):
    def full(**_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(arrays.tempfile, "TemporaryFile", full)
    with pytest.raises(InputError, match=r"cannot keep results in .*: No space left on device"):
        run(crowds(5), 1, progress=False, out=tmp_path / "a.nc")
    assert not list(tmp_path.iterdir())


def test_a_replay_of_a_single_round_begins_before_it():
    (setting,) = settings_of(rounds=1)
    fields, estimates, _ = record_trial(setting, SEED, 0)
    assert (fields["t"][0] == 0.0).all()
    assert (estimates[0] == 0.5).all()
