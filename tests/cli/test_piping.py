"""What a pipe gets: tab-separated columns with a line of names and all digits, and nothing else on stdout."""

import codecs
import csv
import io
import json
import os
import subprocess
import sys

import pytest

import swarmcensus as sc
from swarmcensus.cli import program
from swarmcensus.cli.output import give
from swarmcensus.studies.coordinates import NUMERIC
from swarmcensus.support.answers import Answer
from swarmcensus.support.printed_tables import tsv
from swarmcensus.support.readers import AS_TERMINAL

STUDY = """
name   = "piped"
trials = 6
swarm  = {brain = ["minimalistic", "commons"], robots = [3, 6], accuracy = 0.8}
world  = {topology = "ring", fill_ratio = 0.55}
schedule = {rounds = 5}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("piped") / "piped.nc"
    sc.save(sc.run(sc.Study.parse(STUDY)), path)
    return str(path)


@pytest.fixture
def piped(monkeypatch, accepted):
    """Runs a command whose stdout is a pipe: its rows, and what is on stderr."""
    monkeypatch.delenv(AS_TERMINAL)

    def run(*words):
        out, error = accepted(*words)
        first, *lines = out.splitlines()
        names = first.split("\t")
        assert len(set(names)) == len(names)
        assert all(line.count("\t") == len(names) - 1 for line in lines)
        return list(csv.DictReader(io.StringIO(out), delimiter="\t", quoting=csv.QUOTE_NONE)), error

    return run


def same(row, records):
    """Whether a row has these numbers, to the last digit."""
    for name, value in records.items():
        assert row[name] == ("" if value != value else str(value)), name


def test_show_in_a_pipe_has_fixed_columns_and_all_digits(file, piped):
    rows, error = piped("show", file)
    for row, record in zip(rows, sc.summary(file).drop(columns=[*NUMERIC]).to_dict("records"), strict=True):
        same(row, record)
    one, _ = piped("show", file, "--where", "robots == 3 and brain == 'commons'")
    assert [*one[0]] == [*rows[0]]
    assert len(piped("show", file, "--limit", "1")[0]) == 1
    labelled, _ = piped("show", file, "--label", "commons=Ours")
    assert [row["brain"].replace("Ours", "commons") for row in labelled] == [row["brain"] for row in rows]
    assert "Ours" in {row["brain"] for row in labelled}
    assert error == ""


def test_compare_has_its_table_and_the_verdict_is_a_message(file, piped):
    found = sc.compare(file)
    for words, frame in ([], found.table), (["--pairs"], found.pairs), (["--by", "robots"], found.by("robots")):
        rows, error = piped("compare", file, *words)
        assert len(rows) == len(frame)
        same(rows[0], {k: v for k, v in frame.to_dict("records")[0].items() if not isinstance(v, bool)})
        said = [*found.verdict, *(f"caution: {caution}" for caution in found.cautions)]
        assert error.splitlines()[: len(said)] == said
    assert piped("compare", file, "--quiet")[1] == ""


def test_rows_lack_nothing_of_others_and_hold_no_tabs():
    lines = tsv([{"a": 1_000, "b": float("nan")}, {"b": True, "c": "x\ty\n", "d": {"k": [1, 2.5], "m": 3}}])
    assert [*lines] == ["a\tb\tc\td", "1000\t\t\t", "\ttrue\tx\\u0009y\\u000a\tk=1,2.5, m=3"]


@pytest.mark.parametrize("text", ["wide", "0", "9" * 30])
def test_a_terminal_that_is_asked_for_has_columns(text, file, monkeypatch, refused):
    monkeypatch.setenv(AS_TERMINAL, text)
    assert refused("show", file) == f"swarmcensus: {AS_TERMINAL}={text}: should be a number of columns, such as 100"


def test_letters_missing_from_an_encoding_are_escaped(tmp_path):
    codecs.register_error("swarmcensus", program._escaped)
    assert json.loads('"é 𝄞"'.encode("ascii", "swarmcensus")) == "é 𝄞"
    environment = os.environ | {"PYTHONIOENCODING": "cp1252"}
    command = [sys.executable, "-m", "swarmcensus", "new", "study", "é π.toml"]
    for code, stream, says in ((0, "stdout", "é \\u03c0.toml"), (2, "stderr", "é \\u03c0.toml already exists")):
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True)
        assert done.returncode == code
        assert says in getattr(done, stream).decode("cp1252")


def test_json_is_utf_8_in_any_encoding(monkeypatch):
    for encoding in ("utf-8", "cp1252", "ascii", "latin-1"):
        with io.TextIOWrapper(io.BytesIO(), encoding) as out, monkeypatch.context() as patch:
            patch.setattr(sys, "stdout", out)
            give(Answer(title="é 𝄞"), "show", {"json": True}, ())
            out.flush()
            written = out.buffer.getvalue()
        assert json.loads(written.decode())["title"] == "é 𝄞"
        assert (b"\\u00e9" in written) == (encoding != "utf-8")


def test_a_name_that_is_no_text_is_one_sentence(refused):
    error = refused("new", "study", os.fsdecode(b"\xe9.toml"))
    assert "\\udce9.toml" in error
    assert "encoding" in error
