"""Direct switching: adopt the opinion that was heard last.

This is the voter model with which Zakir, Dorigo and Reina, 2022 and 2025, compare cross-inhibition. A robot explores
for ceil(Exp(`explore`)) rounds. The quality of its opinion is the share of its colour among the readings of this time.
It sends its opinion for ceil(Exp(`disseminate` * quality)) rounds, and then adopts the last opinion that it heard, if
any. With probability `miscommunication` (0.15 in one published setting), a message has the other opinion; with
probability `asocial` (0.1 in another), a robot adopts the colour under it instead. As published: these rules and all
mean times: 2800 and 1800 ticks at 31 per second, here in rounds of 0.1 s.

Deviations:
- The quality is computed from readings. In the source it is computed from tiles, each counted once, which needs known
  positions.
- If several opinions were heard last in the same round, one is drawn at random. Messages count since the last switch,
  in all phases. A robot without a reading in the round of an asocial switch switches socially.
- The first opinion follows from the name: of the first N robots, round(N * black_first) hold black, evenly spread. The
  first exploration is one round longer.
- An opinion is sent for at least one round, even with quality 0.
- `weighted` below 1 mixes in times that do not depend on quality, with mean `disseminate`: 0 is the unweighted rule.
- `debiased` = 1 corrects the share of black for the sensor: clip((share + w - 1) / (b + w - 1), 0, 1).
"""

import math

OPINION = True
PARAMETERS = {
    "explore": 903.0,  # rounds: the mean time of an exploration
    "disseminate": 581.0,  # rounds: the mean time of sending an opinion of quality 1
    "miscommunication": 0.0,  # the probability that a message is of the other opinion
    "asocial": 0.0,  # the probability of adopting the colour under oneself
    "weighted": 1.0,  # how much times depend on quality, from 0 to 1
    "debiased": 0.0,  # 1: the quality is corrected for the sensor
    "black_first": 0.5,  # the share of robots whose first opinion is black
}
NEEDS = {"rounds": "explore + disseminate"}  # until opinions change for the first time
MEMORY = {
    "opinion": -1.0,  # 0 white, 1 black; -1 before the first round
    "tells": 0.0,  # 1 while it sends its opinion, 0 while it explores
    "left": 0.0,  # rounds left of this phase
    "t": 0.0,  # readings since the last switch
    "n": 0.0,  # black ones among them
    "t_now": 0.0,  # readings of this round
    "n_now": 0.0,  # black ones among them
    "said": 0.0,  # the opinion that it sends next, which may be the other one
    "heard": 0.0,  # messages of this round
    "last": -1.0,  # the opinion heard last
}
MESSAGE = ("opinion",)


def observe(me, blacks, looks):
    """Count readings since the last switch, and of this round."""
    me.t += looks
    me.n += blacks
    me.t_now += looks
    me.n_now += blacks


def broadcast(me):
    """Its opinion, while it sends; silence while it explores."""
    if me.tells == 0.0:
        return None
    return (me.said,)


def receive(me, message):
    """Keep one message of the round, each equally likely."""
    me.heard += 1.0
    if me.luck * me.heard < 1.0:
        me.last = message[0]


def fuse(me):
    """Count down the phase; at its end the next one begins."""
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
            me.left = spread(me, me.disseminate * (1.0 - me.weighted + me.weighted * quality(me)))
    me.said = me.opinion
    if 4096.0 * me.luck % 1.0 < me.miscommunication:
        me.said = 1.0 - me.opinion
    me.t_now = 0.0
    me.n_now = 0.0


def look(me):
    """Switch by what was heard, or to the colour under the robot; then explore."""
    lot = 16777216.0 * me.luck % 1.0
    if me.t_now > 0.0 and lot < me.asocial:
        me.opinion = 1.0 if lot * me.t_now < me.asocial * me.n_now else 0.0
    elif me.last >= 0.0:
        me.opinion = 1.0 if me.last > 0.5 else 0.0
    me.tells = 0.0
    me.left = spread(me, me.explore)
    me.t = 0.0
    me.n = 0.0
    me.last = -1.0


def spread(me, mean):
    """A number of rounds, exponentially distributed with this mean and rounded up."""
    return float(math.ceil(-mean * math.log(me.luck)))


def quality(me):
    """The share of its opinion's colour in this exploration; 0 without readings."""
    if me.t == 0.0:
        return 0.0
    black = me.n / me.t
    if me.debiased > 0.0:
        black = corrected(me, black)
    return black if me.opinion > 0.5 else 1.0 - black


def corrected(me, share):
    """The share of black that explains this share of black readings; a half if the sensor tells nothing."""
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
    """The opinion: this brain does not estimate the fill ratio."""
    return held(me)
