"""The parser, which suggests what was probably meant, the types of option values, and options of several commands."""

import argparse
import re
from typing import Any, NoReturn

from swarmcensus.basics.hints import did_you_mean

DIGITS = 18  # of a number, so that it fits into 64 bits


class Parser(argparse.ArgumentParser):
    """A parser whose errors suggest what was probably meant."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Refuse unknown arguments here, where the options of this command are known and one can be suggested."""
        self.given = [argument for argument in args or [] if argument.startswith("--")]
        parsed, rest = super().parse_known_args(args, namespace)
        if rest:
            unknown = next((argument for argument in rest if argument.startswith("-")), rest[0])
            hint = did_you_mean(
                unknown.partition("=")[0], (o for o in self._option_string_actions if o.startswith("--"))
            )
            self.error(f"unrecognized arguments: {' '.join(rest)}" + (f" ({hint.rstrip()})" if hint else ""))
        return parsed, rest

    def error(self, message: str) -> NoReturn:
        """Print the message, with a suggestion for an unknown choice or for a required option that is misspelt."""
        wrong = re.search(r"invalid choice: '(.*)' \(choose from (.*)\)", message)
        hint = did_you_mean(wrong[1], re.findall(r"[\w-]+", wrong[2])) if wrong else ""
        if message.startswith("the following arguments are required"):
            options = [option for option in self._option_string_actions if option.startswith("--")]
            names = (argument.partition("=")[0] for argument in self.given)
            unknown = (name for name in names if not any(option.startswith(name) for option in options))
            hint = next(filter(None, (did_you_mean(name, options) for name in unknown)), "")
        super().error(f"{message}: {hint.rstrip()}" if hint else message)


def add_output_options(sub: argparse.ArgumentParser, json: bool) -> None:
    """Add --quiet and --verbose, and --json if the command prints a table."""
    sub.set_defaults(json=False)
    group = sub.add_argument_group("output")
    if json:
        group.add_argument("--json", action="store_true", help="print one JSON document on stdout, and nothing else")
    volume = group.add_mutually_exclusive_group()
    volume.add_argument("-q", "--quiet", action="store_true", help="print only answers and errors")
    volume.add_argument("-v", "--verbose", action="store_true", help="also report each step on stderr")


def add_run_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of all commands that run studies and write their results."""
    sub.add_argument(
        "--jobs", type=positive, help="number of threads (default: one per core); results do not depend on it"
    )
    sub.add_argument("--trials", type=positive, help="trials per setting, instead of the study's own number")
    sub.add_argument("--seed", type=from_zero, help="seed of all random numbers, instead of the study's own")
    sub.add_argument("--fresh", action="store_true", help="start over instead of continuing what --out holds")


def name_list(text: str) -> list[str]:
    """Names separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def share(text: str) -> tuple[int, int]:
    """A share of the trials, as 1/4. Raises ArgumentTypeError."""
    k, slash, n = text.partition("/")
    if not (slash and k.isdecimal() and n.isdecimal() and len(text) <= DIGITS):
        raise argparse.ArgumentTypeError(f"{text!r}: should be such as 1/4")
    return int(k), int(n)


def positive(text: str) -> int:
    """A whole number from 1. Raises ArgumentTypeError."""
    return _whole(text, 1)


def from_zero(text: str) -> int:
    """A whole number from 0. Raises ArgumentTypeError."""
    return _whole(text, 0)


def round_or_time(text: str) -> Any:
    """A whole number from 0, or a time with a unit. Raises ArgumentTypeError."""
    from swarmcensus.basics.times import parse_time

    if text.strip()[-1:].isalpha():  # a unit
        try:
            return parse_time(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{text[:40]!r}: {error}") from None
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= DIGITS and int(text) >= least):
        raise argparse.ArgumentTypeError(f"{text[:40]!r}: should be a whole number from {least}")
    return int(text)
