"""What runs a study, and which of its settings a graphics card runs: the one place where that is chosen."""

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
from swarmcensus.support.cores import cores
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, wrong_option

if TYPE_CHECKING:
    from swarmcensus.gpu import Card  # runs on the CPU import nothing of it

Device = Literal["cpu", "gpu", "auto"]
DEVICES: tuple[Device, ...] = get_args(Device)
MOST_JOBS = 256  # threads, or cores if the machine has more: threads take memory, and more than cores do not help
UNKNOWN = 2**31  # trials that fit the card of a worker
LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Hardware:
    """What runs studies: so many threads, by default one per core, or the workers of a cluster; and their cards."""

    jobs: int | None = None
    device: Device = "cpu"
    cluster: str | None = None  # the address of a Dask scheduler

    def __post_init__(self) -> None:
        """Raise InputError for a wrong number, address or device, or if this machine should have a card."""
        if self.jobs is not None and self.jobs not in range(1, (most := max(MOST_JOBS, cores())) + 1):
            should = f"should be 1 to {most:,} threads; more threads than cores ({cores()}) are not faster"
            raise wrong_option("jobs", self.jobs, should)
        if self.cluster is not None and "://" not in str(self.cluster):
            should = "should be the address of a Dask scheduler, as tcp://host:8786"
            raise wrong_option("cluster", self.cluster, should)
        if self.device not in DEVICES:
            hint = did_you_mean(str(self.device), DEVICES)
            raise wrong_option("device", self.device, f"{hint}should be {', '.join(DEVICES[:-1])} or {DEVICES[-1]}")
        if self.device == "gpu" and self.cluster is None:
            from swarmcensus.gpu import CardError

            try:
                open_card(self.device)
            except CardError as error:
                why = f"{option('device', self.device)}: {error}"
                raise CardError(why, key="device", value=self.device) from None

    @property
    def threads(self) -> int:
        """How many threads of this process run trials."""
        return cores() if self.jobs is None else self.jobs


@dataclass(frozen=True)
class WhereToRun:
    """What runs a study: a card, if it has work, runs up to `room` trials of a setting at a time, the CPU the others.

    `room` is (setting,), and 0 for settings that run on the CPU. On a cluster the cards are those of its workers.
    """

    hardware: Hardware
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


def placing_of(
    hardware: Hardware,
    study: Study,
    settings: Sequence[Setting],
    trials: NDArray[np.int64] | int,
    *,
    local: bool | None = None,
    quiet: bool = False,
) -> WhereToRun:
    """Choose where so many `trials` of each setting run, and say in a line what a card cannot run, unless `quiet`.

    They have local estimates if `local`, by default as the study says. A cluster's workers open cards of their own.
    Raises InputError.
    """
    device, here = hardware.device, hardware.cluster is None
    all_on_cpu = WhereToRun(hardware, None, np.zeros(len(settings), np.int64))
    if device == "cpu":
        return all_on_cpu
    from swarmcensus.gpu import check_brains, pays_off, why_not

    metrics, trials = metrics_of(study), np.broadcast_to(trials, len(settings))
    ways = {False, study.measure.local if local is None else local}
    card = open_card(device) if device == "gpu" and here else None
    reasons = [why_not(setting, metrics) for setting in settings]
    if device == "auto":
        able = [pair for pair, why in zip(zip(settings, trials.tolist(), strict=True), reasons, strict=True) if not why]
        card = open_card(device) if pays_off(able) and here else None
        if not pays_off(able) or (card is None and here):
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
                room[number] = min(card.most_trials(settings[number], metrics, way) for way in ways)
        except InputError as error:
            if device == "gpu":
                raise
            reasons[number], room[number] = str(error), 0
    refused = Counter(why for why, count in zip(reasons, trials.tolist(), strict=True) if why and count)
    if refused and not quiet:
        why = next(iter(refused)) if len(refused) == 1 else ", ".join(f"{w} ({n:,})" for w, n in refused.items())
        of = counted(int((trials > 0).sum()), "setting")
        LOG.info("%s: %s of %s run on the CPU: %s", study.name, f"{refused.total():,}", of, why)
    return WhereToRun(hardware, card, room)


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
