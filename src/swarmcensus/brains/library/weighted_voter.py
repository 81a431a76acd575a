"""The weighted voter model: robots dance for a bin of the fill ratio, the longer the better it is, and others copy.

The Boolean baseline that Crosscombe, Lawry, Hauert and Homer, 2017, hold three-valued opinions against. A robot has
one site, and every `every` rounds makes a step. One that dances goes on until its steps are up. One that does not takes
over the site of a dancer that it heard, each message as likely, and dances for it quality(site) steps, at least one.
Where it heard nobody it dances again for its own site; where only such as do not dance, it waits. As published are
these rules and the step of 0.5 s, here in rounds of 0.1 s.

Deviations:
- The original is told the qualities of its options, up to 25. Here the options are the ten bins of the fill ratio, and
  quality(bin) = dance * exp(-((middle of the bin - share) / width)^2 / 2), of the share of black in its own readings.
- Steps are rounded up or down by lot, so that their mean is the quality.
- All begin with a dance. Who has waited for `patience` steps dances again: all would wait for ever once nobody dances.
- Sites begin at random, each bin as likely; `faulty` = 1 is a robot that draws its site at random where others listen.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPTIONS = 10
BINS = 10.0
PARAMETERS = {
    "every": 5.0,  # rounds: one step
    "dance": 25.0,  # steps: how long it dances for a bin whose middle is the share that it has seen
    "width": 0.2,  # how far from that share a bin is still good
    "patience": 25.0,  # steps that it waits for a dancer
    "faulty": 0.0,  # 1: it draws its site at random and never listens
    "debiased": 0.0,  # 1: the share of black is corrected for the sensor
}
MEMORY = {
    "site": -1.0,  # the bin that it dances for; -1 before the first round
    "steps": 0.0,  # left to dance; below 0: so many it has waited
    "clock": 0.0,  # rounds since its last step
    "t": 0.0,  # readings
    "n": 0.0,  # of which said black
    "heard": 0.0,  # messages since its last step
    "dancers": 0.0,  # of which of robots that dance
    "kept": 0.0,  # the site of one of these
}
MESSAGE = ("dancing", "site")


def observe(me, blacks, looks):
    """Readings of its whole life."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """Whether it dances, and for which bin."""
    return 1.0 if me.steps > 0.0 else 0.0, max(me.site, 0.0)


def receive(me, message):
    """Of what dancers say one message stays, each as likely."""
    me.heard += 1.0
    if message[0] > 0.0:
        me.dancers += 1.0
        if me.luck * me.dancers < 1.0:
            me.kept = message[1]


def fuse(me):
    """Every few rounds one step of the dance, of listening or of waiting."""
    me.clock += 1.0
    if me.site < 0.0:
        me.site = drawn(me)
        begin(me)
    if me.clock < me.every:
        return
    me.clock = 0.0
    if me.steps > 0.0:
        me.steps -= 1.0
        if me.steps == 0.0 and me.faulty > 0.0:
            me.site = drawn(me)
            begin(me)
    elif me.dancers > 0.0:
        me.site = float(math.floor(min(max(me.kept, 0.0), BINS - 1.0)))  # a liar may name no bin
        begin(me)
    elif me.heard == 0.0 or me.steps <= 1.0 - me.patience:
        begin(me)
    else:
        me.steps -= 1.0
    me.heard = 0.0
    me.dancers = 0.0


def drawn(me):
    """Any bin."""
    return float(math.floor(me.luck * BINS))


def begin(me):
    """How long it dances for its site."""
    me.steps = float(max(math.floor(quality(me) + 16777216.0 * me.luck % 1.0), 1))


def quality(me):
    """Steps, of its site."""
    share = 0.5
    if me.t > 0.0:
        share = me.n / me.t
        if me.debiased > 0.0:
            share = corrected(me, share)
    off = ((me.site + 0.5) / BINS - share) / me.width
    return me.dance * math.exp(-0.5 * off * off)


def corrected(me, share):
    """The share of black at which its sensor says black so often; a half where it says the same of both colours."""
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.5
    return min(max((share + me.w - 1.0) / slope, 0.0), 1.0)


def decide(me):
    """Its site."""
    return me.site


def estimate(me):
    """The middle of its site."""
    if me.site < 0.0:
        return 0.5
    return (me.site + 0.5) / BINS
