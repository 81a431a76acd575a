"""Theory's curves in figures: what a lone robot is expected to do, and the bound of the whole swarm.

Both depend on sensors and fill ratio, not on the brain. What communication achieves lies between them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.lines import Line2D

from swarmcensus.explaining.expectations import ALONE, SWARM, Line, expect
from swarmcensus.figures.coordinates import texts_of
from swarmcensus.figures.panels import Panel
from swarmcensus.results.structure import finished

STYLES = {ALONE: (0, (1, 1.5)), SWARM: (0, (4, 2))}  # dots, and dashes
NAMES = {ALONE: "theory: a robot alone", SWARM: "theory: bound of the whole swarm"}
THIN = 0.9
GREY = "0.3"
DIFFERENT = "settings drawn as one differ in it"

Curves = dict[str, dict[str, Line]]  # value of the colour -> name of the line -> line


def curves_of(results: xr.Dataset, color: str, times: Sequence[int] | None, names: Sequence[str]) -> tuple[Curves, str]:
    """Theory's lines at these rounds or ticks (default: the last) by values of `color`; if there are none, why.

    Settings that are pooled share a line if theory is the same for all of them. Raises InputError.
    """
    texts, ran = texts_of(results, color), finished(results).any(axis=1)
    found: Curves = {}
    why: list[str] = []
    for text in dict.fromkeys(texts[ran].tolist()):
        expected = []
        for k in np.flatnonzero((texts == text) & ran):
            number, rounds = int(results["setting"].values[k]), int(results["rounds"].values[k])
            expected.append(expect(results, number, times or [rounds], names))
        first = expected[0].lines
        why += [one.absent[name] for one in expected for name in names if name in one.absent]
        alike = {name: all(_alike(first[name], one.lines.get(name)) for one in expected) for name in first}
        why += [DIFFERENT] * (not all(alike.values()))
        if any(alike.values()):
            found[text] = {name: line for name, line in first.items() if alike[name]}
    return found, "" if found or not why else why[0]


def shared(curves: Curves) -> dict[str, Line]:
    """Lines that are the same for all values of the colour, as for brains: they are drawn once, in grey."""
    first = next(iter(curves.values()), {}) if len(curves) > 1 else {}
    return {
        name: line for name, line in first.items() if all(_alike(line, lines.get(name)) for lines in curves.values())
    }


def told(panel: Panel, why: str) -> Panel:
    """The panel with the reason in its caption why no theory is drawn in it."""
    return panel._replace(caption=untold(panel.caption, why)) if why else panel


def untold(caption: str, why: str) -> str:
    """The caption with the reason why no theory is drawn."""
    return f"{caption}{'; ' * bool(caption)}no theory: {why}"


def entries(drawn: Sequence[Curves]) -> dict[str, Artist]:
    """The key's entries for the lines that are drawn."""
    known = {name for curves in drawn for lines in curves.values() for name in lines}
    return {NAMES[name]: sample(name) for name in STYLES if name in known}


def sample(name: str) -> Line2D:
    """A line in the style of a theory line, for the key."""
    return Line2D([], [], color=GREY, linewidth=THIN, linestyle=STYLES[name])


def _alike(one: Line, other: Line | None) -> bool:
    return other is not None and all(np.allclose(a, b, rtol=0.02, atol=1e-6) for a, b in zip(one, other, strict=True))
