"""The live page of a swarm that runs: `swarm --watch`. Imports wait until it is needed."""

import argparse
import contextlib
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from swarmcensus.basics.errors import OptionError
from swarmcensus.cli.options import port
from swarmcensus.cli.output import say

if TYPE_CHECKING:
    from swarmcensus.swarm.running import Swarm

HOST = "127.0.0.1"  # the page is for this machine, wherever robots' sockets listen


def add_page_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of the live page."""
    page = sub.add_argument_group("the live page")
    page.add_argument("--watch", action="store_true", help="show the swarm in a browser while it runs, until Ctrl-C")
    page.add_argument("--port", type=port, help="port of the page (default: a free one)")
    page.add_argument("--no-browser", action="store_true", help="only print the address of the page")


class Page:
    """The page of a swarm, served as soon as a robot has written into its log; nothing without --watch."""

    def __init__(self, options: argparse.Namespace, folder: Path) -> None:
        """Listen on the port. Raises InputError if options do not go together, or the page cannot be served."""
        if not options.watch and (options.port is not None or options.no_browser):
            given = "--port" if options.port is not None else "--no-browser"
            raise OptionError(
                f"{given} is for the live page: it goes with --watch", key=given.strip("-").replace("-", "_")
            )
        self.options, self.folder = options, folder
        self._stack = contextlib.ExitStack()
        self._waits = bool(options.watch)
        self._serves = False
        if self._waits:
            from swarmcensus.watching.server import bound

            self._socket = self._stack.enter_context(bound(HOST, options.port or 0))

    def show(self, swarm: "Swarm") -> None:
        """Begin to serve, once there is something to show."""
        if not self._waits or not any(known.last and known.last.ticks for known in swarm.robots):
            return
        from swarmcensus.cli.watch import open_browser
        from swarmcensus.watching.offers import offer_of
        from swarmcensus.watching.server import Served, serving, warm

        self._waits = False
        served = Served(offer_of(self.folder), HOST, self._socket)
        self._stack.enter_context(serving(served))
        self._serves = True
        warm(served, {})
        print(f"live page: {served.address()}", file=sys.stderr, flush=True)  # with --quiet, too: nobody can guess it
        if not self.options.no_browser:
            open_browser(served.address())

    def stay(self) -> None:
        """Serve on after the swarm's end, until Ctrl-C."""
        if self._serves:
            say("The live page goes on showing the day. Press Ctrl-C to stop.")
            with contextlib.suppress(KeyboardInterrupt):
                while True:
                    time.sleep(0.5)

    def close(self) -> None:
        """End the server."""
        self._stack.close()
