"""The history of six robots that every machine runs to be compared: readings, losses and random numbers.

Runs in CPython and in MicroPython. It is drawn by a generator of whole numbers of 32 bits, so that every machine draws
the same.
"""

import struct
from binascii import hexlify

ACCURACIES = ((0.9, 0.8), (0.75, 0.6), (0.3, 0.4), (1.0, 0.7), (0.5, 0.5), (0.8, 0.9))  # b and w of each robot
ROBOTS = len(ACCURACIES)
ROUNDS = 300
STOPS = (1, 2, 3, 5, 9, 17, 33, 65, 129, 200, 300)  # rounds after which all memory is printed
LOOKS = (0, 1, 3, 10)  # readings in a round, one of these
SHARE = 43  # percent of readings that are black
FAR = 5  # one in so many pairs of robots that are no neighbours on the ring hears each other
LOST = 4  # one in so many messages is lost
SEED = 20


class Draws:
    """A linear congruential generator (Knuth's constants, as in Numerical Recipes) modulo 2^32."""

    def __init__(self):
        """Begin."""
        self.state = SEED

    def next(self):
        """The next state."""
        self.state = (self.state * 1664525 + 1013904223) % 2**32
        return self.state

    def below(self, n):
        """A whole number from 0 to n - 1."""
        return (self.next() >> 16) % n

    def fraction(self):
        """An odd number of 2^-24, in (0, 1), which both precisions hold exactly."""
        return ((self.next() >> 9) * 2 + 1) / 2**24


def shown(values, single):
    """Numbers as text, to the bit."""
    return " ".join([bits(1.0 * value, single) for value in values])


def bits(value, single):
    """A number as text."""
    if value != value:
        return "nan"
    return hexlify(struct.pack(">f" if single else ">d", value)).decode()


def flat(values):
    """All numbers of a state, one after another."""
    out = []
    for value in values:
        out.extend([value] if isinstance(value, (int, float)) else value)
    return out


def live(brain, states, radios, fields, owed, is_random, single):
    """Yield what each robot answers and sends in each round, and after some rounds its memory, as lines of text.

    brain: has the functions of the contract. states: of six robots. radios: the `Messages` of each. fields: of the
    memory, in their order. owed: which numbers of `owed` are shown. is_random: whether the brain uses luck. single:
    whether numbers are in single precision.
    """
    draws = Draws()

    def give(me):
        number = draws.fraction()
        if is_random:
            me.luck = number

    for k in range(1, ROUNDS + 1):
        for me in states:
            looks = LOOKS[draws.below(len(LOOKS))]
            blacks = sum([draws.below(100) < SHARE for _ in range(looks)])
            give(me)
            if looks and not (hasattr(brain, "done") and brain.done(me)):
                brain.observe(me, 1.0 * blacks, 1.0 * looks)
        said = []
        for me, radio in zip(states, radios):
            message = None if hasattr(brain, "jam") and brain.jam(me) else brain.broadcast(me)
            said.append(None if message is None else radio.coded(message))
        for i, me in enumerate(states):
            for j, data in enumerate(said):
                near = (i - j) % ROBOTS in (1, ROBOTS - 1)
                hears = i != j and (draws.below(FAR) == 0 or near) and draws.below(LOST) != 0
                if hears and data is not None:
                    give(me)
                    brain.receive(me, radios[i].read(data))
        for i, me in enumerate(states):
            give(me)
            brain.fuse(me)
            answers = [brain.estimate(me)]
            if hasattr(brain, "decide"):
                answers.append(brain.decide(me))
            for name in ("done", "jam"):
                if hasattr(brain, name):
                    answers.append(1.0 if getattr(brain, name)(me) else 0.0)
            if hasattr(brain, "interval"):
                answers.extend(brain.interval(me))
            if hasattr(brain, "steer"):
                give(me)
                command = brain.steer(me)
                answers.extend([0.0, 0.0, 0.0] if command is None else [1.0, command[0], command[1]])
            sent = "silent" if said[i] is None else hexlify(said[i]).decode()
            yield f"{k} {i} {shown(answers, single)} {sent}"
        if k in STOPS:
            for i, (me, radio) in enumerate(zip(states, radios)):
                memory = flat([getattr(me, name) for name in fields]) + [radio.owed[place] for place in owed]
                yield f"{k} {i} memory {shown(memory, single)}"
