"""Whether the networks of settings are connected."""

import contextlib
import warnings
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from swarmcensus.engine.constants import LISTED
from swarmcensus.simulation import sampling
from swarmcensus.studies import Setting
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.plugins import is_unread
from swarmcensus.worlds import components

MOST_WORK = 200_000  # the squares of numbers of robots of all networks that are looked at: a few hundredths of a second
MOST_SAID = 5  # kinds of networks in warnings


class Connections(NamedTuple):
    """Of the networks of a setting: how many were looked at, and of those that are not connected, what they are like.

    A network of directed links is connected if what any robot says reaches every other, so its components are strong.
    """

    looked_at: int
    apart: int  # how many of them are not connected
    components: float  # the mean number in these; NaN if there is none
    degree: float  # the mean number of robots that a robot hears

    def __str__(self) -> str:
        """In words: "49 of 50 networks that were looked at are not connected"."""
        which = f"{self.apart:,} of {counted(self.looked_at, 'network')} that were looked at"
        said = "its network is not" if self.looked_at == 1 else f"{which} {'is' if self.apart == 1 else 'are'} not"
        parts = f"{self.components:.3g} components{' on average' if self.apart > 1 else ''}"
        return f"{said} connected: {parts}, and a mean degree of {self.degree:.3g}"


def connections(setting: Setting, seed: int, trials: int, work: int = MOST_WORK) -> Connections:
    """Look at the networks of the first trials, as many as `work` allows, and at least at one."""
    looked_at = max(1, min(trials, work // setting.robots**2)) if setting.graphs_vary else 1
    found = sampling.links(setting, seed, 0, looked_at) if _hears(setting) else None
    if found is None or found.mode != LISTED:
        return Connections(looked_at, 0, np.nan, setting.robots - 1.0)
    graphs = [slice(*found.starts[k : k + 2]) for k in range(looked_at)]
    parts = np.array([components(setting.robots, found.receivers[g], found.senders[g]) for g in graphs])
    apart = parts > 1
    mean = float(parts[apart].mean()) if apart.any() else np.nan
    return Connections(looked_at, int(apart.sum()), mean, len(found.receivers) / looked_at / setting.robots)


def warn_of_connections(settings: Iterable[Setting], seed: int, trials: int) -> None:
    """Warn of networks that are not connected, for the line that called the caller."""
    kinds = {(s.topology, s.robots, s.missing_links): s for s in settings if _hears(s)}
    sentences = []
    for (topology, robots, missing), setting in kinds.items():
        with contextlib.suppress(InputError):  # of a network that cannot be made: the trial that needs it says so
            found = connections(setting, seed, trials, MOST_WORK // len(kinds))
            if not found.apart:
                continue
            missing_links = f" with missing_links = {missing:g}" if missing else ""
            sentences.append(f"topology {topology.title!r} of {counted(robots, 'robot')}{missing_links}: {found}")
    if len(sentences) > MOST_SAID:
        sentences[MOST_SAID:] = [f"{counted(len(sentences) - MOST_SAID, 'more kind')} of networks are not connected"]
    for sentence in sentences:
        warnings.warn(sentence, stacklevel=3)


def _hears(setting: Setting) -> bool:
    """Whether anything depends on a network's links, and these are known."""
    brain = setting.brain
    if is_unread(setting.topology.named):
        return False
    return setting.body is None and setting.link_success > 0.0 and not brain.is_oracle and not brain.never_speaks
