"""Tables of pages that are made from the code: coordinates, quantities, and the shipped metrics.

    python docs_hooks/tables.py        # writes the tables of docs/data-format.md

A table of that page stands between two comments, which name it. The table of metrics is put into docs/metrics.md when
the site is built, so that a new metric is a new file and nothing else.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from swarmcensus import metrics
from swarmcensus.studies import coordinates
from swarmcensus.vocabulary import quantities

if TYPE_CHECKING:  # the script needs no mkdocs
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

PAGE = Path(__file__).parent.parent / "docs" / "data-format.md"
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


TABLES = {"coordinates": of_coordinates, "numbers": of_numbers, "quantities": of_quantities}


def filled(markdown: str) -> str:
    """The text of docs/data-format.md with its tables as the code has them."""
    for name, table in TABLES.items():
        begin, end = f"<!-- {name}: python docs_hooks/tables.py -->", f"<!-- end of {name} -->"
        before, _, rest = markdown.partition(begin)
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


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
