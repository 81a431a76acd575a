"""The weighted voter model: robots dance for a bin of the fill ratio, longer for a better bin, and others copy them.

This is the Boolean baseline with which Crosscombe, Lawry, Hauert and Homer, 2017, compare three-valued opinions. A
robot has one site, and makes a step every `every` rounds. A robot that dances goes on until its steps are over. A robot
that does not dance takes the site of a dancer that it heard, each message equally likely, and dances for it
quality(site) steps, at least one. If it heard nobody, it dances again for its own site; if it only heard robots that do
not dance, it waits. As published: these rules and the step of 0.5 s, here in rounds of 0.1 s.

Deviations:
- In the source, robots know the qualities of their options, up to 25. Here the options are the ten bins of the fill
  ratio, and quality(bin) = dance * exp(-((middle of the bin - share) / width)^2 / 2), with the share of black in a
  robot's own readings.
- Steps are rounded up or down at random, so that their mean is the quality.
- All robots begin with a dance. A robot that has waited for `patience` steps dances again; otherwise all would wait for
  ever once nobody dances.
- First sites are random, each bin equally likely; `faulty` = 1 is a robot that draws a random site where others listen.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPTIONS = 10
BINS = 10.0
PARAMETERS = {
    "every": 5.0,  # rounds: one step
    "dance": 25.0,  # steps: the length of the dance for a bin whose middle is the share that it has seen
    "width": 0.2,  # the distance from that share over which quality falls
    "patience": 25.0,  # steps that it waits for a dancer
    "faulty": 0.0,  # 1: it draws a random site and never listens
    "debiased": 0.0,  # 1: the share of black is corrected for the sensor
}
NEEDS = {
    "robots": 50,  # with fewer, the right bin is often missing among the first ones
    "rounds": "20 * dance * every",
    "perfect_sensors": "not debiased",
}
MEMORY = {
    "site": -1.0,  # the bin that it dances for; -1 before the first round
    "steps": 0.0,  # of the dance that are left; below 0: the number of waiting steps
    "clock": 0.0,  # rounds since its last step
    "t": 0.0,  # readings
    "n": 0.0,  # black ones among them
    "heard": 0.0,  # messages since its last step
    "dancers": 0.0,  # messages from dancers among them
    "kept": 0.0,  # the site of one dancer
}
MESSAGE = ("dancing", "site")


def observe(me, blacks, looks):
    """Count all readings."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """Whether it dances, and for which bin."""
    return 1.0 if me.steps > 0.0 else 0.0, max(me.site, 0.0)


def receive(me, message):
    """Keep one message of dancers, each equally likely."""
    me.heard += 1.0
    if message[0] > 0.0:
        me.dancers += 1.0
        if me.luck * me.dancers < 1.0:
            me.kept = message[1]


def fuse(me):
    """Every few rounds, make one step of dancing, listening or waiting."""
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
        me.site = float(math.floor(min(max(me.kept, 0.0), BINS - 1.0)))  # a liar may send something that is not a bin
        begin(me)
    elif me.heard == 0.0 or me.steps <= 1.0 - me.patience:
        begin(me)
    else:
        me.steps -= 1.0
    me.heard = 0.0
    me.dancers = 0.0


def drawn(me):
    """A random bin."""
    return float(math.floor(me.luck * BINS))


def begin(me):
    """Set the length of the dance for its site."""
    me.steps = float(max(math.floor(quality(me) + 16777216.0 * me.luck % 1.0), 1))


def quality(me):
    """The quality of its site, in steps."""
    share = 0.5
    if me.t > 0.0:
        share = me.n / me.t
        if me.debiased > 0.0:
            share = corrected(me, share)
    off = ((me.site + 0.5) / BINS - share) / me.width
    return me.dance * math.exp(-0.5 * off * off)


def corrected(me, share):
    """The share of black that explains this share of black readings; a half if the sensor tells nothing."""
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
