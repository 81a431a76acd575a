"""A trained net: five recurrent neurons turn readings and neighbours' messages into an estimate.

Inspired by the evolved recurrent controllers of Almansoori et al. (2022), of which only the abstract was available: a
continuous-time recurrent net whose output is its message. With s = 1/(1 + exp(-z)), neuron i follows

    tau_i dy_i/dt = -y_i + sum_j weights_ij s(y_j + bias_j) + inputs_i . (reading, opinion heard, whether any was heard)

by Euler's rule with a step of one round, and x = s(output . s(y + bias) + offset) is estimate and message. A robot does
not use its assumed sensor accuracy, unless `debiased` is 1. docs/rivals.md says how the weights were trained.

Deviations: everything above is a choice. Readings and opinions are numbers from -1 for white to 1 for black, and 0 for
none; those of a round are averaged. The message is the estimate itself, and not a colour. De-biased readings are not
clipped, because the mean of clipped values is not a share. Before the first round no neuron fires. It was trained to
answer after 100 rounds: with `run`, the rounds of the whole run, a step of the net is 100 / `run` rounds.
"""

import math

NEURONS = 5
INPUTS = 3  # reading, opinion heard, whether any was heard

# fmt: off
PARAMETERS = {
    "run": 0.0,  # rounds of the whole run, to which its 100 rounds of training are stretched; 0: a round is a round
    "debiased": 0.0,  # 1: readings are corrected for the assumed sensor accuracy
    "tau": (6.245, 1.6215, 47.817, 42.526, 14.135),  # rounds, at least 1
    "bias": (-1.0561, 1.4646, -1.1201, -1.7478, -2.8994),
    "inputs": (  # of each neuron
        -1.8906, 0.5379, -2.2285,
        -0.1063, 0.9064, -2.9196,
        1.1192, 2.8373, 1.9308,
        -2.5118, -1.0062, -2.8497,
        -2.5809, -2.8048, -2.6884,
    ),
    "weights": (  # of each neuron, from all neurons
        -3.1012, -3.5627, 0.9566, -3.4075, -1.1845,
        -3.7972, -1.3556, -2.7019, -3.7889, -1.9687,
        -3.7242, -3.4698, -2.7078, -1.8502, -0.544,
        -2.7063, 1.4216, 2.875, -2.8785, -0.958,
        2.5735, 2.939, -3.2562, 3.096, -0.899,
    ),
    "output": (0.476, 0.833, 4.65, -5.59, -5.779),
    "offset": -1.3164,
}
# fmt: on
NEEDS = {"length": "run + 100 * (not run)", "perfect_sensors": "not debiased"}
MEMORY = {
    "t": 0.0,  # readings since the last round
    "n": 0.0,  # black ones among them
    "heard": 0.0,  # messages since then
    "heard_x": 0.0,  # the sum of the estimates in them
    "y": (0.0,) * 5,  # the states of the neurons
    "fires": (0.0,) * 5,  # their outputs
    "x": 0.5,  # the estimate
}
MESSAGE = ("x",)
SUMS = ("heard", "heard_x")


def observe(me, blacks, looks):
    """Count readings."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """The output."""
    return (me.x,)


def receive(me, message):
    """Add up the estimates."""
    me.heard += 1.0
    me.heard_x += message[0]


def fuse(me):
    """One step of all neurons at once, then the output."""
    reading = seen(me)
    opinion = 0.0
    any_heard = 0.0
    if me.heard > 0.0:
        opinion = 2.0 * me.heard_x / me.heard - 1.0
        any_heard = 1.0
    step = 1.0 if me.run == 0.0 else 100.0 / me.run
    for i in range(NEURONS):
        k = INPUTS * i
        drive = me.inputs[k] * reading + me.inputs[k + 1] * opinion + me.inputs[k + 2] * any_heard
        for j in range(NEURONS):
            drive += me.weights[NEURONS * i + j] * me.fires[j]
        me.y[i] += step * (drive - me.y[i]) / max(me.tau[i], step, 1.0)
    total = me.offset
    for i in range(NEURONS):
        me.fires[i] = squash(me.y[i] + me.bias[i])
        total += me.output[i] * me.fires[i]
    me.x = squash(total)
    me.t = 0.0
    me.n = 0.0
    me.heard = 0.0
    me.heard_x = 0.0


def seen(me):
    """The round's readings: from -1 for white to 1 for black; 0 without readings, or if the sensor tells nothing."""
    if me.t == 0.0:
        return 0.0
    share = me.n / me.t
    if me.debiased == 0.0:
        return 2.0 * share - 1.0
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.0
    return 2.0 * (share + me.w - 1.0) / slope - 1.0


def squash(z):
    """The logistic function, in a form that never overflows."""
    return 0.5 + 0.5 * math.tanh(0.5 * z)


def estimate(me):
    """The output."""
    return me.x
