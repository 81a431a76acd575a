"""The commands `show`, `merge` and `verify`. Imports wait until a command needs them."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from swarmcensus.cli.options import Command, Group, add_shared, from_zero, round_or_time
from swarmcensus.cli.output import answer, present, reporting, wrote
from swarmcensus.cli.source import MOST_ROWS, add_limit_option, add_results, add_source_options, again, read
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import misplaced

if TYPE_CHECKING:
    from swarmcensus.runs import Verification

SHOW_OPTIONS = ("checkpoint", "sort", "reverse", "label")  # options of `show` in addition to the source options
DIFFER = 1  # exit code of `verify` if results differ


def add_show_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `show`."""
    add_source_options(sub)
    sub.add_argument(
        "--checkpoint",
        type=round_or_time,
        metavar="K",
        help="count right decisions at this round, or at a time such as '5 min' (default: the last checkpoint)",
    )
    sub.add_argument(
        "--sort",
        metavar="COLUMN",
        help="sort by a column, such as 'final error', right, K or fill_ratio (default: as stored)",
    )
    sub.add_argument("--reverse", action="store_true", help="reverse the order of --sort")
    add_shared(sub, "label")
    add_limit_option(sub, "; with --json and in a pipe: all")


def show(options: argparse.Namespace) -> int:
    """Print a summary of a results file."""
    from swarmcensus.cli import tables
    from swarmcensus.results import round_of, summaries, warn_of

    stored, data = read(options)
    checkpoint = round_of(data, options.checkpoint, "--checkpoint")
    if options.sort:
        data = summaries.ordered(data, options.sort, options.reverse, checkpoint)
    elif options.reverse:
        raise misplaced("reverse", None, "needs --sort")
    shown = data.isel(setting=slice(options.limit or None))
    limit = MOST_ROWS if options.limit is None else options.limit
    title, line = tables.head(stored, options.results), again(options, "show", SHOW_OPTIONS)
    present(
        options,
        "summary",
        lambda: summaries.as_dict(stored, shown, checkpoint),
        lambda: tables.as_rows(shown, checkpoint),
        lambda: tables.settings(data, options.results, limit, checkpoint, title, line),
    )
    if options.json:
        return 0
    tables.failures(data)
    warn_of(data)
    return 0


def add_merge_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `merge`."""
    add_results(sub, text="results files to merge", nargs="+")
    sub.add_argument("--out", type=Path, metavar="FILE.nc", required=True, help="file of the merged results")
    sub.add_argument(
        "--fresh", action="store_true", help="replace --out even if it holds trials that the merged files lack"
    )


def merge(options: argparse.Namespace) -> int:
    """Merge results files into one."""
    from swarmcensus.results import merging
    from swarmcensus.support.files import check_output

    check_output("out", options.out, (".nc",))
    data = merging.write(options.out, options.results, fresh=options.fresh)
    done, total = data.attrs["trials_done"], data.attrs["trials_total"]
    wrote(f"{options.out}: {counted(data.sizes['setting'], 'setting')}, {done:,} of {counted(total, 'trial')}")
    return 0


def add_verify_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `verify`."""
    add_results(sub)
    which = sub.add_mutually_exclusive_group()
    which.add_argument(
        "--sample",
        type=float,
        default=0.01,
        metavar="SHARE",
        help="share of the trials to check (default: %(default)s)",
    )
    which.add_argument("--all", action="store_true", help="check every trial")
    add_shared(sub, "brain_file", "jobs", "device")
    sub.add_argument("--seed", type=from_zero, help="seed of the sample, to check the same trials again")


def verify(options: argparse.Namespace) -> int:
    """Run trials again and compare them with the file; the exit code is 1 if they differ."""
    import secrets

    from swarmcensus.runs import verifying

    if options.all and options.seed is not None:
        raise misplaced("seed", options.seed, "is for a sample: it does not go with --all")
    seed = secrets.randbelow(2**31) if options.seed is None else options.seed
    sample = 1.0 if options.all else options.sample
    with reporting("verify") as progress:
        verification = verifying.verify(
            options.results, sample, brain_file=options.brain_file, seed=seed, jobs=options.jobs, progress=progress,
            device=options.device,
        )  # fmt: skip
    if options.json:
        answer("verification", {
            "results": options.results,
            "trials_checked": verification.checked,
            "trials_stored": verification.stored,
            "seed": None if options.all else seed,
            "differences": verification.differences,
            "labels": verification.labels,
            "notes": verification.notes,
            "unchecked": verification.unchecked,
        })  # fmt: skip
        return _code(verification)
    for difference in (*verification.labels, *verification.differences):
        print(difference)
    trials = f"{verification.checked:,} of {counted(verification.stored, 'trial')} run again"
    trials += "" if options.all else f" (--seed {seed})"
    equal = "the same to the last bit"
    if verification.labels or verification.notes:
        equal = f"the numbers are {equal}"
    if not verification.checked:
        equal = "no trial could be run again"
    differences = f"{len(verification.differences):,} differ" if verification.differences else equal
    labels = [f"labels that do not match the study: {len(verification.labels):,}"] if verification.labels else []
    print("; ".join([f"{options.results}: {trials}: {differences}", *labels, *verification.notes]))
    print("not compared:", *verification.unchecked, sep="\n  ")
    return _code(verification)


def _code(verification: "Verification") -> int:
    return DIFFER if verification.differences or verification.labels else 0


COMMANDS = (
    Command(
        "show", "Print a summary of results, one row per setting.",
        Group.STUDIES, 4, show, add_show_options, table=True,
    ),
    Command(
        "merge", "Merge results with different settings or trials.",
        Group.STUDIES, 9, merge, add_merge_options, json=False,
    ),
    Command(
        "verify", "Run trials again, and compare them bit for bit.",
        Group.STUDIES, 10, verify, add_verify_options,
    ),
)  # fmt: skip
