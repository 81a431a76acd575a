"""Three-valued opinions: of each bin true, false or unsure; robots that found a good one dance for it, others listen.

Crosscombe, Lawry, Hauert and Homer, 2017. A robot holds for each option false (0), half (0.5) or true (1), has a site
out of those it does not hold false, and every `every` rounds makes a step. One that dances goes on until its steps are
up. One that does not takes the beliefs of a dancer that it heard, each message as likely, and joins them to its own:

    true and false -> half;    half and x -> x;    alike -> the same;    more than one true: all of these become half.

The true option, or else a half one drawn by lot, is then its site, for which it dances quality(site) steps, at least
one. Where it heard nobody it dances again for its site; where only such as do not dance, it waits. Beliefs begin at
random out of false and true, with one true at least. As published are these rules and the step of 0.5 s, here in rounds
of 0.1 s.

Deviations:
- The original is told the qualities of its options, up to 25. Here the options are the ten bins of the fill ratio, and
  quality(bin) = dance * exp(-((middle of the bin - share) / width)^2 / 2), of the share of black in its own readings.
- Steps are rounded up or down by lot, so that their mean is the quality.
- All begin with a dance. Who has waited for `patience` steps dances again: all would wait for ever once nobody dances.
- Robots that are unsure of no bin in common would be left with none: all that either was unsure of stay half.
- `faulty` = 1 is their malfunction: a robot that draws beliefs at random where others listen. They make a tenth so.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPTIONS = 10
BINS = 10
PARAMETERS = {
    "every": 5.0,  # rounds: one step
    "dance": 25.0,  # steps: how long it dances for a bin whose middle is the share that it has seen
    "width": 0.2,  # how far from that share a bin is still good
    "patience": 25.0,  # steps that it waits for a dancer
    "faulty": 0.0,  # 1: it draws beliefs at random and never listens
    "debiased": 0.0,  # 1: the share of black is corrected for the sensor
}
MEMORY = {
    "beliefs": (0.5,) * 10,  # of each bin: 0 false, 0.5 half, 1 true
    "site": -1.0,  # the bin that it dances for; -1 before the first round
    "steps": 0.0,  # left to dance; below 0: so many it has waited
    "clock": 0.0,  # rounds since its last step
    "t": 0.0,  # readings
    "n": 0.0,  # of which said black
    "heard": 0.0,  # messages since its last step
    "dancers": 0.0,  # of which of robots that dance
    "kept": (0.5,) * 10,  # the beliefs of one of these
}
MESSAGE = {"dancing": 0.0, "site": 0.0, "beliefs": (0.5,) * 10}


def observe(me, blacks, looks):
    """Readings of its whole life."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """Whether it dances, for which bin, and what it believes."""
    return 1.0 if me.steps > 0.0 else 0.0, max(me.site, 0.0), me.beliefs


def receive(me, message):
    """Of what dancers say one message stays, each as likely."""
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
    """Every few rounds one step of the dance, of listening or of waiting."""
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
    """Beliefs at random: each set of bins that is not empty is as likely to be the true ones."""
    bits = 1 + int(me.luck * (2.0**BINS - 1.0))
    for k in range(BINS):
        me.beliefs[k] = float(bits % 2)
        bits = bits // 2
    halve(me)


def join(me):
    """Its beliefs and those that it heard."""
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
    """Two beliefs in one bin."""
    if abs(one - other) == 1.0:
        return 0.5
    return other if one == 0.5 else one


def halve(me):
    """More than one true: all of these become half."""
    sure = 0
    for k in range(BINS):
        if me.beliefs[k] == 1.0:
            sure += 1
    for k in range(BINS):
        if sure > 1 and me.beliefs[k] == 1.0:
            me.beliefs[k] = 0.5


def begin(me):
    """A site, of several one drawn by lot, and how long it dances for it."""
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
    """The bin that it holds true; -1 where there is none."""
    found = -1
    for k in range(BINS):
        if me.beliefs[k] == 1.0:
            found = k
    return found


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
    """Its site, once it holds all other bins false."""
    possible = 0
    for k in range(BINS):
        if me.beliefs[k] > 0.0:
            possible += 1
    return me.site if possible == 1 else -1.0


def estimate(me):
    """The mean over the bins' middles, each weighted by the belief in it."""
    total = 0.0
    mean = 0.0
    for k in range(BINS):
        total += me.beliefs[k]
        mean += me.beliefs[k] * (k + 0.5) / BINS
    return mean / total
