"""Pictures of the gallery in docs/plotting.md, drawn by the commands next to them.

python docs_hooks/gallery.py       # writes them all into docs/images/gallery/
"""

import os
import re
import shlex
import tempfile
from pathlib import Path

from swarmcensus.cli.commands import main

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "plotting.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| !\[\]\((images/gallery/[\w-]+\.png)\) \|.*\| `([^`]+)` \|$", PAGE, re.MULTILINE)
SMALL = ["--width", "column", "--dpi", "80", "--quiet"]


def draw() -> None:
    """Run the studies of the page, and its commands."""
    os.chdir(tempfile.mkdtemp())
    Path("moving.toml").write_text(PAGE.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    for study in ("moving.toml", ROOT / "studies" / "sizes.toml", ROOT / "studies" / "wrong-beliefs.toml"):
        assert main(["run", str(study), "--out", f"{Path(study).stem}.nc", "--quiet"]) == 0
    for picture, command in ROWS:
        assert main(["plot", *shlex.split(command), *SMALL, "--out", Path(picture).name]) == 0
        (ROOT / "docs" / picture).parent.mkdir(exist_ok=True)
        Path(Path(picture).name).replace(ROOT / "docs" / picture)


if __name__ == "__main__":
    draw()
