"""What all commands have in common: a parser that says what was meant, and how much a command says."""

import argparse
import re
from collections.abc import Mapping
from typing import Any, NoReturn

from swarmcensus.basics.hints import did_you_mean

TABLES = (
    *("reproduce", "run", "show", "explain", "compare", "leaderboard", "tune", "plan", "status", "verify", "replay"),
    *("infer", "list", "brains", "studies", "doctor"),
)  # commands that print a table, and therefore take --json


class Parser(argparse.ArgumentParser):
    """A parser that says what was probably meant."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Refuse what is not known here, where the options that are known here can be named."""
        self.given = [one for one in args or [] if one.startswith("--")]
        found, rest = super().parse_known_args(args, namespace)
        if rest:
            strange = next((one for one in rest if one.startswith("-")), rest[0])
            hint = did_you_mean(
                strange.partition("=")[0], (o for o in self._option_string_actions if o.startswith("--"))
            )
            self.error(f"unrecognized arguments: {' '.join(rest)}" + (f" ({hint.rstrip()})" if hint else ""))
        return found, rest

    def error(self, message: str) -> NoReturn:
        """Say it, and which choice was meant by one that is not known, or which option that is lacking."""
        wrong = re.search(r"invalid choice: '(.*)' \(choose from (.*)\)", message)
        hint = did_you_mean(wrong[1], re.findall(r"[\w-]+", wrong[2])) if wrong else ""
        if message.startswith("the following arguments are required"):
            options = [one for one in self._option_string_actions if one.startswith("--")]
            names = (one.partition("=")[0] for one in self.given)
            strange = (one for one in names if not any(known.startswith(one) for known in options))
            hint = next(filter(None, (did_you_mean(one, options) for one in strange)), "")
        super().error(f"{message}: {hint.rstrip()}" if hint else message)


def add_output_options(commands: Mapping[str, argparse.ArgumentParser]) -> None:
    """Give every command --quiet and --verbose, and --json to those that print a table."""
    for name, command in commands.items():
        command.set_defaults(json=False)
        group = command.add_argument_group("output")
        if name in TABLES:
            group.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else")
        loud = group.add_mutually_exclusive_group()
        loud.add_argument("-q", "--quiet", action="store_true", help="answers and errors, and nothing else")
        loud.add_argument(
            "-v", "--verbose", action="store_true", help="also what is compiled, found and finished, on stderr"
        )
