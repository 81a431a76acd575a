"""What brains, accuracies, topologies, floors and metrics look like in a study file, as JSON schemas.

Names are those that this installation knows. A schema is for an editor: it lets through what only a file or a whole
study can refuse, and refuses nothing that is right.
"""

from collections.abc import Mapping
from typing import Any

from swarmcensus import brains, metrics
from swarmcensus.basics.forms import TEXT, Form, Schema
from swarmcensus.basics.plugins import Plugins
from swarmcensus.basics.times import MOST, WORDS
from swarmcensus.brains import adversary
from swarmcensus.brains.fields import LARGEST
from swarmcensus.worlds import changes, patterns, spreading, wiring

SHARE: Schema = {"type": "number", "minimum": 0, "maximum": 1}
UP_TO_ONE = r"(1(\.0*)?|(0(\.\d*)?|\.\d+)([eE]-\d+)?)"  # a share as text
LISTED_AT_LEAST_ONE: Schema = {"type": "array", "minItems": 1}
FILE: Schema = {"type": "string", "pattern": r"[./\\]"}


def _table(keys: Mapping[str, Schema], *required: str, more: Schema | bool = False) -> Schema:
    closed: Schema = {} if more is True else {"additionalProperties": more}
    return {"type": "object", "properties": dict(keys), "required": list(required), **closed}


def _spread(**bounds: float) -> Schema:
    """One accuracy's distribution, or one error's where they reach below 0."""
    sign = "[+-]?" if bounds.get("minimum", 0) < 0 else r"\+?"
    written = rf"^({spreading.pattern()}|\s*{sign}{UP_TO_ONE}\s*)$"
    return {
        "anyOf": [{**SHARE, **bounds}, {"type": "string", "pattern": written}],
        "description": 'b = w of every robot, or a spread such as "U(0.525, 0.975)" or "N(0.75, 0.1)"',
    }


def _accuracy() -> list[Schema]:
    return [_spread(), _table({"black": _spread(), "white": _spread()}, "black", "white")]


def _drifting() -> list[Schema]:
    """One that falls, to what is least, and one that rises, to what is most."""
    return [
        _table(
            {
                "start": _spread(exclusiveMinimum=0),
                "drift": {"type": "number", "minimum": -1, "exclusiveMaximum": 0},
                "least": {"type": "number", "minimum": 0, "exclusiveMaximum": 1},
            },
            "start",
            "drift",
        ),
        _table(
            {
                "start": _spread(exclusiveMaximum=1),
                "drift": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
                "most": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
            },
            "start",
            "drift",
        ),
    ]


def _error() -> Schema:
    return _table({"error": _spread(minimum=-1)}, "error")


def _change() -> Schema:
    when = {"anyOf": [{"type": "integer", "minimum": changes.LEAST, "maximum": MOST}, WORDS]}
    return _table({"from": SHARE, "to": SHARE, "at": when, "until": when}, "from", "to", "at")


def _named(*kinds: Plugins) -> Schema:
    """A name or the path of a file: a misspelt name is marked, for it has no dot and no slash."""
    return {"anyOf": [{"enum": [name for plugins in kinds for name in plugins.names]}, FILE]}


def _of_brain(*kinds: Plugins) -> Schema:
    name = _named(*kinds)
    number = {"type": "number", "exclusiveMinimum": -LARGEST, "exclusiveMaximum": LARGEST}
    vector = {**LISTED_AT_LEAST_ONE, "items": number}
    values = {"anyOf": [number, {**LISTED_AT_LEAST_ONE, "items": {"anyOf": [number, vector]}}]}
    return {"anyOf": [name, _table({"file": name}, "file", more=values)]}


def _topology() -> Schema:
    ends = {"type": "integer", "minimum": 0}
    pair = {"type": "array", "items": ends, "minItems": 2, "maxItems": 2, "uniqueItems": True}
    edges, directed = {"type": "array", "items": pair}, {"type": "boolean"}
    generator = {"type": "string", "pattern": "_graph$"}
    argument = {"type": ["number", "string", "boolean", "array"]}
    shipped, outside = [*wiring.PLUGINS.shipped], [*wiring.PLUGINS.outside]
    return {
        "anyOf": [
            _named(wiring.PLUGINS),
            _table({"name": {**TEXT, "not": {"enum": shipped}}, "edges": edges, "directed": directed}, "name", "edges"),
            _table({"file": TEXT, "directed": directed}, "file"),
            {**_table({"networkx": generator}, "networkx", more=argument), "not": {"required": ["seed"]}},
            _table({"name": {"enum": shipped}}, "name"),
            *([_table({"name": {"enum": outside}}, "name", more=True)] if outside else []),
        ]
    }


def _floor() -> Schema:
    """Kinds by their names, and as tables with their keys; another package's are not imported for a schema."""
    models = {kind: patterns.keys(kind) for kind in patterns.PLUGINS.shipped}
    bare = [kind for kind, model in models.items() if not any(f.is_required() for f in model.model_fields.values())]
    tables = [_keys(kind, model.model_json_schema()) for kind, model in models.items() if model.model_fields]
    outside = [*patterns.PLUGINS.outside]
    others = [_table({kind: {}}, kind, more=True) for kind in outside]
    return {"anyOf": [{"enum": [*bare, *outside]}, *tables, *others]}


def _keys(kind: str, told: dict[str, Any]) -> Schema:
    """A table of which the first key goes by the kind's name."""
    first, *_ = told["properties"]
    keys = {kind if key == first else key: one for key, one in told["properties"].items()}
    needed = [kind if key == first else key for key in told.get("required", ())]
    return _table(keys, *dict.fromkeys([kind, *needed]))


BRAIN = Form(lambda _: _of_brain(brains.PLUGINS))
BRAIN_OR_ADVERSARY = Form(lambda _: _of_brain(brains.PLUGINS, adversary.PLUGINS))
TOPOLOGY = Form(lambda _: _topology())
FLOOR = Form(lambda _: _floor())
METRIC = Form(lambda _: _named(metrics.PLUGINS))
TRUE_ACCURACY = Form(lambda _: {"anyOf": [*_accuracy(), *_drifting()]})
BELIEF = Form(lambda _: {"anyOf": [*_accuracy(), _error()]})
FILL_RATIO = Form(lambda _: {"anyOf": [SHARE, _change()]})
