"""The majority rule, weighted by quality (DMMD): adopt what most of a few heard robots and oneself hold.

Valentini, Brambilla, Hamann and Dorigo, 2016, direct modulation of majority-based decisions. A robot explores for
ceil(Exp(`explore`)) rounds and takes for the quality of its opinion

    quality = own / (looks + first),    own: how many of the looks read its colour,

tells its opinion for ceil(Exp(`disseminate` * quality)) + `listen` rounds, keeps in the last `listen` of them the
opinions of `senders` others, and then adopts what most of these and itself hold. As published are these rules and all
defaults but `senders`, at ten ticks a second.

Deviations:
- A tie, as of one other that disagrees, leaves the opinion as it is; in the published code one colour wins.
- Which opinion a robot begins with, its name says: of the first N robots round(N * black_first) hold black, spread
  evenly. There the lots are drawn among N robots, which no robot can count.
- Of all senders heard those with the lowest lots are kept, each as likely; published are the last distinct ones. A
  sender that tells two opinions in one window counts as one of them, drawn by lot.
- The quality is nobody's but the robot's own, and so is not sent. The first exploration is one round longer.
- `weighted` below 1 mixes in times that know no quality, of the mean `disseminate`: 0 is the rule without weights.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPINION = True
SLOTS = 4  # the most senders that can be kept
PARAMETERS = {
    "explore": 100.0,  # rounds: the mean of an exploration
    "disseminate": 100.0,  # rounds: the mean of telling an opinion of quality 1, beside the listening
    "listen": 30.0,  # rounds: the end of telling, in which others are heard
    "senders": 4.0,  # of how many others an opinion is kept, 4 at the most
    "first": 1.0,  # readings that count before the first is made: 1 is published and lowers the quality, 0 does not
    "weighted": 1.0,  # how much times depend on quality, from 0 to 1
    "debiased": 0.0,  # 1: the quality is corrected for the sensor
    "black_first": 0.5,  # the share of robots that begin with black
}
MEMORY = {
    "opinion": -1.0,  # 0 white, 1 black; -1 before the first round, where the name says
    "tells": 0.0,  # 1 while it tells its opinion, 0 while it explores
    "left": 0.0,  # rounds left of this phase
    "t": 0.0,  # readings of this exploration
    "n": 0.0,  # of which said black
    "salt": 0.0,  # what makes lots others in each window
    "lots": (2.0,) * 4,  # the lowest lots drawn in this window, the lowest first; 2 where there is none
    "kept": (0.0,) * 4,  # the opinions that came with them
}
MESSAGE = ("opinion", "name")
STEP = 2.0**-20  # lots of two senders differ by more than half of it, those of one by less


def observe(me, blacks, looks):
    """Readings count while the robot explores."""
    if me.tells == 0.0:
        me.t += looks
        me.n += blacks


def broadcast(me):
    """Its opinion, while it tells; silence while it explores."""
    if me.tells == 0.0:
        return None
    return me.opinion, me.name


def receive(me, message):
    """The lowest lots stay, however often and in whatever order they are drawn; of one sender only one."""
    if me.tells == 0.0 or me.left > me.listen:
        return
    opinion, name = message
    lot = drawn(me, name, opinion)
    place = int(min(max(me.senders, 1.0), SLOTS)) - 1
    for k in range(place):
        if abs(me.lots[k] - lot) < 0.5 * STEP:
            place = k
    if lot >= me.lots[place]:
        return
    while place > 0 and me.lots[place - 1] > lot:
        me.lots[place] = me.lots[place - 1]
        me.kept[place] = me.kept[place - 1]
        place -= 1
    me.lots[place] = lot
    me.kept[place] = opinion


def drawn(me, name, said):
    """The lot of a sender in this window, in [0, 1); what it says tells apart what is said under one name."""
    who = mixed(me.salt + 0.7548776662466927 * name)
    return STEP * (math.floor(who / STEP) + 0.5 * mixed(who + 0.5698402909980532 * said))


def mixed(number):
    """A pseudo-random number in [0, 1): a steep map, three times."""
    z = number % 1.0
    for _ in range(3):
        z *= 997.0 * (z + 1.0)
        z -= math.floor(z)
    return z


def fuse(me):
    """One round less of this phase; at its end the next one begins."""
    if me.opinion < 0.0:
        me.opinion = held(me)
        me.left = spread(me, me.explore)
        return
    me.left -= 1.0
    if me.left > 0.0:
        return
    if me.tells == 0.0:
        me.tells = 1.0
        me.left = spread(me, me.disseminate * (1.0 - me.weighted + me.weighted * quality(me))) + me.listen
        me.salt = 4096.0 * me.luck % 1.0
    else:
        lead = balance(me)
        if lead != 0.0:
            me.opinion = 1.0 if lead > 0.0 else 0.0
        me.tells = 0.0
        me.left = spread(me, me.explore)
        me.t = 0.0
        me.n = 0.0
        for k in range(SLOTS):
            me.lots[k] = 2.0
            me.kept[k] = 0.0


def balance(me):
    """By how many black is ahead of white, its own opinion counted."""
    lead = 2.0 * me.opinion - 1.0
    for k in range(SLOTS):
        if me.lots[k] < 2.0:
            lead += 1.0 if me.kept[k] > 0.5 else -1.0
    return lead


def spread(me, mean):
    """A whole number of rounds, exponential with this mean before it is rounded up."""
    return float(math.ceil(-mean * math.log(me.luck)))


def quality(me):
    """The share of its opinion's colour in this exploration; 0 where it read nothing."""
    if me.t == 0.0:
        return 0.0
    black = me.n / me.t
    if me.debiased > 0.0:
        black = corrected(me, black)
    own = black if me.opinion > 0.5 else 1.0 - black
    return own * me.t / (me.t + me.first)


def corrected(me, share):
    """The share of black at which its sensor says black so often; a half where it says the same of both colours."""
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.5
    return min(max((share + me.w - 1.0) / slope, 0.0), 1.0)


def held(me):
    """The opinion, also before the first round."""
    if me.opinion >= 0.0:
        return me.opinion
    share = min(max(me.black_first, 0.0), 1.0)
    return float(math.floor((me.name + 1.0) * share + 0.5) - math.floor(me.name * share + 0.5))


def decide(me):
    """The opinion."""
    return held(me)


def estimate(me):
    """The opinion too: there is no estimate of how much is black."""
    return held(me)
