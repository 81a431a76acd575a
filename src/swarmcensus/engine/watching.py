"""A metric on curves of estimates, round by round.

This file is compiled anew for every metric (see `compiler.py`): `.gauge` is that metric. It knows no brain, so that
another metric costs no brain's compilation.
"""

from .gauge import after, begin, entry, result, watch


@entry
def follow(blank, records, rows, first, truths, out):
    """Show a metric the estimates `rows` (round, robot), from round `first` on; `out` holds what it then says.

    `records` has one a robot, or one for all where the metric is of a swarm; `blank` is what each begins from. Without
    room in `out` nothing is asked for. `truths` (round, 3), or (1, 3) where they stay, are the fill ratios that
    estimates are held against, and the ends of their bins.
    """
    last = records.size - 1
    if first == 1:
        for i in range(records.size):
            records[i] = blank[0]
            begin(records[i])
    for k in range(rows.shape[0]):
        now = min(k, truths.shape[0] - 1)
        if truths.shape[0] > 1 and (k == 0 or truths[k, 1] != truths[k - 1, 1] or truths[k, 2] != truths[k - 1, 2]):
            for i in range(records.size):
                records[i].low = truths[k, 1]
                records[i].high = truths[k, 2]
        truth = truths[now, 0]
        for i in range(rows.shape[1]):
            watch(records[min(i, last)], first + k, rows[k, i], truth)
        after(records[0], first + k)
    for i in range(out.size):
        out[i] = result(records[i])
