"""The command `brains`: what there is on the shelves, and what the conformance suite found."""

from collections.abc import Callable
from typing import Any

from rich.text import Text

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.terminal import console, table
from swarmcensus.conformance.suite import Check

GROUPS = {"number": "estimates a number", "opinion": "has an opinion, black or white", "": "what is wrong"}
Row = dict[str, Any]


def brains() -> list[Row]:
    """The brains that come with swarmcensus and other packages: what each is, and its size on a robot, in bytes.

    Of one that cannot be read there is `fault`, which is None of the others.
    """
    from swarmcensus import brains

    def told(name: str) -> Row:
        brain = brains.load(name)
        return {
            "what": (brain.functions.__doc__ or "").strip().partition("\n")[0],
            "estimates": "opinion" if brain.is_opinion else "number",
            "anonymous": not brain.uses.name,
            "memory_bytes": brain.memory_bytes,
            "message_bytes": brain.message_bytes,
            "parameters": brain.parameters,
        }

    return [_row(name, told) for name in brains.DOOR.names]


def adversaries() -> list[Row]:
    """The adversaries that come with swarmcensus and other packages, likewise."""
    from swarmcensus.brains import adversary

    def told(name: str) -> Row:
        one = adversary.load(name)
        return {"what": (one.functions.__doc__ or "").strip().partition("\n")[0], "parameters": one.parameters}

    return [_row(name, told) for name in adversary.DOOR.names]


def _row(name: str, told: Callable[[str], Row]) -> Row:
    try:
        return {"name": name, **told(name), "fault": None}
    except InputError as error:
        return {"name": name, "fault": str(error)}


def show_brains(rows: list[Row]) -> None:
    """Print them by what they estimate."""
    groups: dict[str, list[tuple[str, ...]]] = {group: [] for group in GROUPS.values()}
    for row in rows:
        sizes = [f"{row[name]:,}" if name in row else "-" for name in ("memory_bytes", "message_bytes")]
        what = row["fault"] or row["what"] + " Not anonymous." * (not row["anonymous"])
        groups[GROUPS[row.get("estimates", "")]].append((row["name"], *sizes, what))
    widest = max(len(row["name"]) for row in rows)
    for group, some in groups.items():
        if some:
            heads = [("brain".ljust(widest), False), ("memory", True), ("message", True), (group, False)]
            console().print(table(heads, some))
            print()
    print("memory and message: bytes, 4 a number; not anonymous: uses its robot's name\n")


def show_adversaries(rows: list[Row]) -> None:
    """Print them with their parameters."""
    cells = []
    for row in rows:
        told = [f"{k} {v:,.10g}" if isinstance(v, float) else k for k, v in row.get("parameters", {}).items()]
        cells.append((row["name"], "-" if row["fault"] else ", ".join(told), row["fault"] or row["what"]))
    console().print(table([("adversary", False), ("parameters", False), ("what it does", False)], cells))


def checks(path: Any, found: list[Check]) -> bool:
    """What the conformance suite found; whether the brain passed."""
    out = console()
    for one in found:
        if not one.used:
            out.print(f"-     {one.name}: not used", style="dim")
            continue
        out.print(Text("pass", "green") if one.fault is None else Text("FAIL", "red bold"), f" {one.name}")
        if one.fault is not None:
            out.print(f"      {one.fault}", soft_wrap=True)
    good = all(one.fault is None for one in found)
    out.print(f"{path}: {'conforms' if good else 'does not conform'}", soft_wrap=True)
    return good
