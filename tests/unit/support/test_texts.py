"""Text files of users in other encodings, and CSV files that spreadsheets open."""

import pandas as pd
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.support.control_characters import spreadsheet_text, write_csv
from swarmcensus.support.printed_tables import tsv

STUDY = 'name = "ring"\ntrials = 1\n[swarm]\nrobots = 4\naccuracy = 0.8\n[world]\ntopology = "ring"\nfill_ratio = 0.5\n'
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-32")


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_studies_are_read_in_any_encoding_with_a_mark(encoding, here):
    (here / "s.toml").write_text(STUDY, encoding=encoding, newline="\r\n")
    assert sc.Study.load("s.toml").text == STUDY


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (STUDY.encode("utf-16-le"), "it is no text, or in another encoding: save it as text in UTF-8"),
        (STUDY.encode("utf-16")[:-1], "line 8 is not UTF-16: save it as text in UTF-8"),
        (b"# a\n# caf\xe9\n", "line 2 is not UTF-8: save it as text in UTF-8"),
    ],
)
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
    assert [*tsv({"label": label} for label in ("\ta", "a", "a ", "a\n"))] == [
        "label",
        r"\u0009a",
        "a",
        "a ",
        r"a\u000a",
    ]
