"""Strategies of hypothesis: values, studies right and wrong, and texts and bytes that were spoiled."""

import math
from copy import deepcopy

import numpy as np
from hypothesis import strategies as st

from swarmcensus.worlds.bodies import Body
from tests.support.drawn import tables_of

# values of every kind that TOML knows, and those that are most likely to hurt
ODD = st.sampled_from(
    [0, 1, -1, 2, 2**31 - 1, 2**31, 2**63, -(2**63), 10**30, 10**400, 0.0, -0.0, 1e308, -1e308, 5e-324, 1e-300,
     math.inf, -math.inf, math.nan, 0.5, 1.0, True, False, "", " ", "ring", "moving", "full", "a\nb", "a\x00b", "\x7f",
     "ü", "名", "../x", "/", "/dev/null", "C:\\x", "U(0, 1)", "U(1, 0)", "N(nan, 1)", "U(1e999, 2)", [], {}, [[]], [{}],
     {"error": 1}, {"black": 1}, {"until": "correct@10 mean +- 0.1"}, {"until": "x"}, {"networkx": "x_graph"}]
)  # fmt: skip
TEXT = st.text(max_size=12)
SCALAR = ODD | st.integers() | st.floats() | TEXT | st.booleans() | st.dates() | st.datetimes()
ANY = st.recursive(
    SCALAR, lambda v: st.lists(v, max_size=3) | st.dictionaries(TEXT, v, max_size=3), max_leaves=6
)  # fmt: skip


# what means something at some key of a study, and is mostly wrong at another one
TABLES = st.sampled_from(
    [{"image": "x.png"}, {"benchmark": "star", "cells": 0}, {"file": "x.py", "a": 1}, {"file": "x.net", "renumber": 1},
     {"name": "small-world", "neighbours": 2}, {"name": "grid", "columns": 2}, {"name": "x", "edges": [[0, 1]]},
     {"networkx": "random_k_out_graph", "k": 1, "alpha": 0.5, "seed": "x"},
     {"networkx": "path_graph", "directed": True},
     {"black": "U(0.5, 0.9)", "white": 0.7}, {"until": "convergence_error median +- 0.01", "at_most": 40},
     "x.py(0.1, 0.2)", "torus", "x.gml", "minimalistic", "0.2 s", "0.005 min", "1e99 h",
     [{"robots": [1, 2], "side": 2.0}], ["talking"]]
)  # fmt: skip
KEYS = st.sampled_from(["case", "side", "density", "ticks", "rounds", "radius", "label", *Body.model_fields]) | TEXT


@st.composite
def tables(draw):
    """The tables of a study that is right, with up to three values in the place of others, or keys of other names."""
    made = deepcopy(tables_of(np.random.default_rng(draw(st.integers(0, 2**32))), "minimalistic", longest=9))
    for _ in range(draw(st.integers(0, 3))):
        level = made
        while (inner := [v for v in level.values() if isinstance(v, dict) and v]) and draw(st.integers(0, 3)):
            level = draw(st.sampled_from(inner))
        value = deepcopy(draw(ANY | TABLES))
        level[draw(st.sampled_from(sorted(level)) | KEYS)] = [value, 1] if draw(st.integers(0, 4)) == 0 else value
    return made


@st.composite
def spoiled(draw, originals):
    """A text or bytes with some places cut out, doubled, exchanged or written over."""
    data = draw(st.sampled_from(originals))
    for _ in range(draw(st.integers(1, 4))):
        lines = draw(st.booleans())
        parts = data.splitlines(keepends=True) if lines else data
        if not parts:
            continue
        a, b = sorted((draw(st.integers(0, len(parts))), draw(st.integers(0, len(parts)))))
        b = b if lines else min(b, a + draw(st.integers(0, 20)))
        new = parts[:0]
        if draw(st.booleans()):
            noise = draw(st.text(max_size=5) if isinstance(data, str) else st.binary(max_size=5))
            new = [noise] if lines else noise
        kept = draw(st.sampled_from([parts[:a] + new + parts[b:], parts[:b] + new + parts[a:], parts[:a] + new]))
        data = data[:0].join(kept) if lines else kept
    return data
