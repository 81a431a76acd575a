"""Opposite: it says black of what it takes for white, and white of what it takes for black."""


def lie(me, x):
    return 1.0 - x
