"""The command `watch`: the live page, or one trial in a file. Imports wait until the command needs them."""

import argparse
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl, urlsplit

from swarmcensus.cli.options import Command, Group, add_shared, assignment, once

from swarmcensus.cli.output import say, wrote
from swarmcensus.support.errors import InputError, OptionError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, wrong_option

if TYPE_CHECKING:
    from swarmcensus.live import LoggedRecording, Offer


def add_watch_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `watch`."""
    sub.add_argument(
        "of",
        type=Path,
        nargs="?",
        metavar="FILE|FOLDER",
        help="what to watch: STUDY.toml, RESULTS.nc, BRAIN.py or a folder of a swarm's logs (default: 25 robots that "
        "move)",
    )
    sub.add_argument(
        "--set",
        type=assignment,
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="initial value of a control, such as robots=100, trial=7 or tick=200; may be repeated",
    )
    add_shared(sub, "parameter", brain_file="of RESULTS.nc")
    sub.add_argument("--moment", default="", metavar="LINK", help="start at the moment of a copied link")
    sub.add_argument(
        "--brain",
        type=Path,
        action="append",
        default=[],
        metavar="BRAIN",
        help="another brain to choose from; the first is shown next to a recording in logs; may be repeated",
    )
    sub.add_argument(
        "--out", type=Path, metavar="FILE.html", help="write the page with this trial as one file, and exit"
    )
    add_shared(sub, "port", "no_browser", "host")


def watch(options: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C, or write it with one trial."""
    from swarmcensus.live import prepared

    with contextlib.ExitStack() as stack:
        if options.out is None and not (options.of and options.of.is_dir()):
            stack.enter_context(prepared())  # while the rest is imported and read
        return _watch(options, stack)


def _watch(options: argparse.Namespace, stack: contextlib.ExitStack) -> int:
    from swarmcensus.live import first_view, offer_of
    from swarmcensus.support.files import check_output

    asked, is_results = _query(options), options.of is not None and options.of.suffix.lower() == ".nc"
    for name, belongs in (("brain", not is_results), ("brain_file", is_results)):
        if getattr(options, name) and not belongs:
            why = "results have their brains" if is_results else "that is of results"
            raise OptionError(f"{option(name)} does not go with {options.of or 'no file'}: {why}", key=name)
    if options.of is not None and options.of.suffix.lower() == ".py":  # a brain, in the small swarm
        options.brain, options.of = [options.of, *options.brain], None
    if options.brain and (options.of is None or not options.of.is_dir()):
        asked.setdefault("brain", str(options.brain[0]))
    check_output("out", options.out, (".html",), *([options.of] if options.of else []))
    offer = offer_of(options.of, tuple(options.brain_file if is_results else options.brain))
    if offer.logged:
        _warn_of_gaps(offer.logged)
    try:
        query, play = first_view(offer, asked)
    except InputError as error:
        for name in ("set", "parameter"):
            if error.key in dict(getattr(options, name)):
                raise OptionError(f"--{name} {error}", key=error.key, value=error.value, hint=error.hint) from None
        raise
    if options.out is not None:
        return _export(options, offer, query, play)
    return _serve(options, offer, query, play, stack.pop_all())


def _warn_of_gaps(logged: "LoggedRecording") -> None:
    """Say what is unknown of a recording."""
    if logged.grows:
        say("This swarm still runs: the page follows it.")
    for what in logged.recording.absent:
        say(f"left out: {what}")
    if not any(life.ticks for life in logged.lives):
        say("the logs hold no ticks: nothing to show")
    whole, lives = sum(life.to_the_bit for life in logged.lives), len(logged.lives)
    if whole < lives:
        states = f"{whole} of {counted(lives, 'robot')} lived again to the bit"
        say(f"{states}: swarmcensus relive tells where the others differ.")


def _serve(
    options: argparse.Namespace,
    offer: "Offer",
    query: dict[str, str],
    play: dict[str, str],
    stack: contextlib.ExitStack,
) -> int:
    from urllib.parse import urlencode

    from swarmcensus.live import LOOPBACK, listen, serve, warm

    served = listen(offer, options.host, options.port or 0, interprets=True)
    with contextlib.suppress(KeyboardInterrupt):  # the usual way to end it, not a failure
        warm(served, query, stack)
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

    from swarmcensus.live import export
    from swarmcensus.support.terminal import console

    silent = options.quiet or not sys.stderr.isatty()
    with Progress(console=console(stderr=True), transient=True, disable=silent) as bar:
        task = bar.add_task("recording", total=1.0)
        size = export(offer, query, options.out, play, lambda share: bar.update(task, completed=share))
    wrote(f"{options.out} ({size / 1e6:.1f} MB)")
    return 0


def _query(options: argparse.Namespace) -> dict[str, str]:
    """What to show, by key: from the link of --moment, or its part behind #, and from --set and --parameter."""
    from swarmcensus.live import KEYS, PLAYED

    text = urlsplit(options.moment).fragment or options.moment
    query = dict(parse_qsl(text.lstrip("#")))
    if options.moment and not query:
        raise wrong_option("moment", options.moment[:80], "should be a copied link, or the part of it behind #")
    controls = once("set", options.set)
    for key in controls:
        if key not in (*KEYS, *PLAYED):
            known = f"{did_you_mean(key, (*KEYS, *PLAYED))}there are {', '.join((*KEYS, *PLAYED))}"
            raise wrong_option("set", key, f"{known}; {option('parameter')} is for parameters of the brain")
    numbers = once("parameter", options.parameter)
    for key in numbers:
        if key in (*KEYS, *PLAYED):
            raise wrong_option("parameter", key, f"is no parameter of a brain: {option('set')} is for it")
    return query | controls | {key: str(list(x) if isinstance(x, tuple) else x) for key, x in numbers.items()}


COMMANDS = (
    Command(
        "watch", "Watch a trial in a browser, or write it as a page.",
        Group.LOOK, 1, watch, add_watch_options, json=False,
    ),
)  # fmt: skip
