"""The checks of docs/brain-contract.md, in CPython; each fault is one sentence."""

from collections.abc import Callable
from typing import Any

from swarmcensus.brains import INTERVAL, Brain
from swarmcensus.checks.message_checks import any_order, sums_add
from swarmcensus.checks.reading_checks import readings_add_up
from swarmcensus.checks.sample_states import (
    NotUsed,
    Violation,
    call,
    copy_of,
    difference,
    fault_of_message,
    line_of,
    lives,
    number_at,
)
from swarmcensus.simulation import fixed


def _fixed_memory(brain: Brain) -> None:
    for _ in lives(brain):
        pass  # `call` checks every state


def _finite(brain: Brain, where: str, me: Any) -> None:
    x = call(brain, where, "estimate", me)
    if not (isinstance(x, int | float) and 0.0 <= x <= 1.0):
        raise Violation(f"{line_of(brain, 'estimate')} gives {x!r}, not a number in [0, 1] ({where})")
    message = call(brain, where, "broadcast", me)
    fault = "" if message is None and brain.uses.silence else fault_of_message(brain, message)
    if fault:
        raise Violation(f"{line_of(brain, 'broadcast')} gives {fault} ({where})")


def _decides(brain: Brain, where: str, me: Any) -> None:
    """`decide` gives an option or -1, and `done` and `jam` return true or false, in every state."""
    if not (brain.decides or brain.ends or brain.jams):
        raise NotUsed
    if brain.decides:
        choice = call(brain, where, "decide", me)
        if not isinstance(choice, int | float) or choice not in range(-1, brain.options):
            most = brain.options - 1
            raise Violation(
                f"{line_of(brain, 'decide')} gives {choice!r}, neither -1 (undecided) nor an option from 0 to "
                f"{most} ({where})"
            )
    for name in {"done", "jam"} & brain.contents.functions:
        if not isinstance(result := call(brain, where, name, me), bool | int | float):
            raise Violation(f"{line_of(brain, name)} gives {result!r}, neither True nor False ({where})")


def _bounds(brain: Brain, where: str, me: Any) -> None:
    if not brain.has_interval:
        raise NotUsed
    result = call(brain, where, "interval", me)
    is_pair = isinstance(result, tuple) and len(result) == 2 and all(isinstance(end, int | float) for end in result)
    if not (is_pair and 0.0 <= result[0] <= result[1] <= 1.0):
        raise Violation(f"{line_of(brain, 'interval')} gives {result!r}: {INTERVAL} ({where})")


def _steers(brain: Brain, where: str, me: Any) -> None:
    if not brain.steers:
        raise NotUsed
    command = call(brain, where, "steer", me)
    if not is_command(command):
        what = "neither two finite numbers, a speed and a turn, nor None"
        raise Violation(f"{line_of(brain, 'steer')} gives {command!r}, {what} ({where})")


def is_command(command: object) -> bool:
    """Whether `steer` may return this."""

    def finite(value: object) -> bool:  # the engine counts numbers below 1e300 as finite
        return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300

    return command is None or (isinstance(command, tuple) and len(command) == 2 and all(map(finite, command)))


def _reads_only(brain: Brain, where: str, me: Any) -> None:
    for name in query_functions(brain):
        before = copy_of(brain, me)
        call(brain, where, name, me)
        changed = difference(brain, before, me, close=0.0)
        if changed:
            x, y = number_at(before, changed), number_at(me, changed)
            raise Violation(
                f"{line_of(brain, name)} changes me.{changed} from {x!r} to {y!r}: it may only read ({where})"
            )


def query_functions(brain: Brain) -> tuple[str, ...]:
    """The functions that return something and may not change the state."""
    return (
        "broadcast",
        "estimate",
        *(name for name in ("steer", "decide", "done", "interval", "jam") if name in brain.contents.functions),
    )


def _same_again(brain: Brain) -> None:
    """Two states with equal histories stay equal and give equal answers, however often they are asked."""
    for (where, first_state), (_, second_state) in zip(lives(brain), lives(brain), strict=True):
        changed = difference(brain, first_state, second_state, close=0.0)
        if changed:
            x, y = number_at(first_state, changed), number_at(second_state, changed)
            raise Violation(
                f"the same history gives me.{changed} = {x!r} and then {y!r}: something is kept outside of me, by "
                f"{line_of(brain, 'observe')}, {line_of(brain, 'receive')} or {line_of(brain, 'fuse')} ({where})"
            )
        names = [name for name in query_functions(brain) if name != "steer"]
        answers = [
            [fixed(call(brain, where, name, me)) for name in names]
            for me in (first_state, second_state, second_state, second_state)
        ]
        for name, answer, *again in zip(names, *answers, strict=True):
            for changed_answer in [value for value in again if value != answer][:1]:
                raise Violation(
                    f"{line_of(brain, name)} gives {answer!r} and then {changed_answer!r} of the same state: something "
                    f"is kept outside of me ({where})"
                )


def _in_every_state(check: Callable[[Brain, str, Any], None]) -> Callable[[Brain], None]:
    """A check of a brain, from a check of one of its states with a description of its history."""

    def of_brain(brain: Brain) -> None:
        for where, me in lives(brain):
            check(brain, where, me)

    return of_brain


IN_EACH_STATE = {
    "gives finite messages and estimates in [0, 1]": _finite,
    "steers by a speed and a turn, or not at all": _steers,
    "decides for an option, or not yet": _decides,
    "tells an interval within [0, 1], the low end first": _bounds,
    "functions that tell something only read": _reads_only,
}
PROMISES: dict[str, Callable[[Brain], None]] = {
    "remembers numbers in MEMORY's fields, nothing else": _fixed_memory,
    **{name: _in_every_state(check) for name, check in IN_EACH_STATE.items()},
    "the same history gives the same state": _same_again,
    "readings at once mean the same as one by one": readings_add_up,
    "messages mean the same in any order": any_order,
    "SUMS only add up": sums_add,
}
