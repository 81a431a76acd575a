"""The evaluation: the tuned brain beside all that the study has, on the study's own seed and trials, as any run."""

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

MARK = "tuned: "  # how the titles of evaluations begin: no other results are ever replaced by one


def evaluation_of(study: Study, tuned: Brain, told: str) -> Study:
    """The same study with one brain more, wherever it has that brain, and with its number of trials at the most.

    What is `told` of the tuned brain becomes part of the study's name.
    """
    tables = read_toml(study.text, "study")
    changes: dict[str, Any] = {"name": f"{MARK}{told}, {study.name}", "trials": study.trials}
    if tuned not in study.swarm.brain and _has(study.swarm.brain, tuned):
        changes["swarm"] = tables["swarm"] | {"brain": [*study.swarm.brain, tuned]}
    cases = [
        table | {"brain": [*case.brain, tuned]} if case.brain and tuned not in case.brain and _has(case.brain, tuned)
        else table
        for table, case in zip(tables.get("case", []), study.case, strict=True)
    ]  # fmt: skip
    return study.with_(**changes, **({"case": cases} if cases else {}))


def _has(brains: list[Brain], one: Brain) -> bool:
    return any(brain.as_written == one.as_written for brain in brains)


def evaluate(
    study: Study,
    out: Path | None,
    jobs: int,
    show: Callable[[Progress], None],
    say: Callable[[str], None] | None,
    fresh: bool,
) -> xr.Dataset:
    """Run an evaluation; with `out` what is finished is kept there, and not run again. Raises Interrupted."""
    if out is None:
        return run(study, jobs, show)
    return run(study, jobs, show, out=out, fresh=fresh or _is_of_another(out, study), say=say)


def check_replaceable(out: Path) -> None:
    """Raise InputError where `out` holds, or a run that was cut off was to write there, what is no evaluation."""
    for title in _titles(out):
        if not title.startswith(MARK):
            raise InputError(
                f"{out} holds results that no evaluation of a tuned brain made: write elsewhere with {option('out')}"
            )


def _is_of_another(out: Path, study: Study) -> bool:
    """Whether there is, or was begun, the evaluation of other values."""
    return any(title != study.name for title in _titles(out)[-1:])


def _titles(out: Path) -> list[str]:
    """The names of the study whose results are there, and of that which was to replace it."""
    titles = []
    if out.exists():
        titles.append(str(store.load(out).attrs.get("title", "")))
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
        titles.append(str(json.loads((folder_of(out) / "run.json").read_text(encoding="utf-8"))["study"]))
    return titles
