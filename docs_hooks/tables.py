"""Tables of pages that are made from the code: coordinates, quantities, and the shipped metrics.

    python docs_hooks/tables.py        # writes the tables of docs/data-format.md and docs/metrics.md

A table stands between two comments, which name it.
"""

from pathlib import Path

from swarmcensus import metrics
from swarmcensus.vocabulary import coordinates, quantities

DOCS = Path(__file__).parent.parent / "docs"
PAGES = [DOCS / "data-format.md", DOCS / "metrics.md"]


def of_coordinates() -> str:
    """The coordinates along `setting`."""
    rows = [f"| `{one.name}` | {one.type} | {one.page} |" for one in coordinates.ALL]
    return "\n".join(["| coordinate | type | meaning |", "|---|---|---|", *rows])


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


TABLES = {"coordinates": of_coordinates, "quantities": of_quantities, "metrics": of_metrics}


def filled(markdown: str) -> str:
    """The text of a page with its tables as the code has them."""
    for name, table in TABLES.items():
        begin, end = f"<!-- {name}: python docs_hooks/tables.py -->", f"<!-- end of {name} -->"
        if begin in markdown:
            before, _, rest = markdown.partition(begin)
            markdown = f"{before}{begin}\n\n{table()}\n\n{end}{rest.partition(end)[2]}"
    return markdown


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


if __name__ == "__main__":
    for page in PAGES:
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")
