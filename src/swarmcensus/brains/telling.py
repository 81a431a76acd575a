"""What a liar says, field by field of a message, by what the fields mean; written as the source of plain functions."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

from swarmcensus.brains.contract import confidence_of

VALUES = ("estimate", "opinion", "option", "belief", "information")  # what one may lie about
SPARE = 1e-6  # of a belief's weight, for the bins that are not the lie's: a weight of 0 could never be made good again


class Field(NamedTuple):
    """A part of a message: what it means, if that is known, and how long it is; 0 for a number."""

    name: str
    role: str
    long: int


class Names(NamedTuple):
    """With what functions begin: those of the adversary, those of the brain, and those that are written here."""

    own: str
    honest: str
    worn: str


HELPERS = {
    "share": "def {worn}share(x):\n    return min(max(x, 0.0), 1.0)",
    "told": "def {worn}told(me, x):\n    return {worn}share({own}lie(me, {worn}share(x)))",
    "bin": "def {worn}bin(x, bins):\n    return float(min(int(x * bins), bins - 1))",
    "weight": "def {worn}weight(k, bin, bins):\n"
    f"    return 1.0 - {SPARE} if k == bin else {SPARE} / max(bins - 1.0, 1.0)",
    "mean": """
def {worn}mean(belief, bins):
    total = 0.0
    first = 0.0
    for k in range(bins):
        total += belief[k]
        first += belief[k] * (k + 0.5) / bins
    return first / total if total > 0.0 else 0.5""",
    "ratio": "def {worn}ratio(information, confidence):\n"
    "    return information / confidence if confidence > 0.0 else 0.5",
    "pooled": """
def {worn}pooled(information, confidence, parts):
    total = 0.0
    weight = 0.0
    for k in range(parts):
        total += information[k]
        weight += confidence[k]
    return total / weight if weight > 0.0 else 0.5""",
}


def functions_source(fields: Sequence[Field], has: Collection[str], names: Names, options: int, silent: bool) -> str:
    """The functions that alter what an honest brain says and hears; `has` are those that the adversary may have."""
    own, honest, worn = names
    before, parts = _saying(fields, has, names, options)
    # of a tuple or None, Numba indexes nothing, but takes it apart
    apart = ", ".join(f"said_{k}" for k, _ in enumerate(fields)) + ", = said"
    lines = [*(["if said is None:", "    return None"] if silent else []), apart, *before]
    functions = [
        "\n    ".join([f"def {worn}tell(me, said):", *lines, f"return ({', '.join(parts)},)"]),
        f"def broadcast(me):\n    return {worn}tell(me, {honest}broadcast(me))",
    ]
    if "hear" in has:
        k = next(k for k, field in enumerate(fields) if field.role in VALUES)
        heard = f"{own}hear(me, {worn}share({_read(fields, k, 'message[{}]', worn, options)}))"
        functions.append(f"def receive(me, message):\n    {honest}receive(me, message)\n    {heard}")
    if "plot" in has:
        functions.append(f"def fuse(me):\n    {honest}fuse(me)\n    {own}plot(me)")
    if "jam" in has:
        functions.append(f"def jam(me):\n    return {own}jam(me)")
    found = list(functions)
    for name, source in reversed(HELPERS.items()):
        if any(f"{worn}{name}(" in one for one in found):
            found.insert(0, source.format(own=own, worn=worn).strip("\n"))
    return "\n\n\n".join(found)


def _read(fields: Sequence[Field], k: int, part: str, worn: str, options: int) -> str:
    """The fill ratio that stands in a field of a message, whose parts are called so."""
    this = part.format(k)
    match fields[k].role:
        case "option":
            return f"({this} + 0.5) / {float(options)}"
        case "belief":
            return f"{worn}mean({this}, {fields[k].long})"
        case "information":
            other, long = part.format(_confidence(fields, k)), fields[k].long
            return f"{worn}pooled({this}, {other}, {long})" if long else f"{worn}ratio({this}, {other})"
    return this


def _confidence(fields: Sequence[Field], k: int) -> int:
    """The place of the confidence that the k-th field, an information, goes with."""
    names = [field.name for field in fields]
    return names.index(confidence_of(fields[k].name, names, {field.name: field.role for field in fields}))


def _each(parts: Sequence[str]) -> str:
    """The source of a vector of these."""
    return f"({', '.join(parts)},)"


def _saying(fields: Sequence[Field], has: Collection[str], names: Names, options: int) -> tuple[list[str], list[str]]:
    """What is said in place of the honest message `said`, field by field; and the lines that go before."""
    own, _, worn = names
    before, parts = [], []
    for k, (_, role, long) in enumerate(fields):
        told = f"{worn}told(me, {_read(fields, k, 'said_{}', worn, options)})"
        sure = f"max({own}boast(me, said_{{}}), 0.0)" if "boast" in has else "said_{}"
        match role:
            case "estimate":
                parts.append(told)
            case "opinion":
                parts.append(f"1.0 if {told} >= 0.5 else 0.0")
            case "option":
                parts.append(f"{worn}bin({told}, {options})")
            case "belief":
                before.append(f"bin_{k} = {worn}bin({told}, {long})")
                parts.append(f"({''.join(f'{worn}weight({j}, bin_{k}, {long}), ' for j in range(long))})")
            case "confidence" if long:
                parts.append(_each([sure.format(f"{k}[{j}]") for j in range(long)]))
            case "confidence":
                parts.append(sure.format(k))
            case "information" if long:
                before.append(f"told_{k} = {told}")
                other = _confidence(fields, k)
                parts.append(_each([f"told_{k} * {sure.format(f'{other}[{j}]')}" for j in range(long)]))
            case "information":
                parts.append(f"{told} * {sure.format(_confidence(fields, k))}")
            case "name" if "forge" in has:
                parts.append(f"1.0 * {own}forge(me, said_{k})")
            case _:
                parts.append(f"said_{k}")
    return before, parts
