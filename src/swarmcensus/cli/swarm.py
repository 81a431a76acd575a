"""The command `swarm`: robots as processes that talk over sockets. Imports wait until the command needs them."""

import argparse
import contextlib
import itertools
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.basics.errors import STOPPED, InputError, OptionError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.options import command, wrong_option
from swarmcensus.cli.deploy import number
from swarmcensus.cli.options import from_zero, positive
from swarmcensus.cli.output import answer, wrote
from swarmcensus.cli.swarm_watch import Page, add_page_options

if TYPE_CHECKING:
    from swarmcensus.studies.study import Study
    from swarmcensus.swarm.outcomes import Outcome
    from swarmcensus.swarm.plans import Air, Plan
    from swarmcensus.swarm.running import Swarm

OF_STUDIES: dict[str, Any] = {  # options that a study file has as keys, with their defaults
    "robots": 20, "topology": "ring", "loss": 0.0, "fill_ratio": 0.55, "accuracy": "0.8", "rounds": 500,
    "message": "float32", "precision": "double",
}  # fmt: skip
TIME = re.compile(r"(\d+(?:\.\d+)?)\s*(ms|s)")


def add_swarm_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `swarm`."""
    sub.add_argument("what", metavar="BRAIN|STUDY.toml", help="a brain's name or file, or a study with a fixed network")
    sub.add_argument("--setting", type=from_zero, help="of a study, its number (default: 0)")
    world = sub.add_argument_group("the swarm, in place of a study")
    world.add_argument("--robots", type=positive, metavar="N", help="processes (default: 20)")
    world.add_argument("--topology", metavar="NAME", help="who hears whom: ring, scale-free, full ... (default: ring)")
    world.add_argument("--loss", type=number, metavar="SHARE", help="of messages that are lost (default: 0)")
    world.add_argument("--fill-ratio", type=number, metavar="F", help="how much is black (default: 0.55)")
    world.add_argument("--accuracy", metavar="B", help='of sensors: 0.8 (default), or a spread "U(0.6, 0.9)"')
    world.add_argument("--rounds", type=positive, metavar="C", help="ticks of each robot (default: 500)")
    world.add_argument("--message", metavar="FORMAT", help="float32 (default), float16, ratio16 or ratio8")
    world.add_argument("--precision", metavar="WHICH", help="of robots' arithmetic: double (default) or single")
    clocks = sub.add_argument_group("clocks and radios")
    clocks.add_argument("--hz", type=number, default=10.0, help="ticks a second (default: 10)")
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
    clocks.add_argument("--host", default="127.0.0.1", help="address that sockets bind to (default: this machine only)")
    clocks.add_argument(
        "--micropython", type=from_zero, default=0, metavar="N", help="robots that run MicroPython (default: 0)"
    )
    sub.add_argument(
        "--at",
        action="append",
        default=[],
        metavar="FAULT",
        help='what happens to robots, such as "5s kill 3" or "10s partition 0-9"; may be repeated',
    )
    sub.add_argument("--trial", type=from_zero, default=0, help="which trial's readings and network (default: 0)")
    sub.add_argument("--seed", type=from_zero, help="seed of all random numbers (default: 0, or the study's)")
    sub.add_argument(
        "--out", type=Path, metavar="FOLDER", help="where logs go; it should be new (default: swarm, swarm-2 ...)"
    )
    add_page_options(sub)


def swarm(options: argparse.Namespace) -> int:
    """Run a swarm of processes."""
    from swarmcensus.cli.swarm_table import showing
    from swarmcensus.deployment.folders import check_free
    from swarmcensus.engine.threads import interruptible
    from swarmcensus.swarm.children import check_system
    from swarmcensus.swarm.faults import faults_of
    from swarmcensus.swarm.plans import plan_of
    from swarmcensus.swarm.running import Stopped, run

    check_system()
    folder = options.out or _free("swarm")
    check_free(folder, "--out")
    if folder.resolve() == Path.cwd():
        raise InputError(f"--out {folder} is the folder that you are in: it should name a new one, such as swarm")
    study, air = _study(options), _air(options)
    seed = study.seed if options.seed is None else options.seed
    plan = interruptible(plan_of)(study, options.setting or 0, seed, options.trial, air, options.micropython)
    faults = faults_of(options.at, plan.setting.robots, plan.period, plan.seconds)
    stopped = ""
    with contextlib.closing(Page(options, folder)) as page:
        try:
            with showing(plan, options) as show:

                def tell(swarm: "Swarm") -> None:
                    show(swarm)
                    page.show(swarm)

                outcome = run(plan, faults, folder, tell)
        except Stopped as after:
            outcome = after.outcome
            stopped = f"swarmcensus: stopped after {after.rounds:,} of {counted(plan.setting.rounds, 'round')}"
        _tell(options, plan, folder, outcome)
        if stopped:
            print(stopped, file=sys.stderr)
            return STOPPED
        page.stay()
    return int(bool(outcome.died) or not outcome.at_work)


def _tell(options: argparse.Namespace, plan: "Plan", folder: Path, outcome: "Outcome") -> None:
    """Print what came of a run."""
    from swarmcensus.cli.swarm_table import summary

    if options.json:
        answer("swarm", vars(outcome) | {"folder": str(folder)})
    else:
        print("\n".join(summary(plan, outcome)))
    logs = len(list(folder.glob("robot-*.log")))  # fewer if it was stopped before all had begun
    wrote(f"{folder}: {counted(logs, 'log')}" + (f"; next: {command('swarmcensus', 'relive', folder)}" if logs else ""))


def _study(options: argparse.Namespace) -> "Study":
    """The study that is given, or the one that options describe."""
    from swarmcensus.studies.study import Study

    given = {name: getattr(options, name) for name in OF_STUDIES if getattr(options, name) is not None}
    if options.what.endswith((".toml", ".nc")):
        if given:
            flag = next(iter(given)).replace("_", "-")
            raise OptionError(f"--{flag} does not go with a study: write it into {options.what}", key=flag)
        return Study.load(options.what)
    if options.setting is not None:
        raise OptionError("--setting goes with a study: swarmcensus swarm STUDY.toml --setting 0", key="setting")
    values = OF_STUDIES | given
    if not 0.0 <= values["loss"] <= 1.0:
        raise wrong_option("loss", values["loss"], "should be a share of messages, from 0 to 1")
    if values["topology"] == "moving":
        raise InputError("--topology moving: robots that move have no fixed neighbours: ring, full or a file")
    if values["message"] == "double":
        raise InputError("--message double has no bytes: float32, float16, ratio16 or ratio8 is right")
    return Study(
        name="swarm",
        seed=options.seed or 0,
        trials=options.trial + 1,
        swarm={
            "brain": options.what, "robots": values["robots"], "accuracy": _accuracy(values["accuracy"]),
            "precision": values["precision"],
        },
        world={
            "topology": values["topology"], "fill_ratio": values["fill_ratio"],
            "link_success": round(1.0 - values["loss"], 12), "message": values["message"],
        },
        schedule={"rounds": values["rounds"], "observations_per_round": 1},
    )  # fmt: skip


def _accuracy(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def _air(options: argparse.Namespace) -> "Air":
    from swarmcensus.swarm.plans import Air

    match = TIME.fullmatch(options.delay.strip())
    if match is None:
        raise wrong_option("delay", options.delay, "should be a time in ms or s, such as 50ms")
    delay = round(float(match[1]) * (1000.0 if match[2] == "s" else 1.0))
    return Air(options.hz, delay, options.duplicate, options.jitter, options.host)


def _free(name: str) -> Path:
    """A folder of this name that is not there yet, or with a number behind it."""
    names = itertools.chain([name], (f"{name}-{k}" for k in itertools.count(2)))
    return next(path for path in map(Path, names) if not path.exists())
