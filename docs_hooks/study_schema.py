"""The reference of study files, made of their JSON schema; and the schema, to fetch."""

import json
import re
from collections.abc import Iterator
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from swarmcensus.studies.json_schema import schema

URI, FILE = "reference/study-schema.md", "reference/study.schema.json"
TABLES = {
    "Swarm": "[swarm]", "World": "[world]", "Schedule": "[schedule]", "Measure": "[measure]",
    "Wanted": "[wanted]", "Fault": "[[faults]]",
    "Members": "[[members]]", "Case": "[[case]]", "Body": "[world.body]",
}  # fmt: skip
KINDS = {"integer": "whole number", "number": "number", "boolean": "`true` or `false`"}
MANY = 12  # names that a cell lists at the most
OPENING = """# Study file, as a schema

Made from the [JSON schema of study files](study.schema.json), which is that of this version without additions of other
packages; `swarmcensus new study --schema` prints that of an installation. The [study file's page](../study-file.md)
explains each key, and [how an editor uses the schema](../study-file.md#in-an-editor). Where a *list* is named, one
value will do, and several span a grid.
"""


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the page and the schema."""
    found = schema()
    files.append(File.generated(config, URI, content=page(found)))
    files.append(File.generated(config, FILE, content=json.dumps(found, indent=2, ensure_ascii=False)))
    return files


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Link the page, which the repository lacks, from the page of study files."""
    return re.sub(r"(?<=which the site has as)\s+tables", f" [tables]({URI})", markdown)


def page(found: dict[str, Any]) -> str:
    """All tables and keys, as Markdown."""
    assert set(found["$defs"]) == set(TABLES)
    parts = [OPENING, "## Top level", "", *_table(found)]
    for name, title in TABLES.items():
        parts += ["", f"## `{title}`", "", found["$defs"][name]["description"], "", *_table(found["$defs"][name])]
    rule = next(kind for kind in found["properties"]["trials"]["anyOf"] if kind.get("type") == "object")
    parts += ["", "## `trials, as a rule`", "", rule["description"], "", *_table(rule)]
    return "\n".join(parts) + "\n"


def _table(table: dict[str, Any]) -> Iterator[str]:
    yield from ("| key | type | default | meaning |", "|---|---|---|---|")
    for key, told in table["properties"].items():
        default = f"`{json.dumps(told['default'])}`" if "default" in told else ""
        default = "required" if key in table.get("required", []) else default
        yield f"| `{key}` | {_type(told)} | {default} | {told['description']} |".replace("||", "\\|\\|")


def _type(told: dict[str, Any]) -> str:
    if "$ref" in told:
        title = TABLES[told["$ref"].rpartition("/")[2]]
        return f"[table](#{''.join(c for c in title.lower() if c.isalnum() or c in '- ').replace(' ', '-')})"
    if "anyOf" in told or "oneOf" in told:
        kinds = told.get("anyOf", told.get("oneOf"))
        lists = [kind["items"] for kind in kinds if kind.get("type") == "array" and isinstance(kind.get("items"), dict)]
        ones = [kind for kind in kinds if not any(kind == one or kind in one.get("anyOf", []) for one in lists)]
        said = dict.fromkeys(_type(kind) for kind in ones if kind.get("type") != "array" or not lists)
        said |= dict.fromkeys(f"{_type(one)}, or a list" for one in lists)
        return " or ".join(said)
    if "enum" in told:
        names = [f"`{json.dumps(name)}`" for name in told["enum"]]
        return ", ".join(names) if len(names) <= MANY else f"a name, as {', '.join(names[:3])}"
    kind = told.get("type")
    if kind == "array":
        items = told.get("items", {})
        return "two numbers" if isinstance(items, list) else f"list of {_type(items)}"
    if kind == "object" and "properties" not in told:
        return f"table of {_type(told['additionalProperties'])}s"
    if kind == "object":
        keys = ", ".join(f"`{key}`" for key in told.get("properties", ()))
        return f"table with {keys}" if keys else f"table of {_type(told['additionalProperties'])}"
    return KINDS.get(str(kind), "text") + _bounds(told)


def _bounds(told: dict[str, Any]) -> str:
    low, high = told.get("minimum"), told.get("maximum")
    above = told.get("exclusiveMinimum")
    if low == 0 and high == 1:
        return " in [0, 1]"
    if above is not None:
        return f" above {above:g}"
    return "" if low is None or low < 0 else f" from {low:g}"
