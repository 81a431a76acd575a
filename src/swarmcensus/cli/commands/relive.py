"""The command `relive`: computes robots' states again from their logs, with their brain."""

from pathlib import Path
from typing import Annotated

from swarmcensus.cli.parameters import FILE, FOLDER, path, share, takes
from swarmcensus.support.answers import Answer
from swarmcensus.support.files import check_output


def relive(
    folder: Annotated[Path, FOLDER], /, *, brain_file: Annotated[Path | None, FILE] = None,
    fill_ratio: Annotated[float | None, takes(share, "F")] = None,
    trace: Annotated[Path | None, takes(path, "FILE.nc|csv")] = None,
) -> Answer:  # fmt: skip
    """Run robots' brains again from their logs, to the bit.

    Args:
        folder: robots' logs, as swarmcensus swarm or boards write
        brain_file: the robots' brain, if FOLDER lacks its file
        fill_ratio: how much of the floor is black (default: that of FOLDER)
        trace: write every robot's estimate and memory after every tick
    """
    from swarmcensus.robots import answer_of, read_recording, relive_all, traces

    check_output("trace", trace, (".csv", ".nc"))
    recording = read_recording(folder, brain_file, fill_ratio)
    lives = relive_all(recording, keep=trace is not None)
    answer = answer_of(recording, lives)
    if trace:
        from swarmcensus.summaries import write_trace

        write_trace(traces.as_trace(recording, lives), trace)
        answer.files = {trace: ""}
    return answer
