"""A metric on curves of estimates, round by round.

This file is compiled for each metric file (see `compiler.py`): `.gauge` is that metric. It knows no brain, so a new
metric does not make brains compile again.
"""

from .gauge import after, begin, entry, result, watch


@entry
def follow(blank, records, rows, first, truths, out):
    """Show a metric the estimates `rows` (round, robot), from round `first` on; `out` gets its results so far.

    `records` has one record per robot, or a single one for a metric of the whole swarm; each starts as `blank`. An
    empty `out` asks for no result. `truths` (round, 3), or (1, 3) if constant, are the true fill ratio and the ends of
    its bin.
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
