"""Tables of pages: those that the code makes, and measured ones from the CSV files of benchmarks/tables/.

    python docs_hooks/tables.py        # writes them into all pages

A table stands between two comments. Of the code, they name what it shows: keys, coordinates, quantities or metrics.
Of measured tables, they name the CSV file and what the page shows of it:

    <!-- table: NAME rows="a, b" by="column" columns="a, b, c" first=8 -->
    <!-- end of table -->

`rows` are those whose first cells are named, `by` sorts by numbers and leaves out rows that have none, and `first` is
a number of rows. Another word names a column, and the value that rows have there. Without an option, all is shown.
Below the last table of a CSV file the page links the file, and the site adds the whole table, which can be sorted.

What keys, coordinates and quantities mean stands on the page, in the last cell of each row: that stays. A new row gets
what the code says.

Tables of Python's names list them by hand. A row of one name gets the first sentence of its docstring. The site adds
what mkdocstrings says of each.
"""

from __future__ import annotations

import functools
import html
import inspect
import json
import pydoc
import re
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from swarmcensus.brains import metrics
from swarmcensus.studies import coordinates
from swarmcensus.studies.keys import Key
from swarmcensus.studies.settings import KEYS, Schedule, Swarm, World
from swarmcensus.support import quantities

if TYPE_CHECKING:  # the script needs no mkdocs
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
MEASURED = "benchmarks/tables"
BETWEEN = re.compile(r"<!-- table: (.*?) -->\n.*?<!-- end of table -->", re.DOTALL)
END = "<!-- end of table -->"
LONG = 40  # characters of a cell that should have room
OPTIONS = {"rows", "by", "columns", "first"}
NAMES = re.compile(r"(?<=<!-- names: python docs_hooks/tables.py -->\n).*?(?=<!-- end of names -->)", re.DOTALL)
NAME = re.compile(r"^\| `([\w.]+)` \|.*$", re.MULTILINE)
SENTENCE = re.compile(r".+?(?<!Eq)(?<!Fig)(?= \(docs/| \(see docs/|\.\s|\.\Z)", re.DOTALL)
LAST_CELL = re.compile(r"^\| `(\w+)` (?:\|.* )?\| (.+) \|$", re.MULTILINE)
VALUES = {  # of keys, in words
    "brain": "text or table", "accuracy": "[accuracy](#accuracies)", "topology": "[topology](#topologies)",
    "assumed_accuracy": "[accuracy](#accuracies) or error", "floor": "[floor](#floors)", "body": "table",
    "fill_ratio": "number in [0, 1], [change](#floors-that-change) or spread",
    "ticks": "whole number from 1, or [time](#times)", "robots": "whole number from 1", "rounds": "whole number from 1",
    "observations_per_round": "whole number from 1", "message_delay": "whole number from 0 to 1000",
    "link_success": "number in [0, 1]", "missing_links": "number in [0, 1]", "density": "number above 0",
    "side": "number above 0", "feedback": "`true` or `false`", "precision": '`"double"` or `"single"`',
    "message": '`"double"`, `"float32"`, `"float16"`, `"ratio16"` or `"ratio8"`',
}  # fmt: skip
WITHOUT = {  # what holds without keys that have no default
    "assumed_accuracy": "the true ones, robot by robot", "density": 'this or `side` for `"moving"`',
    "side": 'this or `density` for `"moving"`', "floor": '`"tiles"`', "body": "a Khepera IV",
}  # fmt: skip
MEMBERS = {  # that the site shows; of others all
    "sc.Study": ["load", "parse", "with_", "settings", "checkpoints", "brains"], "sc.Setting": [], "sc.Brain": [],
    "sc.Comparison": ["verdict", "sentences", "table", "pairs", "ranks", "duels", "profiles", "by"],
    "sc.Interaction": ["sentences", "cells"], "sc.Conformance": ["conforms"], "sc.Reproduction": ["page", "files"],
}  # fmt: skip


Cells = Mapping[str, str]  # the last cells of a table on a page, by the name in the first one: what a name means


def of_coordinates(said: Cells) -> str:
    """The coordinates along `setting`."""
    meanings = {name: said.get(name) or _meaning(KEYS[name]) for name in coordinates.COORDINATES}
    return "\n".join(["| coordinate | meaning |", "|---|---|", *(f"| `{k}` | {m} |" for k, m in meanings.items())])


def of_numbers(said: Cells) -> str:
    """The coordinates that Python adds when it opens results."""
    rows = [f"| `{one.name}` | {one.meaning} |" for one in coordinates.NUMERIC.values()]
    return "\n".join(["| coordinate | meaning |", "|---|---|", *rows])


def of_quantities(said: Cells) -> str:
    """The variables that runs store."""
    stored = [quantity for quantity in quantities.ALL if quantity.group != "derived"]
    rows = [f"| `{q.name}` | {', '.join(q.dims[1:])} | {said.get(q.name) or q.meaning} |" for q in stored]
    return "\n".join(["| variable | of each | meaning |", "|---|---|---|", *rows])


def of_metrics(said: Cells) -> str:
    """The shipped metrics."""
    every = [metrics.load(name) for name in metrics.PLUGINS.shipped]
    rows = [f"| `{one.name}` | {one.unit} | {'low' if one.low else 'high'} | {_cell(one.meaning)} |" for one in every]
    return "\n".join(["| name | unit | better | meaning |", "|---|---|---|---|", *rows])


def of_keys(said: Cells, table: str) -> str:
    """The keys of a table of study files."""
    rows = [
        f"| `{name}` | {VALUES[name]}{', grid' * KEYS[name].spans} | {_default(KEYS[name])} | "
        f"{said.get(name) or _meaning(KEYS[name])} |"
        for name in {"swarm": Swarm, "world": World, "schedule": Schedule}[table].model_fields
    ]
    return "\n".join(["| key | type | default | meaning |", "|---|---|---|---|", *rows])


TABLES = {
    "coordinates": of_coordinates, "numbers": of_numbers, "quantities": of_quantities, "metrics": of_metrics
} | {f"keys of {name}": functools.partial(of_keys, table=name) for name in ("swarm", "world", "schedule")}  # fmt: skip


def filled(page: Path) -> str:
    """The text of a page with its tables as the code and the CSV files have them."""
    markdown = page.read_text(encoding="utf-8")
    up = "../" * (len(page.relative_to(ROOT).parts) - 1)
    for name, table in TABLES.items():
        begin, end = f"<!-- {name}: python docs_hooks/tables.py -->", f"<!-- end of {name} -->"
        before, found, rest = markdown.partition(begin)
        if found:
            old, _, rest = rest.partition(end)
            said = {row[1]: row[2] for row in LAST_CELL.finditer(old)}
            markdown = f"{before}{begin}\n\n{table(said)}\n\n{end}{rest}"
    markdown = NAMES.sub(lambda found: NAME.sub(_described, found[0]), markdown)
    return _replaced(
        markdown, lambda said, is_last: f"<!-- table: {said} -->\n\n{of_measured(said, up, is_last)}\n\n{END}"
    )


def of_measured(said: str, up: str = "", is_last: bool = True) -> str:
    """What a page shows of a CSV file; `up` leads from the page to the repository."""
    name, whole, part = _chosen(said)
    rule = ["---:" if _is_number(part[column]) else "---" for column in part]
    lines = ["| " + " | ".join(_cell(cell) for cell in row) + " |" for row in (part.columns, *part.values)]
    if is_last and part.shape != whole.shape:
        lines += ["", f"[The whole table]({up}{MEASURED}/{name}.csv) has {_size(whole)}."]
    return "\n".join([lines[0], f"|{'|'.join(rule)}|", *lines[1:]])


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Add the whole of each measured table, folded, whose rows javascripts/tables.js sorts; and details of names."""
    markdown = NAMES.sub(lambda found: f"{found[0]}{_details(found[0])}\n", markdown)
    shown = {found[1]: found[0] for found in BETWEEN.finditer(markdown)}
    return _replaced(markdown, lambda said, is_last: shown[said] + (_folded(said) if is_last else ""))


def _described(row: re.Match[str]) -> str:
    """The row of a public name: the first sentence of its docstring."""
    sentence = SENTENCE.match(inspect.getdoc(_public(row[1])) or "")
    assert sentence, row[1]
    return f"| `{row[1]}` | {_cell(' '.join(sentence[0].split()))} |"


def _details(table: str) -> str:
    """What mkdocstrings makes the reference of a table's names of."""
    names = [name for row in table.splitlines() for name in re.findall(r"`([\w.]+)`", row.split(" | ")[0])]
    members = {name: f"\n    options:\n      members: {json.dumps(MEMBERS[name])}" for name in names if name in MEMBERS}
    found = ((name, _public(name)) for name in names)
    return "\n".join(f"::: {one.__module__}.{one.__qualname__}{members.get(name, '')}\n" for name, one in found)


def _public(name: str) -> Any:
    return pydoc.locate(f"swarmcensus.{name.removeprefix('sc.')}")


def _replaced(markdown: str, table: Callable[[str, bool], str]) -> str:
    """A page with other tables, made of what their comments say and whether they are the last of a CSV file."""
    last = {found[1].split()[0]: found.start() for found in BETWEEN.finditer(markdown)}
    return BETWEEN.sub(lambda found: table(found[1], last[found[1].split()[0]] == found.start()), markdown)


def _folded(said: str) -> str:
    _, whole, part = _chosen(said)
    if part.shape == whole.shape:
        return ""
    looks = [_look(whole[column]) for column in whole]
    heads = "".join(
        f'<th scope="col"{look}><button type="button">{html.escape(one)}</button></th>'
        for look, one in zip(looks, whole, strict=True)
    )
    rows = (
        f'<th scope="row">{_html(one)}</th>'
        + "".join(f"<td{look}>{_html(cell)}</td>" for look, cell in zip(looks[1:], row, strict=True))
        for one, *row in whole.values
    )
    table = f"<thead><tr>{heads}</tr></thead><tbody><tr>{'</tr><tr>'.join(rows)}</tr></tbody>"
    return (
        f'\n\n<details class="whole" data-search-exclude><summary>All of it, to be sorted by any column</summary>'
        f'<div tabindex="0"><table class="whole">{table}</table></div></details>\n'
    )


def _chosen(said: str) -> tuple[str, pd.DataFrame, pd.DataFrame]:
    """The name of a CSV file, all of it, and what a comment chooses; cells are texts, as they are in the file."""
    name, *options = shlex.split(said)
    given = dict(option.split("=", 1) for option in options)
    whole = part = pd.read_csv(ROOT / MEASURED / f"{name}.csv", dtype=str, keep_default_na=False)
    for column in given.keys() - OPTIONS:
        part = part[part[column] == given[column]]
    if names := given.get("rows", ""):
        part = part.set_index(part.columns[0], drop=False).loc[names.split(", ")]
    if column := given.get("by", ""):
        numbers = pd.to_numeric(part[column], errors="coerce")
        part = part.loc[numbers.dropna().sort_values(kind="stable").index]
    part = part[given.get("columns", ", ".join(part)).split(", ")].head(int(given.get("first", len(part))))
    return name, whole, part


def _is_number(column: pd.Series) -> bool:
    """Whether a column has numbers and, if at all, gaps."""
    is_number = pd.to_numeric(column, errors="coerce").notna()
    return bool(is_number.any() and (is_number | column.isin(["", "–"])).all())


def _look(column: pd.Series) -> str:
    """The class of a column's cells: of texts they begin at the left, and long ones have room."""
    if _is_number(column):
        return ""
    return ' class="text long"' if column.str.len().max() > LONG else ' class="text"'


def _size(table: pd.DataFrame) -> str:
    return f"{len(table)} rows and {len(table.columns)} columns"


def _html(cell: str) -> str:
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(cell))


def _default(key: Key) -> str:
    """What holds without a key."""
    if key.is_required or key.name in WITHOUT:
        return WITHOUT.get(key.name, "required")
    return f"`{json.dumps(key.default)}`" if isinstance(key.default, str | bool) else str(key.default)


def _meaning(key: Key) -> str:
    """The meaning of a key, as a cell of a table."""
    return key.meaning[0].lower() + key.meaning[1:].rstrip(".")


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


if __name__ == "__main__":
    for path in PAGES:
        path.write_text(filled(path), encoding="utf-8")
