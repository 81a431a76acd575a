"""How long a run takes, said before it begins where that is long."""

import logging
import warnings

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.runs import forecasts, progress
from swarmcensus.runs.tasks import plan_tasks
from swarmcensus.simulation.trials import seconds, walk_seconds

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
