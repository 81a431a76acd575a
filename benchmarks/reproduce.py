"""What `swarmcensus reproduce` costs: python benchmarks/reproduce.py.

Runs it from the shell with an empty cache of compiled code, and with a full one, and prints the stages of each and its
time from start to end; then the time of each of its studies.
"""

import os
import subprocess
import sys
import tempfile
import time

from swarmcensus import Study, run
from swarmcensus.basics.files import shipped_study

COMMAND = [sys.executable, "-m", "swarmcensus", "reproduce"]


def main():
    with tempfile.TemporaryDirectory() as folder:
        for label, cache in (
            ("on a machine that never ran it", {"SWARMCENSUS_CACHE": f"{folder}/cache"}),
            ("again", {}),
        ):
            if not cache:  # whatever the loop above compiled lies in a cache of its own
                subprocess.run([*COMMAND, "--out", f"{folder}/first", "--trials", "1"], capture_output=True, check=True)
            begun = time.monotonic()
            done = subprocess.run(
                [*COMMAND, "--out", f"{folder}/{label}"],
                capture_output=True, text=True, check=True, env=os.environ | cache,
            )  # fmt: skip
            print(f"{label}: {time.monotonic() - begun:.1f} s from the shell to the page")
            print("\n".join("  " + line for line in done.stdout.splitlines() if line.endswith((" s", " s in all"))))
    for path in sorted(shipped_study("paper").glob("*.toml")):
        study = Study.load(path)
        results = run(study, jobs=2)
        trials, seconds = results.attrs["trials_done"], results.attrs["wall_seconds"]
        print(f"study {study.name}: {trials} trials in {seconds:.1f} s with two threads")


if __name__ == "__main__":
    main()
