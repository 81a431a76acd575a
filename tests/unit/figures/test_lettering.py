"""Texts of any length in the room that there is for them."""

import pytest

from swarmcensus.figures.lettering import shortened, width_of, wrapped
from swarmcensus.support.formatting import distinct_texts

NAMES = "watts_strogatz_graph(k=4,p=0.1), my_quite_long_brain_name_of_2024.py, N = 10, f = 0.55"


@pytest.mark.parametrize("width", [20, 60, 200])
@pytest.mark.parametrize("text", [NAMES, "w" * 500, "a b " * 100, "", "$x^2$", "tab\tand\nline"])
def test_lines_are_no_wider_than_their_room_and_few(text, width):
    lines = wrapped(text, width, 9, 6)
    assert len(lines) <= 6
    assert all(0 < width_of(line, 9) <= width for line in lines)
    if not any("…" in line for line in lines):
        assert "".join(lines).replace(" ", "") == "".join(text.split())


def test_line_breaks_in_captions():
    assert wrapped(NAMES, 1000, 9) == [NAMES]
    lines = wrapped(NAMES, 190, 9)
    assert lines == ["watts_strogatz_graph(k=4,p=0.1),", "my_quite_long_brain_name_of_2024.py,", "N = 10, f = 0.55"]
    narrow = wrapped(NAMES, 120, 9)
    assert narrow[-1] == "N = 10, f = 0.55"
    assert narrow[0] == "watts_strogatz_graph("


def test_a_text_too_long_keeps_its_ends():
    short = shortened("abcdefghijklmnopqrstuvwxyz" * 3, 80, 9)
    assert 70 < width_of(short, 9) <= 80
    first, last = short.split("…")
    assert first.startswith("abc")
    assert last.endswith("xyz")
    assert abs(len(first) - len(last)) <= 1
    assert shortened("short", 80, 9) == "short"


def test_numbers_have_as_many_digits_as_tell_them_apart():
    assert distinct_texts(["0.7999999999999999", "0.6", "U(0.5499999999999999,0.95)"]) == ["0.8", "0.6", "U(0.55,0.95)"]
    assert distinct_texts([0.12345671, 0.12345672, 1.0]) == ["0.12345671", "0.12345672", "1"]
    assert distinct_texts(["0.500", "b=0.6"]) == ["0.5", "b=0.6"]
    assert distinct_texts([0.1, 0.1]) == ["0.1", "0.1"]
    assert distinct_texts([0.3, 0.1 + 0.2]) == ["0.29999999999999999", "0.30000000000000004"]
    assert distinct_texts([]) == []
