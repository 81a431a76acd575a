"""The paper's evaluation: its studies run, its figures drawn, its claims measured and explained, a page of it all.

In: the paper's study files.
Out: datasets, figures, claims.json, index.html.
Must not know: the command line.
"""
