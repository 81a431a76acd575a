"""How much memory large swarms take: python benchmarks/memory.py [--robots N] [--topology NAME] [--jobs N].

Runs studies of 1, 2 and 10 settings of a million robots, 100 rounds and one trial each, from the shell and into a
file, by default with two threads, and prints the peak of resident memory of the run, of `show` and of `verify` of its
file.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

STUDY = """trials = 1
[swarm]
robots = {robots}
accuracy = {accuracies}
[world]
topology = "{topology}"
fill_ratio = 0.55
[schedule]
rounds = 100
"""


def peak(*words):
    """GiB that the program had at once."""
    process = subprocess.Popen([sys.executable, "-m", "swarmcensus", *words, "--quiet"], stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    assert status == 0, words
    return used.ru_maxrss / 2**20  # KiB, on Linux


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, default=1_000_000)
    parser.add_argument("--topology", default="ring")
    parser.add_argument("--jobs", default="2")
    parser.add_argument("--settings", type=int, nargs="+", default=[1, 2, 10])
    options = parser.parse_args()
    table = Table("settings", "run", "show", "verify", title="GiB at the peak")
    with tempfile.TemporaryDirectory() as folder:
        study, out = Path(folder) / "study.toml", str(Path(folder) / "out.nc")
        study.write_text(STUDY.format(robots=10, accuracies=[0.6], topology=options.topology))
        peak("run", str(study), "--out", out)  # compiles
        for settings in options.settings:
            accuracies = [round(0.6 + 0.02 * k, 2) for k in range(settings)]
            study.write_text(STUDY.format(robots=options.robots, accuracies=accuracies, topology=options.topology))
            peaks = [peak("run", str(study), "--out", out, "--fresh", "--jobs", options.jobs)]
            peaks += [peak("show", out), peak("verify", out, "--jobs", options.jobs)]
            table.add_row(str(settings), *(f"{gib:.2f}" for gib in peaks))
    Console(width=80).print(table)


if __name__ == "__main__":
    main()
