"""The commands by topic, and the layout of help. It imports no parser, so that commands are listed at once."""

import shutil
import textwrap
from collections.abc import Mapping
from typing import NamedTuple

from swarmcensus.support.errors import OptionError

HELP = ("--help", "-h")
WIDEST = 100  # columns of a page of help


class UsageError(OptionError):
    """Arguments that the parser refuses."""


class Command(NamedTuple):
    """A command: its function in `cli.commands`, what it does, and whether it answers by a table (in a pipe, TSV)."""

    function: str
    text: str
    table: bool = False


TOPICS = {  # in the order of the help
    "studies": {
        "new": Command("new.new", "Write a study or a brain to start from."),
        "run": Command("run.run", "Run a study and write its results.", True),
        "status": Command("run.status", "Show how far a study is, and when it will end."),
        "show": Command("read_results.show", "Print a summary of results, one row per setting.", True),
        "compare": Command("compare.compare", "Rank brains in each world, and test their differences.", True),
        "explain": Command("explain.explain", "Compare results with theory, and show what limits the error.", True),
        "plot": Command("plot.plot", "Draw a figure of results, or of one trial in robots' logs."),
        "export": Command("export.export", "Write results as a table, or robots' logs as MCAP."),
        "merge": Command("read_results.merge", "Merge results with different settings or trials."),
        "verify": Command("read_results.verify", "Run trials again, and compare them bit for bit."),
        "replay": Command("replay.replay", "Run one trial again, and show some rounds; --out has all.", True),
    },
    "brains": {
        "brains": Command("list_brains.brains", "Print or check a brain or an adversary.", True),
        "tune": Command("tune.tune", "Search for good values of a brain's parameters."),
        "leaderboard": Command(
            "leaderboard.leaderboard", "Run all brains, and yours, in one fixed set of worlds.", True
        ),
    },
    "missions": {"plan": Command("plan.plan", "Find how many robots, or minutes, a mission needs.", True)},
    "robots": {
        "calibrate": Command("calibrate.calibrate", "Find robots' sensor accuracies b and w, with intervals.", True),
        "deploy": Command("deploy.deploy", "Write a brain's files for a robot, or check a robot."),
        "swarm": Command("swarm.swarm", "Run robots as processes that talk, or start real ones."),
        "relive": Command("relive.relive", "Run robots' brains again from their logs, to the bit.", True),
        "infer": Command("replay.infer", "Run a brain on recorded readings and links.", True),
    },
    "to look at": {
        "watch": Command("watch.watch", "Watch a trial in a browser, or write it as a page."),
        "reproduce": Command("run.reproduce", "Run the paper's evaluation: its figures and its claims.", True),
    },
    "setup": {
        "list": Command("list_brains.choices", "List what can be used by name: studies, brains, floors ...", True),
        "doctor": Command("doctor.doctor", "Show what is installed, and what is missing.", True),
    },
}
COMMANDS = {name: command for commands in TOPICS.values() for name, command in commands.items()}


def overview() -> str:
    """The page of all commands."""
    blocks = {topic: {name: one.text for name, one in commands.items()} for topic, commands in TOPICS.items()}
    blocks["options"] = {"--help, -h": "show this page, or after COMMAND its options", "--version": "show the version"}
    text = "Robot swarms with lying sensors agree on how much of a floor is black. To begin: swarmcensus reproduce"
    return page("swarmcensus COMMAND", text, blocks)


def page(usage: str, text: str, blocks: Mapping[str, Mapping[str, str]]) -> str:
    """A page of help: how a command is called, what it does, and blocks of names with what each means."""
    width = min(shutil.get_terminal_size().columns, WIDEST)
    lines = [f"Usage: {usage}", "", *textwrap.wrap(text, width)]
    for title, meanings in blocks.items():
        lines += ["", f"{title}:"]
        indent = max(map(len, meanings)) + 4
        for name, meaning in meanings.items():
            first, *others = textwrap.wrap(meaning, max(width - indent, 20), break_on_hyphens=False)
            lines += [f"  {name}".ljust(indent) + first, *(" " * indent + line for line in others)]
    return "\n".join(lines)
