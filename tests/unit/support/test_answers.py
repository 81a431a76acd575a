"""An answer is the same on a terminal, in a pipe, in a notebook and in files."""

import io
import json

import jsonschema
import pandas as pd
import pytest

from swarmcensus.support import terminal
from swarmcensus.support.answers import FORMATS, Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.printed_tables import ASKED, REST, Column, Table
from tests.support.places import ROOT

SCHEMA = json.loads((ROOT / "docs" / "reference" / "answer.schema.json").read_text(encoding="utf-8"))
ROWS = [{"brain": f"brain-{k}", "final_error": k / 7, "right": 0.5, "right_low": float("nan")} for k in range(60)]


class Ranking(Answer):
    """Brains by error."""

    def tables(self, limit):
        kept = ROWS[: limit or None]
        columns = [
            Column("brain", [row["brain"] for row in kept], number=False, name="brain"),
            Column("right %", ["50.0"] * len(kept), rank=REST, name="right", meaning="robots in the right bin"),
            Column("error", [f"{row['final_error']:.2f}" for row in kept], rank=ASKED, name="final_error"),
        ]
        return [Table(columns, more=f"{len(kept)} of 60 brains" * (len(kept) < 60))]


@pytest.fixture
def answer():
    said = {"title": "all brains", "sentences": ["brain-0 is best"], "cautions": ["few trials"]}
    return Ranking(command="rank", rows=ROWS, **said)


def printed(answer, width=80, height=25, **more):
    out = io.StringIO()
    answer.print_on(terminal.console(file=out, width=width, height=height), **more)
    return [line.rstrip() for line in out.getvalue().splitlines()]


def test_sentences_come_first_and_again_below_a_long_table(answer):
    lines = printed(answer)
    assert lines[:4] == ["all brains", "brain-0 is best", "caution: few trials", ""]
    assert lines[4].split() == ["brain", "right", "%", "error"]
    assert lines[-2:] == ["brain-0 is best", "caution: few trials"]
    assert printed(answer, height=100).count("brain-0 is best") == 1
    assert "40 of 60 brains; the property `frame` has all" in lines
    assert len(printed(answer, limit=3)) == 4 + 1 + 3 + 2


def test_columns_are_left_out_from_the_right_and_named(answer):
    lines = printed(answer, width=18, limit=1)
    assert lines[lines.index("") + 1].split() == ["brain", "error"]
    assert "right %" in " ".join(lines)
    assert "robots in the right bin" not in " ".join(lines)
    assert printed(answer, limit=1, columns=["final_error", "brain"])[4].split() == ["error", "brain"]
    with pytest.raises(InputError, match=r"final_eror.*did you mean 'final_error'"):
        printed(answer, columns=["final_eror"])


def test_json_has_one_shape(answer):
    found = json.loads(answer.to_json(columns=["brain", "right_low"], limit=2))
    jsonschema.validate(found, SCHEMA)
    assert found["rows"] == [{"brain": "brain-0", "right_low": None}, {"brain": "brain-1", "right_low": None}]
    assert [one["name"] for one in found["columns"]] == ["brain", "right_low"]
    right = next(one for one in answer.columns if one["name"] == "right")
    assert right == {"name": "right", "title": "right %", "unit": "", "meaning": "robots in the right bin"}
    jsonschema.validate(json.loads(Answer(command="new").to_json()), SCHEMA)


@pytest.mark.parametrize("ending", FORMATS)
def test_it_is_saved_by_the_ending(ending, answer, tmp_path):
    path = tmp_path / f"ranking{ending}"
    answer.save(path)
    read = {".csv": pd.read_csv, ".parquet": pd.read_parquet, ".tsv": lambda p: pd.read_csv(p, sep="\t")}
    if ending in read:
        pd.testing.assert_frame_equal(read[ending](path), answer.frame, check_dtype=False)
    else:
        text = path.read_text(encoding="utf-8")
        assert all(said in text for said in ("brain-59", "brain-0 is best", "few trials", "all brains"))
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


def test_rows_have_a_plain_table_by_default():
    rows = [{"brain": "a", "mean_error": 0.25, "trials": 1200}, {"brain": "b", "mean_error": None, "trials": 7}]
    lines = [line.split() for line in printed(Answer(rows=rows))]
    assert lines == [["brain", "mean", "error", "trials"], ["a", "0.2500", "1,200"], ["b", "-", "7"]]


def test_lists_and_values_by_name_are_texts_in_csv(tmp_path):
    Answer(rows=[{"name": "swift", "keys": ["a", "b"], "parameters": {"every": 10.0}}]).save(tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text() == 'name,keys,parameters\nswift,"a, b",every=10.0\n'


def test_other_endings_are_refused(answer, tmp_path):
    with pytest.raises(InputError, match=r"ends in \.json or"):
        answer.save(tmp_path / "ranking.xlsx")


def test_notebooks_and_markdown_have_sentences_and_table(answer):
    page = answer._repr_html_()
    assert all(text in page for text in ("few trials", "brain-0", "all brains"))
    assert answer.to_markdown().count("| brain-") == 60


def test_files_have_intervals_marks_and_what_all_rows_share():
    given = {"intervals": ["[0.0, 0.2]", "[0.1, 0.3]"], "marks": ["*", ""], "strong": [True, False]}
    column = Column("error", ["0.1", "0.2"], **given)
    columns = [Column("brain", ["a", "b"], number=False), column]
    table = Table(columns, above=["all with robots 5"], notes=lambda _: ["x"])
    text = Answer(table, title="two").to_markdown()
    assert all(said in text for said in ("| a | **\\* 0.1** | [0.0, 0.2] |", "all with robots 5", "two", "\n\nx\n"))
    assert "% all with robots 5" in Answer(table).to_latex()


def test_columns_are_known_by_name_and_head_everywhere(answer):
    for columns in (["brain", "final_error"], ["brain", "error"]):
        assert [*json.loads(answer.to_json(columns=columns))["rows"][0]] == ["brain", "final_error"]
        assert printed(answer, limit=1, columns=columns)[4].split() == ["brain", "error"]
    assert printed(answer, limit=1, columns=["brain", "right_low"])[4].split() == ["brain", "right_low"]


def test_parts_that_no_answer_has_are_refused(tmp_path):
    with pytest.raises(TypeError, match="sentnces"):
        Answer(sentnces=["x"])
    with pytest.raises(InputError, match="no rows"):
        Answer(sentences=["x"]).save(tmp_path / "x.csv")
    assert not any(tmp_path.iterdir())


def test_a_title_of_several_lines_stays_a_comment_in_latex():
    text = Answer(Table([]), title="two\n\\input{evil}", sentences=["a\nb"]).to_latex()
    assert "% two \\input{evil}\n% a b\n" in text


def test_accuracies_of_many_robots_are_counted_for_people_and_whole_in_files():
    rows = [{"accuracy": f"M({','.join(['0.8,0.01'] * 20)})"}]
    answer = Answer(Table.of(rows), title=rows[0]["accuracy"], rows=rows)
    assert [text.count("measured (20 robots)") for text in (str(answer), answer.to_tsv())] == [2, 0]
