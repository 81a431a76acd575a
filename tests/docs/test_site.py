"""The documentation site: built without a warning, whole, and sufficient to itself; its tutorials are notebooks."""

import functools
import html.parser
import os
import re
import runpy
import subprocess
import sys
import urllib.parse
from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus import theory
from swarmcensus.cli.help import COMMANDS
from tests.support.places import ROOT

PAGES = sorted((ROOT / "docs").rglob("*.md"))
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.md"))


def hooked(file, text, on="content"):
    """What a hook of the site makes of a page's text."""
    pytest.importorskip("mkdocs", reason="pip install '.[docs]'")
    found = runpy.run_path(str(ROOT / "docs_hooks" / f"{file}.py"))
    return found[f"on_page_{on}"](text, page=None, config=None, files=None)


class Links(html.parser.HTMLParser):
    """What a page leads to, what it fetches, and its anchors."""

    def __init__(self, text):
        super().__init__()
        self.leads, self.fetches, self.anchors = [], [], set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = {key: value or "" for key, value in attrs}
        self.anchors |= {given[key] for key in ("id", "name") if key in given}
        if tag == "a" and "href" in given:
            self.leads.append(given["href"])
        elif tag == "link" and given.get("rel") not in ("canonical", "next", "prev"):
            self.fetches.append(given["href"])
        elif "src" in given:
            self.fetches.append(given["src"])


def build(folder, **environment):
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    told = {"NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT / "src")} | environment
    return subprocess.run(command, cwd=ROOT, env=os.environ | told, capture_output=True, text=True, timeout=600)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """One that was built before, where BUILT_SITE names it."""
    if built := os.environ.get("BUILT_SITE"):
        return Path(built)
    pytest.importorskip("mkdocs", reason="pip install '.[docs]'")
    folder = tmp_path_factory.mktemp("site")
    done = build(folder, SWARMCENSUS_SITE="quick")
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.long
def test_the_site_is_built_and_no_link_of_it_is_dead(site):
    pages = {page: Links(page.read_text(encoding="utf-8")) for page in site.rglob("*.html") if page.name != "404.html"}
    assert len(pages) > 40
    for page, links in pages.items():
        for target in (*links.leads, *links.fetches):
            parts = urllib.parse.urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            found = (page.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else page
            found = found / "index.html" if found.is_dir() else found
            assert found.is_file(), f"{page.relative_to(site)}: {target}"
            anchor = urllib.parse.unquote(parts.fragment)
            if anchor and found in pages:
                assert anchor in pages[found].anchors, f"{page.relative_to(site)}: {target}"


@pytest.mark.long
def test_pages_of_files_and_of_404_lead_back(site):
    file = Links((site / "source" / "studies" / "leaderboard.toml" / "index.html").read_text(encoding="utf-8"))
    assert "../../../leaderboard/" in file.leads
    assert "first page</a>" in (site / "404.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_table_has_its_head(page):
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for table in re.findall(r"(?:^\| .*\n)(?:^\|.*\n)*", text, re.MULTILINE):
        assert re.fullmatch(r"[|: -]+", table.splitlines()[1] if table.count("\n") > 1 else ""), table


@pytest.mark.long
def test_the_site_fetches_nothing_from_elsewhere(site):
    for page in site.rglob("*.html"):
        for target in Links(page.read_text(encoding="utf-8")).fetches:
            assert not re.match(r"(\w+:)?//", target), f"{page.relative_to(site)}: {target}"
    for style in site.rglob("*.css"):
        assert not re.search(r"(@import|url\(\s*['\"]?(\w+:)?//)", style.read_text(encoding="utf-8")), style


@pytest.mark.long
def test_every_command_and_its_options_are_on_the_page(site):
    page = (site / "reference" / "command-line" / "index.html").read_text(encoding="utf-8")
    assert {name for name in COMMANDS if f'id="{name}"' not in page} == set()
    assert page.index('id="group-missions"') < page.index('id="plan"') < page.index('id="group-robots"')
    for option in ("--cluster WHERE", "--option NAME=VALUE", "--budget N"):
        assert f">{option}</code>" in page
    assert "a brain's parameters" in page.replace("&#39;", "'")


def test_every_page_has_its_place_and_every_picture_its_page():
    settings = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    placed = set(re.findall(r"^ +(?:- )?(?:\w+: )?([\w/-]+\.md)$", settings, re.MULTILINE))
    assert {path.relative_to(ROOT / "docs").as_posix() for path in PAGES} <= placed
    texts = "".join(page.read_text(encoding="utf-8") for page in (*PAGES, ROOT / "README.md")) + settings
    pictures = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs" / "images").rglob("*.*")}
    assert {name for name in pictures if name not in texts} == set()


def test_links_of_the_list_of_pages_are_their_headings():
    """So are the titles of the navigation: mkdocs.yml names none."""
    listed = ROOT / "docs" / "README.md"
    links = re.findall(r"\[([^\]]+)\]\(([^)]+)\)", listed.read_text(encoding="utf-8"))
    linked = {(listed.parent / to).resolve() for _, to in links}
    assert {page for page in PAGES if page.name not in ("README.md", "index.md")} <= linked
    for words, to in links:
        page = listed.parent / to
        if page.is_file():  # some are made with the site
            assert page.read_text(encoding="utf-8").startswith(f"# {words}\n"), to


def test_tooltips_are_of_the_first_use_and_not_in_headings_and_links():
    pytest.importorskip("mkdocs", reason="pip install '.[docs]'")
    words = runpy.run_path(str(ROOT / "docs_hooks" / "glossary.py"))["words"]()
    assert {"K", "bin", "brain", "fill ratio", "tick"} <= set(words)
    assert "round" not in words
    assert not any(re.search(r"[][*`]", told) for told in words.values())
    bin_, k = '<abbr title="a part">bin</abbr>', '<abbr title="a round">K</abbr>'  # K of --share K/N, say
    assert hooked("glossary", f"<h2>{bin_}</h2><a>{bin_}</a>{bin_}{bin_}") == f"<h2>bin</h2><a>bin</a>{bin_}bin"
    assert hooked("glossary", f"{k}<em>{k}</em>") == f"K<em>{k}</em>"


def test_short_code_stays_on_a_line_and_pictures_lead_to_themselves():
    lone, linked = '<img src="a.png">', '<a href="b/"><img src="b.png"></a>'
    long = f"<code>{'x' * 25}</code><pre><code>x</code></pre>"
    shown = hooked("small_screens", f"<code>x &lt; {'y' * 20}</code>{long}{lone}{linked}")
    assert shown == f'<code class="short">x &lt; {"y" * 20}</code>{long}<a href="a.png">{lone}</a>{linked}'


def test_pages_have_the_tables_of_the_code_and_of_the_csv_files():
    """If not: `python docs_hooks/tables.py`."""
    hook = runpy.run_path(str(ROOT / "docs_hooks" / "tables.py"))
    assert sum("<!-- end of " in page.read_text(encoding="utf-8") for page in hook["PAGES"]) > 2
    for page in hook["PAGES"]:
        assert hook["filled"](page) == page.read_text(encoding="utf-8"), page.name


def test_a_page_shows_chosen_rows_and_columns_and_the_site_all(tmp_path):
    hook = runpy.run_path(str(ROOT / "docs_hooks" / "tables.py"))
    (tmp_path / "a.csv").write_text("brain,error,code\nx,0.20,`f`\ny,inf,\nz,,<\n")
    hook["_chosen"].__globals__["ROOT"], hook["_chosen"].__globals__["MEASURED"] = tmp_path, "."
    begin, end = '<!-- table: a by="error" columns="error, brain" first=1 -->\n', "<!-- end of table -->"
    shown = hook["of_measured"]('a by="error" columns="error, brain" first=1', "../")
    assert shown.startswith("| error | brain |\n|---:|---|\n| 0.20 | x |\n\n[The whole table](.././a.csv) has 3 rows")
    assert hook["of_measured"]("a rows='z, x'", "").splitlines()[2:4] == ["| z |  | < |", "| x | 0.20 | `f` |"]
    built = hook["on_page_markdown"](begin + end, page=None, config=None, files=None)
    assert built.startswith(begin + end)
    assert built.count("<tr>") == 4
    assert '<td>0.20</td><td class="text"><code>f</code></td>' in built
    assert '<td class="text">&lt;</td>' in built
    assert hook["of_measured"]("a brain=y columns=error").startswith("| error |\n|---:|\n| inf |\n\n")
    with pytest.raises(KeyError, match="fist"):
        hook["of_measured"]("a fist=1", "")


def test_every_public_name_is_on_the_page_of_python():
    pages = sorted((ROOT / "docs" / "reference").glob("python*.md"))
    python = "".join(page.read_text(encoding="utf-8") for page in pages)
    assert "| `sc.Plan` | The question of missions, one for each world, and the rows that answer it |" in python
    listed = set(re.findall(r"^::: [\w.]+\.(\w+)$", hooked("tables", python, "markdown"), re.MULTILINE))
    assert set(sc.__all__) - {"plot", "theory", "__version__"} <= listed
    assert set(dir(sc.plot)) <= listed
    assert set(theory.__all__) - listed <= {"Truth", "from_links", "spectrum_of"}  # for other packages


@functools.cache
def hook():
    pytest.importorskip("jupytext", reason="pip install '.[docs]'")
    return runpy.run_path(str(ROOT / "docs_hooks" / "notebooks.py"))


@pytest.mark.long
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_tutorials_run(page, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "src"))
    notebook = hook()["executed"](page.read_text(encoding="utf-8"))
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(cells) >= 4
    assert all(cell.execution_count for cell in cells)


@pytest.mark.long
def test_a_notebook_is_shown_with_what_it_prints_and_draws():
    page = '# Title\n\n```toml title="a.toml"\nx = 1\n```\n\n```bash\ncat a.toml; echo progress >&2\n```\n\n'
    page += "```python\nfrom matplotlib.figure import Figure\n\nfigure = Figure()\nfigure.subplots()\nfigure\n```\n\n"
    text, pictures = hook()["shown"](hook()["executed"](f"{page}```python\n6 * 7\n```\n"), "page")
    assert text.startswith('# Title\n\n```toml title="a.toml"\nx = 1\n```\n\n')
    assert "```sh\ncat a.toml; echo progress >&2\n```\n\n``` { .text .output .no-copy }\nx = 1\n```" in text
    assert "![What the cell above draws](page-1.png)" in text
    assert pictures["page-1.png"].startswith(b"\x89PNG")
    assert "``` { .text .output .no-copy }\n42\n```" in text
