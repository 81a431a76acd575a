"""Which tick of which robot a logged message is from. Messages have the low bytes of boot count and tick only."""

from collections import defaultdict
from collections.abc import Mapping, Sequence

from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import LoggedRobot
from swarmcensus.robots.logs.logs import Heard, State, Tick

Place = tuple[int, int]  # a robot's number, and the block of its tick


class Senders:
    """Finds the sender's tick of each message, from the logs of all robots."""

    def __init__(self, members: tuple[LoggedRobot, ...], clock: Clock) -> None:
        """Note what each robot said in each tick."""
        self.clock = clock
        self.said: dict[tuple[int, int, int], list[int]] = defaultdict(list)  # as a message names its tick: blocks
        self.blocks: Mapping[int, Sequence[object]] = {member.number: member.log.blocks for member in members}
        self.last: dict[tuple[int, int], int] = {}  # receiver and sender: the block of the last message
        for member in members:
            boot = 0
            for at, block in enumerate(member.log.blocks):
                if isinstance(block, State):
                    boot = block.boot
                elif isinstance(block, Tick):
                    self.said[member.number, boot & 0xFF, block.tick & 0xFFFF].append(at)

    def of(self, receiver: int, at: int, heard: Heard) -> Place | str:
        """The tick in which a message was said that `receiver` heard in its block `at`, or why it is not known.

        Of several ticks with the same low bytes it is the one with these bytes that is nearest in time, or, without a
        common clock, the next one after the last message of this sender. Ask in the order of the receiver's log.
        """
        known = self.said.get((heard.sender, heard.boot, heard.tick))
        if not known:
            return "missing"
        blocks = self.blocks[heard.sender]
        same = [one for one in known if blocks[one].said == heard.code]  # type: ignore[attr-defined]
        if not same:
            return "forged"
        here, last = self.clock.time(receiver, at), self.last.get((receiver, heard.sender))
        if self.clock.is_common or last is None:
            chosen = min(same, key=lambda one: abs(self.clock.time(heard.sender, one) - here))
        else:
            chosen = next((one for one in same if one > last), same[-1])
        self.last[receiver, heard.sender] = chosen
        return heard.sender, chosen
