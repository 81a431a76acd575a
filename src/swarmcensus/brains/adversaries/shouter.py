"""Shouter: what is farthest from the truth as it sees it, `loud` times as sure as it is, and one more."""

PARAMETERS = {"loud": 1000.0}


def lie(me, x):
    return 0.0 if x >= 0.5 else 1.0


def boast(me, confidence):
    return me.loud * (confidence + 1.0)
