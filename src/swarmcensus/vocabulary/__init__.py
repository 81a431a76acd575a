"""What is measured and compared: each quantity is declared once, here.

In: nothing.
Out: `QUANTITIES`: dimensions, units, meanings, labels, directions.
Must not know: datasets, studies, figures.
"""
