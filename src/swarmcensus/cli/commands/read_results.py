"""The commands `show`, `merge` and `verify`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from swarmcensus.cli.messages import reporting
from swarmcensus.cli.parameters import (
    FILE,
    NUMBER,
    USUAL,
    WHEN,
    WHOLE,
    BrainFiles,
    Hardware,
    Labels,
    Results,
    Where,
    exclusive,
    path,
    takes,
)  # fmt: skip
from swarmcensus.cli.source import read
from swarmcensus.support.answers import Answer
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option_conflict

SEVERAL = takes(path, "RESULTS.nc", several=True)


def show(
    results: Results, /, *, where: Where = None,
    checkpoint: Annotated[Any, WHEN] = None, sort: str | None = None, reverse: bool = False, label: Labels = (),
) -> Answer:  # fmt: skip
    """Print a summary of results, one row per setting.

    Args:
        checkpoint: count right decisions at this round, or at a time such as '5 min' (default: the last checkpoint)
        sort: sort by a column, such as 'final error', right, K or fill_ratio (default: as stored)
        reverse: reverse the order of --sort
    """
    stored, data = read(results, where, label, logs=True)
    from swarmcensus.results import round_of
    from swarmcensus.summaries import Summary, cautions_of, failures, summaries
    from swarmcensus.support.quantities import SEARCHED

    if reverse and not sort:
        raise option_conflict("reverse", None, "needs --sort")
    if SEARCHED in stored.attrs:
        from swarmcensus.search import Candidates

        return Candidates(data, results, sort, reverse)
    at, asked = round_of(data, checkpoint, "--checkpoint"), "final_error" if checkpoint is None else "correct"
    if sort:
        data, asked = summaries.sort_settings(data, sort, reverse, at)
    return Summary(stored, data, at, results, [*cautions_of(data), *failures(data)], asked)


def merge(results: Annotated[Sequence[Path], SEVERAL], /, *, out: Annotated[Path, FILE], fresh: bool = False) -> Answer:
    """Merge results with different settings or trials.

    Args:
        results: results files to merge
        out: file of the merged results, which ends in .nc
        fresh: replace --out if it is there
    """
    from swarmcensus.results import check_there, merging
    from swarmcensus.support.files import check_output

    for one in results:
        check_there(one)
    check_output("out", out, (".nc",))
    data = merging.write(out, results, fresh=fresh)
    done, total = data.attrs["trials_done"], data.attrs["trials_total"]
    return Answer(files={out: f"{counted(data.sizes['setting'], 'setting')}, {done:,} of {counted(total, 'trial')}"})


WHICH = exclusive()


def verify(
    results: Results, /, *, sample: Annotated[float, NUMBER, WHICH] = 0.01, all: Annotated[bool, WHICH] = False,
    brain_file: BrainFiles = (), hardware: Hardware = USUAL, seed: Annotated[int | None, WHOLE] = None,
) -> Answer:  # fmt: skip
    """Run trials again, and compare them bit for bit.

    The exit code is 1 if they differ.

    Args:
        sample: share of the trials to check (default: 0.01)
        all: check every trial
        seed: seed of the sample, to check the same trials again
    """
    from swarmcensus.results import check_there

    check_there(results)
    if all and seed is not None:
        raise option_conflict("seed", seed, "is for a sample: it does not go with --all")
    from swarmcensus.runs import verifying

    with reporting("verify") as progress:
        return verifying.verify(
            results, 1.0 if all else sample, brain_file=brain_file, seed=seed, progress=progress, **vars(hardware)
        )  # fmt: skip
