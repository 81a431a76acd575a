"""Commands that read results: `show`, `merge`, `verify`, `export`. Imports wait until needed."""

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from swarmcensus.basics.counting import counted
from swarmcensus.basics.errors import InputError
from swarmcensus.cli.options import MOST_ROWS
from swarmcensus.cli.output import answer, reporting, wrote

if TYPE_CHECKING:
    from swarmcensus.runs.verifying import Verification

DIFFER = 1  # results that do not come out again as stored


def show(options: argparse.Namespace) -> int:
    """Print the summary of a results file."""
    from swarmcensus.cli import tables
    from swarmcensus.results import selecting, summaries
    from swarmcensus.results.cautions import warn_of_edges, warn_of_start
    from swarmcensus.results.early import opened
    from swarmcensus.results.remeasuring import remeasure
    from swarmcensus.results.source_study import round_of

    stored = remeasure(opened(options.results), delta=options.delta, bins=options.bins)
    data = selecting.where(stored, options.where)
    checkpoint = round_of(data, options.checkpoint, "--checkpoint")
    if options.sort:
        data = summaries.ordered(data, options.sort, options.reverse, checkpoint)
    elif options.reverse:
        raise InputError("--reverse goes with --sort")
    if options.json:
        few = data.isel(setting=slice(options.limit or None))
        answer("summary", summaries.told_of(stored, few, checkpoint))
        return 0
    limit = MOST_ROWS if options.limit is None else options.limit
    title = tables.head(stored, options.results)
    tables.settings(data, options.results, limit, checkpoint, title, _again(options))
    tables.failures(data)
    warn_of_start(data)
    warn_of_edges(data)
    return 0


def _again(options: argparse.Namespace) -> str:
    """The command `show` with what it was given, but for --limit."""
    words = ["swarmcensus", "show", str(options.results)]
    for name in ("where", "bins", "delta", "checkpoint", "sort"):
        value = getattr(options, name)
        words += [f"--{name}", str(value)] if value is not None else []
    return shlex.join([*words, *(["--reverse"] if options.reverse else [])])


def merge(options: argparse.Namespace) -> int:
    """Put results together."""
    from swarmcensus.results import merging

    if options.out.suffix != ".nc":
        raise InputError(f"--out {options.out}: results are written as .nc")
    data = merging.write(options.out, options.results, fresh=options.fresh)
    done, total = data.attrs["trials_done"], data.attrs["trials_total"]
    wrote(f"{options.out}: {counted(data.sizes['setting'], 'setting')}, {done:,} of {counted(total, 'trial')}")
    return 0


def verify(options: argparse.Namespace) -> int:
    """Run trials again and compare; 1 where they differ."""
    import secrets

    from swarmcensus.runs import verifying

    if options.all and options.seed is not None:
        raise InputError(f"--seed {options.seed} chooses a sample: it does not go with --all")
    seed = secrets.randbelow(2**31) if options.seed is None else options.seed
    sample = 1.0 if options.all else options.sample
    with reporting("verify") as progress:
        found = verifying.verify(
            options.results, sample, brain=options.brain, seed=seed, jobs=options.jobs, progress=progress
        )
    if options.json:
        about = {"results": options.results, "trials_checked": found.checked, "trials_stored": found.stored}
        about |= {"seed": None if options.all else seed, "differences": found.differences}
        said = {"labels": found.labels, "notes": found.notes, "unchecked": found.unchecked}
        answer("verification", about | said)
        return _code(found)
    for difference in (*found.labels, *found.differences):
        print(difference)
    what = f"{found.checked:,} of {counted(found.stored, 'trial')} run again" + (
        "" if options.all else f" (--seed {seed})"
    )
    same = "the numbers are the same to the last bit" if found.labels or found.notes else "the same to the last bit"
    same = same if found.checked else "none of them is of a study that can be run"
    differ = f"{len(found.differences):,} differ" if found.differences else same
    labels = [f"{len(found.labels):,} of the file's labels are not its study's"] if found.labels else []
    print("; ".join([f"{options.results}: {what}: {differ}", *labels, *found.notes]))
    print("not compared:", *found.unchecked, sep="\n  ")
    return _code(found)


def _code(found: "Verification") -> int:
    return DIFFER if found.differences or found.labels else 0


def export(options: argparse.Namespace) -> int:
    """Write results as a table."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.results import store
    from swarmcensus.results.early import opened, say_partial
    from swarmcensus.results.remeasuring import remeasure
    from swarmcensus.results.selecting import where

    kinds = {".csv": "csv", ".parquet": "parquet"}
    kind = options.to or (kinds.get(options.out.suffix.lower(), "csv") if options.out else "csv")
    out = options.out or Path(f"{options.results.stem}.{kind}")
    if kinds.get(out.suffix.lower(), kind) != kind:
        raise InputError(f"--out {out}: --to {kind} is written as .{kind}")
    check_writable(out, options.results)
    data = remeasure(opened(options.results), delta=options.delta)
    say_partial(data, options.results)
    rows = store.export(where(data, options.where), out, kind)
    wrote(f"{out}: {counted(rows, 'row')}")
    return 0
