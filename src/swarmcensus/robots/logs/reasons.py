"""Why a tick was not lived again to the bit: the likeliest reason, found by trying others."""

import itertools
from collections.abc import Callable, Sequence

from swarmcensus.robots.logs.folders import LoggedRobot
from swarmcensus.robots.logs.logs import State, Tick
from swarmcensus.robots.logs.replicas import Replica, Unfit, replica_of
from swarmcensus.translation import selftest

ROUNDING = 1e-4  # relative: what another precision, or another library's exp and log, may do to an estimate
MOST_READINGS = 64  # of one tick that are tried

ANOTHER = "the robot ran another brain: the hash of its file"
WHOLE = ANOTHER, " is another brain than the robot's: ", "the robot computed in "  # reasons that hold for a whole log

Lives = Callable[[Replica, Tick], bool]


def said_before(reason: str, before: Sequence[str]) -> bool:
    """Whether a reason was given, and holds for the whole log."""
    return reason in before and any(one in reason for one in WHOLE)


def unfit_reason(member: LoggedRobot, state: State, why: str) -> str:
    """Why a brain does not fit a log."""
    return _hashes(member, state) or f"{member.brain.path} is another brain than the robot's: {why}"


def reason_of(member: LoggedRobot, first: int, at: int, replica: Replica, lives: Lives) -> str:
    """Why the tick in block `at` differs; `replica` is as before it, and came from the state in block `first`."""
    blocks = member.log.blocks
    state, tick = blocks[first], blocks[at]
    assert isinstance(state, State)
    assert isinstance(tick, Tick)
    if other := _hashes(member, state):
        return other
    before, estimate, stuck = replica.kept(), replica.estimate, replica.stuck
    if lies := _readings(tick, replica, lives):
        return lies
    precision = "double" if state.single else "single"
    if _lives_in(member, blocks[first : at + 1], state, lives):
        return f"the robot computed in {precision} precision, and its log says {_other(precision)}"
    replica.become(before, tick.tick - 1)
    replica.estimate, replica.stuck = estimate, stuck
    lives(replica, tick)
    apart = abs(replica.estimate - tick.estimate)
    if 0.0 < apart <= ROUNDING or (apart == 0.0 and not selftest.is_exact(member.brain)):
        where = (
            f"the estimate is {apart:.1e} from that of the robot" if apart else "its memory, or what it said, differs"
        )
        return f"its numbers have another precision, or another exp or log: {where}"
    if replica.said != tick.said:
        what = f"it said {_hex(tick.said)}, and its readings and messages lead to {_hex(replica.said)}"
    else:
        what = f"it believed {tick.estimate:.6g}, and its readings and messages lead to {replica.estimate:.6g}"
    return f"the log was changed, or the sensor and the log got different readings: {what}"


def _hashes(member: LoggedRobot, state: State) -> str | None:
    """The sentence if the robot's brain has another hash than the file."""
    if state.brain == bytes(8) or member.brain.sha256.startswith(state.brain.hex()):
        return None
    return f"{ANOTHER} begins with {state.brain.hex()}, and that of {member.brain.path} with {member.brain.sha256[:16]}"


def _readings(tick: Tick, replica: Replica, lives: Lives) -> str | None:
    """Which other readings give all that the log has."""
    before, estimate, stuck = replica.kept(), replica.estimate, replica.stuck
    most = min(max(tick.looks, 1), MOST_READINGS)
    for looks, blacks in itertools.product((tick.looks, *range(most + 1)), range(most + 1)):
        if blacks <= looks and (blacks, looks) != (tick.blacks, tick.looks):
            replica.become(before, tick.tick - 1)
            replica.estimate, replica.stuck = estimate, stuck
            if lives(replica, tick._replace(blacks=blacks, looks=looks)):
                return (
                    f"the log got another reading than the brain: the log has {tick.blacks} black of "
                    f"{tick.looks}, and what the robot said and held is that of {blacks} of {looks}"
                )
    return None


def _lives_in(member: LoggedRobot, blocks: Sequence[object], state: State, lives: Lives) -> bool:
    """Whether the part can be lived in the other precision."""
    try:
        replica = replica_of(member.brain, state, not state.single)
    except Unfit:
        return False
    return all(lives(replica, block) for block in blocks if isinstance(block, Tick))


def _other(precision: str) -> str:
    return "single" if precision == "double" else "double"


def _hex(said: bytes | None) -> str:
    return "nothing" if said is None else said.hex()
