"""The command `swarm`: robots as processes that talk over sockets. Imports wait until the command needs them."""

import contextlib
import itertools
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from swarmcensus.cli.commands.watch import open_browser
from swarmcensus.cli.messages import say
from swarmcensus.cli.parameters import (  # fmt: skip
    FILE,
    FOLDER,
    NUMBER,
    WHOLE,
    NoBrowser,
    Port,
    Seed,
    Set,
    takes,
    values_of,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, Interrupted
from swarmcensus.support.options import option_conflict, wrong_option

if TYPE_CHECKING:
    from swarmcensus.robots import Fleet, RunningSwarm
    from swarmcensus.studies import Study

USUAL: dict[str, Any] = {  # the study of a brain
    "name": "swarm", "trials": 1000, "swarm": {"robots": 20, "accuracy": 0.8},
    "world": {"topology": "ring", "fill_ratio": 0.55, "message": "float32"},
    "schedule": {"rounds": 500, "observations_per_round": 1},
}  # fmt: skip
ADDRESS = Parameter(metavar="ADDRESS")
HOST = "127.0.0.1"  # the page is for this machine, wherever robots' sockets listen


def milliseconds(text: str) -> int:
    """A time in ms or s."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*(ms|s)", text.strip())
    if match is None:
        raise ValueError("should be a time in ms or s, such as 50ms")
    return round(float(match[1]) * (1000.0 if match[2] == "s" else 1.0))


def swarm(
    what: Annotated[str, Parameter(metavar="BRAIN|STUDY.toml")], /, *, set: Set = (),
    setting: Annotated[int, WHOLE] = 0, hz: Annotated[float, NUMBER] = 10.0,
    jitter: Annotated[float, NUMBER] = 0.1, delay: Annotated[int, takes(milliseconds, "TIME")] = 0,
    duplicate: Annotated[float, NUMBER] = 0.0, host: Annotated[str | None, ADDRESS] = None,
    trial: Annotated[int, WHOLE] = 0, seed: Seed = None, out: Annotated[Path | None, FOLDER] = None,
    on: Annotated[Path | None, FILE] = None, duration: Annotated[int | None, takes(milliseconds, "TIME")] = None,
    watch: bool = False, port: Port = None, no_browser: NoBrowser = False,
) -> Iterator[Answer]:  # fmt: skip
    """Run robots as processes that talk, or start real ones.

    Args:
        what: a study with a fixed network, or a brain, for 20 robots on a ring
        setting: number of the setting of a study (default: 0)
        hz: ticks a second (default: 10)
        jitter: share of a period that ticks are late by, at most (default: 0.1)
        delay: delay of each message, such as 50ms (default: 0ms)
        duplicate: share of messages that are heard twice (default: 0)
        trial: number of the trial (default: 0)
        out: where logs go; it should be new (default: swarm, swarm-2 ...)
        host: address to listen on (default: this machine only; with --on, all); with --on also usb, for robots' serial
            ports, or the serial port of a gateway
        on: file of robots: start those that wait, deployed with --report, and write what they report into logs; all
            should report within 30 s; of the keys, only fill_ratio can be set
        duration: with --on, stop the robots after so long, such as 600s (default: at Ctrl-C)
        watch: show the swarm in a browser while it runs, until Ctrl-C
    """
    values = values_of(set, seed=seed)
    truth = values.pop("fill_ratio", None) if on else None
    processes = {
        "set": values, "setting": setting, "trial": trial, "seed": seed, "delay": delay, "duplicate": duplicate,
        "hz": hz != 10.0 and hz, "jitter": jitter != 0.1 and jitter,
    }  # fmt: skip
    from swarmcensus.brains import load
    from swarmcensus.engine import interruptible
    from swarmcensus.robots import Air, check_free, links_to, plan_of, run, run_fleet
    from swarmcensus.worlds import read_robots

    for name, value in processes.items():
        if on and value:
            raise option_conflict(name, value if name != "set" else None, "is for processes: it does not go with --on")
    if duration is not None and on is None:
        raise option_conflict("duration", None, "goes with --on")
    for name, given in (("port", port is not None), ("no_browser", no_browser)):
        if given and not watch:
            raise option_conflict(name, None, "is for the live page: it goes with --watch")
    names = itertools.chain(["swarm"], (f"swarm-{k}" for k in itertools.count(2)))
    folder = out or next(path for path in map(Path, names) if not path.exists())
    check_free(folder)
    if folder.resolve() == Path.cwd():
        raise wrong_option("out", folder, "this is the folder that you are in: name a new one, such as swarm")
    start: Callable[..., Answer]
    if on is not None:
        robots, brain = read_robots(on), load(what)
        if watch:
            from swarmcensus.live import MOST_CONNECTED, MOST_ROBOTS

            largest, most = max(one.number for one in robots), MOST_ROBOTS if brain.sums else MOST_CONNECTED
            if largest >= most:
                raise InputError.of(on, f"number = {largest}: the live page has places up to {most - 1:,}")
        start = partial(
            run_fleet, brain, robots, folder, links_to(robots, host),
            seconds=duration and duration / 1000, fill_ratio=truth,
        )  # fmt: skip
    else:
        study = _study(what, values).with_(seed=seed)
        air = Air(hz, delay, duplicate, jitter, host or HOST)
        start = partial(run, interruptible(plan_of)(study, setting, study.seed, trial, air), folder)
    with contextlib.ExitStack() as stack:
        served: list[Any] = []
        if watch:
            from swarmcensus.live import Served, bound, offer_of, serving, warm

            socket = stack.enter_context(bound(HOST, port or 0))

        def show(swarm: "RunningSwarm | Fleet") -> None:
            """Start to serve when a robot has written into its log."""
            if watch and not served and swarm.has_ticks:
                served.append(Served(offer_of(folder), HOST, socket))
                stack.enter_context(serving(served[0]))
                warm(served[0], {})
                address = served[0].address()
                print(f"live page: {address}", file=sys.stderr, flush=True)  # with --quiet, too: nobody can guess it
                if not no_browser:
                    open_browser(address)

        try:
            yield start(show=show)
        except Interrupted as stopped:
            yield stopped.results  # type: ignore[misc]
            raise
        if served:
            say("The live page goes on showing the recording. Press Ctrl-C to stop.")
            with contextlib.suppress(KeyboardInterrupt):
                while True:
                    time.sleep(0.5)


def _study(what: str, values: Mapping[str, Any]) -> "Study":
    """The study of this name, or one of a brain, with other values of some keys."""
    from swarmcensus.studies import Study, with_values

    if what.lower().endswith((".toml", ".nc")):
        return Study.load(what, values)
    of_swarm = values.get("swarm")
    if "brain" in {key.rpartition(".")[2] for key in values} or (isinstance(of_swarm, Mapping) and "brain" in of_swarm):
        raise option_conflict("set", "brain=...", f"does not go with {what}, which is the brain")
    if isinstance(of_swarm, Mapping):
        values = {**values, "swarm": {"brain": what, **of_swarm}}
    tables = with_values(USUAL, {"brain": what})
    if with_values(tables, values)["world"].get("topology") == "moving":
        raise option_conflict("set", "topology=moving", "does not go: a swarm of processes needs a fixed network")
    return Study.changed(tables, values)
