"""Tunes a brain, or an adversary to do the most harm: searches on training trials, and compares with the original.

In: a Study, one of its brains or adversaries, and ranges of its parameters.
Out: the program with the values found, a log of all candidates, and a comparison on trials that the search never saw.
Must not know: figures, claims, the command line.
"""
