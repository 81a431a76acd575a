"""What a log of a brain holds, for programs in C that write one with robot_log.h."""

from swarmcensus.brains import FORMATS, Brain, numbers as numbers_of, slots
from swarmcensus.runtime.log import FEEDBACK, SINGLE
from swarmcensus.translation.headers import unit_of
from swarmcensus.translation.messages import owed_places
from swarmcensus.translation.pieces import filled
from swarmcensus.translation.texts import quoted


def logged(brain: Brain, mark: int) -> str:
    """The text of logged.h; `mark` is that of the datagrams."""
    unit, numbers = unit_of(brain), brain.numbers
    memory = [(f"me->{unit.field(name)}", brain.lengths[name]) for name in sorted(brain.lengths)]
    places = owed_places(brain)
    owed = [f"me->owed[{places.index(k)}]" if k in places else "nothing" for k, _ in enumerate(slots(brain.message))]
    calls = [f"{'' if items else '&'}{name}, {items or 1}" for name, items in memory] + [f"&{one}, 1" for one in owed]
    parameters = numbers_of(dict(sorted(brain.parameters.items())))
    return filled(
        "logged.h", brain=quoted(brain.label), mark=f"{mark & 0xFFFF:04x}", form=FORMATS.index(numbers.message),
        hash=", ".join(f"0x{byte:02x}" for byte in bytes.fromhex(brain.sha256[:16])),
        flags=FEEDBACK * numbers.feedback | SINGLE * (numbers.precision == "single"),
        parameters="".join(f"{unit.real(float(x))}, " for x in parameters),
        numbers=len(slots(brain.lengths)), owed=len(owed),
        memory="\n".join(f"    robot_log_put_numbers(log, {call});" for call in calls),
    )  # fmt: skip
