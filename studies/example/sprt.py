"""Wald's sequential test: mostly black or mostly white? A robot that is sure enough decides, and looks no more.

Wald, "Sequential tests of statistical hypotheses", 1945: the fill ratio is 0.5 + margin or 0.5 - margin, and readings
are made until one of both is so much likelier that the decision is wrong with the given probability at most.
"""

import math

PARAMETERS = {
    "margin": 0.05,  # how far the fill ratio is from 0.5
    "wrong": 0.01,  # how often a decision may be wrong
}
MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "evidence": 0.0,  # the logarithm of how much likelier its own readings are if the floor is mostly black
    "heard": 0.0,  # the sum of the neighbours' in this round
    "choice": -1.0,  # 0: white, 1: black
}
MESSAGE = ("evidence",)
SUMS = ("heard",)


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks
    high = seen_black(me, 0.5 + me.margin)
    low = seen_black(me, 0.5 - me.margin)
    me.evidence = me.n * math.log(high / low) + (me.t - me.n) * math.log((1.0 - high) / (1.0 - low))


def seen_black(me, fill_ratio):
    """The probability of a black reading."""
    return min(max(me.b * fill_ratio + (1.0 - me.w) * (1.0 - fill_ratio), 1e-9), 1.0 - 1e-9)


def broadcast(me):
    return (me.evidence,)


def receive(me, message):
    me.heard += message[0]


def fuse(me):
    known = me.evidence + me.heard
    me.heard = 0.0
    enough = math.log((1.0 - me.wrong) / me.wrong)
    if me.choice < 0.0 and abs(known) >= enough:
        me.choice = 1.0 if known > 0.0 else 0.0


def decide(me):
    return me.choice


def done(me):
    """It looks no more, and goes on telling what it has seen."""
    return me.choice >= 0.0


def estimate(me):
    slope = me.b + me.w - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return 0.5
    return min(max((me.n / me.t + me.w - 1.0) / slope, 0.0), 1.0)
