"""Results of brains that decide, made up: what comparing is tried on where no simulation is needed."""

import itertools
import json

import numpy as np
import xarray as xr
from scipy import stats

ROBOT = ("setting", "trial", "robot")
AT = ("setting", "checkpoint", "trial")
BRAINS = ("minimalistic", "bayes-bots", "bayes-bots", "voter")
PRIORS = (np.nan, 1.0, 10.0, np.nan)
SENT = (500, 250, 250, 25)  # messages, roughly
BYTES = (8, 16, 16, 1)
MEMORY = (48, 60, 60, 8)
SAME = {"robots": 5, "fill_ratio": 0.55, "accuracy": "0.7", "assumed_accuracy": "0.7", "rounds": 500}


def made_up(brains=4, worlds=("ring", "full"), trials=20, robots=5, gap=0.0, seed=1):
    """Results of the first so many BRAINS in each world, alike but that each log error is by `gap` above the last's.

    What brains share is the trial, which worlds share too.
    """
    random = np.random.default_rng(seed)
    settings = brains * len(worlds)
    shape = settings, trials, robots
    worse = gap * np.tile(np.arange(brains), len(worlds))[:, None, None]
    shared = random.normal(size=(1, trials, 1))
    error = 0.02 * np.exp(0.5 * shared + worse + 0.3 * random.normal(size=shape))
    late = np.rint(100 * np.exp(0.3 * shared + worse + 0.3 * random.normal(size=shape)))
    sent = np.tile(SENT[:brains], len(worlds))[:, None, None] + random.integers(0, 5, shape)
    when = np.where(random.uniform(size=(settings, trials)) < 0.7, random.integers(50, 200, (settings, trials)), np.inf)

    def tiled(values):
        return "setting", np.array(list(values[:brains]) * len(worlds))

    return xr.Dataset(
        {
            "final_estimate": (ROBOT, 0.55 + error),
            "convergence_error": (ROBOT, error),
            "convergence_round": (ROBOT, late.astype(np.int32)),
            "correct": (AT, random.binomial(robots, 0.9, (settings, 1, trials)) / robots),
            "true_fill_ratio": (("setting", "trial"), np.full((settings, trials), np.nan)),
            "messages_sent": (ROBOT, sent.astype(np.float64)),
            "decision": (ROBOT, random.integers(-1, 2, shape).astype(float)),
            "consensus_right": (("setting", "trial"), (random.uniform(size=(settings, trials)) < 0.7).astype(float)),
            "consensus_round": (("setting", "trial"), when),
            "message_bytes": tiled(BYTES), "memory_bytes": tiled(MEMORY), "anonymous": tiled((1, 1, 1, 1)),
        },
        {
            "setting": np.arange(settings), "trial": np.arange(trials), "robot": np.arange(robots),
            "checkpoint": [500], "brain": tiled(BRAINS), "prior": tiled(PRIORS),
            "topology": ("setting", np.repeat(worlds, brains)),
            **{name: ("setting", np.full(settings, value)) for name, value in (SAME | {"robots": robots}).items()},
        },
        {
            "title": "made up", "truth": "nominal", "bins": 10, "delta": 0.01, "seed": 1,
            "swarmcensus_version": "0.1.0", "trials_done": settings * trials, "trials_total": settings * trials,
            "parameters": json.dumps({"bayes-bots": ["prior"]}),
        },
    )  # fmt: skip


def by_every_sign(off):
    """The two-sided p of one row: of all 2^n ways to give the differences signs, those at least as far apart."""
    off = np.array([one for one in off if one == one])
    ranks = stats.rankdata(np.abs(off))[off != 0]
    signs = np.sign(off[off != 0])
    seen = abs(ranks @ signs)
    ways = [abs(ranks @ np.array(one)) >= seen - 1e-9 for one in itertools.product((-1, 1), repeat=len(ranks))]
    return np.mean(ways) if len(ranks) else 1.0


def with_signs(off, p):
    """The p of ranks and of the number of trials on their side, together."""
    ranks, tossed = np.where(off == 0, 0, stats.rankdata(np.abs(off))), (off != 0).sum()
    ahead = (off * (ranks @ np.sign(off)) > 0).sum()
    exact, most = stats.binom.sf(ahead - 1, tossed, 0.5), stats.binom.pmf(ahead, tossed, 0.5)
    r = ranks.sum() / np.sqrt(tossed * (ranks**2).sum()) if tossed else 1
    return max(p ** (1 / r), exact - most / 2, min(2 * exact, 1) if ahead == tossed else exact / 1.2)


def by_every_deal(first, second):
    """Twice the share of ways to choose the first sample that have a sum of ranks as far on the same side."""
    ranks = stats.rankdata(np.round([*first, *second], 9))
    seen = ranks[: len(first)].sum()
    sums = np.array([sum(one) for one in itertools.combinations(ranks, len(first))])
    return min(1.0, 2 * min((sums <= seen + 1e-9).mean(), (sums >= seen - 1e-9).mean()))
