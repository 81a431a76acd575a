"""The command `completion`."""

import argparse
from pathlib import Path

from swarmcensus.cli.options import Command, Group


def add_completion_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `completion`."""
    sub.add_argument(
        "shell",
        choices=("bash", "zsh", "tcsh"),
        metavar="bash|zsh|tcsh",
        help="for bash: swarmcensus completion bash > ~/.local/share/bash-completion/completions/swarmcensus",
    )


def completion(options: argparse.Namespace) -> int:
    """Print the script that makes a shell complete commands, options and files."""
    import shtab

    from swarmcensus.cli.commands import parser

    top = parser()
    [commands] = [action for action in top._actions if isinstance(action, argparse._SubParsersAction)]
    for sub in commands.choices.values():
        for action in sub._actions:
            if action.type is Path:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(top, options.shell))
    return 0


COMMANDS = (
    Command(
        "completion", "Print the script that makes a shell complete commands, options and files.", Group.SETUP,
        completion, add_completion_options, json=False,
    ),
)  # fmt: skip
