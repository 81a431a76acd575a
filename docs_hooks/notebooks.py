"""Tutorials are notebooks kept as Markdown: run when the site is built, and shown with what their cells print and draw.

A block with a title, such as ```toml title="study.toml", is a cell that writes this file.

Each can be fetched as a notebook of Jupyter. With SWARMCENSUS_SITE=quick they are shown as they are written.

python docs_hooks/notebooks.py FOLDER       # writes all tutorials there as notebooks that have not run
"""

import base64
import functools
import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import jupytext
import nbformat
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files, InclusionLevel
from mkdocs.structure.pages import Page
from nbclient import NotebookClient

from swarmcensus.support.readers import AS_TERMINAL

FOLDER = "tutorials/"
FORGE, BINDER = "https://github.com/", "https://mybinder.org/v2/gh/"
WIDTH = "120"  # columns of the terminal: what a page shows without scrolling
SECONDS = 300  # that a cell may take: the first on a machine compiles
HEAD = """---
jupyter:
  kernelspec:
    display_name: Python 3
    language: python
    name: python3
---

"""
# a kernel claims to be a terminal with colours; what its cells print should be plain
PLAIN = "import os; [os.environ.pop(k, None) for k in ('FORCE_COLOR', 'CLICOLOR_FORCE')]; os.environ['COLUMNS'] = '110'"
FILE = re.compile(r'^```\w+ title="([\w.-]+)"$', re.MULTILINE)
INLINE = "%matplotlib inline"  # the first cell of each notebook, which pages do not show


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Run a tutorial; its pictures and the notebook become files of the site."""
    uri = page.file.src_uri
    if not uri.startswith(FOLDER) or os.environ.get("SWARMCENSUS_SITE") == "quick":
        return markdown
    notebook = executed(markdown)
    stem = uri.removesuffix(".md")
    text, pictures = shown(notebook, Path(stem).name)
    made = pictures | {f"{Path(stem).name}.ipynb": nbformat.writes(notebook).encode()}
    for name, content in made.items():
        files.append(File.generated(config, FOLDER + name, content=content, inclusion=InclusionLevel.INCLUDED))
    title, below = text.split("\n", 1)
    fetch = f"[As a Jupyter notebook]({Path(stem).name}.ipynb){{ .md-button .notebook download }}"
    if config.repo_url and config.repo_url.startswith(FORGE):
        place = f"{BINDER}{config.repo_url.removeprefix(FORGE)}/HEAD?labpath={stem}.ipynb"
        fetch += f" [Run it on Binder]({place}){{ .md-button .notebook }}"
    return f"{title}\n\n{fetch}\n{below}"


@functools.cache  # so that `mkdocs serve` runs again only what changed
def executed(markdown: str) -> Any:
    """The notebook with its outputs, run in an empty folder."""
    notebook = written(markdown)
    scripts = str(Path(sys.executable).parent)
    environment = os.environ | {"PATH": os.pathsep.join([scripts, os.environ["PATH"]]), AS_TERMINAL: WIDTH}
    with tempfile.TemporaryDirectory() as folder:
        client = NotebookClient(
            notebook,
            timeout=SECONDS,
            resources={"metadata": {"path": folder}},
            extra_arguments=[f"--IPKernelApp.exec_lines={PLAIN}", "--IPKernelApp.log_level=40"],
        )
        client.execute(env=environment | {"PYDEVD_DISABLE_FILE_VALIDATION": "1"})
    return notebook


def written(markdown: str) -> Any:
    """The notebook as it is before it runs."""
    cells = FILE.sub(r"```python\n%%writefile \1", markdown)
    return jupytext.reads(f"{HEAD}```python\n{INLINE}\n```\n\n{cells}", "md")


def shown(notebook: Any, stem: str) -> tuple[str, dict[str, bytes]]:
    """A run notebook as Markdown, and its pictures by name."""
    parts: list[str] = []
    pictures: dict[str, bytes] = {}
    for cell in notebook.cells:
        if cell.cell_type != "code":
            parts.append(cell.source)
            continue
        if cell.source == INLINE:
            continue
        parts.append(_source(cell.source))
        if cell.source.startswith("%%writefile"):
            continue  # it would say that it wrote
        printed = "".join(o.text for o in cell.outputs if o.get("name") == "stdout")  # no progress
        if printed.strip():
            parts.append(f"``` {{ .text .output .no-copy }}\n{printed.strip(chr(10))}\n```")
        for output in cell.outputs:
            data = output.get("data", {})
            if "image/png" in data:
                name = f"{stem}-{len(pictures) + 1}.png"
                pictures[name] = base64.b64decode(data["image/png"])
                parts.append(f"![What the cell above draws]({name})")
            elif "text/html" in data:
                parts.append(f'<div class="output">\n{_bare(data["text/html"])}\n</div>')
            elif "text/plain" in data:
                parts.append(f"``` {{ .text .output .no-copy }}\n{data['text/plain'].rstrip()}\n```")
    return "\n\n".join(parts) + "\n", pictures


def _source(text: str) -> str:
    first, _, rest = text.partition("\n")
    magic, _, file = first.partition(" ")
    if magic == "%%bash":
        return f"```sh\n{rest}\n```"
    if magic != "%%writefile":
        return f"```python\n{text}\n```"
    return f'```{Path(file).suffix[1:].replace("py", "python")} title="{file}"\n{rest}\n```'


def _bare(html: str) -> str:
    """A table of pandas without its own looks."""
    return re.sub(r"<style.*?</style>|(?<=<table) [^>]*|(?<=<tr) style=[^>]*", "", html, flags=re.DOTALL)


def write(folder: Path) -> None:
    """Write all tutorials as notebooks."""
    folder.mkdir(parents=True, exist_ok=True)
    for page in (Path(__file__).parents[1] / "docs" / FOLDER).glob("*.md"):
        nbformat.write(written(page.read_text(encoding="utf-8")), folder / f"{page.stem}.ipynb")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
