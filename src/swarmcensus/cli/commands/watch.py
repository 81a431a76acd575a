"""The command `watch`: the live page, or one trial in a file. Imports wait until the command needs them."""

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any
from urllib.parse import parse_qsl, urlencode, urlsplit

from cyclopts import Parameter

from swarmcensus.cli.messages import progress_bar, say
from swarmcensus.cli.parameters import (  # fmt: skip
    ASSIGNMENTS,
    BrainFiles,
    Host,
    NoBrowser,
    Port,
    Set,
    once,
    path,
    takes,
    values_of,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import OptionError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, wrong_option

if TYPE_CHECKING:
    from swarmcensus.live import LoggedRecording


def watch(
    of: Annotated[Path | None, takes(path, "FILE|FOLDER")] = None, /, *, set: Set = (),
    view: Annotated[Sequence[tuple[str, str]], ASSIGNMENTS] = (), brain_file: BrainFiles = (),
    moment: Annotated[str, Parameter(metavar="LINK")] = "",
    out: Annotated[Path | None, takes(path, "FILE.html")] = None, port: Port = None, no_browser: NoBrowser = False,
    host: Host = "127.0.0.1",
) -> Iterator[Answer]:  # fmt: skip
    """Watch a trial in a browser, or write it as a page.

    Args:
        of: what to watch: STUDY.toml, RESULTS.nc, BRAIN.py or a folder of a swarm's logs (default: 25 robots that move)
        view: what to show of it, such as setting=3, trial=7, tick=200, robot=4 or beside=voter; may be repeated
        moment: start at the moment of a copied link
        out: write the page with this trial as one file, and exit
    """
    from swarmcensus.live import LOOPBACK, Watching, first_view, listen, prepared, serve, warm
    from swarmcensus.support.files import check_output

    with contextlib.ExitStack() as stack:
        if out is None and not (of and of.is_dir()):
            stack.enter_context(prepared())  # while the rest is imported and read
        asked, link = _asked(values_of(set), once("view", view)), _link(moment)
        if brain_file and not (of and of.suffix.lower() == ".nc"):
            why = f"does not go with {of or 'no file'}: that is of results"
            raise OptionError(f"{option('brain_file')} {why}", key="brain_file")
        check_output("out", out, (".html",), *filter(None, [of]))
        offer, query, play = first_view(of, asked, tuple(brain_file), link)
        cautions = [*_gaps(offer.logged)] if offer.logged else []
        if out is not None:
            from swarmcensus.live import export

            with progress_bar("recording") as show:
                size = export(offer, query, out, play, lambda share: show(share, 1.0))
            yield Answer(cautions=cautions, files={out: f"{size / 1e6:.1f} MB"})
            return
        served = listen(offer, host, port or 0, interprets=True)
        with contextlib.suppress(KeyboardInterrupt):  # the usual way to end it, not a failure
            warm(served, query, stack.pop_all())
            if host not in LOOPBACK:
                anyone = f"anyone who can reach {host} and knows this address can run simulations on this machine"
                cautions.append(anyone)
            address = served.address(urlencode(query | play))
            yield Watching(address, cautions=cautions)
            say("Press Ctrl-C to stop.")
            if not no_browser:
                open_browser(address)
            serve(served)


def _gaps(logged: "LoggedRecording") -> Iterator[str]:
    """What is unknown of a recording."""
    from swarmcensus.robots import gaps_in

    if logged.grows:
        yield "this swarm still runs: the page follows it"
    else:
        yield from gaps_in(logged.recording)
    if not any(life.ticks for life in logged.lives):
        yield "the logs hold no ticks: nothing to show"
    whole, lives = sum(life.to_the_bit for life in logged.lives), len(logged.lives)
    if whole < lives:
        yield f"{whole} of {counted(lives, 'robot')} lived again to the bit: swarmcensus relive says how others differ"


def open_browser(address: str) -> None:
    """Open the page a moment later, when the server has started; its socket listens already."""
    import threading
    import webbrowser

    opening = threading.Timer(0.3, webbrowser.open, (address,))
    opening.daemon = True  # Ctrl-C does not wait for it
    opening.start()


def _link(moment: str) -> dict[str, str]:
    """What the link of --moment shows, by key."""
    link = dict(parse_qsl((urlsplit(moment).fragment or moment).lstrip("#")))
    if moment and not link:
        raise wrong_option("moment", moment[:80], "should be a copied link, or the part of it behind #")
    return link


def _asked(set: Mapping[str, Any], view: Mapping[str, str]) -> dict[str, str]:
    """What to show, by key as in a link, from --set and --view."""
    from swarmcensus.live import BESIDE, KEYS, PLAYED
    from swarmcensus.studies import short_key, to_text

    of_page = (*KEYS, *PLAYED)
    for key in (one for one in view if one not in of_page and not one.startswith(BESIDE)):
        there = f"{did_you_mean(key, of_page)}there are {', '.join(of_page)}; {option('set')} is for keys of a study"
        raise wrong_option("view", key, there)
    for key in (one for one in set if one in KEYS and one != "seed"):
        raise wrong_option("set", key, f"is no key of a study: {option('view', f'{key}=...')} is for it")
    return {short_key(key, of_page): to_text(value) for key, value in set.items()} | dict(view)
