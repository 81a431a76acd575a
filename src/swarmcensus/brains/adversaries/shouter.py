"""Shouter: it says what is farthest from its estimate, with its confidence plus 1, times `loud`."""

PARAMETERS = {"loud": 1000.0}


def lie(me, x):
    return 0.0 if x >= 0.5 else 1.0


def boast(me, confidence):
    return me.loud * (confidence + 1.0)
