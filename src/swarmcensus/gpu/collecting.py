"""What is found on a card, as the metrics of a batch."""

from dataclasses import fields, replace

import numpy as np

from swarmcensus.engine import Inputs, Tally
from swarmcensus.engine.constants import CLIPPED, COVERAGE, HEARD, LISTED, SENT, VERDICTS, WIDTH, WRONG
from swarmcensus.gpu.source import Features
from swarmcensus.simulation import Batch, Metrics, batch_of as batch, measures_of, networks_of
from swarmcensus.studies import Setting
from swarmcensus.translation import selftest

Arrays = dict[str, np.ndarray]
FOUND = ("where", "value", "final", "correct", "disagreement", "kept")  # as in `Measures`


def differences(setting: Setting, ours: Batch, theirs: Batch, local: bool) -> list[str]:
    """The names of what differs between two batches of the same trials.

    One number in a hundred may where brains use functions that machines round in ways of their own, such as exp.
    """
    exact, close = all(map(selftest.is_exact, setting.brains)), 1e-4 if setting.precision == "single" else 1e-9
    found = []
    for name in ("convergence", "error", "final") if local else [one.name for one in fields(ours)]:
        x, y = getattr(ours, name), getattr(theirs, name)
        if name == "verdicts":
            x, y = x[..., :-1], y[..., :-1]  # the last one is of invalid decisions
        if not isinstance(x, np.ndarray) or np.array_equal(x, y, equal_nan=True):
            continue
        if exact or x.shape != y.shape or np.isclose(x, y, rtol=0.0, atol=close, equal_nan=True).mean() < 0.99:
            found.append(name)
    return found


def bounds_of(given: Inputs, robots: int) -> np.ndarray:
    """Where the links of each robot begin, (graph, robot + 1)."""
    links = given.links
    graphs = np.repeat(np.arange(links.starts.size - 1), np.diff(links.starts))
    heard = np.bincount(graphs * robots + links.receivers, minlength=(links.starts.size - 1) * robots)
    ends = np.cumsum(heard).reshape(-1, robots)
    return np.concatenate([links.starts[:-1, np.newaxis], ends + links.starts[0]], axis=1)


def are_wrong(setting: Setting, given: Inputs, found: Arrays) -> bool:
    """Whether an interval is none."""
    if "bounds_of" not in found:
        return False
    low, high = found["bounds_of"][:, :, 0], found["bounds_of"][:, :, 1]
    return bool((_robots_to_ask(setting, given) & ~((low >= 0.0) & (low <= high) & (high <= 1.0))).any())


def _robots_to_ask(setting: Setting, given: Inputs) -> np.ndarray:
    """Which robots count and have an interval, (trial, robot)."""
    honest = given.honest if given.honest.size else np.ones((len(given.stops), setting.robots), np.bool_)
    groups = given.group if given.group.size else np.zeros(honest.shape, np.int64)
    return np.asarray(honest & np.array([brain.has_interval for brain in setting.brains])[groups])


def batch_of(
    setting: Setting, given: Inputs, features: Features, metrics: Metrics, found: Arrays, bounds: np.ndarray,
    local: bool,
) -> Batch:  # fmt: skip
    """The metrics of a batch, as `simulation.run_batch` gives them; `bounds` are those of links, see `bounds_of`."""
    trials, robots, rounds = len(given.stops), setting.robots, setting.rounds
    if local:
        metrics = replace(metrics, checkpoints=())
    measures = measures_of(setting, trials, metrics)._replace(**{k: found[k] for k in FOUND if k in found})  # type: ignore[arg-type]
    counts = np.zeros((trials, 3, robots), np.int64)
    if "clipped" in found:
        counts[:, CLIPPED] = found["clipped"]
    if features.counted and not local:
        counts[:, SENT], counts[:, HEARD] = found["sent"], found["heard"]
    elif not local:
        degrees = np.full((1, robots), robots - 1)
        if features.mode == LISTED:
            degrees = np.diff(bounds, axis=1)
        counts[:, SENT], counts[:, HEARD] = rounds, max(rounds - given.radio.delay, 0) * degrees
    agreed = np.full((trials, 2), (-1.0, np.inf))
    verdicts = np.empty((trials, 0, VERDICTS))
    if features.judged:
        verdicts = np.full((trials, robots, VERDICTS), np.nan)
        verdicts[..., :6] = found["verdicts"]
        verdicts[..., WRONG] = -1.0
        options = found["unanimous"]
        when = np.argmax(options >= 0, axis=1)
        option = options[np.arange(trials), when]
        agreed[option >= 0] = np.column_stack([option, when + 1.0])[option >= 0]
    if not local:
        measures.agreement[:] = found["agreed"].max(axis=1)
        measures.agreement[measures.agreement > rounds] = np.inf
    sure = _intervals(setting, given, metrics, found)
    made = batch(setting, given, metrics, measures, Tally(counts, verdicts, agreed), sure)
    return replace(made, networks=None if local else networks_of(setting, given.links, trials))


def _intervals(setting: Setting, given: Inputs, metrics: Metrics, found: Arrays) -> np.ndarray:
    """How robots' intervals do, (COVERAGE and WIDTH, checkpoint, trial); NaN where there are none."""
    out = np.full((2, len(metrics.checkpoints), len(given.stops)), np.nan)
    if "bounds_of" in found:
        low, high = found["bounds_of"][:, :, 0], found["bounds_of"][:, :, 1]
        truths = setting.fill_ratios(np.array(metrics.checkpoints, np.int64))[:, np.newaxis, np.newaxis]
        asked = _robots_to_ask(setting, given)
        counted = np.where(asked.any(axis=1), asked.sum(axis=1), np.nan)
        out[COVERAGE] = (asked & (low <= truths) & (truths <= high)).sum(axis=2) / counted
        # one after another, as the engine adds them up
        out[WIDTH] = np.cumsum(np.where(asked, high - low, 0.0), axis=2)[..., -1] / counted
    return out
