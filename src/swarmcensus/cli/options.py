"""What the options of all commands share: a parser that says what was meant, types of values, common options."""

import argparse
import re
from typing import Any, NoReturn

from swarmcensus.basics.hints import did_you_mean

DIGITS = 18  # of a number, so that it fits into 64 bits


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


def add_output_options(sub: argparse.ArgumentParser, json: bool) -> None:
    """Give a command --quiet and --verbose, and --json if it prints a table."""
    sub.set_defaults(json=False)
    group = sub.add_argument_group("output")
    if json:
        group.add_argument("--json", action="store_true", help="one JSON document on stdout, and nothing else")
    loud = group.add_mutually_exclusive_group()
    loud.add_argument("-q", "--quiet", action="store_true", help="answers and errors, and nothing else")
    loud.add_argument(
        "-v", "--verbose", action="store_true", help="also what is compiled, found and finished, on stderr"
    )


def add_run_options(sub: argparse.ArgumentParser) -> None:
    """The options of all commands that run a study and keep its results."""
    sub.add_argument("--jobs", type=positive, help="threads (default: one a core); the numbers do not depend on it")
    sub.add_argument("--trials", type=positive, help="instead of the study's own number")
    sub.add_argument("--seed", type=from_zero, help="instead of the study's own")
    sub.add_argument("--fresh", action="store_true", help="begin anew instead of going on with what --out holds")


def name_list(text: str) -> list[str]:
    """Names with commas between them."""
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
