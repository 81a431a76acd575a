"""What came of a batch of trials, by the names of the dataset's variables."""

import numpy as np

from swarmcensus.engine.constants import (
    CHANGED,
    COVERAGE,
    DECIDED_IN,
    DECISION,
    DONE_ESTIMATE,
    DONE_IN,
    HEARD,
    SENT,
    VERDICTS,
    WIDTH,
)
from swarmcensus.results.values import Columns
from swarmcensus.simulation.trials import Batch, Metrics


def columns(batch: Batch, local: bool, metrics: Metrics) -> Columns:
    """What came of some trials, by the variables' names; without the dimension `setting`.

    Variables of decisions are there if any brain of the study decides, NaN of one that does not; those of intervals
    likewise.
    """
    if local:
        return {
            "local_convergence_step": batch.convergence.astype(np.int32),
            "local_convergence_error": batch.error,
        }
    filled, sure = batch.true_fill_ratio, batch.intervals
    kept = {} if batch.kept is None else {"estimates": batch.kept}
    return (
        batch.watched
        | kept
        | _decided(batch, metrics)
        | ({"coverage": sure[COVERAGE], "interval_width": sure[WIDTH]} if metrics.intervals else {})
        | {
            "convergence_round": batch.convergence.astype(np.int32),
            "convergence_error": batch.error,
            "final_estimate": batch.final,
            "correct": batch.correct,
            "true_fill_ratio": np.full(len(batch.final), np.nan) if filled is None else filled,
            "messages_sent": batch.counts[:, SENT].astype(np.float64),
            "messages_heard": batch.counts[:, HEARD].astype(np.float64),
        }
    )


def _decided(batch: Batch, metrics: Metrics) -> Columns:
    """What robots decided, and when they were done."""
    verdicts = batch.verdicts
    if not verdicts.size and (metrics.decides or metrics.ends):
        verdicts = np.full((*batch.final.shape, VERDICTS), np.nan)
    found: Columns = {}
    if metrics.decides:
        places = {"decision": DECISION, "decision_round": DECIDED_IN, "decision_change": CHANGED}
        no_one = np.isnan(batch.consensus[:, :1])  # decides, and somebody may yet be done
        found |= {name: np.where(no_one, np.nan, verdicts[..., place]) for name, place in places.items()}
        names = ("consensus", "consensus_round", "consensus_right", "right_option")
        found |= {name: batch.consensus[:, k] for k, name in enumerate(names)}
    if metrics.ends:
        found |= {"done_round": verdicts[..., DONE_IN], "done_estimate": verdicts[..., DONE_ESTIMATE]}
    return found
