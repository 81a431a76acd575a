"""A stand-in for a card: the CPU engine computes what it runs."""

import threading

import numpy as np

from swarmcensus.gpu import Card, CardFull
from swarmcensus.runs import devices
from swarmcensus.simulation import run_batch


class FakeCard(Card):
    """A card with room for so many trials; `batches` are those that it ran, (setting, first, trials, local)."""

    name = "Fake 1"

    def __init__(self, most=1000):
        self.most, self.batches, self.threads = most, [], set()
        self.compile_for = lambda kinds, seed: None

    def most_trials(self, setting, metrics, local):
        return self.most

    def run_batch(self, setting, seed, first, trials, metrics, stop, local=False):
        batch = run_batch(setting, seed, first, trials, metrics, stop, local)
        self.threads.add(threading.get_ident())
        self.batches.append((setting, first, trials, local))
        return batch


class Fuller(FakeCard):
    """A card that says it has more room than it has."""

    room = 2

    def run_batch(self, setting, seed, first, trials, *rest):
        if trials > self.room:
            raise CardFull("the memory of Fake 1 is full")
        return super().run_batch(setting, seed, first, trials, *rest)


class Rounding(FakeCard):
    """A card that rounds final estimates otherwise."""

    def run_batch(self, *given):
        batch = super().run_batch(*given)
        batch.final[:] = np.nextafter(batch.final, 1.0)
        return batch


def put(monkeypatch, card):
    """Make it the card of this process."""
    monkeypatch.setattr(devices, "the_card", lambda: card)
    return card
