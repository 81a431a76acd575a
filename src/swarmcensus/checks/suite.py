"""All checks of a brain file: which brain is meant, and what each check finds, in this process."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from swarmcensus import brains
from swarmcensus.brains import adversary
from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option

KEEPS, COMPILES, AGREES = "keeps the contract", "compiles", "CPython and machine code agree"
DEFAULT_BRAIN = "minimalistic"  # the brain that an adversary wraps if none is named
Test = Callable[[brains.Brain], None]


@dataclass(frozen=True)
class Check:
    """One check: its name, what is wrong (None if nothing is), and whether the brain has the part it checks."""

    name: str
    fault: str | None
    used: bool = True

    @property
    def state(self) -> str:
        """How it ended, in a word or a mark."""
        return "-" if not self.used else "pass" if self.fault is None else "FAIL"


def checks() -> dict[str, Test]:
    """All checks by name, in order; each raises Violation."""
    from swarmcensus.checks import machine_code  # imports Numba
    from swarmcensus.checks.contract_checks import PROMISES

    return PROMISES | {COMPILES: machine_code.compiles, AGREES: machine_code.agrees}


class Mismatch(InputError):
    """No brain is there to check, though no file is at fault: an adversary does not fit the brain that it wraps."""


def brain_to_check(path: str | Path, wrapping: str = "") -> brains.Brain:
    """The brain with this name or file, or the adversary with this name or file, `wrapping` a brain.

    Raises InputError.
    """
    if not is_adversary(path):
        hint = did_you_mean(str(path), [*brains.PLUGINS.names, *adversary.PLUGINS.names])
        if str(path) not in brains.PLUGINS and not Path(path).is_file() and (hint or wrapping):
            raise BrainError.named("brain", str(path), f"{hint}there is no brain, adversary or file of this name")
        if wrapping:
            raise wrong_option(
                "wrapping", wrapping, f"{path} has no lie(me, x), so it is no adversary; only adversaries wrap a brain"
            )
        return brains.load(path)
    lies, brain = adversary.load(path), brains.load(wrapping or DEFAULT_BRAIN)
    try:
        return brains.lying_brain(lies, brain)
    except ValueError as error:
        raise Mismatch(f"{error}{': name another brain with --wrapping' * (not wrapping)}") from None


def is_adversary(path: str | Path) -> bool:
    """Whether this is the name or file of an adversary, and of no brain."""
    return str(path) not in brains.PLUGINS and adversary.exists(str(path), None)


def gist(fault: str) -> str:
    """A fault without the history in which it was found."""
    return fault.rpartition(" (")[0] or fault


def examine(brain: brains.Brain, tests: dict[str, Test], begin: Callable[[str], object] = str) -> Iterator[Check]:
    """Run checks in this process, and `begin` before each with its name.

    A known fault is not repeated, and a brain that does not compile is not run.
    """
    known: dict[str, str] = {}
    for name, test in tests.items():
        if name == AGREES and COMPILES in known:
            continue
        begin(name)
        fault, used = _outcome(test, brain)
        yield Check(name, "the same as above" if fault and gist(fault) in known.values() else fault, used)
        if fault:
            known[name] = gist(fault)


def fault_of(test: Test, brain: brains.Brain) -> str | None:
    """What a check finds wrong, or None."""
    return _outcome(test, brain)[0]


def _outcome(test: Test, brain: brains.Brain) -> tuple[str | None, bool]:
    """What a check finds wrong, or None, and whether the brain has the part that it checks."""
    import numpy as np

    from swarmcensus.checks.sample_states import NotUsed, Violation, in_a_line

    try:
        with np.errstate(all="ignore"):
            test(brain)
    except NotUsed:
        return None, False
    except Violation as fault:
        return str(fault), True
    except Exception as error:
        return in_a_line(error), True
    return None, True
