"""The command `calibrate`: sensors' accuracies from readings on a black and a white strip."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from swarmcensus.cli.parameters import FILE, FOLDER, NUMBER, path, takes
from swarmcensus.support.answers import Answer
from swarmcensus.support.files import check_output
from swarmcensus.support.options import command, wrong_option

TABLES = takes(path, "COUNTS.csv", several=True)


def calibrate(
    counts: Annotated[Sequence[Path], TABLES] = (), /, *, black: Annotated[Path | None, FOLDER] = None,
    white: Annotated[Path | None, FOLDER] = None, width: Annotated[float, NUMBER] = 0.02,
    out: Annotated[Path | None, FILE] = None,
) -> Answer:  # fmt: skip
    """Find robots' sensor accuracies b and w, with intervals.

    Args:
        counts: tables of counts or readings, as a board with 'deploy --calibrate' prints them
        black: robots' logs of a run over black
        white: robots' logs of a run over white
        width: of an interval for which readings are missing (default: 0.02)
        out: file of robots to write, for 'deploy --robots' and studies
    """
    from swarmcensus.robots import calibrate as answer_of

    if not 0.0 < width < 1.0:
        raise wrong_option("width", width, "should be above 0 and below 1")
    check_output("out", out, (".toml",), *counts)
    found = answer_of(counts, black=black, white=white, width=width, out=out)
    if out:
        found.next = command("swarmcensus", "deploy", "BRAIN", "FOLDER", "--target", "udp", "--robots", out)
    return found
