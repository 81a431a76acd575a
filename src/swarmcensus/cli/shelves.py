"""The command `brains`: what there is on the shelves, and what the conformance suite found."""

from typing import Any

from rich.text import Text

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.terminal import console, table
from swarmcensus.conformance.suite import Check

ESTIMATES, OPINIONS, UNREADABLE = "estimates a number", "has an opinion, black or white", "what is wrong"


def shipped() -> None:
    """The brains that come with swarmcensus and other packages, with their sizes on a robot, by what they estimate."""
    from swarmcensus import brains

    groups: dict[str, list[tuple[str, str, str, str]]] = {ESTIMATES: [], OPINIONS: [], UNREADABLE: []}
    for name in brains.DOOR.names:
        try:
            brain = brains.load(name)
        except InputError as error:
            groups[UNREADABLE].append((name, "-", "-", str(error)))
            continue
        what = (brain.functions.__doc__ or "").strip().splitlines()[0] + " Not anonymous." * brain.uses.name
        rows = groups[OPINIONS if brain.is_opinion else ESTIMATES]
        rows.append((name, f"{brain.memory_bytes:,}", f"{brain.message_bytes:,}", what))
    widest = max(len(name) for name in brains.DOOR.names)
    for group, rows in groups.items():
        if rows:
            heads = [("brain".ljust(widest), False), ("memory", True), ("message", True), (group, False)]
            console().print(table(heads, rows))
            print()
    print("memory and message: bytes, 4 a number; not anonymous: uses its robot's name\n")


def shipped_adversaries() -> None:
    """The adversaries that come with swarmcensus and other packages, with their parameters."""
    from swarmcensus.brains import adversary

    rows = []
    for name in adversary.DOOR.names:
        try:
            one = adversary.load(name)
        except InputError as error:
            rows.append((name, "-", str(error)))
            continue
        what = (one.functions.__doc__ or "").strip().partition("\n")[0]
        told = (f"{k} {v:,.10g}" if isinstance(v, float) else k for k, v in one.parameters.items())
        rows.append((name, ", ".join(told), what))
    console().print(table([("adversary", False), ("parameters", False), ("what it does", False)], rows))


def checks(path: Any, found: list[Check]) -> bool:
    """What the conformance suite found; whether the brain passed."""
    out = console()
    for one in found:
        out.print(Text("pass", "green") if one.fault is None else Text("FAIL", "red bold"), f" {one.name}")
        if one.fault is not None:
            out.print(f"      {one.fault}", soft_wrap=True)
    good = all(one.fault is None for one in found)
    out.print(f"{path}: {'conforms' if good else 'does not conform'}", soft_wrap=True)
    return good
