"""The names of the dataset: what is measured, and what settings differ in. Each is declared once, here.

In: nothing.
Out: `QUANTITIES` and `COORDINATES`: dimensions, units, meanings, labels, directions.
Must not know: datasets, studies, figures.
"""
