"""What is found on a card, as the metrics of a batch."""

import numpy as np

from swarmcensus.engine import Inputs
from swarmcensus.engine.constants import CLIPPED, COVERAGE, HEARD, LISTED, SENT, VERDICTS, WIDTH, WRONG
from swarmcensus.gpu.source import Features
from swarmcensus.simulation import Batch, Metrics, consensus_of, networks_of
from swarmcensus.studies import Setting

Arrays = dict[str, np.ndarray]


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
    setting: Setting, given: Inputs, features: Features, metrics: Metrics, found: Arrays, local: bool
) -> Batch:
    """The metrics of a batch, as `simulation.run_batch` gives them."""
    trials, robots, rounds = len(given.stops), setting.robots, setting.rounds
    checks = 0 if local else len(metrics.checkpoints)
    honest = given.honest if given.honest.size else np.ones((trials, robots), np.bool_)

    def counted(array: np.ndarray) -> np.ndarray:
        """The honest robots of (trial, robot, ...)."""
        return array if honest.all() else array[honest].reshape(trials, -1, *array.shape[2:])

    counts = np.zeros((3, trials, robots), np.int64)
    if "clipped" in found:
        counts[CLIPPED] = found["clipped"]
    if features.counted and not local:
        counts[SENT], counts[HEARD] = found["sent"], found["heard"]
    elif not local:
        degrees = np.full((1, robots), robots - 1)
        if features.mode == LISTED:
            degrees = np.diff(bounds_of(given, robots), axis=1)
        counts[SENT], counts[HEARD] = rounds, max(rounds - given.radio.delay, 0) * degrees
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
    agreement = np.zeros(trials)
    if not local:
        agreement = found["agreed"].max(axis=1).astype(np.float64)
        agreement[agreement > rounds] = np.inf
    kept = None
    if metrics.estimates:
        kept = np.stack([counted(row) for row in found["kept"]]) if checks else np.empty((0, trials, 0))
    return Batch(
        convergence=counted(found["where"]),
        error=counted(np.abs(found["value"] - setting.fill_ratio)),
        final=counted(found["final"]),
        correct=found.get("right", np.empty((0, trials))),
        disagreement=found.get("widths", np.empty((0, trials))),
        agreement=agreement,
        counts=counted(counts.transpose(1, 2, 0)).transpose(0, 2, 1),
        verdicts=counted(verdicts) if features.judged else verdicts,
        consensus=consensus_of(setting, agreed, setting.fill_ratio),
        intervals=_intervals(setting, given, metrics, found, checks),
        fill_ratio=np.full(trials, setting.fill_ratio),
        kept=kept,
        networks=None if local else networks_of(setting, given.links, trials),
    )


def _intervals(setting: Setting, given: Inputs, metrics: Metrics, found: Arrays, checks: int) -> np.ndarray:
    """How robots' intervals do, (COVERAGE and WIDTH, checkpoint, trial); NaN where there are none."""
    out = np.full((2, checks, len(given.stops)), np.nan)
    if "bounds_of" in found:
        low, high = found["bounds_of"][:, :, 0], found["bounds_of"][:, :, 1]
        truths = setting.fill_ratios(np.array(metrics.checkpoints, np.int64))[:, np.newaxis, np.newaxis]
        asked = _robots_to_ask(setting, given)
        counted = np.where(asked.any(axis=1), asked.sum(axis=1), np.nan)
        out[COVERAGE] = (asked & (low <= truths) & (truths <= high)).sum(axis=2) / counted
        # one after another, as the engine adds them up
        out[WIDTH] = np.cumsum(np.where(asked, high - low, 0.0), axis=2)[..., -1] / counted
    return out
