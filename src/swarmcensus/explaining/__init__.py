"""Measured figures beside what theory expects of them: `sc.explain`.

In: a dataset.
Out: an `Explanation` of one setting, or the agreement of all of them with theory.
Must not know: who ran the trials and how, what is drawn.
"""
