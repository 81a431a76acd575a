"""Tunes a brain: searches for good parameters on training trials, and compares the result with the original brain.

In: a Study, one of its brains, and ranges of its parameters.
Out: the tuned brain, a log of all candidates, and a comparison on trials that the search never saw.
Must not know: figures, claims, the command line.
"""
