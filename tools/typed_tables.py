"""Writes src/swarmcensus/studies/typed.py: a study's tables as editors and type checkers see them.

    python tools/typed_tables.py

Keys, types, defaults and descriptions are those of the models in studies/tables.py. A test fails if the file is not
what this script writes.
"""

import json
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from swarmcensus.studies.json_schema import schema_of
from swarmcensus.studies.members import Members
from swarmcensus.studies.precision import Until
from swarmcensus.studies.settings import Schedule, Swarm, World
from swarmcensus.studies.tables import Case, Measure, Tables
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.faults import Fault

FILE = Path(__file__).parent.parent / "src" / "swarmcensus" / "studies" / "typed.py"
WIDTH = 120
PLAIN = {"integer": "Whole", "number": "Real", "boolean": "bool", "string": "str", "object": "Mapping[str, Any]"}
OBJECTS = {  # Python objects that a key takes, beside what a study file may hold
    "brain": "Path | Brain", "accuracy": "Accuracy", "assumed_accuracy": "Accuracy | Misjudgement",
    "floor": "Path | Floor",
    "topology": "Path | nx.Graph | Topology", "fill_ratio": "Change", "metrics": "Path | Metric",
}  # fmt: skip
OF_MEMBERS = {"brain": "Path | Brain | Adversary"}
MODELS: tuple[type[BaseModel], ...] = (Until, Body, Swarm, World, Schedule, Case, Measure, Fault, Members, Tables)
HEAD = '''"""A study's tables as editors and type checkers see them. tools/typed_tables.py writes this file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Protocol, Required, TypeAlias, TypedDict, TypeVar

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from swarmcensus.brains import Adversary, Brain
from swarmcensus.brains.metrics import Metric
from swarmcensus.worlds import Accuracy, Change, Floor, Misjudgement, Topology

T = TypeVar("T")


class Column(Protocol):
    """Values of pandas or xarray."""

    def to_numpy(self) -> Any:
        """The values as an array."""


Whole: TypeAlias = int | np.integer[Any]
Real: TypeAlias = float | np.integer[Any] | np.floating[Any]
Several: TypeAlias = T | Sequence[T] | NDArray[Any] | Column
'''


def name_of(model: type[BaseModel]) -> str:
    """The name of a table's type."""
    return "StudyTables" if model is Tables else f"{model.__name__}Table"


def kinds(node: Any, key: str, objects: dict[str, str]) -> list[str]:
    """The types of a value, as text, from its JSON schema."""
    if "anyOf" in node:
        return list(dict.fromkeys(kind for one in node["anyOf"] for kind in kinds(one, key, objects)))
    if "$ref" in node:
        return [node["$ref"].rpartition("/")[2] + "Table"]
    if node.get("properties", {}).keys() == Until.model_fields.keys():
        return [name_of(Until)]
    if node.get("type") == "array":
        if isinstance(node["items"], list):
            return [f"tuple[{', '.join(' | '.join(kinds(one, key, objects)) for one in node['items'])}]"]
        inner = " | ".join(kinds(node["items"], key, objects))
        inner += f" | {objects[key]}" if key in objects else ""
        return [f"Sequence[{inner}]" if inner.endswith("Table") else f"Several[{inner}]"]
    if isinstance(values := node.get("additionalProperties"), dict) and "type" in values:
        return [f"Mapping[str, {PLAIN[values['type']]}]"]
    if "enum" in node and "type" in node:
        return [f"Literal[{', '.join(map(_quoted, node['enum']))}]"]
    return ["str" if "enum" in node else PLAIN[node["type"]]]


def type_of(node: Any, key: str, objects: dict[str, str]) -> str:
    """The type of a key; a list's own type stands for its single value, too."""
    found = kinds(node, key, objects)
    several = [one for one in found if one.startswith("Several")]
    return several[0] if several else " | ".join(found)


def _quoted(text: str) -> str:
    return f'"{text}"'


def table(model: type[BaseModel], schema: dict[str, Any]) -> str:
    """The class of a table."""
    needed = schema.get("required", [])
    objects = OBJECTS | (OF_MEMBERS if model is Members else {})
    lines = [f"class {name_of(model)}(TypedDict, total=False):", f'    """{_summary(model)}"""', ""]
    for key, node in schema["properties"].items():
        kind = type_of(node, key, objects)
        lines.append(f"    {key}: Required[{kind}]" if key in needed else f"    {key}: {kind}")
        lines.append(f'    """{node["description"]}{_default(node, node["description"])}"""')
    return "\n".join(lines)


def _default(node: dict[str, Any], description: str) -> str:
    """What a docstring says of a key's default, on a line of its own if it is long."""
    value = node.get("default", [])
    value = value[0] if isinstance(value, list) and len(value) == 1 else value
    if value == []:
        return ""
    said = f"Default: {value if isinstance(value, bool) else json.dumps(value)}."
    return f" {said}" if len(description) + len(said) < WIDTH - 12 else f"\n\n    {said}\n    "


def _summary(model: type[BaseModel]) -> str:
    return re.split(r"\n\n", (model.__doc__ or "").strip())[0].replace("\n    ", " ").replace("\n", " ")


def text() -> str:
    """The file."""
    tables = {model: schema_of(model, "table") for model in MODELS}
    parts = [f"{table(model, schema)}\n" for model, schema in tables.items()]
    return "\n\n".join([HEAD, *parts])


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
