"""The command `relive`: computes robots' states again from their logs, with their brain or others."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from swarmcensus.cli.parameters import FILE, FOLDER, FORMATS, Parameters, known, once, path, share, takes
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import OptionError
from swarmcensus.support.files import check_output
from swarmcensus.support.options import option_conflict, wrong_option

if TYPE_CHECKING:
    from swarmcensus.brains import Brain
    from swarmcensus.robots import Recording


def relive(
    folder: Annotated[Path, FOLDER], /, *,
    brain: Annotated[Sequence[str], takes(str, "BRAIN", several=True), known("brains.brain")] = (),
    parameter: Parameters = (), message: FORMATS | None = None, brain_file: Annotated[Path | None, FILE] = None,
    fill_ratio: Annotated[float | None, takes(share, "F")] = None,
    out: Annotated[Path | None, takes(path, "FILE.nc")] = None,
    trace: Annotated[Path | None, takes(path, "FILE.nc|csv")] = None,
) -> Answer:  # fmt: skip
    """Run robots' brains again from their logs, to the bit.

    Args:
        folder: robots' logs, as swarmcensus swarm or boards write
        brain: replay under this brain too; may be repeated
        message: format of messages under --brain (default: that of the logs)
        brain_file: the robots' brain, if FOLDER lacks its file
        fill_ratio: how much of the floor is black (default: that of FOLDER)
        out: results to write: one setting per brain
        trace: write every robot's estimate and memory after every tick, under --brain if there is one
    """
    from swarmcensus.robots import Clock, answer_of, read_recording, relive_all, relive_with, traces

    if message and not brain:
        raise option_conflict("message", None, "goes with --brain")
    if parameter and len(brain) != 1:
        raise option_conflict("parameter", None, "goes with one --brain")
    if trace and len(brain) > 1:
        raise OptionError("--trace goes with one --brain at most: give each brain its own relive", key="trace")
    check_output("out", out, (".nc",))
    check_output("trace", trace, (".csv", ".nc"))
    if out and trace and out.resolve() == trace.resolve():
        raise OptionError(f"--out and --trace both name {out}: they should name two files", key="out")
    recording = read_recording(folder, brain_file, fill_ratio)
    others = _others(recording, brain, once("parameter", parameter), out)
    clock, files = Clock(recording.members), {}
    lives = relive_all(recording, keep=bool(trace) and not others)
    lived = [traces.as_logged(recording, lives)]
    lived += [relive_with(recording, one, message, clock, bool(trace)) for one in others]
    if out:
        from swarmcensus.results import save
        from swarmcensus.summaries import dataset_of

        save(dataset_of(recording, lived, clock, message), out)
        files[out] = ""
    if trace:
        from swarmcensus.summaries import write_trace

        write_trace(traces.as_trace(recording, lived[-1], clock), trace)
        files[trace] = ""
    answer = answer_of(recording, lives, lived)
    answer.files = files
    return answer


def _others(recording: "Recording", names: Sequence[str], values: Mapping[str, Any], out: Any) -> "list[Brain]":
    """The brains of --brain."""
    found = [recording.other(name) for name in names]
    try:
        found = [brain.with_parameters(values) for brain in found]
    except ValueError as error:
        raise OptionError(f"--parameter: {error}", key="parameter") from None
    labels = [recording.as_it_was.label, *(brain.label for brain in found)]
    if twice := next((label for label in labels if labels.count(label) > 1 and out), None):
        why = "the robots' own brain is always there" if twice == labels[0] else "give each --brain once"
        raise wrong_option("out", out, f"{twice} would be there twice: {why}")
    return found
