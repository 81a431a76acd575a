"""The command `translate`. Imports wait until it needs them."""

import argparse
from pathlib import Path

from swarmcensus.basics.errors import OptionError
from swarmcensus.basics.options import command, wrong_option
from swarmcensus.cli.output import answer, say, wrote

NUMBERS = {"float": "single", "double": "double"}  # types of C, and the precisions they have
MESSAGES = ("float32", "float16", "ratio16", "ratio8")


def add_translate_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `translate`."""
    sub.add_argument("brain", metavar="BRAIN", help="a brain's name, or its file")
    sub.add_argument("--to", choices=("c",), required=True, metavar="c", help="the language: C, as of 1999")
    sub.add_argument(
        "--number",
        choices=tuple(NUMBERS),
        default="float",
        metavar="|".join(NUMBERS),
        help="the type of all numbers (default: float, of 4 bytes)",
    )
    sub.add_argument(
        "--parameter",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="value of a parameter, such as every=10, or weights=0.5,0.3,0.2 for a vector; may be repeated",
    )
    sub.add_argument(
        "--message",
        choices=MESSAGES,
        default="float32",
        metavar="|".join(MESSAGES),
        help="how numbers become bytes in messages (default: float32)",
    )
    sub.add_argument("--out", type=Path, metavar="FOLDER", help="folder to write to (default: BRAIN-c)")


def translate(options: argparse.Namespace) -> int:
    """Write a brain as C, with a self-test."""
    from swarmcensus.brains import load
    from swarmcensus.brains.packing import Numbers
    from swarmcensus.deployment.translating import write

    brain = load(options.brain)
    given = dict(_parameter(text) for text in options.parameter)
    try:
        brain = brain.with_parameters(given)
    except ValueError as error:
        raise OptionError(f"--parameter: {error}", key="parameter") from None
    brain = brain.with_numbers(Numbers(precision=NUMBERS[options.number], message=options.message))  # type: ignore[arg-type]
    folder = options.out or Path(f"{Path(options.brain).stem}-c")
    paths = write(brain, folder)
    for path in paths:
        wrote(path)
    if options.json:
        about = {"brain": brain.label, "number": options.number, "message": options.message}
        size = {"memory_bytes": brain.memory_bytes, "message_bytes": brain.message_bytes}
        answer("translation", about | size | {"files": [str(path) for path in paths]})
    say(f"next: {command('make', '-C', folder, 'check')}, which compares the C with Python bit for bit")
    return 0


def _parameter(text: str) -> tuple[str, float | tuple[float, ...]]:
    """The name and the value in a text such as every=10."""
    name, equals, value = text.partition("=")
    try:
        numbers = tuple(float(part) for part in value.split(","))
    except ValueError:
        numbers = ()
    if not equals or not numbers:
        raise wrong_option("parameter", text, "a name and a number, such as every=10, are right")
    return name.strip(), numbers if len(numbers) > 1 else numbers[0]
