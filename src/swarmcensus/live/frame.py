"""`sc.watch`: the live page from Python; in a notebook it is shown as a frame."""

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import xarray as xr

from swarmcensus.live.choices import first_view, offer_of
from swarmcensus.live.server import listen, serving
from swarmcensus.studies import Study
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.templates import render
from swarmcensus.support.toml_text import to_toml_value


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
    of: str | Path | Study | xr.Dataset | None = None, *, brain: str | Path | None = None,
    brain_file: str | Path | None = None, height: int = 900, port: int = 0, **asked: object,
) -> Watching:  # fmt: skip
    """Serve the live page of a study, of results, of a file of either, or of a folder of logs, in the background.

    A notebook shows the returned object as a frame `height` pixels high; its `address` opens the page in a browser on
    this machine. `brain` is the name of a brain or a brain file; for logs, what the same recording is shown under next
    to it. `brain_file` is the file that results were made with, if it is your own.
    `asked` are initial values of controls, such as setting=3, trial=7, robots=100, beside="commons", tick=500, robot=4,
    and of parameters of the brain, by their names.
    Port 0 takes a free port. Raises InputError.
    """
    if not isinstance(of, str | Path | Study | xr.Dataset | None):
        should = "should be a study, results, a file of either, a folder of logs, or None"
        raise InputError(f"{type(of).__name__}: {should}", key="of")
    for name, value, least, most in (("port", port, 0, 65_535), ("height", height, 100, 10_000)):
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            should = f"should be a whole number from {least} to {most:,}"
            raise InputError(f"{name}={value!r}: {should}", key=name, value=value)
    words = {key: to_toml_value(value) if isinstance(value, Mapping) else str(value) for key, value in asked.items()}
    logged = isinstance(of, str | Path) and Path(of).is_dir()
    is_file = brain is not None and (logged or str(brain).lower().endswith(".py"))
    files: tuple[Path, ...] = (Path(str(brain)),) if is_file else ()
    files += (Path(brain_file),) if brain_file is not None else ()
    if brain is not None and not logged:
        words["brain"] = str(brain)
    offer = offer_of(Path(of) if isinstance(of, str) else of, files)
    query, _ = first_view(offer, words)
    served = listen(offer, port=port, interprets=True)
    running = contextlib.ExitStack()
    running.enter_context(serving(served))
    return Watching(served.address(urlencode(words | query)), height, running)
