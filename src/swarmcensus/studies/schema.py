"""The JSON schema of study files, by which an editor completes and checks them."""

from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from swarmcensus.basics.forms import Schema
from swarmcensus.studies.tables import Schedule, Swarm, Tables, World

DRAFT = "http://json-schema.org/draft-07/schema#"  # which editors know best


def schema() -> Schema:
    """The schema, a JSON object: tables, keys, values and what each means, with the names that this installation knows.

    What it refuses is no study; what it lets through may still be none, for files and how keys go together are seen
    by `Study.load` alone.
    """
    found = Tables.model_json_schema(schema_generator=_Plain)
    keys = {name: field for table in (Swarm, World, Schedule) for name, field in table.model_fields.items()}
    for name, told in found["$defs"]["Case"]["properties"].items():
        told["description"] = keys[name].description
    return {"$schema": DRAFT, **found, "title": "swarmcensus study file"}


class _Plain(GenerateJsonSchema):
    """Schemas without what says nothing in TOML: titles, and null, which it has not."""

    def nullable_schema(self, schema: Any) -> Schema:
        return self.generate_inner(schema["schema"])

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False

    def default_schema(self, schema: Any) -> Schema:
        found = super().default_schema(schema)
        if found.get("default") is None or isinstance(found["default"], dict):
            found.pop("default", None)
        return found

    def tuple_schema(self, schema: Any) -> Schema:
        found = super().tuple_schema(schema)
        if "prefixItems" in found:
            found["items"] = found.pop("prefixItems")
        return found
