"""How a tick differs that was not lived again to the bit: by another brain's file, or in which part."""

from collections.abc import Sequence

from swarmcensus.robots.logs.folders import LoggedRobot
from swarmcensus.robots.logs.logs import State, Tick
from swarmcensus.robots.logs.replicas import Replica

ANOTHER = "the robot ran another brain: the hash of its file"
WHOLE = ANOTHER, " is another brain than the robot's: "  # reasons that hold for a whole log


def said_before(reason: str, before: Sequence[str]) -> bool:
    """Whether a reason was given, and holds for the whole log."""
    return reason in before and any(one in reason for one in WHOLE)


def unfit_reason(member: LoggedRobot, state: State, why: str) -> str:
    """Why a brain does not fit a log."""
    return _hashes(member, state) or f"{member.brain.path} is another brain than the robot's: {why}"


def reason_of(member: LoggedRobot, state: State, tick: Tick, replica: Replica) -> str:
    """How `replica`, after this tick, differs from the log; it came from `state`."""
    if other := _hashes(member, state):
        return other
    if replica.said != tick.said:
        return f"its message differs: {_hex(tick.said)} in the log, {_hex(replica.said)} computed again"
    if replica.estimate != tick.estimate:
        return f"its estimate differs: {tick.estimate:.17g} in the log, {replica.estimate:.17g} computed again"
    return "its memory differs, or the random numbers that it drew"


def _hashes(member: LoggedRobot, state: State) -> str | None:
    """The sentence if the robot's brain has another hash than the file."""
    if state.brain == bytes(8) or member.brain.sha256.startswith(state.brain.hex()):
        return None
    return f"{ANOTHER} begins with {state.brain.hex()}, and that of {member.brain.path} with {member.brain.sha256[:16]}"


def _hex(said: bytes | None) -> str:
    return "nothing" if said is None else said.hex()
