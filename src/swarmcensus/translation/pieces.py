"""Pieces of programs in `boards/`: texts with ${names} in the places of values, and files with several functions."""

import functools
import re
from collections.abc import Mapping
from pathlib import Path
from string import Template

BOARDS = Path(__file__).parent / "boards"


@functools.cache
def piece(name: str) -> str:
    """The text of a file."""
    return (BOARDS / name).read_text(encoding="utf-8")


def filled(file: str, /, **values: object) -> str:
    """The text of a file with values in the places of their names."""
    return Template(piece(file)).substitute(values)


@functools.cache
def functions(name: str) -> Mapping[str, str]:
    """The functions in a file by name: each begins with a line such as `//: number_min`."""
    _, *parts = re.split(r"^//: (\w+)\n", piece(name), flags=re.MULTILINE)
    return {name: f"\n{text.rstrip()}" for name, text in zip(parts[::2], parts[1::2], strict=True)}
