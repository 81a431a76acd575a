"""When a trial settles: K of its robots, from all rounds of the trial, apart from the rounds that are shown."""

import numpy as np

from swarmcensus.live.frames import Show
from swarmcensus.simulation import convergence

MOST_VALUES = 20_000_000  # estimates of a trial; K of a larger one is not shown
AT_ONCE = 100  # robots


class Settling:
    """A trial that is computed to its end in pieces."""

    def __init__(self, show: Show) -> None:
        """Begin at round 0; robots settle when their estimates stay within the tolerance of their study."""
        self.show, self.rounds = show, show.rounds
        self._next, self._last = 0, show.trace.stretch_of(self.rounds)
        self._parts = [show.trace.start.estimates]
        self._tells = (self.rounds + 1) * show.setting.robots <= MOST_VALUES

    def on(self) -> bool:
        """Go on by one stretch; returns whether the end is reached."""
        if self._tells and self._next <= self._last:
            self._parts.append(self.show.trace.at(self._next).estimates)
            self._next += 1
        return not self._tells or self._next > self._last

    def median(self) -> float | None:
        """The median K of the honest robots that always had an estimate; None if it is not within the trial."""
        if not self._tells:
            return None
        curves = np.concatenate(self._parts)
        whole = np.flatnonzero(self.show.honest & ~np.isnan(curves).any(axis=0))
        if not whole.size:
            return None
        some = (whole[k : k + AT_ONCE] for k in range(0, whole.size, AT_ONCE))  # so that copies are small
        found = float(np.median(np.concatenate([convergence(curves[:, one], self.show.delta) for one in some])))
        return found if found < self.rounds else None
