"""Checks whether a brain file keeps the contract, and whether machine code and CPython agree.

In: a brain file.
Out: checks, each with a fault in a sentence, or none.
Must not know: studies, results, runs.
"""
