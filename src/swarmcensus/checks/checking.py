"""Whether a brain file keeps the contract: `sc.check`."""

from pathlib import Path

from swarmcensus.brains import PLUGINS, exists, find
from swarmcensus.checks import suite
from swarmcensus.checks.suite import Check
from swarmcensus.support.answers import Answer
from swarmcensus.support.printed_tables import Column, Table

LIVES = {"alone": "alone", "hearing": "next to a neighbour in the same state"}


class Conformance(Answer):
    """The checks of a brain or adversary, in order, and `notes` on what breaks no promise but should be known.

    `single` is of a day at 10 Hz in single precision, if asked for: the reading at which it differs from double
    precision by more than 0.01, "alone" and "hearing" a neighbour, None if it never does; or a text, why it ended.
    """

    checks: list[Check]
    notes: list[str]
    conforms: bool
    single: dict[str, int | None] | str | None


def check(brain: str | Path, *, wrapping: str = "", single: bool = False) -> Conformance:
    """Check a brain or an adversary, a name or a file, against the contract, as `swarmcensus brains --check` does.

    An adversary wraps the brain `wrapping`, by default the paper's. With `single`, a brain that conforms also runs for
    a day in single precision. The file is compiled and run in a process of its own, which takes up to a minute. Its
    faults are returned, not raised; raises InputError if there is no such file, and if `wrapping` cannot be wrapped.
    """
    if wrapping:
        find(wrapping)  # so that a misspelt name is not reported as an error of the adversary
    if not (str(brain) in PLUGINS or exists(str(brain), None) or Path(brain).exists()):
        suite.brain_to_check(brain, wrapping)  # raises the right error
    checks, notes, lived = suite.check(brain, wrapping=wrapping), suite.notes(brain, wrapping), None
    faults = [one for one in checks if one.fault is not None]
    if single and not faults:
        lived = suite.single_life(brain, wrapping)
        notes.append(lived if isinstance(lived, str) else _life(lived))
    code = 2 if any(one.decided for one in faults) else 1 if faults else 0
    verdict = ("keeps the contract", "is not decided", "does not keep the contract")[code]
    said = [f"{one.state}  {one.name}: {one.fault}" for one in faults] + [f"note: {note}" for note in notes]
    names = [one.name + ": not used" * (not one.used) for one in checks]
    states = Column("", [one.state for one in checks], number=False, name="state")
    rows = [{"check": one.name, "state": one.state, "fault": one.fault} for one in checks]
    found = {"conforms": not faults, "notes": notes, "single": lived}
    return Conformance(
        Table([states, Column("check", names, number=False, name="check")], folds=True), rows=rows, checks=checks,
        sentences=[f"{brain} {verdict}", *said], fields={"file": brain, **found}, code=code, **found,
    )  # fmt: skip


def _life(lived: dict[str, int | None]) -> str:
    """A sentence on a day of readings in single precision."""
    apart = [f"at reading {at:,} {LIVES[how]}" for how, at in lived.items() if at is not None]
    if not apart:
        return "single precision stays within 0.01 of double precision for a day at 10 Hz, which is 864,000 readings"
    return f"single precision differs from double precision by more than 0.01 {' and '.join(apart)}"
