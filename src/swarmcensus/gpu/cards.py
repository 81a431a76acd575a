"""A card that runs batches of networks."""

import numpy as np

from swarmcensus.gpu.driver import CardError, Driver
from swarmcensus.simulation import Batch, Metrics
from swarmcensus.studies import Setting


def why_not(setting: Setting, metrics: Metrics) -> str | None:
    """Why a card cannot run a setting, in words that follow "as"; None if it can."""
    if setting.body is not None:
        return "robots move"
    if metrics.watched:
        return "metric files are measured"
    return None


class Card:
    """Runs batches on the card of a driver."""

    def __init__(self, driver: Driver) -> None:
        """Use the card."""
        self.driver, self.name = driver, driver.name

    def most_trials(self, setting: Setting, metrics: Metrics, local: bool) -> int:
        """How many trials fit the free memory. Raises CardFull where one does not."""
        raise CardError("this version runs nothing on a card")

    def run_batch(
        self,
        setting: Setting,
        seed: int,
        first: int,
        trials: int,
        metrics: Metrics,
        stop: np.ndarray,
        local: bool = False,
    ) -> Batch | None:
        """Run trials as `simulation.run_batch` does; None if `stop` was set meanwhile."""
        raise CardError("this version runs nothing on a card")
