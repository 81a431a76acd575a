"""The command `watch`: the live page, or one trial in a file. Imports wait until the command needs them."""

import contextlib
import logging
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any
from urllib.parse import parse_qsl, urlencode, urlsplit

from cyclopts import Parameter

from swarmcensus.cli.messages import LOG, say
from swarmcensus.cli.parameters import (  # fmt: skip
    ASSIGNMENTS,
    BrainFiles,
    Host,
    NoBrowser,
    Parameters,
    Port,
    known,
    once,
    path,
    takes,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, OptionError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, wrong_option

if TYPE_CHECKING:
    from swarmcensus.live import LoggedRecording


def watch(
    of: Annotated[Path | None, takes(path, "FILE|FOLDER")] = None, /, *,
    set: Annotated[Sequence[tuple[str, str]], ASSIGNMENTS] = (), parameter: Parameters = (),
    brain_file: BrainFiles = (), moment: Annotated[str, Parameter(metavar="LINK")] = "",
    brain: Annotated[Sequence[Path], takes(path, "BRAIN", several=True), known("brains.brain")] = (),
    out: Annotated[Path | None, takes(path, "FILE.html")] = None, port: Port = None, no_browser: NoBrowser = False,
    host: Host = "127.0.0.1",
) -> Iterator[Answer]:  # fmt: skip
    """Watch a trial in a browser, or write it as a page.

    Args:
        of: what to watch: STUDY.toml, RESULTS.nc, BRAIN.py or a folder of a swarm's logs (default: 25 robots that move)
        set: initial value of a control, such as robots=100, trial=7 or tick=200; may be repeated
        moment: start at the moment of a copied link
        brain: another brain to choose from; the first is shown next to a recording in logs; may be repeated
        out: write the page with this trial as one file, and exit
    """
    from swarmcensus.live import LOOPBACK, Watching, first_view, listen, offer_of, prepared, serve, warm
    from swarmcensus.support.files import check_output

    with contextlib.ExitStack() as stack:
        if out is None and not (of and of.is_dir()):
            stack.enter_context(prepared())  # while the rest is imported and read
        given = {"set": once("set", set), "parameter": once("parameter", parameter)}
        asked, is_results = _query(moment, **given), of is not None and of.suffix.lower() == ".nc"
        if brain and is_results:
            raise OptionError(f"{option('brain')} does not go with {of}: results have their brains", key="brain")
        if brain_file and not is_results:
            why = f"does not go with {of or 'no file'}: that is of results"
            raise OptionError(f"{option('brain_file')} {why}", key="brain_file")
        if of is not None and of.suffix.lower() == ".py":  # a brain, in the small swarm
            brain, of = [of, *brain], None
        if brain and not (of and of.is_dir()):
            asked.setdefault("brain", str(brain[0]))
        check_output("out", out, (".html",), *filter(None, [of]))
        offer = offer_of(of, tuple(brain_file if is_results else brain))
        cautions = [*_gaps(offer.logged)] if offer.logged else []
        try:
            query, play = first_view(offer, asked)
        except InputError as error:
            for name in given:
                if error.key in given[name]:
                    raise OptionError(f"--{name} {error}", key=error.key, value=error.value, hint=error.hint) from None
            raise
        if out is not None:
            from rich.progress import Progress

            from swarmcensus.live import export
            from swarmcensus.support.terminal import console

            silent = not (LOG.isEnabledFor(logging.INFO) and sys.stderr.isatty())
            with Progress(console=console(stderr=True), transient=True, disable=silent) as bar:
                task = bar.add_task("recording", total=1.0)
                size = export(offer, query, out, play, lambda share: bar.update(task, completed=share))
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
    if logged.grows:
        yield "this swarm still runs: the page follows it"
    for what in logged.recording.absent:
        yield f"left out: {what}"
    if not any(life.ticks for life in logged.lives):
        yield "the logs hold no ticks: nothing to show"
    whole, lives = sum(life.to_the_bit for life in logged.lives), len(logged.lives)
    if whole < lives:
        states = f"{whole} of {counted(lives, 'robot')} lived again to the bit"
        yield f"{states}: swarmcensus relive says where the others differ"


def open_browser(address: str) -> None:
    """Open the page a moment later, when the server has started; its socket listens already."""
    import threading
    import webbrowser

    opening = threading.Timer(0.3, webbrowser.open, (address,))
    opening.daemon = True  # Ctrl-C does not wait for it
    opening.start()


def _query(moment: str, set: Mapping[str, str], parameter: Mapping[str, Any]) -> dict[str, str]:
    """What to show, by key: from the link of --moment, or its part behind #, and from --set and --parameter."""
    from swarmcensus.live import KEYS, PLAYED

    controls = (*KEYS, *PLAYED)
    query = dict(parse_qsl((urlsplit(moment).fragment or moment).lstrip("#")))
    if moment and not query:
        raise wrong_option("moment", moment[:80], "should be a copied link, or the part of it behind #")
    for key in (one for one in set if one not in controls):
        there = f"{did_you_mean(key, controls)}there are {', '.join(controls)}"
        raise wrong_option("set", key, f"{there}; {option('parameter')} is for parameters of the brain")
    for key in (one for one in parameter if one in controls):
        raise wrong_option("parameter", key, f"is no parameter of a brain: {option('set')} is for it")
    return {**query, **set} | {key: str([*x] if isinstance(x, tuple) else x) for key, x in parameter.items()}
