"""Swarms of processes in storms: robots are killed, restarted, stopped, cut off and flooded, and the rest goes on."""

import itertools
import random
import socket
import sys

import numpy as np
import pytest

from swarmcensus.robots.logs.logs import Gap, read_log
from swarmcensus.robots.swarm.plans import Air, plan_of
from swarmcensus.robots.swarm.reports import total
from swarmcensus.robots.swarm.running import run
from swarmcensus.robots.target import datagram_bytes
from tests.support.small import study_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes with signals")
ROBOTS, HZ, ROUNDS = 16, 50.0, 500


def storm(seed):
    """Faults of a storm; robot 0 has none but cuts."""
    chance, busy, faults = random.Random(seed), dict.fromkeys(range(ROBOTS), 0), []
    for at in np.linspace(50, ROUNDS - 100, 24).astype(int).tolist():
        do, robot, until = chance.choice(["kill", "stop", "restart", "cut"]), chance.randrange(1, ROBOTS), None
        if do != "cut" and busy[robot] > at:
            continue
        if do != "restart" and (do != "kill" or chance.random() < 0.7):
            until = at + chance.randrange(5, 90)
        blank = {"blank": True} if (do == "restart" or (do == "kill" and until)) and chance.random() < 0.5 else {}
        named = [*range(robot)] if do == "cut" else [robot]
        faults.append({"at": at, "do": do, "robots": {"named": named}} | blank | ({"until": until} if until else {}))
        if do != "cut":
            busy[robot] = until or (ROUNDS if do == "kill" else at + 1)
    return faults


def flood(swarm, chance):
    """Send each robot 75 random datagrams from a socket that none knows; half of them begin as messages do."""
    size = datagram_bytes(swarm.plan.setting.brain)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        for _, port in itertools.product(range(75), swarm.ports.values()):
            like = chance.random() < 0.5
            noise = bytes([swarm.plan.mark & 0xFF]) + chance.randbytes(size - 1)
            stranger.sendto(noise if like else chance.randbytes(chance.randrange(64)), ("127.0.0.1", port))


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_a_storm_ends_no_process(tmp_path, seed):
    world = {"topology": {"networkx": "circulant_graph", "offsets": [1, 2]}, "link_success": 0.8, "message": "ratio16"}
    study = study_of("commons", ROBOTS, 0.8, ROUNDS, looks=1, faults=storm(seed), **world)
    plan = plan_of(study, 0, 0, seed, Air(hz=HZ, duplicate=0.05, delay=10))
    seen, chance = [], random.Random(seed)

    def show(swarm):
        if chance.random() < 0.05:
            flood(swarm, chance)
        seen[:] = swarm.robots

    outcome = run(plan, tmp_path / "out", show).fields
    assert (outcome["died"], outcome["undone"]) == ({}, 0)
    assert total(seen, "refused") > 0
    logs = [read_log(tmp_path / "out" / f"robot-{number}.log") for number in range(ROBOTS)]
    gaps = [block for log in logs for block in log.blocks if isinstance(block, Gap)]
    assert all(gap.is_last or gap.length < 200 for gap in gaps)
    right = np.array(outcome["estimates"])
    right = right[np.isfinite(right)]
    assert len(right) >= ROBOTS // 3
    assert {m.sender for log in logs for tick in log.ticks for m in tick.heard} <= {*range(ROBOTS)}
    assert np.median(np.abs(right - 0.55)) < 0.06
    assert np.abs(right - 0.55).max() < 0.25
