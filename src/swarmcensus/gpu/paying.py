"""When a card is faster than this machine's cores."""

from collections.abc import Iterable

from swarmcensus.simulation import seconds
from swarmcensus.studies import Setting

WORTH = 1.0  # predicted seconds on one core, from which on a card's start is worth it


def pays_off(work: Iterable[tuple[Setting, int]]) -> bool:
    """Whether a card is faster for so many trials of some settings of networks, its start included."""
    return sum(trials * seconds(setting) for setting, trials in work) > WORTH
