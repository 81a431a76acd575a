"""Texts: encodings, spreadsheets, numbers as people read them, templates; and how many cores are used."""

import os

import jinja2
import numpy as np
import pandas as pd
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.figures.notebook import shown
from swarmcensus.live.pages import PAGE, SCRIPTS, STYLES, recorded_page
from swarmcensus.support import cores
from swarmcensus.support.control_characters import spreadsheet_text, write_csv
from swarmcensus.support.formatting import counted, distinct_texts, fixed, grouped, rounded
from swarmcensus.support.printed_tables import tsv
from swarmcensus.support.templates import render

STUDY = 'name = "ring"\ntrials = 1\n[swarm]\nrobots = 4\naccuracy = 0.8\n[world]\ntopology = "ring"\nfill_ratio = 0.5\n'
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-32")


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_studies_are_read_in_any_encoding_with_a_mark(encoding, here):
    (here / "s.toml").write_text(STUDY, encoding=encoding, newline="\r\n")
    assert sc.Study.load("s.toml").text == STUDY


@pytest.mark.parametrize(("content", "said"), [
    (STUDY.encode("utf-16-le"), "it is no text, or in another encoding: save it as text in UTF-8"),
    (STUDY.encode("utf-16")[:-1], "line 8 is not UTF-16: save it as text in UTF-8"),
    (b"# a\n# caf\xe9\n", "line 2 is not UTF-8: save it as text in UTF-8"),
])  # fmt: skip
def test_other_encodings_are_named(content, said, here, refused):
    for name in ("s.toml", "s.csv"):
        (here / name).write_bytes(content)
    assert f"s.toml: cannot be read as text: {said}" in refused("run", "s.toml")
    assert f"s.csv: cannot be read as text: {said}" in refused("infer", "s.csv", "--accuracy", "0.8")


def test_brains_are_utf_8_and_keep_their_hash(here, refused):
    source = brains.load("voter").source
    for encoding in ENCODINGS[:2]:
        (here / "own.py").write_text(source, encoding=encoding, newline="\r\n")
        assert brains.load("own.py").source == source  # and so its hash
    (here / "own.py").write_text(source, encoding="utf-16")
    (here / "s.toml").write_text(STUDY.replace("robots", 'brain = "own.py"\nrobots'))
    assert "own.py: cannot be read as text: it is in UTF-16: save it as UTF-8" in refused("run", "s.toml")


TEXTS = {"=cmd|' /C calc'!A0": "'=cmd|' /C calc'!A0", "@x": "'@x", "+a": "'+a", "-1.5": "-1.5", "-": "-", "'=": "''="}


def test_texts_like_formulas_have_an_apostrophe_and_numbers_have_none(tmp_path):
    assert {text: spreadsheet_text(text) for text in TEXTS} == TEXTS
    frame = pd.DataFrame({"label": [*TEXTS], "number": [-1.5, 2, None, 0, 1, 3]})
    write_csv(frame, tmp_path / "t.csv")
    again = pd.read_csv(tmp_path / "t.csv", dtype={"label": str})
    assert again["label"].tolist() == [*TEXTS.values()]
    assert again["number"].equals(frame["number"])
    assert again["label"].str.replace(r"^'(?=[=+\-@'\t\r])", "", regex=True).tolist() == [*TEXTS]
    assert [*tsv([{"label": "=1+2", "K": -1.5}])] == ["label\tK", "'=1+2\t-1.5"]
    labels = [{"label": label} for label in ("\ta", "a", "a ", "a\n")]
    assert [*tsv(labels)] == ["label", r"\u0009a", "a", "a ", r"a\u000a"]


# ---- numbers as people read them
@pytest.mark.parametrize(("count", "said"), [
    (0, "0 settings"), (1, "1 setting"), (np.int64(1), "1 setting"), (np.int64(1000), "1,000 settings"),
])  # fmt: skip
def test_one_is_singular_and_thousands_have_commas(count, said):
    assert counted(count, "setting") == said


@pytest.mark.parametrize(("value", "said"), [
    (10000, "10,000"), (np.int64(1000), "1,000"), (0.55, "0.55"), (np.float64(2), "2.0"), ("ring", "ring"),
])  # fmt: skip
def test_whole_numbers_have_commas_and_nothing_else_changes(value, said):
    assert grouped(value) == said


def test_medians_of_whole_numbers_keep_their_halves():
    """Two medians that differ never look the same, and none is rounded to an even number."""
    assert [fixed(value) for value in (142.5, 719.5, 720.0, 1441.3)] == ["142.5", "719.5", "720", "1,441"]
    assert rounded(142.5, 140.0, 144.5, 0) == ("142.5", "[140, 144.5]")


def test_numbers_have_as_many_digits_as_tell_them_apart():
    for values, texts in (
        (["0.7999999999999999", "0.6", "U(0.5499999999999999,0.95)"], ["0.8", "0.6", "U(0.55,0.95)"]), ([], []),
        ([0.12345671, 0.12345672, 1.0], ["0.12345671", "0.12345672", "1"]), (["0.500", "b=0.6"], ["0.5", "b=0.6"]),
        ([0.1, 0.1], ["0.1", "0.1"]), ([0.3, 0.1 + 0.2], ["0.29999999999999999", "0.30000000000000004"]),
    ):  # fmt: skip
        assert distinct_texts(values) == texts


# ---- hTML templates escape all values and refuse unknown names; jinja2 is imported only where HTML is made
NASTY = "<script>alert('&')</script>"
ESCAPED = "&lt;script&gt;alert(&#39;&amp;&#39;)&lt;/script&gt;"


def test_values_are_escaped_and_unknown_names_are_errors(tmp_path):
    (tmp_path / "a.html.jinja").write_text("<p>{{ text }}</p>")
    assert render(tmp_path / "a.html.jinja", text=NASTY) == f"<p>{ESCAPED}</p>"
    with pytest.raises(jinja2.UndefinedError, match="text"):
        render(tmp_path / "a.html.jinja", other=1)


def test_titles_of_results_and_recordings_are_escaped(small_results):
    assert f"<b>{ESCAPED} (seed" in shown(small_results.assign_attrs(title=NASTY)).partition("<details>")[0]
    page = recorded_page({"form": {"name": NASTY}})
    assert f"<title>{ESCAPED} – swarmcensus</title>" in page
    assert NASTY not in page


def test_live_page_has_all_assets():
    assert {path.name for path in PAGE.iterdir() if path.suffix in (".css", ".js")} == {*STYLES, *SCRIPTS}


# ---- how many cores are used: those that affinity and the quotas of containers leave
@pytest.mark.parametrize(("own", "files", "most"), [
    ("0::/a/b", {"a/cpu.max": "250000 100000", "a/b/cpu.max": "max 100000"}, 3),
    ("0::/a/b", {"cpu.max": "50000 100000", "a/b/cpu.max": "400000 100000"}, 1),
    ("0::/elsewhere", {"cpu.max": "200000 100000\n"}, 2),
    ("0::/", {"cpu.max": "damaged"}, 8),
    ("4:memory:/a\n0::/", {"cpu.max": "150000 100000\n"}, 2),
    (None, {}, 8),
])  # fmt: skip
def test_a_quota_counts_as_cores(own, files, most, tmp_path, monkeypatch):
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    if own is not None:
        (tmp_path / "own").write_text(own)
    monkeypatch.setattr(cores, "GROUPS", tmp_path)
    monkeypatch.setattr(cores, "OWN_GROUPS", tmp_path / "own")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    assert cores.cores() == most
