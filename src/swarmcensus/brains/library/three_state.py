"""Three-valued opinions: each bin is true, false or unsure; robots that found a good one dance for it, others listen.

Crosscombe, Lawry, Hauert and Homer, 2017. A robot's belief about each option is false (0), half (0.5) or true (1). Its
site is one of the options that it does not believe to be false. Every `every` rounds it makes a step. A robot that
dances goes on until its steps are over. A robot that does not dance takes the beliefs of a dancer that it heard, each
message equally likely, and merges them with its own:

    true and false -> half;    half and x -> x;    equal -> the same;    more than one true: all of these become half.

The true option, or a random half one, is then its site, for which it dances quality(site) steps, at least one. If it
heard nobody, it dances again for its site; if it only heard robots that do not dance, it waits. Beliefs begin randomly
false or true, with at least one true. As published: these rules and the step of 0.5 s, here in rounds of 0.1 s.

Deviations:
- In the source, robots know the qualities of their options, up to 25. Here the options are the ten bins of the fill
  ratio, and quality(bin) = dance * exp(-((middle of the bin - share) / width)^2 / 2), with the share of black in a
  robot's own readings.
- Steps are rounded up or down at random, so that their mean is the quality.
- All robots begin with a dance. A robot that has waited for `patience` steps dances again; otherwise all would wait for
  ever once nobody dances.
- Two robots without a common unsure bin would be left with none: all bins that either was unsure of stay half.
- `faulty` = 1 is the source's malfunction: a robot draws random beliefs where others listen. There, a tenth are faulty.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPTIONS = 10
BINS = 10
PARAMETERS = {
    "every": 5.0,  # rounds: one step
    "dance": 25.0,  # steps: the length of the dance for a bin whose middle is the share that it has seen
    "width": 0.2,  # the distance from that share over which quality falls
    "patience": 25.0,  # steps that it waits for a dancer
    "faulty": 0.0,  # 1: it draws random beliefs and never listens
    "debiased": 0.0,  # 1: the share of black is corrected for the sensor
}
NEEDS = {
    "robots": 50,  # with fewer, the right bin is often missing among the first ones
    "rounds": "20 * dance * every",
    "perfect_sensors": "not debiased",
}
MEMORY = {
    "beliefs": (0.5,) * 10,  # of each bin: 0 false, 0.5 half, 1 true
    "site": -1.0,  # the bin that it dances for; -1 before the first round
    "steps": 0.0,  # of the dance that are left; below 0: the number of waiting steps
    "clock": 0.0,  # rounds since its last step
    "t": 0.0,  # readings
    "n": 0.0,  # black ones among them
    "heard": 0.0,  # messages since its last step
    "dancers": 0.0,  # messages from dancers among them
    "kept": (0.5,) * 10,  # the beliefs of one dancer
}
MESSAGE = {"dancing": 0.0, "site": 0.0, "beliefs": (0.5,) * 10}


def observe(me, blacks, looks):
    """Count all readings."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """Whether it dances, for which bin, and what it believes."""
    return 1.0 if me.steps > 0.0 else 0.0, max(me.site, 0.0), me.beliefs


def receive(me, message):
    """Keep one message of dancers, each equally likely."""
    me.heard += 1.0
    if message[0] > 0.0:
        me.dancers += 1.0
        if me.luck * me.dancers < 1.0:
            for k in range(BINS):
                me.kept[k] = valued(message[2][k])


def valued(belief):
    """One of the three values."""
    return 1.0 if belief > 0.75 else 0.0 if belief < 0.25 else 0.5


def fuse(me):
    """Every few rounds, make one step of dancing, listening or waiting."""
    me.clock += 1.0
    if me.site < 0.0:
        draw(me)
        begin(me)
    if me.clock < me.every:
        return
    me.clock = 0.0
    if me.steps > 0.0:
        me.steps -= 1.0
        if me.steps == 0.0 and me.faulty > 0.0:
            draw(me)
            begin(me)
    elif me.dancers > 0.0:
        join(me)
        begin(me)
    elif me.heard == 0.0 or me.steps <= 1.0 - me.patience:
        begin(me)
    else:
        me.steps -= 1.0
    me.heard = 0.0
    me.dancers = 0.0


def draw(me):
    """Random beliefs: each non-empty set of true bins is equally likely."""
    bits = 1 + int(me.luck * (2.0**BINS - 1.0))
    for k in range(BINS):
        me.beliefs[k] = float(bits % 2)
        bits = bits // 2
    halve(me)


def join(me):
    """Merge its beliefs with those that it heard."""
    left = 0.0
    for k in range(BINS):
        left += joined(me.beliefs[k], me.kept[k])
    for k in range(BINS):
        if left > 0.0:
            me.beliefs[k] = joined(me.beliefs[k], me.kept[k])
        else:
            me.beliefs[k] = max(me.beliefs[k], me.kept[k])
    halve(me)


def joined(one, other):
    """Merge two beliefs about one bin."""
    if abs(one - other) == 1.0:
        return 0.5
    return other if one == 0.5 else one


def halve(me):
    """If more than one bin is true, all of these become half."""
    sure = 0
    for k in range(BINS):
        if me.beliefs[k] == 1.0:
            sure += 1
    for k in range(BINS):
        if sure > 1 and me.beliefs[k] == 1.0:
            me.beliefs[k] = 0.5


def begin(me):
    """Choose a site, at random among several, and the length of the dance for it."""
    found = truth(me)
    if found < 0:
        halves = 0
        for k in range(BINS):
            if me.beliefs[k] == 0.5:
                halves += 1
        chosen = int(4096.0 * me.luck % 1.0 * halves)
        for k in range(BINS):
            if me.beliefs[k] == 0.5:
                if chosen == 0:
                    found = k
                chosen -= 1
    me.site = float(found)
    me.steps = float(max(math.floor(quality(me) + 16777216.0 * me.luck % 1.0), 1))


def truth(me):
    """The bin that it believes to be true; -1 for none."""
    found = -1
    for k in range(BINS):
        if me.beliefs[k] == 1.0:
            found = k
    return found


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
    """Its site, once it believes all other bins to be false."""
    possible = 0
    for k in range(BINS):
        if me.beliefs[k] > 0.0:
            possible += 1
    return me.site if possible == 1 else -1.0


def estimate(me):
    """The mean of the bins' middles, weighted by the beliefs."""
    total = 0.0
    mean = 0.0
    for k in range(BINS):
        total += me.beliefs[k]
        mean += me.beliefs[k] * (k + 0.5) / BINS
    return mean / total
