"""Direct comparison (DC): hear one robot, drawn by lot, and adopt its opinion if its quality is above one's own.

Valentini, Brambilla, Hamann and Dorigo, 2016. A robot explores for ceil(Exp(`explore`)) rounds and takes for the
quality of its opinion

    quality = own / (looks + first),    own: how many of the looks read its colour,

tells both for ceil(Exp(`disseminate` * m)) + `listen` rounds, where m is the larger one of its own colour's share and
the other's, hears others in the last `listen` of them, and then adopts the opinion of one sender, each as likely, if
the quality that came with it is above its own. As published are these rules and all defaults, at ten ticks a second.

Deviations:
- Which opinion a robot begins with, its name says: of the first N robots round(N * black_first) hold black, spread
  evenly. There the lots are drawn among N robots, which no robot can count.
- Of all senders heard one is drawn by a lot that is the same for all messages of a sender; published is one of the
  last few distinct senders. A sender that tells two things in one window counts as one of them, drawn by lot.
- The first exploration is one round longer.
- `weighted` below 1 mixes in times that know no share, of the mean `disseminate`; qualities are compared all the same.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPINION = True
PARAMETERS = {
    "explore": 100.0,  # rounds: the mean of an exploration
    "disseminate": 100.0,  # rounds: the mean of telling an opinion of quality 1, beside the listening
    "listen": 30.0,  # rounds: the end of telling, in which others are heard
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
    "lot": 2.0,  # the lowest lot drawn in this window
    "kept": -1.0,  # the opinion that came with it
    "kept_quality": 0.0,  # and its quality
    "quality": 0.0,  # of its own opinion, as it is told
}
MESSAGE = ("opinion", "quality", "name")
STEP = 2.0**-20  # lots of two senders differ by more than half of it, those of one by less


def observe(me, blacks, looks):
    """Readings count while the robot explores."""
    if me.tells == 0.0:
        me.t += looks
        me.n += blacks


def broadcast(me):
    """Its opinion and the quality, while it tells; silence while it explores."""
    if me.tells == 0.0:
        return None
    return me.opinion, me.quality, me.name


def receive(me, message):
    """The lowest lot wins, however often and in whatever order it is drawn."""
    if me.tells == 0.0 or me.left > me.listen:
        return
    opinion, quality, name = message
    lot = drawn(me, name, 1.618033988749895 * opinion + quality)
    if lot < me.lot:
        me.lot = lot
        me.kept = opinion
        me.kept_quality = quality


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
        me.quality = share(me, me.opinion)
        larger = max(me.quality, share(me, 1.0 - me.opinion))
        me.left = spread(me, me.disseminate * (1.0 - me.weighted + me.weighted * larger)) + me.listen
        me.salt = 4096.0 * me.luck % 1.0
    else:
        if me.kept >= 0.0 and me.kept_quality > me.quality:
            me.opinion = 1.0 if me.kept > 0.5 else 0.0
        me.tells = 0.0
        me.left = spread(me, me.explore)
        me.t = 0.0
        me.n = 0.0
        me.lot = 2.0
        me.kept = -1.0
        me.kept_quality = 0.0
        me.quality = 0.0


def spread(me, mean):
    """A whole number of rounds, exponential with this mean before it is rounded up."""
    return float(math.ceil(-mean * math.log(me.luck)))


def share(me, colour):
    """The share of a colour in this exploration; 0 where it read nothing."""
    if me.t == 0.0:
        return 0.0
    black = me.n / me.t
    if me.debiased > 0.0:
        black = corrected(me, black)
    found = black if colour > 0.5 else 1.0 - black
    return found * me.t / (me.t + me.first)


def corrected(me, said):
    """The share of black at which its sensor says black so often; a half where it says the same of both colours."""
    slope = me.b + me.w - 1.0
    if abs(slope) < 1e-12:
        return 0.5
    return min(max((said + me.w - 1.0) / slope, 0.0), 1.0)


def held(me):
    """The opinion, also before the first round."""
    if me.opinion >= 0.0:
        return me.opinion
    first = min(max(me.black_first, 0.0), 1.0)
    return float(math.floor((me.name + 1.0) * first + 0.5) - math.floor(me.name * first + 0.5))


def decide(me):
    """The opinion."""
    return held(me)


def estimate(me):
    """The opinion too: there is no estimate of how much is black."""
    return held(me)
