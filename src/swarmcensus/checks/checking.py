"""Whether a brain file keeps the contract: `sc.check`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus.brains import PLUGINS, exists, find
from swarmcensus.checks import suite
from swarmcensus.checks.suite import Check
from swarmcensus.support.answers import Answer
from swarmcensus.support.printed_tables import Column, Table

CONFORMS, UNDECIDED = "keeps the contract", "is not decided"
LIVES = {"alone": "alone", "hearing": "next to a neighbour in the same state"}


@dataclass(repr=False)
class Conformance(Answer):
    """The checks of a brain or adversary, in order, and `notes` on what breaks no promise but should be known.

    `single` is of a day at 10 Hz in single precision, if asked for: the reading at which it differs from double
    precision by more than 0.01, "alone" and "hearing" a neighbour, None if it never does; or a text, why it ended.
    """

    name: str
    checks: list[Check]
    notes: list[str]
    single: dict[str, int | None] | str | None = None

    @property
    def conforms(self) -> bool:
        """Whether it keeps the contract."""
        return all(check.fault is None for check in self.checks)

    @property
    def verdict(self) -> str:
        """Whether it conforms, in words: also that a check was given up, and no other found a fault."""
        if self.conforms:
            return CONFORMS
        known = any(check.decided for check in self.checks if check.fault is not None)
        return "does not keep the contract" if known else UNDECIDED

    @property
    def code(self) -> int:  # type: ignore[override]
        """1 if a check was given up, 2 if one failed."""
        return {CONFORMS: 0, UNDECIDED: 1}.get(self.verdict, 2)

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """The verdict, each fault, and each note."""
        faults = [f"{check.state}  {check.name}: {check.fault}" for check in self.checks if check.fault is not None]
        return [f"{self.name} {self.verdict}", *faults, *(f"note: {note}" for note in self.notes)]

    @property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """The checks."""
        return [{"check": check.name, "state": check.state, "fault": check.fault} for check in self.checks]

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """What JSON says of all checks."""
        return {"file": self.name, "conforms": self.conforms, "notes": self.notes, "single": self.single}

    def tables(self, limit: int) -> list[Table]:
        """One table."""
        names = [check.name + ": not used" * (not check.used) for check in self.checks]
        states = Column("", [check.state for check in self.checks], number=False, name="state")
        return [Table([states, Column("check", names, number=False, name="check")], folds=True).first(limit)]


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
    found = Conformance(str(brain), suite.check(brain, wrapping=wrapping), suite.notes(brain, wrapping))
    if single and found.conforms:
        found.single = suite.single_life(brain, wrapping)
        found.notes.append(found.single if isinstance(found.single, str) else _life(found.single))
    return found


def _life(lived: dict[str, int | None]) -> str:
    """A sentence on a day of readings in single precision."""
    apart = [f"at reading {at:,} {LIVES[how]}" for how, at in lived.items() if at is not None]
    if not apart:
        return "single precision stays within 0.01 of double precision for a day at 10 Hz, which is 864,000 readings"
    return f"single precision differs from double precision by more than 0.01 {' and '.join(apart)}"
