"""What is asked before a study runs on a card."""

import functools
from collections.abc import Iterable

from swarmcensus.brains import Brain
from swarmcensus.simulation import seconds
from swarmcensus.studies import Setting
from swarmcensus.translation import bare, codec_unit, number_type

WORTH = 1.0  # predicted seconds on one core, from which on a card's start is worth it


def pays_off(work: Iterable[tuple[Setting, int]]) -> bool:
    """Whether a card is faster for so many trials of some settings of networks, its start included."""
    return sum(trials * seconds(setting) for setting, trials in work) > WORTH


def check_brains(brains: Iterable[Brain]) -> None:
    """Raise InputError, with the line, if one of these brains cannot be translated."""
    for brain in brains:
        _translate(brain.as_written)


@functools.cache
def _translate(brain: Brain) -> None:
    bare(brain, "", codec_unit(number_type(brain)))
