"""Whether a brain file keeps its promises: lives to hold it against, checks, and machine code against CPython.

In: a brain file.
Out: checks, each with a fault in a sentence or none.
Must not know: studies, results, runs.
"""
