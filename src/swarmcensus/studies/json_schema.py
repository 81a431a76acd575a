"""The JSON schema of study files, with which editors complete and check them."""

from typing import Any

from swarmcensus.studies.tables import Tables
from swarmcensus.studies.wanted import OPEN
from swarmcensus.support.toml_types import Schema

DRAFT = "http://json-schema.org/draft-07/schema#"  # the draft that editors support best
# pydantic's own names of bounds behind a validator, and a later draft's name for the items of a pair
NAMES = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum", "prefixItems": "items"}
NULL = {"type": "null"}  # TOML has none


def schema() -> Schema:
    """The schema, a JSON object: tables, keys, values and their meanings, with the names that this installation knows.

    It refuses no valid study. It may accept an invalid one, as only `Study.load` checks files and keys against each
    other.
    """
    found: Schema = _plain(Tables.model_json_schema())
    for word, keys in OPEN.items():  # which a plan finds
        form: Schema = {"type": "object", "properties": {word: {"type": "array"}}, "required": [word]}
        form["additionalProperties"] = False
        for table, key in (one.split(".") for one in keys):
            about = found["$defs"][table.title()]["properties"][key]
            says = {name: about.pop(name) for name in ("description", "default") if name in about}
            kinds = about.pop("anyOf", None) or [dict(about)]
            about.clear()
            about.update(says | {"anyOf": [*kinds, form]})
    return {"$schema": DRAFT, "title": "swarmcensus study file", **found}


def _plain(node: Any) -> Any:
    """The schema in one draft, without titles of keys, and without null and defaults that TOML cannot express."""
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
