"""The command `watch`: the live page, or one trial in a file. Imports wait until needed."""

import argparse
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl, urlsplit

from swarmcensus.basics.errors import InputError
from swarmcensus.cli.output import say, wrote

if TYPE_CHECKING:
    from swarmcensus.watching.offers import Offer


def add_watch_options(sub: argparse.ArgumentParser) -> None:
    """Of `watch`."""
    sub.add_argument(
        "of",
        type=Path,
        nargs="?",
        metavar="STUDY.toml|RESULTS.nc|BRAIN.py",
        help="default: 25 robots that move",
    )
    sub.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="such as robots=100, setting=3, trial=7, tick=500; may be repeated",
    )
    sub.add_argument("--at", default="", metavar="ADDRESS", help="the moment of somebody's copied link")
    sub.add_argument(
        "--brain",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="a brain file that may be watched too; may be repeated",
    )
    sub.add_argument("--export", type=Path, metavar="FILE.html", help="write the page with this trial in it, and end")
    sub.add_argument("--port", type=_port, default=0, help="default: a free one")
    sub.add_argument("--host", default="127.0.0.1", help="whom to answer to (default: this machine alone)")
    sub.add_argument("--no-browser", action="store_true", help="print the address, and open nothing")


def watch(options: argparse.Namespace) -> int:
    """Serve the page until it is interrupted, or write it with one trial."""
    from swarmcensus.watching.offers import PLAYED, check_moment, offer_of, wanted

    asked = _asked(options)
    if options.of is not None and options.of.suffix == ".py":  # a brain, in the small swarm
        options.brain, options.of = [options.of, *options.brain], None
    if options.brain and (options.of is None or options.of.suffix != ".nc"):
        asked.setdefault("brain", str(options.brain[0]))
    if options.export is not None and options.export.suffix != ".html":
        raise InputError(f"--export {options.export}: a page is written as .html")
    offer = offer_of(options.of, tuple(options.brain))
    play = {key: asked.pop(key) for key in PLAYED if key in asked}
    check_moment(wanted(offer, asked), play)  # what is wrong is told here, rather than in the browser
    if options.export is not None:
        return _export(options, offer, asked, play)
    return _serve(options, offer, asked, play)


def _serve(options: argparse.Namespace, offer: "Offer", asked: dict[str, str], play: dict[str, str]) -> int:
    from urllib.parse import urlencode

    from swarmcensus.watching.server import LOOPBACK, listen, serve, warm

    served = listen(offer, options.host, options.port)
    with contextlib.suppress(KeyboardInterrupt):  # as it is meant to be ended, which is no failure
        warm(served, asked)
        address = served.address(urlencode(asked | play))
        print(address, flush=True)
        say("Ctrl-C ends it.")
        if options.host not in LOOPBACK:
            say(f"Whoever reaches {options.host} and has this address can watch, and make this machine work.")
        if not options.no_browser:
            _open_browser(address)
        serve(served)
    return 0


def _open_browser(address: str) -> None:
    """Open it once the server answers, which it does by then: its socket listens before."""
    import threading
    import webbrowser

    opening = threading.Timer(0.3, webbrowser.open, (address,))
    opening.daemon = True  # Ctrl-C does not wait for it
    opening.start()


def _export(options: argparse.Namespace, offer: "Offer", asked: dict[str, str], play: dict[str, str]) -> int:
    from rich.progress import Progress

    from swarmcensus.basics.files import check_writable
    from swarmcensus.basics.terminal import console
    from swarmcensus.watching.exporting import export

    check_writable(options.export, *([options.of] if options.of else []))
    silent = options.quiet or not sys.stderr.isatty()
    with Progress(console=console(stderr=True), transient=True, disable=silent) as bar:
        task = bar.add_task("recording", total=1.0)
        size = export(offer, asked, options.export, play, lambda share: bar.update(task, completed=share))
    wrote(f"{options.export} ({size / 1e6:.1f} MB)")
    return 0


def _asked(options: argparse.Namespace) -> dict[str, str]:
    """What is asked for by an address, or part of one, and by --set."""
    text = urlsplit(options.at).fragment or options.at
    asked = dict(parse_qsl(text.lstrip("#")))
    if options.at and not asked:
        raise InputError(f"--at {options.at[:80]}: should be a copied link, or what stands behind its #")
    for one in options.set:
        key, sign, value = one.partition("=")
        if not sign:
            raise InputError(f"--set {one}: should be such as robots=100")
        asked[key] = value
    return asked


def _port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 5 and int(text) <= 65_535):
        raise argparse.ArgumentTypeError(f"{text[:40]!r}: should be a port, from 1 to 65535, or 0 for a free one")
    return int(text)
