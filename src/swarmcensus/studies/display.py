"""How a study shows itself in a notebook: the keys that span its grid with all their values, then the others."""

import html
from collections.abc import Iterator
from typing import Any

from swarmcensus.basics.counting import counted
from swarmcensus.studies.grids import Grid
from swarmcensus.studies.toml_text import to_toml_value

MOST_VALUES = 12
LONGEST = 60  # letters of a value
COUNTED = 10_000  # settings of which those that are alike are counted once
OF_FIXED = {"rounds", "observations_per_round", "message_delay"}
OF_MOVING = {"ticks", "density", "side", "floor"}


def size_of(study: Any) -> str:
    """How many settings a study has, and how many trials of each."""
    settings = sum(grid.count for grid in study.grids)
    if study.case and settings <= COUNTED:
        settings = len(study.settings())
    trials = "at most " * bool(study.until) + counted(study.trials, "trial")
    return f"{counted(settings, 'setting')} of {trials}"


def grid(study: Any) -> str:
    """The study as a table in HTML: a row for each key, those of several values first."""
    rows = sorted(_keys(study.grids[0]), key=lambda row: len(row[1]) < 2)
    rows += [(f"[[{name}]]", [f"{len(tables)} more"]) for name, tables in _more(study) if tables]
    lines = [
        f"<tr><th style='text-align:left'>{html.escape(key)}</th><td style='text-align:right'>"
        f"{len(values) if len(values) > 1 else ''}</td><td style='text-align:left'>{html.escape(_listed(values))}</td>"
        "</tr>"
        for key, values in rows
    ]
    head = f"<b>{html.escape(study.name)}</b>: {size_of(study)}, seed {study.seed}"
    columns = "<tr><th style='text-align:left'>key</th><th></th><th style='text-align:left'>values</th></tr>"
    return f"<div>{head}<table><thead>{columns}</thead><tbody>{''.join(lines)}</tbody></table></div>"


def _keys(of: Grid) -> Iterator[tuple[str, list[Any]]]:
    """The keys of a grid that mean something in it, with their values."""
    idle = (set() if of.moves else OF_MOVING) | (set() if of.stands else OF_FIXED)
    for table in (of.swarm, of.world, of.schedule):
        default = {name: field.default for name, field in type(table).model_fields.items()}
        for name, values in table:
            said = values != default[name] or name in ("brain", "rounds", "ticks", "observations_per_round")
            if isinstance(values, list) and name not in idle and said:
                yield name, values


def _more(study: Any) -> Iterator[tuple[str, Any]]:
    for name in ("case", "members", "faults"):
        yield name, getattr(study, name)


def _listed(values: list[Any]) -> str:
    texts = [to_toml_value(value).strip('"') for value in values[:MOST_VALUES]]
    texts = [text if len(text) <= LONGEST else f"{text[:LONGEST]}…" for text in texts]
    return ", ".join(texts) + (", …" if len(values) > MOST_VALUES else "")
