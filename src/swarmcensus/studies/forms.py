"""What brains, accuracies, topologies, floors and metrics look like in a study file, as JSON schemas.

Names are those that this installation knows. A schema is for an editor: it lets through what only a file or a whole
study can refuse, and refuses nothing that is right.
"""

from collections.abc import Mapping

from swarmcensus import brains, metrics
from swarmcensus.basics.doors import Door
from swarmcensus.basics.forms import Form, Schema
from swarmcensus.brains import adversary
from swarmcensus.worlds import patterns, wiring

SHARE: Schema = {"type": "number", "minimum": 0, "maximum": 1}
TEXT: Schema = {"type": "string", "minLength": 1}
SPREAD: Schema = {
    "anyOf": [SHARE, {"type": "string", "pattern": r"^\s*[A-Za-z][\w.-]*\s*\([^()]*\)\s*$"}],
    "description": 'b = w of every robot, or a spread such as "U(0.525, 0.975)" or "N(0.75, 0.1)"',
}


def _table(keys: Mapping[str, Schema], *required: str, more: bool = False) -> Schema:
    closed = {} if more else {"additionalProperties": False}
    return {"type": "object", "properties": dict(keys), "required": list(required), **closed}


ACCURACY: list[Schema] = [
    SPREAD,
    _table({"black": SPREAD, "white": SPREAD}, "black", "white"),
]
DRIFTING = _table(
    {"start": SPREAD, "drift": {"type": "number", "minimum": -1, "maximum": 1}, "least": SHARE, "most": SHARE},
    "start",
    "drift",
)
ERROR = _table({"error": {"anyOf": [{"type": "number", "minimum": -1, "maximum": 1}, {"type": "string"}]}}, "error")
CHANGE = _table(
    {
        "from": SHARE,
        "to": SHARE,
        "at": {"type": ["integer", "string"]},
        "until": {"type": ["integer", "string"]},
    },
    "from",
    "to",
    "at",
)


def _named(*doors: Door) -> Schema:
    """A name or the path of a file."""
    return {"anyOf": [{"enum": [name for door in doors for name in door.names]}, TEXT]}


def _of_brain(*doors: Door) -> Schema:
    name = _named(*doors)
    return {"anyOf": [name, _table({"file": name}, "file", more=True)]}


def _topology() -> Schema:
    pair = {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 2, "maxItems": 2}
    edges, directed = {"type": "array", "items": pair}, {"type": "boolean"}
    return {
        "anyOf": [
            _named(wiring.DOOR),
            _table({"name": TEXT, "edges": edges, "directed": directed}, "name", "edges"),
            _table({"file": TEXT, "directed": directed}, "file"),
            _table({"networkx": TEXT}, "networkx", more=True),
            _table({"name": {"enum": wiring.DOOR.names}}, "name", more=True),
        ]
    }


def _floor() -> Schema:
    names = patterns.DOOR.names
    tables = [_table({name: {}}, name, more=True) for name in names]
    return {"anyOf": [{"enum": names}, *tables]}


BRAIN = Form(lambda _: _of_brain(brains.DOOR))
BRAIN_OR_ADVERSARY = Form(lambda _: _of_brain(brains.DOOR, adversary.DOOR))
TOPOLOGY = Form(lambda _: _topology())
FLOOR = Form(lambda _: _floor())
METRIC = Form(lambda _: _named(metrics.DOOR))
TRUE_ACCURACY = Form(lambda _: {"anyOf": [*ACCURACY, DRIFTING]})
BELIEF = Form(lambda _: {"anyOf": [*ACCURACY, ERROR]})
FILL_RATIO = Form(lambda _: {"anyOf": [SHARE, CHANGE]})
