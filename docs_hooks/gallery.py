"""Pictures of the galleries in docs/plotting.md and docs/lecture.md, drawn by the commands next to them.

python docs_hooks/gallery.py [PAGE]       # writes those of one page, or all, into docs/images/gallery/
"""

import os
import re
import shlex
import sys
import tempfile
from pathlib import Path

from swarmcensus.cli.commands import main

ROOT = Path(__file__).parents[1]
ROW = re.compile(r"^\| !\[\]\((images/gallery/([\w-]+\.\w+))\) \|.*\| `([^`]+)` \|$", re.MULTILINE)
SMALL = ["--width", "column", "--dpi", "80", "--quiet"]
STUDIES = {  # of each page: the name of the study that it shows, and the arguments of all runs
    "plotting": ("moving.toml", ["moving.toml", "studies/sizes.toml", "studies/wrong-beliefs.toml"]),
    "lecture": ("lecture.toml", []),
}


def page_of(name: str) -> str:
    """The text of a page."""
    return (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")


def draw(name: str) -> None:
    """Run the studies of a page, and its commands."""
    page, (study, runs) = page_of(name), STUDIES[name]
    os.chdir(tempfile.mkdtemp())
    Path("studies").symlink_to(ROOT / "studies")
    Path(study).write_text(page.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    for command in runs or re.findall(r"^swarmcensus run (.+)$", page, re.MULTILINE):
        words = shlex.split(command)
        out = [] if "--out" in words else ["--out", f"{Path(words[0]).stem}.nc"]
        assert main(["run", *words, *out, "--quiet"]) == 0
    for path, picture, command in ROW.findall(page):
        asked = command.removeprefix("swarmcensus plot ").partition(" --out ")[0]
        assert main(["plot", *shlex.split(asked), *SMALL, "--out", picture]) == 0
        (ROOT / "docs" / path).parent.mkdir(exist_ok=True)
        Path(picture).replace(ROOT / "docs" / path)


if __name__ == "__main__":
    for one in sys.argv[1:] or STUDIES:
        draw(one)
