"""The command `completion`: what makes a shell complete commands, options and files."""

import argparse
from collections import defaultdict
from pathlib import Path


def completion(options: argparse.Namespace) -> int:
    """Print the script of a shell."""
    import shtab

    from swarmcensus.cli.options import parser

    top = parser(defaultdict(lambda: completion))  # nothing is called
    for sub in _parsers(top):
        for action in sub._actions:
            if action.type is Path:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(top, options.shell))
    return 0


def _parsers(top: argparse.ArgumentParser) -> list[argparse.ArgumentParser]:
    """One for each command."""
    [commands] = [one for one in top._actions if isinstance(one, argparse._SubParsersAction)]
    return list(commands.choices.values())
