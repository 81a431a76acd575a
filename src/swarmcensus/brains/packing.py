"""How a message becomes bytes: which codings of `runtime/codec.py` a format has for which fields of MESSAGE."""

from collections.abc import Mapping
from typing import Literal, NamedTuple, get_args

from swarmcensus.brains.contract import confidence_of
from swarmcensus.runtime import runtime as robot

Precision = Literal["double", "single"]
Format = Literal["double", "float32", "float16", "ratio16", "ratio8"]  # "double" is a simulation without a format
FORMATS: tuple[Format, ...] = get_args(Format)
BYTES = robot.SIZES  # of a coding: for one number, but for "ratio16" and "ratio8", which are of two
STEPS, MOST = robot.STEPS, {"whole16": robot.WHOLE}
READ = {  # of a coding: the name in the functions read_NAME and holds_NAME of `runtime/codec.py`
    "float32": "real", "float16": "half", "ratio16": "pair", "ratio8": "pair", "share16": "share", "share8": "share",
    "log8": "log", "whole16": "whole",
}  # fmt: skip
OWED = ("estimate", "confidence", "information", "belief")  # what rounding takes of these is added to the next message
BY_ROLE = {  # in the formats of ratios; an opinion is 0 or 1, or between them where it is the mean of several
    "estimate": "share", "confidence": "log8", "opinion": "share8", "option": "whole16", "name": "whole16",
    "belief": "float16",
}  # fmt: skip


class Numbers(NamedTuple):
    """The number formats of a robot: of its arithmetic, and of its messages."""

    precision: Precision = "double"
    message: Format = "double"
    feedback: bool = True  # whether what rounding took of a message is added to the next one


PLAIN = Numbers()


class Part(NamedTuple):
    """One or two numbers of a message, which are coded together."""

    coding: str  # a key of BYTES
    places: tuple[int, ...]  # which numbers of the message: an information and its confidence, or one
    owed: bool  # whether rounding errors may be carried over


def parts(message: Mapping[str, int], roles: Mapping[str, str], format: Format) -> tuple[Part, ...]:
    """The parts of a message in a format, in the order of their bytes.

    `message` has the fields and their lengths, 0 for a number. In the formats of ratios a number without a role is sent
    as float32, because nothing is known of its size. "double" has no parts: nothing is rounded.
    """
    if format == "double":
        return ()
    places, at = {}, 0
    for name, items in message.items():
        places[name] = range(at, at := at + max(items, 1))
    pairs: dict[str, str] = {}  # an information and its confidence, where they are sent together
    for name in (name for name in message if format in STEPS and roles.get(name) == "information"):
        confidence = confidence_of(name, list(message), roles)
        if confidence not in pairs.values():
            pairs[name] = confidence
    out = []
    for name in (name for name in message if name not in pairs.values()):
        role = roles.get(name, "")
        coding = BY_ROLE.get(role, "float32") if format in STEPS else format
        coding += format.removeprefix("ratio") * (coding == "share")
        if name in pairs:
            out += [Part(format, both, True) for both in zip(places[name], places[pairs[name]], strict=True)]
        else:
            out += [Part(coding, (place,), role in OWED) for place in places[name]]
    return tuple(out)


def bytes_of(parts: tuple[Part, ...]) -> int:
    """The size of a message."""
    return sum(BYTES[part.coding] for part in parts)
