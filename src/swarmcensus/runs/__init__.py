"""Work: a study cut into tasks, handed to threads or a cluster, resumed, stopped, watched, and verified.

In: a Study and where its results go.
Out: a dataset whose finished work is never lost.
Must not know: figures, claims, the command line.
"""
