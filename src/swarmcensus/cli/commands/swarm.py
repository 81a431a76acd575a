"""The command `swarm`: robots as processes that talk over sockets. Imports wait until the command needs them."""

import contextlib
import itertools
import re
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from swarmcensus.cli.commands.watch import open_browser
from swarmcensus.cli.messages import say
from swarmcensus.cli.parameters import (  # fmt: skip
    COUNT,
    FOLDER,
    FORMATS,
    NAME,
    NUMBER,
    SHARE,
    WHOLE,
    Host,
    NoBrowser,
    Port,
    share,
    takes,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import Interrupted, OptionError
from swarmcensus.support.options import option, option_conflict, wrong_option

if TYPE_CHECKING:
    from swarmcensus.robots import RunningSwarm
    from swarmcensus.studies import Study

USUAL: dict[str, Any] = {  # values of keys of a study file that its options have by default
    "robots": 20, "topology": "ring", "fill_ratio": 0.55, "accuracy": "0.8", "rounds": 500, "message": "float32",
}  # fmt: skip
HOST = "127.0.0.1"  # the page is for this machine, wherever robots' sockets listen


def milliseconds(text: str) -> int:
    """A time in ms or s."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*(ms|s)", text.strip())
    if match is None:
        raise ValueError("should be a time in ms or s, such as 50ms")
    return round(float(match[1]) * (1000.0 if match[2] == "s" else 1.0))


def swarm(
    what: Annotated[str, Parameter(metavar="BRAIN|STUDY.toml")], /, *, setting: Annotated[int | None, WHOLE] = None,
    robots: Annotated[int | None, COUNT] = None, topology: Annotated[str | None, NAME] = None,
    link_success: Annotated[float | None, SHARE] = None, fill_ratio: Annotated[float | None, takes(share, "F")] = None,
    accuracy: Annotated[str | None, Parameter(metavar="B")] = None, rounds: Annotated[int | None, COUNT] = None,
    message: FORMATS | None = None, precision: Literal["double", "single"] | None = None,
    hz: Annotated[float, NUMBER] = 10.0, jitter: Annotated[float, NUMBER] = 0.1,
    delay: Annotated[int, takes(milliseconds, "TIME")] = 0, duplicate: Annotated[float, NUMBER] = 0.0,
    host: Host = HOST, micropython: Annotated[int, WHOLE] = 0,
    fault: Annotated[Sequence[str], takes(str, "FAULT", several=True)] = (), trial: Annotated[int, WHOLE] = 0,
    seed: Annotated[int | None, WHOLE] = None, out: Annotated[Path | None, FOLDER] = None, watch: bool = False,
    port: Port = None, no_browser: NoBrowser = False,
) -> Iterator[Answer]:  # fmt: skip
    """Run robots as processes that talk over sockets.

    Args:
        what: a brain's name or file, or a study with a fixed network
        setting: number of the setting of a study (default: 0)
        robots: processes (default: 20)
        topology: who hears whom: ring, scale-free, full ... (default: ring)
        link_success: share of messages that arrive (default: 1)
        fill_ratio: how much of the floor is black (default: 0.55)
        accuracy: accuracy of sensors: 0.8 (default), or a spread "U(0.6, 0.9)"
        rounds: ticks of each robot (default: 500)
        message: format of messages (default: float32)
        precision: precision of numbers (default: double)
        hz: ticks a second (default: 10)
        jitter: share of a period that ticks are late by, at most (default: 0.1)
        delay: delay of each message, such as 50ms (default: 0ms)
        duplicate: share of messages that are heard twice (default: 0)
        micropython: robots that run MicroPython (default: 0)
        fault: what happens to robots, such as "5s kill 3" or "10s partition 0-9"; may be repeated
        trial: number of the trial (default: 0)
        seed: seed of all random numbers (default: 0, or as in the study)
        out: where logs go; it should be new (default: swarm, swarm-2 ...)
        watch: show the swarm in a browser while it runs, until Ctrl-C
    """
    asked = {name: value for name, value in locals().items() if value is not None}
    from swarmcensus.engine import interruptible
    from swarmcensus.robots import Air, check_free, faults_of, plan_of, run

    for name, given in (("port", port is not None), ("no_browser", no_browser)):
        if given and not watch:
            raise option_conflict(name, None, "is for the live page: it goes with --watch")
    names = itertools.chain(["swarm"], (f"swarm-{k}" for k in itertools.count(2)))
    folder = out or next(path for path in map(Path, names) if not path.exists())
    check_free(folder)
    if folder.resolve() == Path.cwd():
        raise wrong_option("out", folder, "this is the folder that you are in: name a new one, such as swarm")
    study, air = _study(what, asked), Air(hz, delay, duplicate, jitter, host)
    plan = interruptible(plan_of)(study, setting or 0, asked.get("seed", study.seed), trial, air, micropython)
    faults = faults_of(fault, plan.setting.robots, plan.period, plan.seconds)
    with contextlib.ExitStack() as stack:
        served: list[Any] = []
        if watch:
            from swarmcensus.live import Served, bound, offer_of, serving, warm

            socket = stack.enter_context(bound(HOST, port or 0))

        def show(swarm: "RunningSwarm") -> None:
            """Start to serve when a robot has written into its log."""
            if watch and not served and any(known.last and known.last.ticks for known in swarm.robots):
                served.append(Served(offer_of(folder), HOST, socket))
                stack.enter_context(serving(served[0]))
                warm(served[0], {})
                address = served[0].address()
                print(f"live page: {address}", file=sys.stderr, flush=True)  # with --quiet, too: nobody can guess it
                if not no_browser:
                    open_browser(address)

        try:
            yield run(plan, faults, folder, show)
        except Interrupted as stopped:
            yield stopped.results  # type: ignore[misc]
            raise
        if served:
            say("The live page goes on showing the recording. Press Ctrl-C to stop.")
            with contextlib.suppress(KeyboardInterrupt):
                while True:
                    time.sleep(0.5)


def _study(what: str, asked: Mapping[str, Any]) -> "Study":
    """The study of this name, or the one that options describe."""
    from swarmcensus.studies import KEYS, Study

    given = {name: value for name, value in asked.items() if name in KEYS}
    if what.lower().endswith((".toml", ".nc")):
        for name in given:
            raise OptionError(f"{option(name)} does not go with a study: write it into {what}", key=name)
        return Study.load(what)
    if "setting" in asked:
        raise option_conflict("setting", None, "goes with a study: swarmcensus swarm STUDY.toml --setting 0")
    if given.get("topology") == "moving":
        raise wrong_option("topology", "moving", "robots that move have no fixed neighbours: ring, full or a file")
    values = USUAL | given | {"brain": what, "observations_per_round": 1}
    with contextlib.suppress(ValueError):  # a spread stays a text
        values["accuracy"] = float(values["accuracy"])
    tables: dict[str, Any] = {"name": "swarm", "seed": asked.get("seed", 0), "trials": asked["trial"] + 1}
    for key, value in values.items():
        tables.setdefault(KEYS[key].table, {})[key] = value
    return Study(**tables)
