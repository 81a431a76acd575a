"""Tables of pages that are made from the code: of quantities and coordinates, and of the metrics that are shipped.

    python docs_hooks/tables.py        # writes the tables of docs/data-format.md anew

The table of metrics is put into its page when the site is built; `swarmcensus list metrics` prints it.
"""

from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

from swarmcensus import metrics
from swarmcensus.vocabulary import coordinates, quantities

PAGE = Path(__file__).parent.parent / "docs" / "data-format.md"
METRICS = "<!-- the table of metrics is put here when the site is built -->"


def of_quantities() -> str:
    """The variables that runs store, beside those of settings."""
    stored = [quantity for quantity in quantities.ALL if quantity.group != "derived"]
    rows = [f"| `{q.name}` | {', '.join(q.dims)} | {q.unit} | {q.page or q.meaning} |" for q in stored]
    return "\n".join(["| variable | dimensions | unit | meaning |", "|---|---|---|---|", *rows])


def of_coordinates() -> str:
    """The coordinates along `setting`."""
    rows = [f"| `{one.name}` | {one.type} | {one.page} |" for one in coordinates.ALL]
    return "\n".join(["| coordinate | type | meaning |", "|---|---|---|", *rows])


def of_metrics() -> str:
    """The metrics that are shipped."""
    every = [metrics.load(name) for name in metrics.DOOR.shipped]
    rows = [f"| `{one.name}` | {one.unit} | {'low' if one.low else 'high'} | {_cell(one.meaning)} |" for one in every]
    return "\n".join(["| name | unit | better | what it is |", "|---|---|---|---|", *rows])


def filled(markdown: str) -> str:
    """The text of docs/data-format.md with its tables as the code has them."""
    for name, table in (("coordinates", of_coordinates()), ("quantities", of_quantities())):
        begin, end = f"<!-- {name}: python docs_hooks/tables.py -->", f"<!-- end of {name} -->"
        before, _, rest = markdown.partition(begin)
        markdown = f"{before}{begin}\n\n{table}\n\n{end}{rest.partition(end)[2]}"
    return markdown


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put the table of metrics into its page."""
    return markdown.replace(METRICS, of_metrics())


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
