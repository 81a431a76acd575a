"""Direct comparison (DC): hear one robot, drawn at random, and adopt its opinion if its quality is above one's own.

Valentini, Brambilla, Hamann and Dorigo, 2016. A robot explores for ceil(Exp(`explore`)) rounds. The quality of its
opinion is

    quality = own / (looks + first),    own: how many of the looks read its colour,

It sends both for ceil(Exp(`disseminate` * m)) + `listen` rounds, where m is `best` or, where that is 0, the larger of
the shares of its own and of the other colour, and hears others in the last `listen` of them. Then it adopts the opinion
of one sender, all equally likely, if the quality sent with it is above its own. As published: these rules and all
defaults but `best`, at ten ticks per second.

Deviations:
- In a public fork of the authors' program, m is the ideal quality of the best option, the same for all robots. No robot
  knows it, so by default m is what the robot has measured; `best` sets it.
- The first opinion follows from the name: of the first N robots, round(N * black_first) hold black, evenly spread. In
  the source, they are drawn among N robots, but no robot knows N.
- One of all senders heard is drawn by a random number that is the same for all messages of a sender; the source draws
  from the last few distinct senders. A sender of two messages in one window counts with one of them, drawn at random.
- The first exploration is one round longer.
- `weighted` below 1 mixes in times that do not depend on the shares, with mean `disseminate`; qualities are still
  compared.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPINION = True
PARAMETERS = {
    "explore": 100.0,  # rounds: the mean time of an exploration
    "disseminate": 100.0,  # rounds: the mean time of sending an opinion of quality 1, without the listening
    "listen": 30.0,  # rounds: the last part of sending, in which others are heard
    "best": 0.0,  # the ideal quality of the best option, which sets the mean time of sending; 0: as measured
    "first": 1.0,  # readings added to the number of looks: published is 1, which lowers the quality
    "weighted": 1.0,  # how much times depend on quality, from 0 to 1
    "debiased": 0.0,  # 1: the quality is corrected for the sensor
    "black_first": 0.5,  # the share of robots whose first opinion is black
}
NEEDS = {"rounds": "explore + disseminate + listen"}  # until opinions change for the first time
MEMORY = {
    "opinion": -1.0,  # 0 white, 1 black; -1 before the first round
    "tells": 0.0,  # 1 while it sends its opinion, 0 while it explores
    "left": 0.0,  # rounds left of this phase
    "t": 0.0,  # readings of this exploration
    "n": 0.0,  # black ones among them
    "salt": 0.0,  # makes random numbers differ between windows
    "lot": 2.0,  # the lowest random number of a sender in this window
    "kept": -1.0,  # the opinion that came with it
    "kept_quality": 0.0,  # and its quality
    "quality": 0.0,  # of its own opinion, as it is told
}
MESSAGE = ("opinion", "quality", "name")
STEP = 2.0**-20  # numbers of two senders differ by more than half of it, those of one sender by less


def observe(me, blacks, looks):
    """Readings count while the robot explores."""
    if me.tells == 0.0:
        me.t += looks
        me.n += blacks


def broadcast(me):
    """Its opinion and the quality, while it sends; silence while it explores."""
    if me.tells == 0.0:
        return None
    return me.opinion, me.quality, me.name


def receive(me, message):
    """Keep the message with the lowest random number, whatever the order and number of messages."""
    if me.tells == 0.0 or me.left > me.listen:
        return
    opinion, quality, name = message
    lot = drawn(me, name, 1.618033988749895 * opinion + quality)
    if lot < me.lot:
        me.lot = lot
        me.kept = opinion
        me.kept_quality = quality


def drawn(me, name, said):
    """The random number of a sender in this window, in [0, 1); messages of one sender differ slightly by content."""
    who = mixed(me.salt + 0.7548776662466927 * name)
    return STEP * (math.floor(who / STEP) + 0.5 * mixed(who + 0.5698402909980532 * said))


def mixed(number):
    """A pseudo-random number in [0, 1), by three iterations of a steep map."""
    z = number % 1.0
    for _ in range(3):
        z *= 997.0 * (z + 1.0)
        z -= math.floor(z)
    return z


def fuse(me):
    """Count down the phase; at its end the next one begins."""
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
        larger = me.best if me.best > 0.0 else max(me.quality, share(me, 1.0 - me.opinion))
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
    """A number of rounds, exponentially distributed with this mean and rounded up."""
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
    """The share of black that explains this share of black readings; a half if the sensor tells nothing."""
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
    """The opinion: this brain does not estimate the fill ratio."""
    return held(me)
