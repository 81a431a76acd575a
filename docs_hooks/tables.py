"""Tables of pages that are made from the code: keys, coordinates, quantities, and the shipped metrics.

    python docs_hooks/tables.py        # writes the tables of docs/data-format.md and docs/study-file.md

A table of these pages stands between two comments, which name it. The table of metrics is put into docs/metrics.md when
the site is built, so that a new metric is a new file and nothing else.
"""

from __future__ import annotations

import functools
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.brains import metrics
from swarmcensus.studies import coordinates
from swarmcensus.studies.fields import LARGEST
from swarmcensus.studies.json_schema import schema
from swarmcensus.studies.keys import Key
from swarmcensus.studies.settings import KEYS
from swarmcensus.support import quantities

if TYPE_CHECKING:  # the script needs no mkdocs
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

PAGES = [Path(__file__).parent.parent / "docs" / name for name in ("data-format.md", "study-file.md")]
METRICS = "<!-- the shipped metrics -->"


def of_coordinates() -> str:
    """The coordinates along `setting`."""
    rows = [f"| `{one.name}` | {one.type} | {one.page}{_elsewhere(one)} |" for one in coordinates.COORDINATES.values()]
    return "\n".join(["| coordinate | type | meaning |", "|---|---|---|", *rows])


def of_numbers() -> str:
    """The coordinates that Python adds when it opens results."""
    rows = [f"| `{one.name}` | {one.page} |" for one in coordinates.NUMERIC.values()]
    return "\n".join(["| coordinate | meaning |", "|---|---|", *rows])


def of_quantities() -> str:
    """The variables that runs store."""
    stored = [quantity for quantity in quantities.ALL if quantity.group != "derived"]
    rows = [f"| `{q.name}` | {', '.join(q.dims)} | {q.unit} | {q.page or q.meaning} |" for q in stored]
    return "\n".join(["| variable | dimensions | unit | meaning |", "|---|---|---|---|", *rows])


def of_metrics() -> str:
    """The shipped metrics."""
    every = [metrics.load(name) for name in metrics.PLUGINS.shipped]
    rows = [f"| `{one.name}` | {one.unit} | {'low' if one.low else 'high'} | {_cell(one.meaning)} |" for one in every]
    return "\n".join(["| name | unit | better | meaning |", "|---|---|---|---|", *rows])


def of_keys(table: str) -> str:
    """The keys of a table of study files."""
    nodes = schema()["$defs"][table.title()]["properties"]
    rows = [
        f"| `{name}` | {KEYS[name].values or _values(node)}{', grid' * KEYS[name].spans} | {_default(KEYS[name])} | "
        f"{KEYS[name].page or _meaning(KEYS[name])} |"
        for name, node in nodes.items()
    ]
    return "\n".join(["| key | type | default | meaning |", "|---|---|---|---|", *rows])


TABLES = {"coordinates": of_coordinates, "numbers": of_numbers, "quantities": of_quantities} | {
    f"keys of {table}": functools.partial(of_keys, table) for table in ("swarm", "world", "schedule")
}


def filled(markdown: str) -> str:
    """The text of a page with its tables as the code has them."""
    for name, table in TABLES.items():
        begin, end = f"<!-- {name}: python docs_hooks/tables.py -->", f"<!-- end of {name} -->"
        before, found, rest = markdown.partition(begin)
        if found:
            markdown = f"{before}{begin}\n\n{table()}\n\n{end}{rest.partition(end)[2]}"
    return markdown


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put the table of metrics into its page."""
    return markdown.replace(METRICS, of_metrics())


def _elsewhere(one: coordinates.Coordinate) -> str:
    """Where a coordinate says nothing, and what it is there."""
    if one.world in (None, "any"):
        return ""
    blank = {"text": "empty", "number": "NaN", "whole number": one.blank}[one.type]
    return f"; {blank} {'on fixed networks' if one.world == 'moving' else 'where robots move'}"


def _values(node: dict[str, Any]) -> str:
    """The values of a key, in words, from its schema."""
    node = node["anyOf"][0] if "anyOf" in node else node  # one value, or a list of them
    if names := [f"`{json.dumps(name)}`" for name in node.get("enum", ())]:
        return f"{', '.join(names[:-1])} or {names[-1]}"
    if node["type"] == "boolean":
        return "`true` or `false`"
    low, high = node["minimum"], node["maximum"]
    if node["type"] == "number":
        return "number above 0" if high > 1 else f"number in [{low:g}, {high:g}]"
    return f"whole number from {low}" + (f" to {high}" if high < LARGEST else "")


def _default(key: Key) -> str:
    """What holds without a key."""
    if key.is_required or key.default is None or key.without:
        return key.without or "required"
    return f"`{json.dumps(key.default)}`" if isinstance(key.default, str | bool) else str(key.default)


def _meaning(key: Key) -> str:
    """The meaning of a key, as a cell of a table."""
    return key.meaning[0].lower() + key.meaning[1:].rstrip(".")


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


if __name__ == "__main__":
    for path in PAGES:
        path.write_text(filled(path.read_text(encoding="utf-8")), encoding="utf-8")
