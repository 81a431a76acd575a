"""What `swarmcensus reproduce` costs: python benchmarks/reproduce.py.

Runs it twice from the shell, so that the second run finds its brains compiled, and prints the second's stages
and its time from start to end; then the time of each of its studies, and the thread scaling of the largest.
"""

import subprocess
import sys
import tempfile
import time

from swarmcensus import Study, run
from swarmcensus.paper.reproducing import studies_folder

COMMAND = [sys.executable, "-c", "import sys; from swarmcensus.cli.commands import main; sys.exit(main())", "reproduce"]


def main():
    with tempfile.TemporaryDirectory() as folder:
        for label in ("first run, compiling what is not compiled yet", "second run"):
            begun = time.monotonic()
            done = subprocess.run([*COMMAND, "--out", folder], capture_output=True, text=True, check=True)
            print(f"{label}: {time.monotonic() - begun:.1f} s from the shell to the page")
        print("\n".join("  " + line for line in done.stdout.splitlines() if line.endswith((" s", " s in all"))))
    for path in sorted(studies_folder().glob("*.toml")):
        study = Study.load(path)
        results = run(study, jobs=2)
        trials, seconds = results.attrs["trials_done"], results.attrs["wall_seconds"]
        print(f"study {study.name}: {trials} trials in {seconds:.1f} s with two threads")


if __name__ == "__main__":
    main()
