"""Which settings of a study run on a graphics card, and which on the CPU: the one place where that is chosen."""

import functools
import logging
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from swarmcensus.runs.tasks import metrics_of
from swarmcensus.studies import Setting, Study
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, wrong_option

if TYPE_CHECKING:
    from swarmcensus.gpu import Card  # runs on the CPU import nothing of it

Device = Literal["cpu", "gpu", "auto"]
DEVICES: tuple[Device, ...] = get_args(Device)
UNKNOWN = 2**31  # trials that fit the card of a worker
LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class WhereToRun:
    """The card of this process, if it runs anything, and how many trials of each setting it may run at a time.

    `room` is (setting,), and 0 for settings that run on the CPU. On a cluster the cards are those of its workers.
    """

    card: "Card | None"
    room: NDArray[np.int64]

    @property
    def on_card(self) -> NDArray[np.bool_]:
        """Which settings run on a card, (setting,)."""
        return self.room > 0

    @property
    def label(self) -> str:
        """What a results file says of the card; empty if all of it ran on CPUs."""
        if not self.on_card.any():
            return ""
        return f"gpu ({self.card.name})" if self.card else "gpu"

    def on_cpu(self, settings: Sequence[Setting]) -> list[Setting]:
        """Those of the settings that run on the CPU."""
        return [setting for setting, on_card in zip(settings, self.on_card, strict=True) if not on_card]


def check_device(device: str, cluster: bool = False) -> None:
    """Raise InputError if there is no such device, or none in this machine."""
    if device not in DEVICES:
        hint = did_you_mean(str(device), DEVICES)
        raise wrong_option("device", device, f"{hint}should be {', '.join(DEVICES[:-1])} or {DEVICES[-1]}")
    if device == "gpu" and not cluster:
        from swarmcensus.gpu import CardError

        try:
            open_card(device)
        except CardError as error:
            why = f"{option('device', device)}: {error}"
            raise CardError(why, key="device", value=device) from None


def placing_of(
    study: Study,
    settings: Sequence[Setting],
    trials: NDArray[np.int64],
    device: Device,
    *,
    local: bool = False,
    cluster: bool = False,
    quiet: bool = False,
) -> WhereToRun:
    """Choose where so many `trials` of each setting run, and say in a line what a card cannot run, unless `quiet`.

    A cluster's workers open cards of their own. Raises InputError.
    """
    check_device(device, cluster)
    all_on_cpu = WhereToRun(None, np.zeros(len(settings), np.int64))
    if device == "cpu":
        return all_on_cpu
    from swarmcensus.gpu import check_brains, pays_off, why_not

    metrics = metrics_of(study)
    card = open_card(device) if device == "gpu" and not cluster else None
    reasons = [why_not(setting, metrics) for setting in settings]
    if device == "auto":
        able = [pair for pair, why in zip(zip(settings, trials.tolist(), strict=True), reasons, strict=True) if not why]
        card = open_card(device) if pays_off(able) and not cluster else None
        if not pays_off(able) or (card is None and not cluster):
            if not quiet:
                why = "there is no card" if pays_off(able) else "too short for a card to be worth its start"
                LOG.info("%s: runs on the CPU: %s", study.name, why)
            return all_on_cpu
        if card and not quiet:
            LOG.info("%s: networks run on the card %s", study.name, card.name)
    room = np.where([not why for why in reasons], UNKNOWN, 0)
    for number in np.flatnonzero((room > 0) & (trials > 0)).tolist():
        try:
            check_brains(settings[number].brains)
            if card is not None:
                room[number] = min(card.most_trials(settings[number], metrics, way) for way in {False, local})
        except InputError as error:
            if device == "gpu":
                raise
            reasons[number], room[number] = str(error), 0
    refused = Counter(why for why, count in zip(reasons, trials.tolist(), strict=True) if why and count)
    if refused and not quiet:
        why = next(iter(refused)) if len(refused) == 1 else ", ".join(f"{w} ({n:,})" for w, n in refused.items())
        of = counted(int((trials > 0).sum()), "setting")
        LOG.info("%s: %s of %s run on the CPU: %s", study.name, f"{refused.total():,}", of, why)
    return WhereToRun(card, room)


def placing_of_study(study: Study, device: Device, quiet: bool = True) -> WhereToRun:
    """Choose where all trials of a study run. Raises InputError."""
    settings = study.settings()
    return placing_of(
        study, settings, np.full(len(settings), study.trials), device, local=study.measure.local, quiet=quiet
    )


def open_card(device: Device) -> "Card | None":
    """This process's card; None if "auto" finds none. Raises CardError."""
    from swarmcensus.gpu import CardError

    try:
        return the_card()
    except CardError:
        if device == "gpu":
            raise
        return None


@functools.cache
def the_card() -> "Card":
    """The card, opened once in a process. Raises CardError."""
    from swarmcensus.gpu import Card, open_driver

    return Card(open_driver())
