"""Links that lead out of docs/ lead to pages of the site: a file of the repository is shown whole, a folder listed.

So pages read on a forge as they are, and the site needs no forge. A page that help or a docstring names is a link too.
"""

import os
import re
from pathlib import Path, PurePosixPath

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files, InclusionLevel
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
PROJECT = {"CHANGELOG.md": "project/changelog.md", "CONTRIBUTING.md": "project/contributing.md"}
LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(\))")
BLOCK = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)
HEAD = "---\nsearch:\n  exclude: true\nhide:\n  - navigation\n---\n\n"
NAMED = re.compile(r"(?<![\w/])docs/([\w-]+)\.md(?![^<]*</code>)")
LANGUAGES = {".py": "python", ".toml": "toml", ".csv": "text", ".yml": "yaml", ".cff": "yaml", ".json": "json"}


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pages of the project, and one for each file and folder that some page leads to."""
    for name, uri in PROJECT.items():
        files.append(File.generated(config, uri, content=with_links(_text(ROOT / name), name)))
    leading: dict[Path, list[str]] = {}  # to each file or folder, the pages that lead there
    for file in _written(files):
        for path in _outward(file):
            leading.setdefault(path, []).append(file)
    for path in sorted(leading):
        for one in (path, *_within(path)):
            _add(files, config, one, leading.get(one, leading[path]))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn them."""
    return markdown if page.file.generated_by else with_links(markdown, f"docs/{page.file.src_uri}")


def on_page_content(html: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Link what the references name."""
    if not page.file.src_uri.startswith("reference/"):
        return html
    return NAMED.sub(lambda found: f'<a href="../../{found[1]}/">{_title(f"docs/{found[1]}.md")}</a>', html)


def with_links(markdown: str, place: str) -> str:
    """The text of the repository's file `place` with links that hold on the site."""

    def turned(found: re.Match[str]) -> str:
        before, target, anchor, after = found.groups()
        aim = _aim(target, place)
        if aim is None:
            return found[0]
        here = PurePosixPath(_uri(place)).parent
        return f"{before}{os.path.relpath(_uri(aim), here).replace(os.sep, '/')}{anchor or ''}{after}"

    return "".join(part if part.startswith("```") else LINK.sub(turned, part) for part in BLOCK.split(markdown))


def _aim(target: str, place: str) -> str | None:
    """The repository's file that a link leads to; None of what is elsewhere."""
    if re.match(r"\w+:", target):
        return None
    return os.path.normpath(f"{PurePosixPath(place).parent}/{target}").replace(os.sep, "/")


def _uri(name: str) -> str:
    """Where the site has a file of the repository."""
    if name in PROJECT:
        return PROJECT[name]
    if name == "docs/README.md":
        return "index.md"
    return name.removeprefix("docs/") if name.startswith("docs/") else f"source/{name}.md"


def _written(files: Files) -> list[str]:
    return [*(f"docs/{f.src_uri}" for f in files.documentation_pages() if not f.generated_by), *PROJECT]


def _outward(name: str) -> set[Path]:
    text = "".join(part for part in BLOCK.split(_text(ROOT / name)) if not part.startswith("```"))
    aims = (_aim(found[2], name) for found in LINK.finditer(text))
    return {ROOT / aim for aim in aims if aim and _uri(aim).startswith("source/") and (ROOT / aim).exists()}


def _add(files: Files, config: MkDocsConfig, path: Path, leading: list[str]) -> None:
    name = path.relative_to(ROOT).as_posix()
    if files.get_file_from_path(_uri(name)):
        return
    if path.is_dir():
        text = "\n".join(f"- [{p.name}]({path.name}/{p.name}.md)" for p in _within(path))
    else:
        text = f"````{LANGUAGES.get(path.suffix, 'text')}\n{_text(path)}````"
    back = " · ".join(f"[{_title(page)}]({os.path.relpath(_uri(page), f'source/{name}/..')})" for page in leading)
    content = f"{HEAD}# `{name}`\n\nBack to {back}\n\n{text}\n"
    files.append(File.generated(config, _uri(name), content=content, inclusion=InclusionLevel.NOT_IN_NAV))


def _within(path: Path) -> list[Path]:
    return sorted(p for p in path.iterdir() if p.suffix in LANGUAGES) if path.is_dir() else []


def _title(name: str) -> str:
    """The heading of a page, without its mark-up; home has the project's name."""
    return _text(ROOT / name).partition("\n")[0].removeprefix("# ")


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
