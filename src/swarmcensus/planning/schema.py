"""The JSON schema of mission files, by which an editor completes and checks them."""

from swarmcensus.basics.forms import Schema
from swarmcensus.planning.mission import Mission
from swarmcensus.studies.schema import schema_of


def schema() -> Schema:
    """The schema, a JSON object, as `swarmcensus.studies.schema` has that of studies.

    What it refuses is no mission; how keys go together is seen by `plan` alone.
    """
    return schema_of(Mission, "mission")
