"""Strategies of hypothesis: values, studies right and wrong, and texts and bytes that were spoiled."""

import math

from hypothesis import strategies as st

from swarmcensus.worlds.bodies import Body

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


def mostly(good):
    """Values that are right nine times in ten, one of them or a list."""
    return st.integers(0, 19).flatmap(
        lambda n: ANY if n == 0 else good if n < 14 else st.lists(good, min_size=1, max_size=3)
    )


SHARE = st.sampled_from([0.0, 0.05, 0.3, 0.5, 0.675, 1.0, 1]) | st.floats(0.0, 1.0)
SPREAD = st.builds("U({!r}, {!r})".format, st.floats(0.0, 0.5), st.floats(0.5, 1.0)) | st.builds(
    "N({!r},{!r})".format, SHARE, st.floats(1e-3, 1.0)
)
SPREAD_FILE = st.sampled_from(["x.py(0.1, 0.2)", "x.py", "x y.py()"])
SENSOR = SHARE | SPREAD | st.fixed_dictionaries({"black": SHARE | SPREAD, "white": SHARE | SPREAD})
ROBOTS = st.integers(1, 3)
EDGES = st.lists(st.tuples(st.integers(0, 2), st.integers(0, 2)).map(list), max_size=4)
NAMED = ["small-world", "random-geometric", "grid", "torus", "x.py", "x.gml"]
TOPOLOGY = st.sampled_from(["full", "ring", "line", "scale-free", "moving", *NAMED]) | st.one_of(
    st.fixed_dictionaries(
        {"name": st.sampled_from(NAMED)},
        optional={"columns": SCALAR, "neighbours": SCALAR, "radius": SHARE, "label": TEXT | SCALAR},
    ),
    st.fixed_dictionaries({"name": TEXT, "edges": EDGES | ANY}, optional={"directed": st.booleans() | SCALAR}),
    st.fixed_dictionaries(
        {"file": TEXT | st.sampled_from(["x.py", "x.net"])},
        optional={"directed": st.booleans(), "weights": TEXT, "renumber": st.booleans() | SCALAR, "label": TEXT},
    ),
    st.fixed_dictionaries(
        {"networkx": st.sampled_from(["path_graph", "gnp_random_graph", "random_k_out_graph", "x_graph"])},
        optional={"p": SHARE | SCALAR, "k": SCALAR, "seed": SCALAR, "directed": st.booleans(), "alpha": SHARE},
    ),
)
PATTERNS = [{"benchmark": "band"}, {"benchmark": "star", "cells": 0}, "x.py", {"file": "x.py", "a": 1}]
FLOOR = st.sampled_from(
    ["tiles", "half", {"clusters": 0.2}, {"stripes": 0.5}, {"image": "x.png"}, {"clusters": 0.0}, *PATTERNS]
)
UNTIL = ["convergence_error median +- 0.01", "correct@2 mean +- 1", "correct@99 mean +- 1"]
RULE = st.fixed_dictionaries(
    {"until": st.sampled_from(UNTIL) | TEXT},
    optional={"at_least": st.integers(0, 20) | SCALAR, "at_most": st.integers(6, 40) | SCALAR},
)
TICKS = st.integers(1, 3) | st.sampled_from(["0.1 s", "0.2 s", "1 s", "0.005 min", "0.15 s", "1 h", "soon", "1e99 h"])
FAULT = st.fixed_dictionaries(
    {"at": TICKS | st.integers(1, 4) | SCALAR, "robots": ROBOTS | SHARE | SCALAR,
     "stop": st.sampled_from(["talking", "sensing", "moving", ["talking", "sensing"]]) | ANY},
)  # fmt: skip
SIZES = st.sampled_from([1e-12, 1e-9, 1e-3, 0.05, 0.1, 0.7, 2.0, 1e9, 1e12]) | SCALAR
BODY = st.dictionaries(st.sampled_from([*Body.model_fields, "size"]), SIZES | ANY | TICKS, max_size=2)


@st.composite
def table(draw, keys, required=()):
    """A table of a study: some of its keys, the required ones nearly always, and now and then one of another name."""
    chosen = {k for k in keys if draw(st.integers(0, 19)) < (19 if k in required else 7)}
    made = {k: draw(keys[k]) for k in keys if k in chosen}
    if draw(st.integers(0, 24)) == 0:
        made[draw(TEXT)] = draw(ANY)
    return made


SWARM = {
    "brain": mostly(st.sampled_from(["minimalistic", "legacy"])), "robots": mostly(ROBOTS),
    "accuracy": mostly(SENSOR | SPREAD_FILE),
    "assumed_accuracy": mostly(SENSOR | st.builds(lambda s: {"error": s}, SHARE)),
}  # fmt: skip
WORLD = {
    "topology": mostly(TOPOLOGY), "fill_ratio": mostly(SHARE | st.just("U(0.3, 0.7)")),
    "link_success": mostly(SHARE), "missing_links": SHARE,
    "density": mostly(st.floats(0.1, 10.0)), "side": mostly(st.floats(0.5, 5.0)), "floor": mostly(FLOOR),
}  # fmt: skip
SCHEDULE = {
    "rounds": mostly(st.integers(1, 3)), "observations_per_round": mostly(st.integers(1, 12)), "ticks": mostly(TICKS)
}  # fmt: skip
STUDY = table(
    {
        "name": mostly(TEXT.filter(bool)),
        "seed": mostly(st.integers(0, 2**63 - 1)),
        "trials": mostly(st.integers(1, 2) | RULE),
        "swarm": table(SWARM, ("robots", "accuracy")),
        "world": table(WORLD | {"body": BODY}, ("topology", "fill_ratio")),
        "schedule": table(SCHEDULE),
        "measure": table(
            {"delta": mostly(st.floats(1e-9, 2.0)), "bins": mostly(st.integers(1, 20)), "truth": mostly(st.just("floor")),  # noqa: E501
             "checkpoints": mostly(TICKS), "local": mostly(st.booleans())},
        ),
        "faults": st.lists(FAULT, max_size=2) | ANY,
        "case": st.lists(table(SWARM | WORLD | SCHEDULE), min_size=1, max_size=2) | ANY,
    },
    ("trials", "swarm", "world"),
)  # fmt: skip


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
