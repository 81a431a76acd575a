"""The statistics of trials: intervals, the bootstrap, signed-rank tests, corrections of p-values, rankings.

In: arrays of numbers, with one row or column per trial.
Out: arrays of intervals, p-values and ranks.
Must not know: any other room but `basics`.
"""
