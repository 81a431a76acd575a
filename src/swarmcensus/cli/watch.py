"""The command `watch`: the live page, or one trial in a file. Imports wait until the command needs them."""

import argparse
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl, urlsplit

from swarmcensus.basics.errors import InputError, OptionError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.options import wrong_option
from swarmcensus.cli.options import port
from swarmcensus.cli.output import say, wrote

if TYPE_CHECKING:
    from swarmcensus.watching.days import LoggedDay
    from swarmcensus.watching.offers import Offer


def add_watch_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `watch`."""
    sub.add_argument(
        "of",
        type=Path,
        nargs="?",
        metavar="STUDY.toml|RESULTS.nc|BRAIN.py|FOLDER",
        help="what to watch; a folder has a swarm's logs (default: 25 robots that move)",
    )
    sub.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="initial value of a control or of a parameter of the brain, such as robots=100, trial=7, momentum=0.8; "
        "may be repeated",
    )
    sub.add_argument("--at", default="", metavar="ADDRESS", help="start at the moment of a copied link")
    sub.add_argument(
        "--brain",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="another brain file to choose from; the first is shown beside a day in logs; may be repeated",
    )
    sub.add_argument(
        "--export", type=Path, metavar="FILE.html", help="write the page with this trial as one file, and exit"
    )
    sub.add_argument("--port", type=port, default=0, help="port of the server (default: a free one)")
    sub.add_argument("--host", default="127.0.0.1", help="address to listen on (default: this machine only)")
    sub.add_argument("--no-browser", action="store_true", help="only print the address")


def watch(options: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C, or write it with one trial."""
    from swarmcensus.watching.offers import PLAYED, check_moment, offer_of, wanted

    query = _query(options)
    if options.of is not None and options.of.suffix == ".py":  # a brain, in the small swarm
        options.brain, options.of = [options.of, *options.brain], None
    if options.brain and (options.of is None or not (options.of.suffix == ".nc" or options.of.is_dir())):
        query.setdefault("brain", str(options.brain[0]))
    if options.export is not None and options.export.suffix != ".html":
        raise wrong_option("export", options.export, "a page is written as .html")
    offer = offer_of(options.of, tuple(options.brain))
    if offer.logged:
        _tell_day(offer.logged)
        for name in list(offer.logged.brains)[:1]:
            query.setdefault("beside", name)
    play = {key: query.pop(key) for key in PLAYED if key in query}
    trial = wanted(offer, query)
    check_moment(trial, play)  # so that errors are reported here, not in the browser
    if offer.logged:
        for setting in trial.settings:  # so are those of a brain that cannot live the day
            offer.logged.under(setting.brain)
    if options.export is not None:
        return _export(options, offer, query, play)
    return _serve(options, offer, query, play)


def _tell_day(logged: "LoggedDay") -> None:
    """Say what of a day is not known."""
    if logged.grows:
        say("This swarm still runs: the page follows it.")
    for what in logged.day.absent:
        say(f"left out: {what}")
    whole, lives = sum(life.to_the_bit for life in logged.lives), len(logged.lives)
    if whole < lives:
        minds = f"{whole} of {counted(lives, 'mind')} lived again to the bit"
        say(f"{minds}: swarmcensus relive tells where the others differ.")


def _serve(options: argparse.Namespace, offer: "Offer", query: dict[str, str], play: dict[str, str]) -> int:
    from urllib.parse import urlencode

    from swarmcensus.watching.server import LOOPBACK, listen, serve, warm

    served = listen(offer, options.host, options.port)
    with contextlib.suppress(KeyboardInterrupt):  # the usual way to end it, and no failure
        warm(served, query)
        address = served.address(urlencode(query | play))
        print(address, flush=True)
        say("Press Ctrl-C to stop.")
        if options.host not in LOOPBACK:
            say(f"Anyone who can reach {options.host} and knows this address can run simulations on this machine.")
        if not options.no_browser:
            open_browser(address)
        serve(served)
    return 0


def open_browser(address: str) -> None:
    """Open the page a moment later, when the server has started; its socket listens already."""
    import threading
    import webbrowser

    opening = threading.Timer(0.3, webbrowser.open, (address,))
    opening.daemon = True  # Ctrl-C does not wait for it
    opening.start()


def _export(options: argparse.Namespace, offer: "Offer", query: dict[str, str], play: dict[str, str]) -> int:
    from rich.progress import Progress

    from swarmcensus.basics.files import check_writable
    from swarmcensus.basics.terminal import console
    from swarmcensus.watching.exporting import export

    check_writable(options.export, *([options.of] if options.of else []))
    silent = options.quiet or not sys.stderr.isatty()
    with Progress(console=console(stderr=True), transient=True, disable=silent) as bar:
        task = bar.add_task("recording", total=1.0)
        size = export(offer, query, options.export, play, lambda share: bar.update(task, completed=share))
    wrote(f"{options.export} ({size / 1e6:.1f} MB)")
    return 0


def _query(options: argparse.Namespace) -> dict[str, str]:
    """What to show, by key: from the address of --at, or the part behind its #, and from --set."""
    text = urlsplit(options.at).fragment or options.at
    query = dict(parse_qsl(text.lstrip("#")))
    if options.at and not query:
        raise InputError(f"--at {options.at[:80]}: should be a copied link, or the part of it behind #")
    given: dict[str, str] = {}
    for pair in options.set:
        key, sign, value = pair.partition("=")
        if not sign or not key:
            raise wrong_option("set", pair, "should be such as robots=100")
        if key in given:
            raise OptionError(f"--set gives {key} twice", key="set")
        given[key] = value
    return query | given
