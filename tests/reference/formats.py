"""Number formats of messages by brute force: with Python's and NumPy's own conversions, and tables of all codes."""

import math

import numpy as np

from swarmcensus.brains import Brain

RATIOS = {16: np.arange(65536) / 32768 - 0.5, 8: np.arange(256) / 128 - 0.5}
LOGS = np.array([0.0, *(2.0 ** (k / 4 - 16) for k in range(255))])
MOST = {"option": 65535.0, "name": 65535.0}
SIZES = {"opinion": 1, "option": 2, "name": 2, "confidence": 1, "belief": 2, "": 4}
CARRIED = ("estimate", "information", "confidence", "belief")


def single(x: float) -> float:
    """The nearest float32."""
    with np.errstate(over="ignore"):
        return float(np.float32(x))


def real(x: float) -> float:
    """In 32 bits."""
    return float(np.clip(single(x), np.finfo(np.float32).min, np.finfo(np.float32).max))


def half(x: float) -> float:
    """In 16 bits, the largest where it is too large."""
    with np.errstate(over="ignore"):
        return float(np.clip(np.float16(x), -65504.0, 65504.0))


def ratio(x: float, bits: int, rounded) -> float:
    """The ratio nearest to x, of two as near the one with an even code."""
    steps = 2.0 ** (bits - 1)
    code = min(max(round(rounded(rounded(x + 0.5) * steps)), 0), 2**bits - 1)
    return float(RATIOS[bits][code])


def log(x: float) -> float:
    """The confidence nearest to x on a scale of logarithms; nothing below half a step under the least."""
    if x < 2.0**-16.125:
        return 0.0
    return float(LOGS[1 + np.argmin(np.abs(np.log2(LOGS[1:]) - math.log2(x)))])


class Formats:
    """What robots of a brain say in its number formats, and what they owe to their next messages."""

    def __init__(self, brain: Brain, robots: int) -> None:
        self.brain = brain
        self.rounded = single if brain.numbers.precision == "single" else float
        self.owed = [dict.fromkeys(range(100), 0.0) for _ in range(robots)]
        self.clipped = [0] * robots

    def sent(self, i: int, message: object) -> object:
        """The message of robot i as it is read."""
        format = self.brain.numbers.message
        if format == "double" or message is None:
            return message
        flat: list[tuple[float, str, str]] = []  # number, field, role
        for part, (name, items) in zip(message, self.brain.message.items(), strict=True):
            flat += [(float(x), name, self.brain.roles.get(name, "")) for x in (part if items else (part,))]
        owed = self.owed[i] if self.brain.numbers.feedback else dict.fromkeys(range(100), 0.0)
        wanted = [self.rounded(x + (owed[k] if role in CARRIED else 0.0)) for k, (x, _, role) in enumerate(flat)]
        read, holds = list(wanted), [True] * len(flat)
        if format == "float32":
            read, holds = [real(x) for x in wanted], [abs(single(x)) <= 3.4028234663852886e38 for x in wanted]
        elif format == "float16":
            read, holds = [half(x) for x in wanted], [abs(x) < 65520 for x in wanted]
        else:
            bits, used = int(format.removeprefix("ratio")), set()
            roles = [role for *_, role in flat]
            for k, role in enumerate(roles):
                if role == "information":
                    pair = self._confidence(flat, k, used)
                    if pair is None:
                        read[k], holds[k] = half(wanted[k]), abs(wanted[k]) < 65520
                        continue
                    used.add(pair)
                    read[pair] = self.rounded(log(wanted[pair]))
                    part = self.rounded(wanted[k] / wanted[pair]) if wanted[pair] > 0.0 else 0.5
                    read[k] = self.rounded(ratio(part, bits, self.rounded) * read[pair])
                    holds[k] = holds[pair] = 0.0 <= wanted[pair] <= LOGS[-1]
            for k, role in enumerate(roles):
                if role == "estimate":
                    read[k], holds[k] = ratio(wanted[k], bits, self.rounded), -0.5 <= wanted[k] < 1.5
                elif role == "confidence" and k not in used:
                    read[k], holds[k] = self.rounded(log(wanted[k])), 0.0 <= wanted[k] <= LOGS[-1]
                elif role in MOST:
                    read[k], holds[k] = min(max(round(wanted[k]), 0), MOST[role]), 0.0 <= wanted[k] <= MOST[role]
                elif role == "opinion":
                    read[k], holds[k] = ratio(wanted[k], 8, self.rounded), -0.5 <= wanted[k] < 1.5
                elif role == "belief":
                    read[k], holds[k] = half(wanted[k]), abs(wanted[k]) < 65520
                elif role == "":
                    read[k], holds[k] = real(wanted[k]), abs(single(wanted[k])) <= 3.4028234663852886e38
        self.clipped[i] += not all(holds)
        for k, (*_, role) in enumerate(flat):
            if role in CARRIED:
                lost = self.rounded(owed[k] - self.rounded(wanted[k] - self.rounded(flat[k][0])))  # in adding it
                rest = self.rounded(self.rounded(wanted[k] - read[k]) + lost)
                self.owed[i][k] = rest if holds[k] else 0.0
        it, counts = iter(map(float, read)), self.brain.message.values()
        return tuple(tuple(next(it) for _ in range(items)) if items else next(it) for items in counts)

    def _confidence(self, flat, k: int, used: set[int]) -> int | None:
        """Which number is the confidence of the information at k: in a vector that of the same item."""
        names = list(self.brain.message)
        name = flat[k][1]
        later = [*names[names.index(name) :], *names]
        field = next(one for one in later if self.brain.roles.get(one) == "confidence")
        item = [j for j, (_, one, _) in enumerate(flat) if one == name].index(k)
        place = [j for j, (_, one, _) in enumerate(flat) if one == field][item]
        return None if place in used else place


def size(brain: Brain) -> int:
    """The bytes of a message."""
    format = brain.numbers.message
    roles = [brain.roles.get(name, "") for name, items in brain.message.items() for _ in range(max(items, 1))]
    if format in ("float32", "float16"):
        return len(roles) * (4 if format == "float32" else 2)
    wide = 2 if format == "ratio16" else 1
    sizes = SIZES | {"information": wide, "estimate": wide}
    return sum(sizes[role] for role in roles)
