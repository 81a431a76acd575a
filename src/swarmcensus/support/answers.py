"""What a command finds out, the same on a terminal, in a pipe, in a notebook, and in files of many formats."""

import csv
import io
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option
from swarmcensus.support.printed_tables import Column, Table, fields, html, latex, markdown, tsv

if TYPE_CHECKING:
    import pandas as pd
    from rich.console import Console

ENDS = ("low", "high")
ALL = "the property `frame` has all"
MOST_ROWS = 40  # of a table for people, unless more are asked for
SUFFIXES = (".csv", ".html", ".json", ".md", ".parquet", ".tex", ".tsv", ".txt")  # of files of answers
Row = Mapping[str, Any]


class Answer:
    """What a command found out: sentences, cautions, rows of plain numbers, and tables that show them to people.

    `sentences` say it in words, `cautions` what could mislead. `rows` has a row for each item, with all digits, and
    `tables` shows them, at most `limit` rows of each (0: all); the first one has the same rows. `files` were written,
    each with what is said of it, and `next` is the command that follows. `fields` are more entries of JSON. `code` is
    the exit code of the command `command`. Tables for people have `usual_limit` rows, unless others are asked for.
    """

    command: str = ""
    title: str = ""
    sentences: Sequence[str] = ()
    cautions: Sequence[str] = ()
    rows: Sequence[Row] = ()
    fields: Mapping[str, Any] = {}
    files: Mapping[Path, str] = {}
    next: str = ""
    code: int = 0
    usual_limit: int = MOST_ROWS
    _tables: Sequence[Table] = ()

    def __init__(self, *tables: Table, **parts: Any) -> None:
        """An answer of these tables and parts."""
        self._tables = tables
        vars(self).update(parts)

    def tables(self, limit: int) -> Sequence[Table]:
        """The tables for people."""
        return [table.first(limit) for table in self._tables]

    @property
    def frame(self) -> "pd.DataFrame":
        """The rows as a pandas table."""
        import pandas as pd

        return pd.DataFrame([*self.rows])

    @property
    def columns(self) -> list[dict[str, str]]:
        """What each entry of the rows is: name, title, unit and meaning, in the order of the rows."""
        from swarmcensus.support.quantities import QUANTITIES

        known = {one.name: one for table in self.tables(1)[:1] for one in table.columns if one.name}
        found = []
        for name in dict.fromkeys(chain.from_iterable(self.rows)):
            about = known.get(name) or QUANTITIES.get(name)
            ends = {f"{k}_{end}": f"{k}, {end} end of the interval" for k in (name[:-4], name[:-5]) for end in ENDS}
            title = (about and (about.head if isinstance(about, Column) else about.title)) or name.replace("_", " ")
            meaning = about.meaning if about else ends.get(name, "")
            found.append({"name": name, "title": title, "unit": about.unit if about else "", "meaning": meaning})
        return found

    def print_on(
        self, out: "Console", limit: int | None = None, columns: Sequence[str] = (), wider: str = ALL, longer: str = ALL
    ) -> None:
        """Print it for people: what was found, tables, and what was found once more below a long table.

        `wider` says where columns are that do not fit, `longer` where rows are that were left out.
        """
        from swarmcensus.support.terminal import show

        first, *others = self.tables(self.usual_limit if limit is None else limit) or [Table([])]
        if columns:  # of other tables too if they have them all
            others = [_only(one, columns) for one in others if {*columns} <= _named(one).keys()]
            first = _only(first, columns)
        if self.title:
            out.print(self.title)
        self._say(out)
        lines = 0
        for table in (first, *others) if first.columns else ():
            if table is not first or self.sentences or self.cautions:
                out.print()
            lines += show(table, out, wider, longer)
        if lines > out.height > len(self.sentences) and (self.sentences or self.cautions):
            out.print()
            self._say(out)

    def _say(self, out: "Console") -> None:
        for style, lines in (("", self.sentences), ("yellow", [f"caution: {caution}" for caution in self.cautions])):
            for line in lines:  # in which addresses and commands stay whole, to be copied
                parts = textwrap.wrap(line, out.width, break_long_words=False, break_on_hyphens=False)
                out.print(*parts, sep="\n", style=style, soft_wrap=True)

    def __repr__(self) -> str:
        """The text of a terminal of 120 columns."""
        from swarmcensus.support.terminal import as_text

        return as_text(self.print_on)

    def _repr_html_(self) -> str:
        """The same for notebooks."""
        said = [*self.sentences, *(f"caution: {caution}" for caution in self.cautions)]
        first, *others = self.tables(self.usual_limit) or [Table([])]
        return html(first, self.title, said) + "".join(map(html, others))

    def to_json(self, limit: int = 0, columns: Sequence[str] = (), ascii_only: bool = False) -> str:
        """One JSON document."""
        from swarmcensus.support.documents import document

        return document(
            "answer",
            {
                "command": self.command, "title": self.title, "sentences": [*self.sentences],
                "cautions": [*self.cautions], "columns": self.columns, "rows": self._rows(limit, columns),
                "files": [*self.files], "next": self.next, **self.fields,
            },
            ascii_only,
        )  # fmt: skip

    def to_tsv(self, limit: int = 0, columns: Sequence[str] = ()) -> str:
        """The rows as tab-separated columns, with a line of names."""
        return "".join(f"{line}\n" for line in tsv(self._rows(limit, columns)))

    def to_csv(self) -> str:
        """The same with commas."""
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(fields(self.rows))
        return out.getvalue()

    def to_latex(self) -> str:
        """The table for a paper, with the package booktabs; what its columns mean, and sentences, are in comments."""
        return "".join(f"% {line}\n" for line in self.sentences) + "\n".join(map(latex, self.tables(0)[:1]))

    def to_markdown(self) -> str:
        """The sentences and tables in Markdown."""
        said = [*self.sentences, *(f"Caution: {caution}" for caution in self.cautions)]
        return "\n\n".join([*said, *map(markdown, self.tables(0))]) + "\n"

    def save(self, path: str | Path) -> None:
        """Write it in the format of the path's ending, whole or not at all. Raises InputError."""
        from swarmcensus.support.files import atomic_write, check_output

        check_output("save", path, SUFFIXES)
        ending = Path(path).suffix.lower()
        texts: dict[str, Callable[[], str]] = {
            ".csv": self.to_csv, ".json": self.to_json, ".tsv": self.to_tsv, ".tex": self.to_latex,
            ".md": self.to_markdown, ".html": self._repr_html_, ".txt": lambda: f"{self!r}\n",
        }  # fmt: skip
        with atomic_write(path) as temporary:
            if ending in texts:
                temporary.write_text(texts[ending](), encoding="utf-8")
            else:
                self.frame.to_parquet(temporary, index=False)

    def _rows(self, limit: int, columns: Sequence[str]) -> list[Row]:
        rows = [*self.rows][: limit or None]
        if not columns:
            return rows
        names = _chosen(columns, {name: name for name in chain.from_iterable(rows)})
        return [{name: row.get(name) for name in names} for row in rows]


def _only(table: Table, columns: Sequence[str]) -> Table:
    """The table with these columns only, by their names or heads."""
    kept = _chosen(columns, _named(table))
    others = [one.head for one in table.columns if one not in kept]
    return replace(table, columns=kept, notes=lambda left_out: table.notes([*left_out, *others]))


def _named(table: Table) -> dict[str, Column]:
    return {key: one for one in table.columns for key in (one.head, one.name) if key}


def _chosen(wanted: Iterable[str], known: Mapping[str, Any]) -> list[Any]:
    for name in wanted:
        if name not in known:
            raise wrong_option("columns", name, f"{did_you_mean(name, known)}there are {', '.join(known)}")
    return [known[name] for name in wanted]
