"""Random studies of fixed networks with all that a study may have, and whether two engines give the same of them."""

import warnings

import numpy as np

import swarmcensus as sc
from swarmcensus.gpu import collecting
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation import run_batch
from tests.support.drawn import drawn
from tests.support.places import EXAMPLE

GO_ON = np.zeros(1, np.uint8)
BRAINS = (
    "minimalistic", "commons", "swift", "census", "steadfast", "sure", "tracking", "voter", "belief-sharing",
    "bayes-bots", "alone", "information-filter", "three-state", "w-msr", "oracle", "changing-floor", "recurrent",
    *(str(EXAMPLE / f"{name}.py") for name in ("pairwise", "histogram", "quiet", "sprt", "leader", "shy")),
)  # fmt: skip


def random_study(number: int, brains=BRAINS) -> sc.Study:
    """The study of this number."""
    rng = np.random.default_rng(number)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return drawn(rng, brains[rng.integers(len(brains))], longest=130, on_a_card=True)


def differences(card, study: sc.Study, trials=3, first=2) -> list[str]:
    """What differs between a card's results and the engine's, bit by bit."""
    found, metrics = [], metrics_of(study)
    for setting in study.settings():
        for local in (False, True)[: 1 + study.measure.local]:
            given = (setting, study.seed, first, trials, metrics, GO_ON, local)
            try:
                ours = run_batch(*given)
            except sc.InputError:  # with drawn parameters a brain may fail, and has no numbers to compare
                continue
            theirs = card.run_batch(*given)
            names = collecting.differences(setting, ours, theirs, local)
            found += [f"{setting}{' alone' * local}: {name}" for name in names]
    return found
