"""When each tick of each robot was: by a common clock where all logs know the time, else by the robots' own ticks."""

from swarmcensus.reliving.folders import Member
from swarmcensus.reliving.logs import State, Tick


class Clock:
    """Times of blocks, in ticks, from the first start of any robot on."""

    def __init__(self, members: tuple[Member, ...]) -> None:
        """Read the starts of all robots."""
        starts = [state for member in members for state in member.log.states]
        self.restarted = any(len({state.boot for state in member.log.states}) > 1 for member in members)
        self.is_common = self.restarted and all(state.now for state in starts)
        begun = min(state.now for state in starts)
        times = {member.number: self._times(member, begun) for member in members}
        first = min(of_robot[0] for of_robot in times.values())  # logs may begin after many ticks
        self.times = {number: [time - first for time in of_robot] for number, of_robot in times.items()}

    def time(self, robot: int, at: int) -> int:
        """The time of a block: 0 at the start, 1 after the first tick."""
        return self.times[robot][at]

    @property
    def rounds(self) -> int:
        """The time of the last block of all."""
        return max(max(times) for times in self.times.values())

    def _times(self, member: Member, begun: int) -> list[int]:
        times: list[int] = []
        time, boot = 0, -1
        shift = 0  # from a tick's number to its time
        for block in member.log.blocks:
            if isinstance(block, State):
                if block.boot != boot:
                    boot = block.boot
                    after = round((block.now - begun) / max(block.period, 1)) if self.is_common else time
                    # without a clock nothing is known of the time between two boots
                    shift = max(after, time) - block.tick if times else after - (block.tick if self.is_common else 0)
                time = block.tick + shift
            elif isinstance(block, Tick):
                time = block.tick + shift
            times.append(time)
        return times
