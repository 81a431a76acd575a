"""A trial that is stepped while it is watched, by brains that may never return."""

from swarmcensus.simulation import Stepped, watched


class Simulated(Stepped):
    """One trial of a setting; a function of its brain that does not return is looked for."""

    def approach(self, k: int) -> bool:
        """Run one stretch on the way to the k-th; returns whether that is reached."""
        with watched([self.setting], self.seed, self.trial):
            return super().approach(k)
