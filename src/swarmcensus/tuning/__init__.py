"""Tuning: parameters of a brain searched for on training trials, and what came of it held against what was there.

In: a Study, one of its brains, and ranges of its parameters.
Out: the brain with other parameters, a log of what was tried, and a comparison on trials that the search never saw.
Must not know: figures, claims, the command line.
"""
