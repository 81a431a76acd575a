"""The evaluation: an ordinary run of the study, with its own seed and trials, to which the tuned brain is added."""

import contextlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.options import option
from swarmcensus.brains import Brain
from swarmcensus.results import store
from swarmcensus.results.presence import folder_of
from swarmcensus.runs.collect import Progress
from swarmcensus.runs.running import run
from swarmcensus.studies.study import Study
from swarmcensus.studies.toml_text import read_toml

MARK = "tuned: "  # titles of evaluations begin with it: an evaluation replaces no other results


def evaluation_of(study: Study, tuned: Brain, label: str) -> Study:
    """The study with the tuned brain added wherever the original appears, and with the largest number of trials.

    The tuned brain's label, `label`, becomes part of the study's name.
    """
    tables = read_toml(study.text, "study")
    changes: dict[str, Any] = {"name": f"{MARK}{label}, {study.name}", "trials": study.trials}
    if tuned not in study.swarm.brain and _has(study.swarm.brain, tuned):
        changes["swarm"] = tables["swarm"] | {"brain": [*study.swarm.brain, tuned]}
    cases = [
        table | {"brain": [*case.brain, tuned]} if case.brain and tuned not in case.brain and _has(case.brain, tuned)
        else table
        for table, case in zip(tables.get("case", []), study.case, strict=True)
    ]  # fmt: skip
    return study.with_(**changes, **({"case": cases} if cases else {}))


def _has(brains: list[Brain], original: Brain) -> bool:
    return any(brain.as_written == original.as_written for brain in brains)


def evaluate(
    study: Study,
    out: Path | None,
    jobs: int,
    show: Callable[[Progress], None],
    say: Callable[[str], None] | None,
    fresh: bool,
) -> xr.Dataset:
    """Run an evaluation; with `out` finished trials are kept there and not run again. Raises Interrupted."""
    if out is None:
        return run(study, jobs, show)
    return run(study, jobs, show, out=out, fresh=fresh or _is_of_another(out, study), say=say)


def check_replaceable(out: Path) -> None:
    """Raise InputError if `out`, or an unfinished run that writes it, holds results other than an evaluation."""
    for title in _titles(out):
        if not title.startswith(MARK):
            raise InputError(
                f"{out} holds results that no evaluation of a tuned brain made: write elsewhere with {option('out')}"
            )


def _is_of_another(out: Path, study: Study) -> bool:
    """Whether `out` holds the finished or unfinished evaluation of other values."""
    return any(title != study.name for title in _titles(out)[-1:])


def _titles(out: Path) -> list[str]:
    """The names of the study whose results `out` holds, and of the study of an unfinished run, as far as they exist."""
    titles = []
    if out.exists():
        titles.append(str(store.load(out).attrs.get("title", "")))
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
        titles.append(str(json.loads((folder_of(out) / "run.json").read_text(encoding="utf-8"))["study"]))
    return titles
