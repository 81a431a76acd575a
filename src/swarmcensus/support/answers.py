"""What a command finds out, the same on a terminal, in a pipe, in a notebook, and in files of many formats."""

import csv
import io
import json
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option
from swarmcensus.support.printed_tables import ASKED, Column, Table, fields, html, latex, markdown, tsv

if TYPE_CHECKING:
    import pandas as pd
    from rich.console import Console

ALL = "the property `frame` has all"
MOST_ROWS = 40  # of a table for people, unless more are asked for
FORMATS = {  # by the endings of files: the method that makes the text
    ".json": "to_json", ".csv": "to_csv", ".tsv": "to_tsv", ".parquet": "", ".tex": "to_latex", ".md": "to_markdown",
    ".html": "to_html",
}  # fmt: skip
ROWS = (".csv", ".parquet", ".tsv")  # have nothing but rows
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
        if unknown := [name for name in parts if type(self) is Answer and not hasattr(Answer, name)]:
            raise TypeError(f"an answer has no {', '.join(unknown)}")
        self._tables = tables
        vars(self).update(parts)

    def tables(self, limit: int) -> Sequence[Table]:
        """The tables for people: by default one of all rows as they are."""
        return [table.first(limit) for table in self._tables or ([Table.of(self.rows)] if self.rows else [])]

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
            value, _, end = name.rpartition("_")
            of_end = f"{value}, {end} end of the interval" * (end in ("low", "high"))
            title = (about and (about.head if isinstance(about, Column) else about.title)) or name.replace("_", " ")
            meaning = about.meaning if about else of_end
            found.append({"name": name, "title": title, "unit": about.unit if about else "", "meaning": meaning})
        return found

    @property
    def said(self) -> list[str]:
        """The sentences and cautions."""
        return [*self.sentences, *(f"caution: {caution}" for caution in self.cautions)]

    def print_on(
        self, out: "Console", limit: int | None = None, columns: Sequence[str] = (), wider: str = ALL, longer: str = ALL
    ) -> None:
        """Print it for people: what was found, tables, and what was found once more below a long table.

        `wider` says where columns are that do not fit, `longer` where rows are that were left out.
        """
        from swarmcensus.support.terminal import show

        first, *others = self._chosen(self.usual_limit if limit is None else limit, columns)
        if self.title:
            out.print(self.title)
        said, lines, left_out = self._say(out), 0, dict[str, None]()
        for table in (first, *others) if first.columns else ():
            if table is not first or self.sentences or self.cautions:
                out.print()
            rows, lacking = show(table, out, longer)
            lines += rows
            left_out |= dict.fromkeys(lacking)
        if left_out:
            which = f"as they do not fit into {out.width} columns: {', '.join(left_out)}"
            out.print(f"left out, {which}; {wider}", style="dim")
        if lines > out.height > said > 0:
            out.print()
            self._say(out)

    def _say(self, out: "Console") -> int:
        """Print sentences and cautions, and return how many lines."""
        said = 0
        for style, lines in (("", self.sentences), ("yellow", self.said[len(self.sentences) :])):
            for line in lines:  # in which addresses and commands stay whole, to be copied
                parts = textwrap.wrap(line, out.width, break_long_words=False, break_on_hyphens=False)
                out.print(*parts, sep="\n", style=style, soft_wrap=True)
                said += len(parts)
        return said

    def _chosen(self, limit: int, columns: Sequence[str]) -> list[Table]:
        """The tables with these columns: the first one, and others that have them all."""
        first, *others = self.tables(limit) or [Table([])]
        if not columns:
            return [first, *others]
        return [_only(first, columns, self.rows), *(_only(one, columns) for one in others if _has(one, columns))]

    def __repr__(self) -> str:
        """The text of a terminal of 120 columns."""
        from swarmcensus.support.terminal import as_text

        return as_text(self.print_on)

    def _repr_html_(self) -> str:
        """The same for notebooks."""
        return self.to_html(self.usual_limit)

    def to_html(self, limit: int = 0, columns: Sequence[str] = ()) -> str:
        """A part of a page."""
        first, *others = self._chosen(limit, columns)
        return html(first, self.title, self.said) + "".join(map(html, others))

    def to_json(self, limit: int = 0, columns: Sequence[str] = (), ascii_only: bool = False) -> str:
        """One JSON document; with `ascii_only`, for streams that are not UTF-8, other letters are escaped."""
        from swarmcensus.support.documents import json_value

        rows = self._rows(limit, columns)
        about = [one for one in self.columns if not columns or one["name"] in {*chain.from_iterable(rows)}]
        content = {
            "format": "swarmcensus answer 1", "command": self.command, "title": self.title, "sentences": self.sentences,
            "cautions": self.cautions, "columns": about, "rows": rows, "files": [*self.files], "next": self.next,
        }  # fmt: skip
        return json.dumps(json_value(content | dict(self.fields)), indent=1, allow_nan=False, ensure_ascii=ascii_only)

    def to_tsv(self, limit: int = 0, columns: Sequence[str] = ()) -> str:
        """The rows as tab-separated columns, with a line of names."""
        return "".join(f"{line}\n" for line in tsv(self._rows(limit, columns)))

    def to_csv(self, limit: int = 0, columns: Sequence[str] = ()) -> str:
        """The same with commas."""
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(fields(self._rows(limit, columns)))
        return out.getvalue()

    def to_latex(self, limit: int = 0, columns: Sequence[str] = ()) -> str:
        """The table for a paper, with the package booktabs; all else is in comments."""
        about = [f"% {' '.join(line.split())}\n" for line in (self.title, *self.said) if line]
        return "".join(about) + latex(self._chosen(limit, columns)[0])

    def to_markdown(self, limit: int = 0, columns: Sequence[str] = ()) -> str:
        """The title, sentences and tables in Markdown."""
        parts = [self.title, *self.said]
        for table in self._chosen(limit, columns):
            parts += [table.title, *table.above, markdown(table.plain()), table.legend(), *table.notes(()), table.more]
        return "\n\n".join(filter(None, parts)) + "\n"

    def save(self, path: str | Path, limit: int = 0, columns: Sequence[str] = ()) -> None:
        """Write it in the format of the path's ending, whole or not at all. Raises InputError."""
        from swarmcensus.support.files import atomic_write, check_output

        check_output("save", path, tuple(FORMATS))
        ending = Path(path).suffix.lower()
        if ending in ROWS and not self.rows:
            others = ", ".join(one for one in FORMATS if one not in ROWS)
            raise wrong_option("save", path, f"this answer has no rows: it can be written as {others}")
        with atomic_write(path) as temporary:
            if FORMATS[ending]:
                temporary.write_text(getattr(self, FORMATS[ending])(limit, columns), encoding="utf-8")
            else:
                Answer(rows=self._rows(limit, columns)).frame.to_parquet(temporary, index=False)

    def _rows(self, limit: int, columns: Sequence[str]) -> list[Row]:
        rows = [*self.rows][: limit or None]
        if not columns:
            return rows
        titles = {one["title"]: one["name"] for one in self.columns}
        names = _look_up(columns, titles | {name: name for name in chain.from_iterable(rows)})
        return [{name: row.get(name) for name in names} for row in rows]


def _only(table: Table, columns: Sequence[str], rows: Sequence[Row] = ()) -> Table:
    """The table with these columns only, by their names or heads; others are those of the rows."""
    own = {key: one for one in table.columns for key in (one.head, one.name) if key}
    lines = len(table.columns[0].cells) if table.columns else 0
    names = dict.fromkeys(chain.from_iterable(rows))
    every = Table.of([*rows][:lines]).columns if {*columns} - {*own} else []
    more = {name: replace(one, head=name) for name, one in zip(names, every, strict=False)}
    asked = [replace(one, rank=ASKED) for one in _look_up(columns, more | own)]
    kept = [one for one in table.columns if not one.head] + asked
    others = [one.head for one in table.columns if one.head not in {one.head for one in kept}]
    return replace(table, columns=kept, notes=lambda left_out: table.notes([*left_out, *others]))


def _has(table: Table, columns: Sequence[str]) -> bool:
    return {*columns} <= {key for one in table.columns for key in (one.head, one.name)}


def _look_up(wanted: Iterable[str], known: Mapping[str, Any]) -> list[Any]:
    from swarmcensus.support.quantities import QUANTITIES

    for name in wanted:
        if name not in known:
            own = dict.fromkeys(getattr(one, "name", one) or key for key, one in known.items())
            is_compared = name in QUANTITIES and QUANTITIES[name].low is not None
            hint = f"compare --metric {name} has it; " if is_compared else did_you_mean(name, known)
            raise wrong_option("columns", name, f"{hint}there are {', '.join(map(str, own))}")
    return [known[name] for name in wanted]
