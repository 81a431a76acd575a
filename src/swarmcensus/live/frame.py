"""`sc.watch`: the live page from Python; in a notebook it is shown as a frame."""

import contextlib
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import xarray as xr

from swarmcensus.live.choices import first_view
from swarmcensus.live.server import listen, serving
from swarmcensus.studies import Study, to_text
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.templates import render
from swarmcensus.support.toml_text import plain


class Watching(Answer):
    """A live page, served until `stop` or the end of this process."""

    def __init__(
        self, address: str, height: int = 900, running: contextlib.ExitStack | None = None, **parts: Any
    ) -> None:  # fmt: skip
        """What is served at an address; a notebook shows it in a frame `height` pixels high."""
        super().__init__(sentences=[address], fields={"address": address}, **parts)
        self.address, self.height, self._running = address, height, running or contextlib.ExitStack()

    def stop(self) -> None:
        """End the server."""
        self._running.close()

    def _repr_html_(self) -> str:
        return render(Path(__file__).with_name("frame.html.jinja"), address=self.address, height=self.height)


def watch(
    of: str | Path | Study | xr.Dataset | None = None, *, brain_file: str | Path | None = None, height: int = 900,
    port: int = 0, **asked: object,
) -> Watching:  # fmt: skip
    """Serve the live page of a study, of results, of a file of either, or of a folder of logs, in the background.

    A notebook shows the returned object as a frame `height` pixels high; its `address` opens the page in a browser on
    this machine. `brain_file` is the file that results were made with, if it is your own.
    `asked` are the words of a link: what to show first, such as setting=3, trial=7, beside="commons", tick=500 or
    robot=4, and other values of a study's keys, such as robots=100, brain="mine.py" or **{"brain.prior": 5}.
    Port 0 takes a free port. Raises InputError.
    """
    if not isinstance(of, str | Path | Study | xr.Dataset | None):
        should = "should be a study, results, a file of either, a folder of logs, or None"
        raise InputError(f"{type(of).__name__}: {should}", key="of")
    for name, value, least, most in (("port", port, 0, 65_535), ("height", height, 100, 10_000)):
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            should = f"should be a whole number from {least} to {most:,}"
            raise InputError(f"{name}={value!r}: {should}", key=name, value=value)
    words = {key: to_text(plain(value)) for key, value in asked.items()}
    files = () if brain_file is None else (Path(brain_file),)
    offer, query, play = first_view(Path(of) if isinstance(of, str) else of, words, files)
    served = listen(offer, port=port, interprets=True)
    running = contextlib.ExitStack()
    running.enter_context(serving(served))
    return Watching(served.address(urlencode(query | play)), height, running)
