"""Census: commons that weighs readings by their age, finds changes of the floor, and bounds what liars can do.

Three pairs of sums of the evidence of `commons` are mixed alike, with k = b + w - 1; docs/census.md derives all of it:

    s, v    all readings, with the momentum of `swift` while the network is steady
    S, V    ripe: after each round of mixing    S <- S (1 - v / V') + s,    V <- V' = V + 2 v / 3
    a, e    short: the latest readings, at most a quarter of v and at most `memory`

Ripening. S / V is a mean of s / v over all rounds, in which a reading made in round r has the weight 1 - (r / t)^2,
because mixing has spread old readings over more robots. V / v tells t. All sums treat s and v alike, so S / V is
consistent for f, whatever is lost or late, and if robots move, fail or join late.

Change. If the floor has changed, a / e differs from S / V by more than chance. Coins tell what chance does: where a
round's readings add r to e, heads or tails add sqrt(r) / 2 to a sum c or take it away. c is mixed and forgotten as a
is. The noise d is the mean of c^2 / e over rounds and robots. A robot begins anew, from a and e cut to KEPT, if

    (S / V - a / e)^2 > z^2 d / e    or    > (confirm^2 + 2 ln(n / 8 m)) d / e, if m > 0 of n voices have begun anew

and counts the long sums only of robots that have, until v is SETTLED. It tries the change: to its trust in it, it adds
the logarithms of how much likelier each new reading is if S / V of the round before is true than if its own old ones
are. Above SURE, its own sums begin anew too. If the change is refuted, the next trust is half as large, after a pause.

Liars. Each robot also says the sums o, p of its own readings alone. A neighbour whose own readings differ from its own
by more than PAIR standard errors is not heard. Of the others it makes r, a mean that a minority cannot draw far, with
the standard error E = 1 / (2 sqrt(p n)) for n robots. Then

    sums whose S / V is more than GATE E from r are not counted, and weights are at most CAP times the own
    the estimate is S / V; where that is more than CUT_OFF E from r, it is drawn to r, and is r from FAR_OFF E on
    if its own S / V is, the robot sets its sums to r: others have mixed in lies

A robot that has done so, or has heard own readings more than CLEAR standard errors off, is on guard as long as it has
run: its limits are narrower, and its sums are drawn to r by LEAN shares of new readings a round.

Patches. Where successive readings of a robot are alike, as on black in clusters, d is at least the mean of what
(S / V - a / e)^2 e has been, cut at CUT^2 d, and standard errors of own readings are `alike` / PATCHY times as large.
"""

import math

OWN = 3.0  # the weight of the own sums in a mean without momentum, in messages, if fewer arrive
KEPT = 1.0  # evidence in the sums of a robot that begins anew, in readings of a perfect sensor
SETTLED = 30.0  # evidence from which on it counts the sums of all robots again
LEAST = 10.0  # evidence that the short sums may always hold
CROWDED = 8.0  # times the voices heard: the most robots for which short sums are taken to stand
MIXED = 2.0  # the same where one round mixes all
PRIOR_WINDOWS = 2.0  # the weight of the first guess of the noise, in lives of the short sums
WINDOWS = 16.0  # lives of the short sums over which the noise is averaged
FEW = 8.0  # voices of which one that begins anew is as good as all
CUT = 3.0  # deviations beyond which a difference counts no further in the noise seen
PATCHY = 0.05  # correlation of successive readings on ground in patches
WALK = 0.002  # the share of a round in that correlation
OLDEST = 16384.0  # rounds: the sums forget older readings, so that they bear single precision
PAIR = 4.5  # standard errors of the difference of two robots' own readings, beyond which one is not heard
CLEAR = 5.5  # and beyond which it is a lie
NEAR = 2.5  # standard errors within which the own readings of others count in r
WINSOR = 0.6  # and beyond which they count as if they were so far off
MOST = 30.0  # robots that count in its standard error, at most
RECENT = 20.0  # r is averaged over the last 1 / RECENT of all rounds
CAP = 2.0  # the largest weight of a message, in own weights
GATE = 5.0  # standard errors of r, from it to the sums that count, and to own sums that others have not spoilt
CUT_OFF = 1.75  # and to the estimate
FAR_OFF = 2.5  # and to sums so far off that r is the estimate
GUARDED_GATE = 0.75  # the same for a robot on guard
GUARDED_CUT_OFF = 0.5
GUARDED_FAR_OFF = 1.0
LEAN = 3.0  # its pull to r, in shares of new readings
TRUST = 4.0  # in a change that others tell of, in nats
SURE = 4.5  # and when own readings confirm it
DOUBT = 3.5  # below which the estimate is cut again
LEAST_TRUST = 0.5  # after lies
PAUSE = 4.0  # rounds without a search for changes, at full trust
STEEPEST = 1e6  # the largest ratio of sums that a robot can have
MOST_SUM = 1e24  # and the largest evidence

PARAMETERS = {
    "momentum": 0.9,  # g of `swift`
    "crowd": 50.0,  # the number of voices above which momentum is reduced
    "memory": 100.0,  # the most evidence in the short sums, in readings of a perfect sensor
    "z": 3.5,  # standard deviations of a change that a robot finds
    "confirm": 1.5,  # standard deviations that confirm a change that enough neighbours have begun with
    "belief": 1.0,  # how many times wider all limits to what others say are
}
MEMORY = {
    "s": 0.0,  # sent: evidence for black
    "v": 0.0,  # and evidence
    "said_s": 0.0,  # in the round before
    "said_v": 0.0,
    "ripe_s": 0.0,  # S
    "ripe_v": 0.0,  # V
    "short_s": 0.0,  # a
    "short_v": 0.0,  # e
    "coins": 0.0,  # c
    "noise": 0.0,  # d
    "seen": 0.0,  # the noise that differences of short and ripe sums have shown
    "windows": 0.0,  # lives of the short sums in them
    "alone": 0.0,  # evidence in a that nobody else has mixed in, scaled as variances are
    "alike": 0.0,  # the correlation of the readings of successive rounds
    "last": 0.5,  # what the readings of the round before say
    "fresh_s": 0.0,  # evidence for black of this round
    "fresh": 0.0,  # and evidence
    "coin": 0.0,  # of this round: 1 or -1; none in the first
    "anew": 0.0,  # 1: the robot has begun anew, and is not yet settled
    "own_s": 0.0,  # o: evidence for black of its own readings
    "own_v": 0.0,  # p: and evidence
    "trial": 0.0,  # above 0: whether others are right about a change is not decided
    "new_s": 0.0,  # own evidence for black since it is not
    "new_v": 0.0,  # and evidence
    "near_s": 0.0,  # evidence for black in r, in shares of p
    "near_v": 0.0,  # and evidence: n
    "near": 0.5,  # r
    "error": 10.0,  # E
    "guard": 0.0,  # rounds for which the robot is still on guard
    "pause": 0.0,  # rounds in which it looks for no change
    "trust": 4.0,  # in the next change, in nats
    "unit": 0.0,  # what evidence of 1 per round would have become, as sent
    "said_unit": 0.0,
    "rounds": 0.0,  # so far, or since the robot began anew
    "first": 0.0,  # messages in the first round
    "company": 0.0,  # the sum of marks heard in the first round and the own; 0 before, -1 and -2 without momentum
    "x": 0.5,  # estimate
    "guess": 0.5,  # what it would be without limits
    "heard": 0.0,  # messages since the last round
    "heard_company": 0.0,
    "alarms": 0.0,  # of robots that are without momentum or evidence
    "lies": 0.0,  # that are clear lies
    "near_heard_s": 0.0,  # the own sums in those that count in r
    "near_heard_v": 0.0,
    "begun": 0.0,  # of robots that have begun anew
    "voices": 0.0,  # whose short sums count
    "heard_short_s": 0.0,  # the sums in them
    "heard_short_v": 0.0,
    "heard_coins": 0.0,
    "heard_noise": 0.0,
    "heard_seen": 0.0,
    "counted": 0.0,  # whose long sums count
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
    "heard_ripe_s": 0.0,
    "heard_ripe_v": 0.0,
}
MESSAGE = (
    "s", "v", "ripe_s", "ripe_v", "short_s", "short_v", "coins", "noise", "seen", "anew", "company", "own_s", "own_v",
)  # fmt: skip
ROLES = {
    "s": "information",
    "v": "confidence",
    "ripe_s": "information",
    "ripe_v": "confidence",
    "short_s": "information",
    "short_v": "confidence",
    "own_s": "information",
    "own_v": "confidence",
}


def mark(me):
    """The mark of a robot, the square of a name, because sums of squares are rarely equal."""
    return (me.name + 1.0) ** 2


def observe(me, blacks, looks):
    """Add unbiased evidence, weighted by how much the sensor tells."""
    slope = me.b + me.w - 1.0
    s = slope * (blacks - looks * (1.0 - me.w))
    v = slope * slope * looks
    me.s += s
    me.v += v
    me.short_s += s
    me.short_v += v
    me.own_s += s
    me.own_v += v
    me.alone += v
    me.fresh_s += s
    me.fresh += v


def tossed(me):
    """The coins, with that of this round."""
    return me.coins + me.coin * 0.5 * math.sqrt(me.fresh)


def broadcast(me):
    """All sums, the noises, the mark, and whether the robot has begun anew (1) and tries a change (2), or both (3)."""
    company = me.company if me.rounds > 0.0 else mark(me)
    anew = me.anew + 2.0 if me.trial > 0.0 else me.anew
    return (
        me.s, me.v, me.ripe_s, me.ripe_v, me.short_s, me.short_v, tossed(me), me.noise, me.seen, anew, company,
        me.own_s, me.own_v,
    )  # fmt: skip


def receive(me, message):
    """A neighbour's sums, as far as they can be believed."""
    s, v, ripe_s, ripe_v, short_s, short_v, coins, noise, seen, anew, company, own_s, own_v = message
    if not (sound(s, v) and sound(ripe_s, ripe_v) and sound(short_s, short_v) and sound(own_s, own_v)):
        return
    if not (sound(coins, short_v) and noise >= 0.0 and seen >= 0.0):  # nor if they are no numbers
        return
    me.heard += 1.0
    me.heard_company += company
    if company == -1.0 or v <= 0.0:
        me.alarms += 1.0
    tries = anew >= 2.0
    if tries:
        anew -= 2.0
    old = tries if me.trial <= 0.0 else me.fresh <= 0.0  # own readings, of one of the two
    weight = min(own_v, me.own_v)
    if not old and weight > 0.0 and not meet(me, own_s / own_v, weight, anew):
        return
    believed = True
    if me.trial <= 0.0 and me.rounds > 1.0 and ripe_v > 0.0:
        believed = abs(ripe_s / ripe_v - me.near) <= limit(me, GATE, GUARDED_GATE)
    if not believed and (me.guard > 0.0 or (anew == 0.0 and not tries)):
        return
    if anew > 0.0:
        me.begun += 1.0
    me.voices += 1.0
    most = CAP * max(me.short_v, LEAST)
    share = most / short_v if short_v > most else 1.0
    me.heard_short_s += share * short_s
    me.heard_short_v += share * short_v
    me.heard_coins += share * coins
    me.heard_noise += min(noise, 0.25)
    me.heard_seen += min(seen, 0.25 * CUT * CUT)
    if not believed or (me.anew > 0.0 and anew == 0.0):
        return
    me.counted += 1.0
    most = CAP * max(me.v, me.own_v)
    share = most / v if v > most > 0.0 else 1.0
    me.heard_s += share * s
    me.heard_v += share * v
    me.heard_ripe_s += share * ripe_s
    me.heard_ripe_v += share * ripe_v


def sound(s, v):
    """Whether a robot can have such sums."""
    return abs(s) <= STEEPEST * v and v <= MOST_SUM


def meet(me, other, weight, anew):
    """Whether a neighbour's own readings agree with the own; if so, count them in r where they are near it."""
    wide = width(me)
    apart = 2.0 * abs(other - me.own_s / me.own_v) / math.sqrt(1.0 / me.own_v + 1.0 / weight)
    if apart > PAIR * wide:
        if apart > CLEAR * wide and anew == 0.0 and me.anew == 0.0 and me.trial <= 0.0:
            me.lies += 1.0
        return False
    if me.rounds > 1.0:
        error = math.sqrt(0.25 * wide * wide / weight + me.error * me.error)
        off = other - me.near
        if abs(off) > NEAR * error:
            return True
        other = me.near + min(max(off, -WINSOR * error), WINSOR * error)
    elif apart > NEAR * wide:
        return True
    me.near_heard_s += weight * other
    me.near_heard_v += weight
    return True


def width(me):
    """How many times more own readings vary than independent ones, and how much more is believed."""
    return me.belief * max(1.0, me.alike / PATCHY)


def limit(me, free, guarded):
    """A distance from r, given in standard errors for a robot that is not on guard and for one that is."""
    return me.error * (guarded if me.guard > 0.0 else free)


def fuse(me):
    """Average all voices, ripen, step beyond the mean, look for a change, and for lies."""
    voices = 1.0 + me.voices
    look_around(me)
    me.guard = max(me.guard - 1.0, 0.0)
    me.pause = max(me.pause - 1.0, 0.0)
    if me.lies > 0.0:
        me.guard = max(me.guard, me.rounds)
    own = 1.0 if me.company != -1.0 else max(OWN, me.counted)
    mixed = own + me.counted
    s = (own * me.s + me.heard_s) / mixed
    v = (own * me.v + me.heard_v) / mixed
    me.ripe_s = (own * me.ripe_s + me.heard_ripe_s) / mixed
    me.ripe_v = (own * me.ripe_v + me.heard_ripe_v) / mixed
    ripen(me, s, v)
    step(me, s, v, voices)
    gain = max(me.said_unit / max(me.rounds, 1.0), 1.0)
    walk(me)
    compare(me, v / gain, voices)
    guess = ratio(me, v / gain)
    me.x = guess
    doubt(me)
    me.guess = guess
    if me.v > SETTLED or (me.fresh <= 0.0 and me.begun <= 0.0):
        me.anew = 0.0
    clear(me)
    me.coin = 1.0 if me.luck < 0.5 else -1.0


def clear(me):
    """Forget the messages and readings of this round."""
    me.heard = me.heard_company = me.alarms = me.lies = me.near_heard_s = me.near_heard_v = 0.0
    me.voices = me.begun = me.heard_noise = me.heard_seen = me.fresh_s = me.fresh = 0.0
    me.heard_short_s = me.heard_short_v = me.heard_coins = 0.0
    me.counted = me.heard_s = me.heard_v = me.heard_ripe_s = me.heard_ripe_v = 0.0


def look_around(me):
    """Give up momentum, for good, if the network changes (-1) or one round mixes all of it (-2); as in `swift`."""
    if me.rounds == 0.0:
        me.first = me.heard
        me.company = me.heard_company + mark(me)
    elif me.rounds == 1.0 and me.heard_company == me.heard * me.company:
        me.company = -2.0
    if me.heard == 0.0 or me.heard != me.first or me.alarms > 0.0:
        me.company = -1.0


def ripen(me, s, v):
    """Draw the ripe sums towards the mixed ones."""
    ripe_v = me.ripe_v + 2.0 / 3.0 * v
    if ripe_v <= v:
        me.ripe_s = s
        me.ripe_v = v
    else:
        me.ripe_s = (ripe_v - v) / me.ripe_v * me.ripe_s + s
        me.ripe_v = ripe_v


def step(me, s, v, voices):
    """Set what is sent next: beyond the means by the momentum, as in `swift`."""
    unit = me.unit + 1.0
    g = 0.0
    if me.company > 0.0 and me.rounds > 1.0:
        g = me.momentum * min(1.0, me.crowd / voices) ** 2
        if v + g * (v - me.said_v) <= 0.5 * v:
            g = 0.0
    keep = 1.0 - 1.0 / OLDEST if 3.0 * me.ripe_v > OLDEST * v else 1.0
    ahead_s = keep * (s + g * (s - me.said_s))
    ahead_v = keep * (v + g * (v - me.said_v))
    me.ripe_s *= keep
    me.ripe_v *= keep
    me.said_s, me.said_v = me.s, me.v
    me.s, me.v = ahead_s, ahead_v
    me.unit, me.said_unit = unit + g * (unit - me.said_unit), unit
    me.rounds += 1.0


def walk(me):
    """Learn how much successive readings are alike, from their squared difference against that of unlike ones."""
    if me.fresh <= 0.0:
        return
    now = me.fresh_s / me.fresh
    q = (me.b + me.w - 1.0) * min(max(me.near, 0.0), 1.0) + 1.0 - me.w
    if me.rounds > 1.0:
        me.alike += WALK * (4.0 * q * (1.0 - q) * (1.0 - me.alike) - 2.0 * me.fresh * (now - me.last) ** 2)
    me.last = now


def compare(me, long, voices):
    """Mix the short sums, learn the noise, and begin anew if short and ripe sums differ by more than chance."""
    me.short_s = (me.short_s + me.heard_short_s) / voices
    me.short_v = (me.short_v + me.heard_short_v) / voices
    me.coins = (tossed(me) + me.heard_coins) / voices
    me.noise = (me.noise + me.heard_noise) / voices
    me.seen = (me.seen + me.heard_seen) / voices
    me.alone /= voices
    if me.short_v <= 0.0:
        return
    if me.windows == 0.0:
        me.noise = me.seen = 0.25 / voices
    part = me.fresh / me.short_v
    me.windows = min(me.windows + part, WINDOWS)
    weight = min(part / (PRIOR_WINDOWS + me.windows), 1.0)
    me.noise += weight * (me.coins * me.coins / me.short_v - me.noise)
    cut_short(me, min(me.memory, max(LEAST, 0.25 * long)))
    if long <= 1.01 * me.short_v:  # all readings are still in the short sums
        return
    crowded = CROWDED if me.company > -2.0 else MIXED
    noise = min(max(me.noise, 0.25 / (crowded * voices)) + 0.25 * me.alone / me.short_v, 0.25 / voices)
    square = (me.ripe_s / me.ripe_v - me.short_s / me.short_v) ** 2 * me.short_v
    if me.alike > PATCHY:
        noise = max(noise, me.seen)
    me.seen += weight * (min(square, CUT * CUT * noise) - me.seen)
    least = me.z * me.z
    if me.begun > 0.0 and me.anew == 0.0:
        least = min(least, me.confirm * me.confirm + 2.0 * math.log(max(voices / (FEW * me.begun), 1.0)))
    if me.pause <= 0.0 and square > least * noise:
        begin_anew(me)


def cut_short(me, most):
    """Forget: limit the evidence in the short sums."""
    if me.short_v > most:
        part = most / me.short_v
        me.short_s *= part
        me.short_v = most
        me.coins *= part
        me.alone *= part * part


def begin_anew(me):
    """Keep of the past what the short sums hold, cut, and try whether own readings agree."""
    cut_short(me, KEPT)
    me.s = me.ripe_s = me.short_s
    me.v = me.ripe_v = me.short_v
    me.anew = 1.0
    me.company = min(me.company, -1.0)
    me.unit = me.said_unit = me.rounds = 2.0
    if me.trial <= 0.0:
        me.trial = me.trust
        me.new_s = me.new_v = 0.0


def doubt(me):
    """Bound the estimate by what the robots near have read themselves, and find lies in the sums."""
    if me.own_v <= 0.0:
        return
    part = min(1.0, RECENT * me.fresh / me.own_v)
    me.near_s += part * ((me.own_s + me.near_heard_s) / me.own_v - me.near_s)
    me.near_v += part * ((me.own_v + me.near_heard_v) / me.own_v - me.near_v)
    me.near = me.near_s / me.near_v
    me.error = 0.5 * width(me) / math.sqrt(me.own_v * min(me.near_v, MOST))
    if me.trial > 0.0:
        weigh(me)
        if 0.0 < me.trial < DOUBT:
            cut(me)
        return
    if abs(me.x - me.near) > GATE * me.error:
        set_right(me)
    cut(me)
    if me.guard > 0.0:
        lean = min(1.0, LEAN * me.fresh / me.own_v)
        me.s += lean * (me.near * me.v - me.s)
        me.ripe_s += lean * (me.near * me.ripe_v - me.ripe_s)
    if me.own_v > OLDEST * me.fresh > 0.0:
        me.own_s *= 1.0 - 1.0 / OLDEST
        me.own_v *= 1.0 - 1.0 / OLDEST


def cut(me):
    """Draw the estimate to r where it is far from it."""
    off = me.x - me.near
    most = limit(me, CUT_OFF, GUARDED_CUT_OFF)
    if abs(off) > most:
        none = limit(me, FAR_OFF, GUARDED_FAR_OFF)
        most *= max(0.0, (none - abs(off)) / (none - most))
        me.x = min(max(me.near + (most if off > 0.0 else -most), 0.0), 1.0)


def weigh(me):
    """Whether the own readings of this round are for the change."""
    me.new_s += me.fresh_s
    me.new_v += me.fresh
    if me.fresh <= 0.0:
        return
    own = me.own_s / me.own_v
    now = me.fresh_s / me.fresh
    wide = width(me)
    me.trial += 2.0 * me.fresh * ((now - own) ** 2 - (now - me.guess) ** 2) / (wide * wide)
    if me.trial > SURE:
        me.own_s, me.own_v = me.new_s, me.new_v
        me.near_s, me.near_v = me.x, 1.0
        me.trial, me.trust = 0.0, TRUST
        return
    alike = me.anew == 0.0 and 2.0 * abs(own - me.x) * math.sqrt(me.own_v) < 1.0
    if not alike and me.trial > 0.0:
        return
    if me.trial < (0.5 * me.trust if alike else me.trust):
        me.trust = max(0.5 * me.trust, LEAST_TRUST)
        me.pause = PAUSE * TRUST / me.trust
    me.trial = 0.0
    if not alike:
        set_right(me)


def set_right(me):
    """Set all sums to what the robots near have read themselves."""
    age = max(me.rounds / 3.0, 1.0)
    me.s = me.said_s = me.near * me.own_v
    me.v = me.said_v = me.own_v
    me.ripe_s = me.s * age
    me.ripe_v = me.v * age
    me.short_s = me.near * me.short_v
    me.x = min(max(me.near, 0.0), 1.0)
    me.guard = max(me.guard, me.rounds)


def ratio(me, long):
    """The ratio of the ripe sums, with the prior of `commons`, in [0, 1]."""
    if me.ripe_v <= 0.0 or long <= 0.0:
        return 0.5
    prior = min(0.25, 0.0625 / long) / long
    return min(max((me.ripe_s / me.ripe_v + 0.5 * prior) / (1.0 + prior), 0.0), 1.0)


def estimate(me):
    """The ratio after the latest round."""
    return me.x
