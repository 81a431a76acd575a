"""The coordinates of the dataset along `setting`: everything that settings differ in.

They follow from the keys of `studies/settings.py`; `OTHERS` come from other tables of a study file. Parameters of
brains are coordinates too, by their own names; they have no entry.
"""

import dataclasses

import numpy as np

from swarmcensus.studies.keys import Coordinate
from swarmcensus.studies.settings import KEYS, Setting, set_apart, shown
from swarmcensus.support.quantities import QUANTITIES

OTHERS = (
    Coordinate(
        "text", "{}", idle="plain", plural="mixtures of robots", name="members",
        of=lambda setting: "; ".join(map(str, setting.members)) if setting.members else None,
    ),
    Coordinate(
        "whole number", "{:,.0f} liars", plural="numbers of liars", blank=0, name="liars",
        of=lambda setting: setting.robots - setting.honest if setting.members else None,
    ),
    Coordinate(
        "text", "{}", idle="nobody lies", plural="adversaries", name="adversary",
        of=lambda setting: (
            "; ".join(dict.fromkeys(m.name for m in setting.members if not m.honest)) if setting.members else None
        ),
    ),
    Coordinate(
        "text", "f {}", idle="f stays", name="fill_ratio_change",
        of=lambda setting: str(setting.change) if setting.change else None,
    ),
    Coordinate(
        "text", "f from {}", idle="f fixed", name="fill_ratio_spread",
        of=lambda setting: str(setting.spread) if setting.spread else None,
    ),
)  # fmt: skip
_OF_KEYS = [
    dataclasses.replace(
        key.coordinate, name=name, world=key.coordinate.world or key.world,
        blank=key.default if key.is_new else None,
    )
    for name, key in KEYS.items() if key.coordinate
]  # fmt: skip
COORDINATES = {
    one.name: one for one in (*(c for c in _OF_KEYS if c.always), *OTHERS, *(c for c in _OF_KEYS if not c.always))
}
NUMERIC = {  # derived from `accuracy`, a text, when Python opens results
    f"accuracy_{what}": Coordinate("number", title=title, meaning=meaning, name=f"accuracy_{what}")
    for what, title, meaning in (
        ("black", "sensor accuracy $b$", "b, how likely black is read as black: the mean over robots, in round 1"),
        ("white", "sensor accuracy $w$", "w, how likely white is read as white: the mean over robots, in round 1"),
        ("spread", "spread of sensor accuracies",
         "how far robots differ: the standard deviation of b or w, the larger one"),
        ("drift", "drift of sensors a round", "what they gain in a round"),
    )
}  # fmt: skip
IN_CAPTIONS = (  # in this order; others follow
    "topology", "brain", "robots", "density", "side", "fill_ratio", "fill_ratio_change", "fill_ratio_spread", "floor",
    "rounds", "observations_per_round", "link_success", "message_delay", "precision", "message", "assumed_accuracy",
    "accuracy", "checkpoint", "members", "adversary", "liars",
)  # fmt: skip
# of quantities that are measured at checkpoints
ROUNDS = Coordinate("whole number", "after {:,.0f}", counts=True, name="checkpoint")
TAKEN = {  # names of the dataset, and of its summary
    *QUANTITIES, *COORDINATES, *NUMERIC, "setting", "trial", "robot", "checkpoint", "end", "parameters",
    "trials", "failed", "K", "error", "right",
}  # fmt: skip
PREFIXES = ("edge_", "edges_", "floor_", "row_", "column_")  # of other variables of the dataset
SUFFIXES = ("_low", "_high")  # of columns of the summary
OF_FIGURES = COORDINATES | NUMERIC | {ROUNDS.name: ROUNDS}


def coordinates_of(setting: Setting) -> dict[str, object]:
    """The setting's coordinates in the dataset, by their names; without those of newer keys at their default."""
    found = {one.name: _value(setting, one) for one in COORDINATES.values() if one.always}
    found |= {name: shown(value) for name, value in setting.brain.parameters.items()}
    found |= setting.world_parameters
    found |= {one.name: value for one in OTHERS if (value := _value(setting, one)) is not None}
    return found | {key.name: getattr(setting, key.field) for key in set_apart(setting)}


def _value(setting: Setting, coordinate: Coordinate) -> object:
    value = coordinate.of(setting) if coordinate.of else getattr(setting, coordinate.name)
    if value is None:
        return np.nan if coordinate.type == "number" else None
    return str(value) if coordinate.type == "text" else value


def is_taken(name: str) -> bool:
    """Whether a name already means something in datasets and summaries, so that no parameter or metric may have it."""
    return name in TAKEN or name.startswith(PREFIXES) or name.endswith(SUFFIXES)


def goes_unsaid(name: str, value: object) -> bool:
    """Whether a coordinate has the value that lines and tables leave out."""
    return name in COORDINATES and value == COORDINATES[name].unsaid


def caption_form(name: str) -> str:
    """The format in captions of a value of a coordinate, or of a brain's parameter."""
    return (name in OF_FIGURES and OF_FIGURES[name].caption) or name + " = {}"


def idle_caption(name: str) -> str:
    """The caption's text for an idle value; empty if captions leave it out."""
    return COORDINATES[name].idle if name in COORDINATES else ""


def title_of(name: str) -> str:
    """The title of a coordinate on an axis or in a key."""
    return (name in OF_FIGURES and OF_FIGURES[name].title) or name.replace("_", " ").replace("$", r"\$")


def plural_of(name: str) -> str:
    """The name of several values of a coordinate."""
    return (name in COORDINATES and COORDINATES[name].plural) or f"values of {name}"
