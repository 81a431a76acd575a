"""The first round in which nearly the whole swarm decides for the correct bin (bins: paper, Sec. IV-A)."""

from math import inf

UNIT = "rounds"
MEANING = "first round with 95 % of the swarm in the correct bin; infinite where there is none"
BETTER = "low"
BOUNDS = (1.0, inf)
SHARE = 0.95


def begin(our):
    our.right = 0.0
    our.when = inf


def watch(our, k, estimate, truth):
    if our.low <= estimate < our.high:
        our.right += 1.0


def after(our, k):
    if our.right >= SHARE * our.robots:
        our.when = min(our.when, k)
    our.right = 0.0


def result(our):
    return our.when
