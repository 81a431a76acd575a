"""How far the estimates of a swarm are from each other, and from which round on they agree.

The disagreement is half the width from the 5 % to the 95 % quantile of the honest robots' estimates. Each quantile lies
between two of the estimates, linear as in NumPy.
"""

import numpy as np

from swarmcensus.engine.calling import place, seen_as
from swarmcensus.engine.compiling import loop

TAIL = 0.05  # share of robots beyond each quantile
MARGIN = 1e-12  # of bounds, far more than rounding errors of numbers from 0 to 1
AT_ONCE = 256  # estimates of a small swarm's rounds that are compared with two bounds


@loop()
def half_width(row, honest, room):
    """The disagreement of the estimates `row`; `room` (robot) is overwritten."""
    _, _, _, _, width = _around_quantiles(row, honest, room)
    return width


@loop()
def agreed_from(rows, first, honest, delta, room, agreed):
    """The first index from which on the disagreement stays within delta, up to the last of these rows.

    `rows` are estimates (round, robot) of the indices `first` and later; `agreed` (a float) is the answer for earlier
    ones. Going backwards, few rows need the quantiles: bounds of the estimates around them mostly hold in the row
    before, too, and prove that it is within delta. Such bounds come from the quantiles of a row, or from any estimate.
    """
    robots = rows.shape[1]
    count = robots
    for i in range(honest.size):
        count -= not honest[i]
    reach = delta - MARGIN
    at = rows[rows.shape[0] - 1, 0]
    a, b, c, d = at - reach, at - reach, at + reach, at + reach
    many = max(AT_ONCE // robots, 1)
    last = rows.shape[0]
    while last > 0:
        begin = max(last - many, 0)
        at = a + (d - a) / 2.0
        if last - begin == 1 or not _are_near(rows[begin:last], honest, count, at - reach, at + reach):
            for k in range(last - 1, begin - 1, -1):
                row = rows[k]
                if not _are_inside(row, honest, count, a, b, c, d):
                    a, b, c, d = row[0] - reach, row[0] - reach, row[0] + reach, row[0] + reach
                    if not _are_inside(row, honest, count, a, b, c, d):
                        a, b, c, d, width = _around_quantiles(row, honest, room)
                        if width > delta:
                            return float(first + k + 1)
                        spare = delta - width - MARGIN
                        a, b, c, d = a - spare, b - spare, c + spare, d + spare
        last = begin
    return agreed


@loop(forceinline=True)
def _places(count):
    """The place, in order, below each of the two quantiles of so many estimates."""
    return np.int64(TAIL * (count - 1)), np.int64((1.0 - TAIL) * (count - 1))


@loop()
def _are_near(rows, honest, count, low, high):
    """Whether at most as many honest estimates of all these rows as one row has in a tail are outside these bounds.

    Robots are counted without branches, so that the processor handles several at once, and an estimate that is no
    number is outside.
    """
    lower, upper = _places(count)
    above = below = 0
    if honest.size == 0:
        estimates = seen_as(place(rows, 0), rows.size, np.float64)
        for k in range(estimates.size):
            above += estimates[k] >= low
            below += estimates[k] <= high
    else:
        for r in range(rows.shape[0]):
            row = rows[r]
            for i in range(row.size):
                above += honest[i] & (row[i] >= low)
                below += honest[i] & (row[i] <= high)
    every = rows.shape[0] * count
    return above >= every - lower and below >= every - max(count - 2 - upper, 0)


@loop()
def _are_inside(row, honest, count, a, b, c, d):
    """Whether the estimates around the lower quantile are a and b or more, those around the other c and d or less."""
    lower, upper = _places(count)
    from_a = from_b = to_c = to_d = 0
    if honest.size == 0:
        for i in range(row.size):
            from_a += row[i] >= a
            from_b += row[i] >= b
            to_c += row[i] <= c
            to_d += row[i] <= d
    else:
        for i in range(row.size):
            from_a += honest[i] & (row[i] >= a)
            from_b += honest[i] & (row[i] >= b)
            to_c += honest[i] & (row[i] <= c)
            to_d += honest[i] & (row[i] <= d)
    enough = from_a >= count - lower and from_b >= count - min(lower + 1, count - 1)
    return enough and to_c > upper and to_d > min(upper + 1, count - 1)


@loop()
def _around_quantiles(row, honest, room):
    """The two honest estimates around each quantile, in order, and half the distance of the quantiles."""
    count = np.int64(0)
    for i in range(row.size):
        if honest.size == 0 or honest[i]:
            room[count] = row[i]
            count += 1
    a, b, low = _quantile(room, count, TAIL)
    c, d, high = _quantile(room, count, 1.0 - TAIL)
    return a, b, c, d, (high - low) / 2.0


@loop()
def _quantile(values, count, share):
    """The two of values[:count] around their quantile, and the quantile; rearranges the values."""
    place = (count - 1) * share
    k = np.int64(place)
    part = place - k
    _select(values, count, k)
    lower = upper = values[k]
    if k + 1 < count:
        upper = values[k + 1]
        for i in range(k + 2, count):
            upper = min(upper, values[i])
    step = upper - lower
    return lower, upper, upper - step * (1.0 - part) if part >= 0.5 else lower + step * part


@loop()
def _select(values, count, k):
    """Rearrange values[:count], which are numbers, such that none before values[k] is greater and none after it less.

    Values are exchanged without branches, which a processor would mostly guess wrongly. Pivots are anywhere, as
    estimates of neighbours are alike: in a full network, the middle one could take a hundred times as long.
    """
    first, last, anywhere = 0, count, 1
    while last - first > 1:
        anywhere = (anywhere * 1103515245 + 12345) % 2**31  # a linear congruential generator
        pivot = values[first + (anywhere * (last - first) >> 31)]
        less = first
        for i in range(first, last):
            x = values[i]
            values[i], values[less] = values[less], x
            less += x < pivot
        if k < less:
            last = less
            continue
        same = less
        for i in range(less, last):
            x = values[i]
            values[i], values[same] = values[same], x
            same += x == pivot
        if k < same:
            return
        first = same
