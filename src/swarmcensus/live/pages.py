"""The HTML of the page: live, with links to its styles and scripts, or recorded, with everything in one file."""

import base64
import hashlib
import json
from pathlib import Path
from typing import Any

from swarmcensus.support.templates import render

PAGE = Path(__file__).with_name("page")
STYLES = ("uPlot.css", "watch.css")
SCRIPTS = (
    "konva.js", "uPlot.js", "frames.js", "source.js", "colours.js", "view.js", "trail.js", "stage.js", "charts.js",
    "panel.js", "trial.js", "player.js", "live.js", "save.js", "main.js",
)  # fmt: skip


def live_page() -> str:
    """The page that a server sends; the browser then fetches styles and scripts."""
    return render(PAGE / "index.html.jinja", styles=STYLES, scripts=SCRIPTS, recording=None)


def recorded_page(recording: dict[str, Any]) -> str:
    """The page of a recorded trial. Its security policy names the hash of the script and of the style that it holds."""
    style, script = (_joined(names) for names in (STYLES, SCRIPTS))
    sources = f"script-src '{_hash(script)}'; style-src '{_hash(style)}'; img-src data:"
    contents = {"name": recording["form"]["name"], "style": style, "script": script}
    contents["policy"] = f"default-src 'none'; {sources}; base-uri 'none'"
    contents["data"] = json.dumps(recording, allow_nan=False).replace("<", "\\u003c")
    contents["licences"] = _joined(tuple(path.name for path in sorted(PAGE.glob("*-license.txt"))))
    return render(PAGE / "index.html.jinja", recording=contents)


def _joined(names: tuple[str, ...]) -> str:
    return "\n".join((PAGE / name).read_text(encoding="utf-8") for name in names)


def _hash(text: str) -> str:
    """The hash of an element's content as a policy states it: the template puts a line break before and after it."""
    return "sha256-" + base64.b64encode(hashlib.sha256(f"\n{text}\n".encode()).digest()).decode()
