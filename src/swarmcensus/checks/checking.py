"""Whether a brain file keeps the contract: `sc.check`."""

from dataclasses import dataclass
from pathlib import Path

from swarmcensus.brains import PLUGINS, exists, find
from swarmcensus.checks import suite
from swarmcensus.checks.suite import Check


@dataclass(frozen=True, repr=False)
class Conformance:
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
        faults = [check for check in self.checks if check.fault is not None]
        if not faults:
            return "conforms"
        return "does not conform" if any(check.decided for check in faults) else "not decided"

    def __str__(self) -> str:
        """One line for each fault and note."""
        faults = [
            f"{'FAIL' if check.decided else '?   '}  {check.name}: {check.fault}"
            for check in self.checks
            if check.fault is not None
        ]
        heads = {"conforms": "keeps the contract", "does not conform": "does not keep the contract"}
        head = f"{self.name} {heads.get(self.verdict, f'is {self.verdict}')}"
        return "\n".join([head, *faults, *(f"note: {note}" for note in self.notes)])

    def __repr__(self) -> str:
        """The same, so that a notebook shows it."""
        return str(self)


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
    if not (single and found.conforms):
        return found
    return Conformance(found.name, found.checks, found.notes, suite.single_life(brain, wrapping))
