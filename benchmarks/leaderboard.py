"""What `swarmcensus leaderboard` costs: python benchmarks/leaderboard.py.

Runs it from the shell with an empty cache of compiled code, then with a brain of one's own beside what is there, and
prints how long each took from start to end.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

COMMAND = [sys.executable, "-m", "swarmcensus", "leaderboard"]
MINE = Path(__file__).parents[1] / "studies" / "example" / "my_brain.py"


def main():
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"SWARMCENSUS_CACHE": f"{folder}/cache"}
        for label, more in (("all shipped brains, compiled first", []), ("one more", [str(MINE)])):
            begun = time.monotonic()
            subprocess.run(
                [*COMMAND, *more, "--out", f"{folder}/out", *sys.argv[1:]],
                capture_output=True, check=True, env=environment,
            )  # fmt: skip
            print(f"{label}: {time.monotonic() - begun:.1f} s from the shell to the page")


if __name__ == "__main__":
    main()
