"""What a log of a brain holds, for programs in C that write one with robot_log.h."""

from swarmcensus.brains import FORMATS, Brain
from swarmcensus.runtime.log import FEEDBACK, SINGLE
from swarmcensus.translation.comments import quoted
from swarmcensus.translation.headers import unit_of
from swarmcensus.translation.messages import owed_places
from swarmcensus.translation.pieces import filled


def logged(brain: Brain, mark: int) -> str:
    """The text of logged.h; `mark` is that of the datagrams."""
    unit, numbers = unit_of(brain), brain.numbers
    memory = [(f"me->{unit.field(name)}", brain.lengths[name]) for name in sorted(brain.lengths)]
    places = owed_places(brain)
    owed = [f"me->owed[{places.index(k)}]" if k in places else "nothing" for k in range(_items(brain.message))]
    calls = [f"{'' if items else '&'}{name}, {items or 1}" for name, items in memory] + [f"&{one}, 1" for one in owed]
    parameters: list[float] = []
    for name in sorted(brain.parameters):
        value = brain.parameters[name]
        parameters.extend(value if isinstance(value, tuple) else [value])
    return filled(
        "logged.h", brain=quoted(brain.label), mark=f"{mark & 0xFFFF:04x}", form=FORMATS.index(numbers.message),
        hash=", ".join(f"0x{byte:02x}" for byte in bytes.fromhex(brain.sha256[:16])),
        flags=FEEDBACK * numbers.feedback | SINGLE * (numbers.precision == "single"),
        parameters="".join(f"{unit.real(float(x))}, " for x in parameters),
        numbers=_items(brain.lengths), owed=len(owed),
        memory="\n".join(f"    robot_log_put_numbers(log, {call});" for call in calls),
    )  # fmt: skip


def _items(lengths: dict[str, int]) -> int:
    """How many numbers fields of these lengths have; 0 is the length of a number."""
    return sum(items or 1 for items in lengths.values())
