"""A setting and a trial become numbers: batches, rides, single trials in full, the reference in CPython, blame.

In: a Setting, a seed, trials, what to measure.
Out: a Batch of metrics, or a life in full.
Must not know: datasets, files, threads, other settings' results.
"""
