"""Opposite: it says white for black and black for white."""


def lie(me, x):
    return 1.0 - x
