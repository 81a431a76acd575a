"""What is printed of a swarm: what happens to robots, and how a run ends."""

import os
import re
import signal
import sys

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.swarm.outcomes import outcome_of
from swarmcensus.robots.swarm.plans import Air, plan_of
from swarmcensus.robots.swarm.reports import Report, RobotState
from swarmcensus.robots.swarm.running import RunningSwarm, run
from swarmcensus.support.errors import Interrupted
from tests.support.small import study_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes with signals")
SMALL = ["--set", "robots=4", "--set", "rounds=150", "--hz", "50"]


def plan(robots=20, liars=0):
    members = [{"robots": liars, "brain": "shouter", "honest": False}] if liars else []
    study = study_of("commons", robots, 0.8, rounds=500, looks=1, trials=1, members=members, message="ratio16")
    return plan_of(study, 0, 0, 0, Air())


def swarm(robots=20, liars=0, **more):
    """One in the middle of its run."""
    given = plan(robots, liars)
    known = []
    for k, member in enumerate(given.members):
        report = Report(k, 1, 1, 1, 200, 0, 0.5 if member.honest else 0.9, heard=99999, sent=99999, missed=1234)
        known.append(RobotState(report, None))
        known[-1].state = "stopped" if k == 3 else "runs"
    happened = ["1.0 s: kill robot 9", "2.0 s: restart robot 3", "4.0 s: stop robot 3"]
    return RunningSwarm(given, None, None, None, known, happened=happened, **more)


def test_the_memory_of_a_restarted_robot_is_reported(tmp_path):
    kills = [{"at": 231, "until": 241, "robots": {"named": [1]}}, {"at": 251, "until": 261, "robots": {"named": [2]}}]
    faults = [kills[0] | {"do": "kill"}, kills[1] | {"do": "kill", "blank": True}]
    given = plan_of(plan(4).study.with_(faults=faults), 0, 0, 0, Air(hz=100))
    seen = []

    def show(now):
        seen[:] = now.happened
        if (now.seconds > 3.5 and "starts blank" in str(seen)) or now.seconds > 20:  # of a busy machine
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as stopped:
        run(given, tmp_path / "out", show)
    assert any("robot 1 goes on from its tick 200" in event for event in seen)
    assert any("robot 2 starts blank" in event for event in seen)
    assert not any("robot 0" in event for event in seen)
    assert 300 < stopped.value.done < 500


def test_a_swarm_that_is_stopped_tells_what_there_is(tmp_path, capsys, monkeypatch):
    from swarmcensus.robots.swarm import running

    looked = running._bury

    def bury(now):
        looked(now)
        if now.seconds > 1.0:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(running, "_bury", bury)
    assert main(["swarm", "commons", *SMALL, "--out", str(tmp_path / "out")]) == 130
    printed = capsys.readouterr()
    assert "the mean over the " in printed.out
    assert printed.out.splitlines()[-1] == f"{tmp_path / 'out'}: 4 logs"
    ended = rf"next: swarmcensus relive {tmp_path}/out\nswarmcensus: stopped after \d+ of 150 rounds"
    assert re.search(ended, printed.err)


def test_means_are_of_honest_robots_at_work():
    some = swarm(liars=5)
    some.robots[7].state = "killed"
    counted = sum(m.honest and some.robots[m.number].state == "runs" for m in some.plan.members)
    outcome = outcome_of(some.plan, some.robots, 1.0, 1.0)
    assert f"error     0.0500, the mean over the {counted} honest robots at work at the end" in outcome.sentences
    assert outcome.code == 0
    nobody = outcome_of(plan(), [RobotState() for _ in range(20)], 1.0, 1.0)
    assert "error     unknown: no robot was at work at the end" in nobody.sentences
    assert nobody.code == 1
