"""What is asked before a study runs on a card."""

import functools
from collections.abc import Iterable

from swarmcensus.brains import Brain
from swarmcensus.simulation import seconds
from swarmcensus.studies import Setting
from swarmcensus.support.cores import cores
from swarmcensus.translation import bare, codec_unit, number_type

WORTH = 1.0  # seconds that a card takes to start, and about those to compile for a brain


def pays_off(work: Iterable[tuple[Setting, int]]) -> bool:
    """Whether so many trials of some settings of networks take all cores longer than a card needs to start."""
    work = list(work)
    brains = {brain.as_written for setting, _ in work for brain in setting.brains}
    return sum(trials * seconds(setting) for setting, trials in work) / cores() > WORTH * (1 + len(brains))


def check_brains(brains: Iterable[Brain]) -> None:
    """Raise InputError, with the line, if one of these brains cannot be translated."""
    for brain in brains:
        _translate(brain.as_written)


@functools.cache
def _translate(brain: Brain) -> None:
    bare(brain, "", codec_unit(number_type(brain)))
