"""Linear consensus: in each phase, a robot steps towards the mean of its share of black and its neighbours' values.

LeBlanc, Zhang, Koutsoukos, Sundaram, "Resilient asymptotic consensus in robust networks", 2013, as robots ran it in
Strobel, Castello Ferrer, Dorigo, "Blockchain technology secures robot swarms", 2020. At the end of phase k

    u = mean of the share of black readings in the phase and of the values received in it;  x += (u - x) / k

As published: this step, phases of 45 s, silence in the first three phases, at most 20 distinct senders per phase, each
counted once.

Deviations:
- `debiased` = 1 replaces the share by clip((share + w - 1) / (b + w - 1), 0, 1), and 2 by the same without clip, whose
  mean is right for poor sensors too; 0, the default, is the raw share.
- `run`, the rounds of the whole run, makes a phase 4.5 % of it, as 45 s are of the published 1,000 s; with 0, the
  default, a phase takes `phase` rounds.
- The latest value of a sender counts; of several in one round under one name, as forgers send them, the smallest.
- If there are more than 20 senders, 20 are drawn at random: the first in an order of names that is drawn per phase.
- Values are clipped to [0, 1].
- Without a reading in the phase, u is the mean of the values received; without those too, x stays.
"""

SENDERS = 20  # counted per phase
PRIME = 67108859  # of 26 bits, so that products fit 53 bits; cubes are distinct because 3 does not divide PRIME - 1

PARAMETERS = {
    "phase": 450.0,  # rounds: 45 s of ticks
    "silent": 3.0,  # phases at the beginning in which it says nothing
    "run": 0.0,  # rounds of the whole run, to which phases are scaled; 0: they take `phase` rounds
    "debiased": 0.0,  # 1: the share is corrected for the sensor; 2: and not clipped
}
NEEDS = {
    "silent": "silent * (0.045 * run + phase * (not run))",
    "perfect_sensors": "not debiased",
}
MEMORY = {
    "x": 0.5,  # the value of the consensus
    "k": 1.0,  # the number of the phase
    "past": 0.0,  # its completed rounds
    "t": 0.0,  # observations made in it
    "n": 0.0,  # black ones among them
    "salt": 0.0,  # determines the order of names
    "senders": 0.0,  # that are kept
    "key": (0.0,) * 20,  # the places of their names in that order, rising
    "said": (0.0,) * 20,  # their last values
    "when": (0.0,) * 20,  # and the rounds of the phase in which they sent them
}
MESSAGE = ("x", "name")


def observe(me, blacks, looks):
    """Count readings."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """The value, after the silent phases."""
    if me.k <= me.silent:
        return None
    return me.x, me.name


def receive(me, message):
    """Keep the value, in the order of the places of senders' names."""
    x = min(max(message[0], 0.0), 1.0)
    key = place(message[1], me.salt)
    senders = int(me.senders)
    k = 0
    while k < senders and me.key[k] < key:
        k += 1
    if k < senders and me.key[k] == key:
        if me.when[k] < me.past or x < me.said[k]:
            me.said[k] = x
            me.when[k] = me.past
        return
    if k == SENDERS:
        return
    for j in range(min(senders, SENDERS - 1), k, -1):
        me.key[j] = me.key[j - 1]
        me.said[j] = me.said[j - 1]
        me.when[j] = me.when[j - 1]
    me.key[k] = key
    me.said[k] = x
    me.when[k] = me.past
    me.senders = min(senders + 1.0, 1.0 * SENDERS)


def place(name, salt):
    """The place of a name in the order given by `salt`: twice a shift and a cube, modulo PRIME."""
    k = int(name % PRIME)
    for _ in range(2):
        k = (k + int(salt)) % PRIME
        k = k * k % PRIME * k % PRIME
    return 1.0 * k


def fuse(me):
    """At the end of a phase, make the step."""
    me.past += 1.0
    if me.past < (me.phase if me.run == 0.0 else 0.045 * me.run):
        return
    total = 0.0
    values = me.senders
    for k in range(int(me.senders)):
        total += me.said[k]
    if me.t > 0.0:
        total += share(me)
        values += 1.0
    if values > 0.0:
        me.x += (total / values - me.x) / me.k
    me.k += 1.0
    me.past = 0.0
    me.t = 0.0
    me.n = 0.0
    me.senders = 0.0
    me.salt = 1.0 * int(me.luck * PRIME)


def share(me):
    """The share of black readings in the phase; with `debiased`, corrected for the sensor."""
    if me.debiased == 0.0:
        return me.n / me.t
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.5  # a sensor that tells nothing
    unbiased = (me.n / me.t + me.w - 1.0) / slope
    return unbiased if me.debiased == 2.0 else min(max(unbiased, 0.0), 1.0)


def estimate(me):
    """The value."""
    return min(max(me.x, 0.0), 1.0)  # rounding may exceed [0, 1]
