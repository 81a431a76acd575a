"""Whole: has all that a brain may have, and calls it what headers of boards and simulators call other things.

Commons with fewer numbers, and beside it votes for one of three options, of which a robot keeps one at random.
"""

import math

RESET = (0.5, 1.0, 2.0)  # a table of real numbers
RUN = ((0, 1), (1, 0))  # and one of whole numbers
PORTB = 0.25

PARAMETERS = {
    "NORMAL": 0.5,  # the weight of its own numbers
    "SREG": (0.75, 1.0),  # of readings in even and in odd rounds
    "delay": 12.0,  # readings after which it is done
}
MEMORY = {
    "SP": 0.0,  # evidence for black
    "PB0": 0.0,  # evidence
    "kilo_ticks": 0.0,  # rounds
    "SLEEP": (0.0, 0.0, 0.0),  # votes
    "OCR0A": 0.0,  # messages since the last round
    "main": 0.0,  # the sum of the evidence for black in them
    "B": 0.0,  # and of the evidence
    "W": 0.0,  # one of their options, each as likely
    "t": 0.0,  # readings
    "UCSR0A": 0.0,  # the random number of the last one
}
MESSAGE = ("SP", "PB0")
ROLES = {"SP": "information", "PB0": "confidence"}
OPTIONS = 3
NEEDS = {"rounds": "delay"}


def observe(me, blacks, looks):
    slope = me.b + me.w - 1.0
    weight = me.SREG[int(me.kilo_ticks) % 2]
    me.SP += weight * slope * (blacks - looks * (1.0 - me.w))
    me.PB0 += weight * slope * slope * looks
    me.UCSR0A = me.luck
    me.t += looks


def rand_soft(luck):
    return min(math.floor(3.0 * luck), 2)


def broadcast(me):
    if int(me.kilo_ticks + me.name) % 5 == 4:
        return None
    return me.SP, me.PB0


def receive(me, message):
    me.OCR0A += 1.0
    me.main += message[0]
    me.B += message[1]
    if me.luck * me.OCR0A < 1.0:
        me.W = 1.0 * option(message[0], message[1])


def fuse(me):
    n = 0
    for k in range(len(RESET)):
        n += RUN[k % 2][1 - k % 2]
        me.SLEEP[k] *= RESET[1] - PORTB * me.luck
    if me.OCR0A > 0.0 and n == 3:
        voltage = me.NORMAL + (1.0 - me.NORMAL) / (1.0 + me.OCR0A)
        me.SP = voltage * me.SP + (1.0 - voltage) * (me.main / me.OCR0A)
        me.PB0 = voltage * me.PB0 + (1.0 - voltage) * (me.B / me.OCR0A)
        me.SLEEP[int(me.W)] += 1.0
    me.SLEEP[rand_soft(me.UCSR0A)] += PORTB
    delay(me)


def delay(me):
    me.kilo_ticks += 1.0
    me.OCR0A = me.main = me.B = 0.0


def estimate(me):
    return set_color(me.SP, me.PB0)


def set_color(evidence, size):
    return min(max(evidence / size, 0.0), 1.0) if size > 0.0 else 0.5


def option(evidence, size):
    return min(int(3.0 * set_color(evidence, size)), 2)


def decide(me):
    if done(me):
        return option(me.SP, me.PB0)
    return -1


def done(me):
    return me.t >= me.delay


def interval(me):
    x, half = estimate(me), RESET[0] / (1.0 + me.PB0)
    return max(0.0, x - half), min(1.0, x + half)


def steer(me):
    if me.t < 2.0:
        return None
    return 0.1, me.luck - 0.5
