"""Cross-inhibition: who hears the other opinion gives up its own, and takes up the next that it hears.

Zakir, Dorigo and Reina, 2022 and 2025. A robot with an opinion explores for ceil(Exp(`explore`)) rounds, takes for the
quality of its opinion the share of its colour among the readings of this time, and tells its opinion for
ceil(Exp(`disseminate` * quality)) rounds. Then it looks at the last opinion that it heard, if any:

    it has the other one -> it has none;    it has none -> it adopts what it heard.

A robot without an opinion is silent for ceil(Exp(`uncommitted`)) rounds, twice, before it looks. Each message is of the
other opinion with probability `miscommunication`, 0.15 in one of their settings; with probability `asocial`, 0.1 in
another, a robot adopts the colour under it instead. As published are these rules and all mean times: 2800, 1800 and 400
ticks at 31 a second, here in rounds of 0.1 s.

Deviations:
- The quality is of readings; published is that of tiles, each counted once, which a robot that knows no places cannot.
- Of several opinions that were last heard in the same round one is drawn by lot. What was heard counts since the last
  look, in all phases. A robot that makes no reading in the round of an asocial look does as if it were a social one.
- Which opinion a robot begins with, its name says: of the first N robots round(N * black_first) hold black, spread
  evenly. The first exploration is one round longer.
- An opinion is told for one round at least, even one of quality 0.
- `weighted` below 1 mixes in times that know no quality, of the mean `disseminate`: 0 is the rule without weights.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPINION = True
NONE = 0.5  # the opinion of a robot that has none
PARAMETERS = {
    "explore": 903.0,  # rounds: the mean of an exploration
    "disseminate": 581.0,  # rounds: the mean of telling an opinion of quality 1
    "uncommitted": 129.0,  # rounds: the mean of each of the two phases without an opinion
    "miscommunication": 0.0,  # the probability that a message is of the other opinion
    "asocial": 0.0,  # the probability of adopting the colour under oneself
    "weighted": 1.0,  # how much times depend on quality, from 0 to 1
    "debiased": 0.0,  # 1: the quality is corrected for the sensor
    "black_first": 0.5,  # the share of robots that begin with black
}
MEMORY = {
    "opinion": -1.0,  # 0 white, 1 black, 0.5 none; -1 before the first round, where the name says
    "tells": 0.0,  # 1 in the second phase, 0 in the first, in which it explores
    "left": 0.0,  # rounds left of this phase
    "t": 0.0,  # readings since it last looked at what it heard
    "n": 0.0,  # of which said black
    "t_now": 0.0,  # readings of this round
    "n_now": 0.0,  # of which said black
    "said": 0.0,  # the opinion that it tells next, which may be the other one
    "heard": 0.0,  # messages of this round
    "last": -1.0,  # the opinion heard last
}
MESSAGE = ("opinion",)


def observe(me, blacks, looks):
    """Readings since the last look, and of this round."""
    me.t += looks
    me.n += blacks
    me.t_now += looks
    me.n_now += blacks


def broadcast(me):
    """Its opinion, while it tells one; else silence."""
    if me.tells == 0.0 or me.opinion == NONE:
        return None
    return (me.said,)


def receive(me, message):
    """Of a round's messages one stays, each as likely."""
    me.heard += 1.0
    if me.luck * me.heard < 1.0:
        me.last = message[0]


def fuse(me):
    """One round less of this phase; at its end the next one begins."""
    me.heard = 0.0
    me.left -= 1.0
    if me.opinion < 0.0:
        me.opinion = held(me)
        me.left = spread(me, me.explore)
    elif me.left <= 0.0:
        if me.tells == 1.0:
            look(me)
        else:
            me.tells = 1.0
            me.left = spread(me, told(me))
    me.said = me.opinion
    if 4096.0 * me.luck % 1.0 < me.miscommunication:
        me.said = 1.0 - me.opinion
    me.t_now = 0.0
    me.n_now = 0.0


def told(me):
    """The mean time of its second phase."""
    if me.opinion == NONE:
        return me.uncommitted
    return me.disseminate * (1.0 - me.weighted + me.weighted * quality(me))


def look(me):
    """What was heard, or the colour under it, changes its opinion; then it explores."""
    lot = 16777216.0 * me.luck % 1.0
    if me.t_now > 0.0 and lot < me.asocial:
        me.opinion = 1.0 if lot * me.t_now < me.asocial * me.n_now else 0.0
    elif me.last >= 0.0:
        heard = 1.0 if me.last > 0.5 else 0.0
        if me.opinion == NONE:
            me.opinion = heard
        elif me.opinion != heard:
            me.opinion = NONE
    me.tells = 0.0
    me.left = spread(me, me.uncommitted if me.opinion == NONE else me.explore)
    me.t = 0.0
    me.n = 0.0
    me.last = -1.0


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
    return black if me.opinion > 0.5 else 1.0 - black


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
    """The opinion; no decision where there is none."""
    if me.opinion == NONE:
        return -1.0
    return held(me)


def estimate(me):
    """The opinion too, or a half: there is no estimate of how much is black."""
    return held(me)
