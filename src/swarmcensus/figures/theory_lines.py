"""Theory's curves for figures: what a robot alone is expected to do, and the bound of the whole swarm.

Both are of sensors and fill ratio, whatever the brain: what robots make of talking lies between them.
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

Curves = dict[str, dict[str, Line]]  # by the colour's value, then by the line's name


def curves_of(results: xr.Dataset, color: str, times: Sequence[int] | None, names: Sequence[str]) -> tuple[Curves, str]:
    """Theory's lines by the values of `color`, and why there is none, if there is none at all.

    At these rounds or ticks, by default after the last. Where settings of a value are pooled, theory must say the same
    of all of them. Raises InputError.
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
    """The lines that all of several values of the colour have alike, as brains have: they are drawn once, in grey."""
    first = next(iter(curves.values()), {}) if len(curves) > 1 else {}
    return {
        name: line for name, line in first.items() if all(_alike(line, lines.get(name)) for lines in curves.values())
    }


def told(panel: Panel, why: str) -> Panel:
    """A panel whose caption says why nothing of theory is drawn in it."""
    return panel._replace(caption=untold(panel.caption, why)) if why else panel


def untold(caption: str, why: str) -> str:
    """A caption that says why nothing of theory is drawn."""
    return f"{caption}{'; ' * bool(caption)}no theory: {why}"


def entries(drawn: Sequence[Curves]) -> dict[str, Artist]:
    """What the key says of the lines that are drawn."""
    known = {name for curves in drawn for lines in curves.values() for name in lines}
    return {NAMES[name]: sample(name) for name in STYLES if name in known}


def sample(name: str) -> Line2D:
    """A line of the style of theory's."""
    return Line2D([], [], color=GREY, linewidth=THIN, linestyle=STYLES[name])


def _alike(one: Line, other: Line | None) -> bool:
    return other is not None and all(np.allclose(a, b, rtol=0.02, atol=1e-6) for a, b in zip(one, other, strict=True))
