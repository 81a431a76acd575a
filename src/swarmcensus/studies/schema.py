"""The JSON schema of study files, by which an editor completes and checks them."""

from typing import Any

from pydantic import BaseModel

from swarmcensus.basics.forms import Schema
from swarmcensus.studies.tables import Schedule, Swarm, Tables, World

DRAFT = "http://json-schema.org/draft-07/schema#"  # which editors know best
# a bound behind a validator comes out under pydantic's own name, and a pair of values under that of a later draft
NAMES = {
    "ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum", "prefixItems": "items",
}  # fmt: skip
NULL = {"type": "null"}  # which TOML has not


def schema() -> Schema:
    """The schema, a JSON object: tables, keys, values and what each means, with the names that this installation knows.

    What it refuses is no study; what it lets through may still be none, for files and how keys go together are seen
    by `Study.load` alone.
    """
    found = schema_of(Tables, "study")
    keys = {name: field for table in (Swarm, World, Schedule) for name, field in table.model_fields.items()}
    for name, told in found["$defs"]["Case"]["properties"].items():
        told["description"] = keys[name].description
    return found


def schema_of(tables: type[BaseModel], what: str) -> Schema:
    """The schema of a kind of file, such as "study", from the model of all its tables."""
    return {"$schema": DRAFT, "title": f"swarmcensus {what} file", **_plain(tables.model_json_schema())}


def _plain(node: Any) -> Any:
    """The same in one draft, without what says nothing in TOML: titles of keys, null, and tables as defaults."""
    if isinstance(node, list):
        return [_plain(one) for one in node]
    if not isinstance(node, dict):
        return node
    found = {NAMES.get(key, key): _plain(value) for key, value in node.items()}
    if isinstance(found.get("title"), str):
        del found["title"]
    if "default" in found and (found["default"] is None or isinstance(found["default"], dict)):
        del found["default"]
    if "anyOf" in found:
        kinds = [inner for kind in found["anyOf"] for inner in (kind["anyOf"] if [*kind] == ["anyOf"] else [kind])]
        found["anyOf"] = [kind for kind in kinds if kind != NULL]
        if len(found["anyOf"]) == 1:
            found |= found.pop("anyOf")[0]
    return found
