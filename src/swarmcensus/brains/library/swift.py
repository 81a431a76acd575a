"""Swift: commons with momentum, so that news travels further in a round; off for good wherever who hears whom changes.

What a robot says next goes beyond the mean of the voices, by how far that mean is from what it said one round before:

    s, v <- M + g (M - said),    M the mean of own and heard, as in commons;    f = s / v of the means

A second-order step (Polyak, 1964, as it is used in consensus, Muthukrishnan, Ghosh, Schultz, 1998). Like M it treats s
and v alike, so f stays consistent. Where messages are lost, are old, or come from others than before, it swings up
without bound; and a robot with momentum does harm beside one without. So a robot is shaken as soon as it hears nobody,
or fewer or more than in its first round, or a mind without evidence (older than that mind's first reading), or somebody
who is shaken, which all tell. Who is shaken mixes as commons does, for good, and within a few rounds all are. Where
nothing changes, all keep their momentum.

The last 1 / (1 - g) rounds of readings do not count in full yet. Where one round mixes all that is a loss. So g falls
with the square of the voices heard above a crowd; and robots all of whose neighbours heard just whom they heard, which
in a connected swarm is true of all or none, give it up too. They tell it by what they say in place of whether they are
shaken: a mark of their own first, then for good the sum of all marks that they heard, which hardly ever is another's by
chance. Momentum begins in the third round, when all this is known. A robot whose v would halve by the step does without
it once. The prior is that of commons, as much larger as momentum has made the sums.
"""

PARAMETERS = {
    "momentum": 0.9,  # g
    "crowd": 50.0,  # voices from which on there is less of it
}
MEMORY = {
    "s": 0.0,  # said: evidence for black
    "v": 0.0,  # and evidence
    "said_s": 0.0,  # in the round before
    "said_v": 0.0,
    "mean_s": 0.0,  # the means, with the readings since
    "mean_v": 0.0,
    "unit": 0.0,  # what evidence of 1 a round would have become, said likewise
    "said_unit": 0.0,
    "rounds": 0.0,  # so far
    "first": 0.0,  # messages in the first round
    "company": 0.0,  # marks heard in the first round, and the own; 0 before, -1: shaken, no momentum
    "heard": 0.0,  # messages since the last round
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
    "heard_company": 0.0,
    "alarms": 0.0,  # messages of who is shaken, or knows nothing
}
MESSAGE = ("s", "v", "company")
ROLES = {"s": "information", "v": "confidence"}
SUMS = ("heard", "heard_s", "heard_v", "heard_company", "alarms")


def mark(me):
    """What sums seldom mistake for others: squares of names."""
    return (me.name + 1.0) ** 2


def observe(me, blacks, looks):
    """Unbiased evidence, by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.s += s
    me.v += v
    me.mean_s += s
    me.mean_v += v


def broadcast(me):
    """The sums, and whom the robot heard, or that it is shaken."""
    return me.s, me.v, me.company if me.rounds > 0.0 else mark(me)


def receive(me, message):
    """A neighbour's sums."""
    s, v, company = message
    me.heard += 1.0
    me.heard_s += s
    me.heard_v += v
    me.heard_company += company
    if company < 0.0 or v <= 0.0:
        me.alarms += 1.0


def fuse(me):
    """The mean of all voices, and the step beyond it."""
    voices = 1.0 + me.heard
    me.mean_s = (me.s + me.heard_s) / voices
    me.mean_v = (me.v + me.heard_v) / voices
    if me.rounds == 0.0:
        me.first = me.heard
        me.company = me.heard_company + mark(me)
    elif me.rounds == 1.0 and me.heard_company == me.heard * me.company:
        me.company = -1.0
    if me.heard == 0.0 or me.heard != me.first or me.alarms > 0.0:
        me.company = -1.0
    s = me.mean_s
    v = me.mean_v
    unit = me.unit + 1.0
    ahead_unit = unit
    if me.company > 0.0 and me.rounds > 1.0:
        g = me.momentum * min(1.0, me.crowd / voices) ** 2
        ahead = v + g * (v - me.said_v)
        if ahead > 0.5 * v:
            s += g * (s - me.said_s)
            v = ahead
            ahead_unit += g * (unit - me.said_unit)
    me.said_s = me.s
    me.said_v = me.v
    me.said_unit = unit
    me.s = s
    me.v = v
    me.unit = ahead_unit
    me.rounds += 1.0
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0
    me.heard_company = 0.0
    me.alarms = 0.0


def estimate(me):
    """The ratio of the means, with the prior, in [0, 1]."""
    if me.mean_v <= 0.0:
        return 0.5
    gain = max(me.said_unit / max(me.rounds, 1.0), 1.0)
    prior = min(0.25, 0.0625 * gain / me.mean_v) * gain
    return min(max((me.mean_s + 0.5 * prior) / (me.mean_v + prior), 0.0), 1.0)
