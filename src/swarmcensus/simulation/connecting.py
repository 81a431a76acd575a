"""Whether the networks of settings are connected."""

import contextlib
import functools
import warnings
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from swarmcensus.engine import Links
from swarmcensus.engine.constants import LISTED
from swarmcensus.simulation import sampling
from swarmcensus.studies import Setting
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.plugins import is_unread
from swarmcensus.worlds import Topology, components

MOST_WORK = 200_000  # the squares of numbers of robots of all networks that are looked at: a few hundredths of a second
MOST_SAID = 5  # kinds of networks in warnings


class Connections(NamedTuple):
    """Of the networks of a setting: how many were looked at, and of those that are not connected, what they are like.

    A network of directed links is connected if what any robot says reaches every other, so its components are strong.
    """

    trials: int
    looked_at: int
    apart: int  # how many of them are not connected
    components: float  # the mean number in these; NaN if there is none
    degree: float  # the mean number of robots that a robot hears

    def __str__(self) -> str:
        """In words: "49 of 50 networks are not connected"."""
        some = " that were looked at" * (self.looked_at < self.trials)
        which = f"{self.apart:,} of {counted(self.looked_at, 'network')}{some}"
        said = "its network is not" if self.looked_at == 1 else f"{which} {'is' if self.apart == 1 else 'are'} not"
        parts = f"{self.components:.3g} components{' on average' if self.apart > 1 else ''}"
        return f"{said} connected: {parts}, and a mean degree of {self.degree:.3g}"


def connections(
    setting: Setting, seed: int, trials: int, work: int = MOST_WORK, known: np.ndarray | None = None
) -> Connections:
    """Look at the networks of the first trials, as many as `work` allows, and at least at one.

    They need not be made if they are `known`, as `networks_of` gives them.
    """
    if not _hears(setting):
        return Connections(trials, trials, 0, np.nan, setting.robots - 1.0)
    if known is None or not setting.graphs_vary:
        looked_at = max(1, min(trials, work // setting.robots**2)) if setting.graphs_vary else 1
        known = networks_of(setting, sampling.links(setting, seed, 0, looked_at), looked_at)
    parts, degrees = known
    apart = parts > 1
    mean = float(parts[apart].mean()) if apart.any() else np.nan
    return Connections(trials, len(parts), int(apart.sum()), mean, float(degrees.mean()))


def networks_of(setting: Setting, links: Links, trials: int) -> np.ndarray:
    """The number of components and the mean degree of each trial's network (2, trial), given the links of all."""
    if links.mode != LISTED:
        return np.tile([[1.0], [setting.robots - 1.0]], trials)
    if not setting.graphs_vary:
        return np.tile(_of_fixed(setting.topology, setting.robots), trials)
    parts = components(setting.robots, links.receivers, links.senders, links.starts)
    return np.stack([parts, np.diff(links.starts) / setting.robots])


@functools.lru_cache(maxsize=64)
def _of_fixed(topology: Topology, robots: int) -> np.ndarray:
    """The same of a network that all trials share, (2, 1)."""
    links = topology.links(robots, 0, 0, 1, lossless=False, sums=False)
    return np.array([components(robots, links.receivers, links.senders), [len(links.receivers) / robots]], np.float64)


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
