"""The paper's evaluation: its studies are run, figures drawn, claims checked and explained, on one page.

In: the paper's study files.
Out: datasets, figures, claims.json, index.html.
Must not know: the command line.
"""
