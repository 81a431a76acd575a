"""HTML templates escape all values and refuse unknown names; jinja2 is imported only where HTML is made."""

import jinja2
import pytest

from swarmcensus.figures.notebook import shown
from swarmcensus.live.pages import PAGE, SCRIPTS, STYLES, recorded_page
from swarmcensus.support.templates import render

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
