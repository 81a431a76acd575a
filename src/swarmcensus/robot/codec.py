"""Numbers of messages in few bits.

Written as brains are, with plain arithmetic and `math` alone: the simulator, a robot's Python and its C run this file.
So a message has the same bytes everywhere, and a receiver reads the same numbers. A code is a whole number from 0 on.

half: IEEE half precision, 16 bits; a larger number becomes the largest, 65504.
ratio: -1/2 to 3/2, in 1 / `steps`: 32768 for 16 bits, 128 for 8. A ratio beyond these ends becomes the nearest of them.
log: 8 bits, four steps an octave, from 2^-16 to 2^47.5; 0 for less. A larger number becomes the largest.
whole: a whole number from 0 to `most`.
"""

import math

LARGEST_REAL = 3.4028234663852886e38
LARGEST_LOG = 2.0**47.5
LEAST_LOG = 1.3992e-05  # half a step below 2^-16
MIDDLES = (
    0.5452538663326288,
    0.6484197773255048,
    0.7711054127039704,
    0.9170040432046712,
)  # 2^-1 times 2^1/8, 2^3/8, ...
QUARTERS = (1.0, 1.189207115002721, 1.4142135623730951, 1.681792830507429)  # 2^0, 2^1/4, 2^1/2, 2^3/4


def nearest(x):
    """The whole number nearest to x, of two equally near the even one."""
    low = 1.0 * math.floor(x)
    rest = x - low
    if rest > 0.5 or (rest == 0.5 and low % 2.0 == 1.0):
        return low + 1.0
    return low


def half_code(x):
    """The code of x in half precision; that of 0 if x is not a number."""
    sign = 0.0
    size = x
    if x < 0.0:
        sign = 32768.0
        size = -x
    if size >= 65520.0:
        return sign + 31743.0
    if not size >= 6.103515625e-05:  # 2^-14
        return sign + nearest(size * 16777216.0) if size > 0.0 else sign
    part, power = math.frexp(size)
    return sign + (power + 13.0) * 1024.0 + nearest(part * 2048.0)


def half_value(code):
    """The number with this code."""
    sign = 1.0
    rest = code
    if code >= 32768.0:
        sign = -1.0
        rest = code - 32768.0
    power = math.floor(rest / 1024.0)
    part = rest - 1024.0 * power
    if power == 0:
        return sign * part * 5.960464477539063e-08  # 2^-24
    return sign * math.ldexp(1024.0 + part, power - 25)


def ratio_code(ratio, steps):
    """The code of a ratio."""
    if not ratio > -0.5:
        return 0.0
    return nearest(min((ratio + 0.5) * steps, 2.0 * steps - 1.0))


def ratio_value(code, steps):
    """The ratio with this code."""
    return code / steps - 0.5


def log_code(x):
    """The code of a number that is 0 or more."""
    if not x >= LEAST_LOG:
        return 0.0
    if x >= LARGEST_LOG:
        return 255.0
    part, power = math.frexp(x)
    code = 4.0 * (power + 15.0) + 1.0
    for k in range(4):
        if part >= MIDDLES[k]:
            code += 1.0
    return code


def log_value(code):
    """The number with this code."""
    if code < 1.0:
        return 0.0
    octave = math.floor((code - 1.0) / 4.0)
    quarter = int(code - 1.0 - 4.0 * octave)
    return math.ldexp(QUARTERS[quarter], octave - 16)


def whole_code(x, most):
    """The code of a whole number."""
    return nearest(min(max(x, 0.0), most))


def ratio_of(information, confidence):
    """The ratio that is sent of the two; 1/2 without confidence."""
    if confidence > 0.0:
        return information / confidence
    return 0.5


def read_real(x):
    """What a receiver reads of a number in 32 bits; `x` is in single precision."""
    return min(max(x, -LARGEST_REAL), LARGEST_REAL) if x == x else 0.0


def holds_real(x):
    """Whether 32 bits hold a number."""
    return abs(x) <= LARGEST_REAL


def read_half(x):
    """What a receiver reads of a number in half precision."""
    return half_value(half_code(x))


def holds_half(x):
    """Whether half precision holds a number."""
    return abs(x) < 65520.0


def read_share(x, steps):
    """What a receiver reads of a fill ratio."""
    return ratio_value(ratio_code(x, steps), steps)


def holds_share(x, steps):
    """Whether a coding of ratios holds a fill ratio."""
    return -0.5 <= x < 1.5


def read_log(x):
    """What a receiver reads of a confidence."""
    return log_value(log_code(x))


def holds_log(x):
    """Whether the coding of confidences holds one."""
    return 0.0 <= x <= LARGEST_LOG


def read_pair(information, confidence, steps):
    """What a receiver reads of an information and its confidence."""
    size = log_value(log_code(confidence))
    return ratio_value(ratio_code(ratio_of(information, confidence), steps), steps) * size, size


def holds_pair(information, confidence, steps):
    """Whether the coding of confidences holds that of a pair."""
    return abs(information) <= LARGEST_REAL and 0.0 <= confidence <= LARGEST_LOG


def read_whole(x, most):
    """What a receiver reads of a whole number."""
    return whole_code(x, most)


def holds_whole(x, most):
    """Whether a coding of whole numbers holds one."""
    return 0.0 <= x <= most
