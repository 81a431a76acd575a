"""The figures: one function per kind, from a study's results or a trace to a matplotlib Figure.

All use matplotlib's object-oriented interface only (no pyplot): no display, no global state, any thread.
`save` writes what they return. `panels` picks the numbers, `sheets` knows how panels look.
"""

from swarmcensus.figures.curves import curves
from swarmcensus.figures.decisions import decisions, decisions_grid
from swarmcensus.figures.heatmaps import heatmap
from swarmcensus.figures.panels import Panel, panels_of
from swarmcensus.figures.scatters import scatter, scatter_grid
from swarmcensus.figures.sheets import save

__all__ = ["Panel", "curves", "decisions", "decisions_grid", "heatmap", "panels_of", "save", "scatter",
           "scatter_grid"]  # fmt: skip
