"""The command `swarm`: robots as processes that talk over sockets. Imports wait until the command needs them."""

import argparse
import contextlib
import itertools
import re
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.cli.options import Command, Group, add_shared, from_zero, number, positive, share

from swarmcensus.cli.output import answer, say, wrote
from swarmcensus.support.errors import STOPPED, OptionError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command, misplaced, option, wrong_option

if TYPE_CHECKING:
    from swarmcensus.robots import Air, Outcome, RunningSwarm, SwarmPlan
    from swarmcensus.studies import Study

OF_STUDIES: dict[str, Any] = {  # keys of a study file, with their defaults if they differ from a study's
    "robots": 20, "topology": "ring", "link_success": None, "fill_ratio": 0.55, "accuracy": "0.8", "rounds": 500,
    "message": "float32", "precision": None,
}  # fmt: skip
TIME = re.compile(r"(\d+(?:\.\d+)?)\s*(ms|s)")


def add_swarm_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `swarm`."""
    sub.add_argument("what", metavar="BRAIN|STUDY.toml", help="a brain's name or file, or a study with a fixed network")
    add_shared(sub, setting="of a study; default: 0")
    world = sub.add_argument_group("the swarm, in place of a study")
    world.add_argument("--robots", type=positive, metavar="N", help="processes (default: 20)")
    world.add_argument("--topology", metavar="NAME", help="who hears whom: ring, scale-free, full ... (default: ring)")
    world.add_argument("--link-success", type=share, metavar="SHARE", help="share of messages that arrive (default: 1)")
    add_shared(world, fill_ratio="default: 0.55")
    world.add_argument("--accuracy", metavar="B", help='of sensors: 0.8 (default), or a spread "U(0.6, 0.9)"')
    world.add_argument("--rounds", type=positive, metavar="C", help="ticks of each robot (default: 500)")
    add_shared(world, message="default: float32", precision="default: double")
    clocks = sub.add_argument_group("clocks and radios")
    add_shared(clocks, hz="default: 10")
    clocks.add_argument(
        "--jitter",
        type=number,
        default=0.1,
        metavar="SHARE",
        help="of a period that ticks are late by, at most (default: 0.1)",
    )
    clocks.add_argument("--delay", default="0ms", metavar="TIME", help="of each message, such as 50ms (default: 0ms)")
    clocks.add_argument(
        "--duplicate", type=number, default=0.0, metavar="SHARE", help="of messages that are heard twice (default: 0)"
    )
    add_shared(clocks, "host")
    clocks.add_argument(
        "--micropython", type=from_zero, default=0, metavar="N", help="robots that run MicroPython (default: 0)"
    )
    sub.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="FAULT",
        help='what happens to robots, such as "5s kill 3" or "10s partition 0-9"; may be repeated',
    )
    add_shared(sub, trial="default: 0", seed="default: 0")
    sub.add_argument(
        "--out", type=Path, metavar="FOLDER", help="where logs go; it should be new (default: swarm, swarm-2 ...)"
    )
    add_page_options(sub)


def swarm(options: argparse.Namespace) -> int:
    """Run a swarm of processes."""
    from swarmcensus.cli.swarm_table import showing

    from swarmcensus.engine import interruptible
    from swarmcensus.robots import Stopped, check_free, check_system, faults_of, plan_of, run

    check_system()
    folder = options.out or _free("swarm")
    check_free(folder)
    if folder.resolve() == Path.cwd():
        raise wrong_option("out", folder, "this is the folder that you are in: name a new one, such as swarm")
    study, air = _study(options), _air(options)
    seed = study.seed if options.seed is None else options.seed
    plan = interruptible(plan_of)(study, options.setting or 0, seed, options.trial or 0, air, options.micropython)
    faults = faults_of(options.fault, plan.setting.robots, plan.period, plan.seconds)
    stopped = ""
    with contextlib.closing(Page(options, folder)) as page:
        try:
            show = showing(plan, options)

            def tell(swarm: "RunningSwarm") -> None:
                show(swarm)
                page.show(swarm)

            outcome = run(plan, faults, folder, tell)
        except Stopped as after:
            outcome = after.outcome
            stopped = f"swarmcensus: stopped after {after.rounds:,} of {counted(plan.setting.rounds, 'round')}"
        _report(options, plan, folder, outcome)
        if stopped:
            print(stopped, file=sys.stderr)
            return STOPPED
        page.stay()
    return int(bool(outcome.died) or not outcome.at_work)


def _report(options: argparse.Namespace, plan: "SwarmPlan", folder: Path, outcome: "Outcome") -> None:
    """Print the outcome of a run."""
    from swarmcensus.cli.swarm_table import summary

    if options.json:
        answer("swarm", vars(outcome) | {"folder": str(folder)})
    else:
        print("\n".join(summary(plan, outcome)))
    logs = len(list(folder.glob("robot-*.log")))  # fewer if it was stopped before all had begun
    wrote(f"{folder}: {counted(logs, 'log')}" + (f"; next: {command('swarmcensus', 'relive', folder)}" if logs else ""))


def _study(options: argparse.Namespace) -> "Study":
    """The given study, or the one that options describe."""
    from swarmcensus.studies import KEYS, Study

    given = {name: getattr(options, name) for name in OF_STUDIES if getattr(options, name) is not None}
    if options.what.lower().endswith((".toml", ".nc")):
        if given:
            name = next(iter(given))
            raise OptionError(f"{option(name)} does not go with a study: write it into {options.what}", key=name)
        return Study.load(options.what)
    if options.setting is not None:
        raise misplaced("setting", None, "goes with a study: swarmcensus swarm STUDY.toml --setting 0")
    values = OF_STUDIES | given
    if values["topology"] == "moving":
        raise wrong_option("topology", "moving", "robots that move have no fixed neighbours: ring, full or a file")
    values |= {"brain": options.what, "accuracy": _accuracy(values["accuracy"]), "observations_per_round": 1}
    tables: dict[str, Any] = {"name": "swarm", "seed": options.seed or 0, "trials": (options.trial or 0) + 1}
    for key, value in values.items():
        if value is not None:
            tables.setdefault(KEYS[key].table, {})[key] = value
    return Study(**tables)


def _accuracy(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def _air(options: argparse.Namespace) -> "Air":
    from swarmcensus.robots import Air

    match = TIME.fullmatch(options.delay.strip())
    if match is None:
        raise wrong_option("delay", options.delay, "should be a time in ms or s, such as 50ms")
    delay = round(float(match[1]) * (1000.0 if match[2] == "s" else 1.0))
    return Air(10.0 if options.hz is None else options.hz, delay, options.duplicate, options.jitter, options.host)


def _free(name: str) -> Path:
    """A new folder of this name, with a number behind it if the name is taken."""
    names = itertools.chain([name], (f"{name}-{k}" for k in itertools.count(2)))
    return next(path for path in map(Path, names) if not path.exists())


HOST = "127.0.0.1"  # the page is for this machine, wherever robots' sockets listen


def add_page_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of the live page."""
    page = sub.add_argument_group("the live page")
    page.add_argument("--watch", action="store_true", help="show the swarm in a browser while it runs, until Ctrl-C")
    add_shared(page, "port", "no_browser")


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
            from swarmcensus.live import bound

            self._socket = self._stack.enter_context(bound(HOST, options.port or 0))

    def show(self, swarm: "RunningSwarm") -> None:
        """Start to serve when there is something to show."""
        if not self._waits or not any(known.last and known.last.ticks for known in swarm.robots):
            return
        from swarmcensus.cli.commands.watch import open_browser

        from swarmcensus.live import Served, offer_of, serving, warm

        self._waits = False
        served = Served(offer_of(self.folder), HOST, self._socket)
        self._stack.enter_context(serving(served))
        self._serves = True
        warm(served, {})
        print(f"live page: {served.address()}", file=sys.stderr, flush=True)  # with --quiet, too: nobody can guess it
        if not self.options.no_browser:
            open_browser(served.address())

    def stay(self) -> None:
        """Continue to serve after the swarm's end, until Ctrl-C."""
        if self._serves:
            say("The live page goes on showing the recording. Press Ctrl-C to stop.")
            with contextlib.suppress(KeyboardInterrupt):
                while True:
                    time.sleep(0.5)

    def close(self) -> None:
        """End the server."""
        self._stack.close()


COMMANDS = (
    Command(
        "swarm", "Run robots as processes that talk over sockets.",
        Group.ROBOTS, 2, swarm, add_swarm_options,
    ),
)  # fmt: skip
