"""Whether a board computes what it should: its self-test's output compared to that of CPython in the same precision."""

import ast
import builtins
import contextlib
import io
import math
import struct
import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus import brains
from swarmcensus.brains import Numbers, slots
from swarmcensus.robots.target import in_single
from swarmcensus.runtime import codec, runtime
from swarmcensus.support.answers import Answer
from swarmcensus.support.documents import json_value
from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.formatting import counted
from swarmcensus.translation import BOARDS, codec as codec_of

DOUBLE, SINGLE = 53, 24  # binary digits of 8-byte and 4-byte floats
CLOSE = {DOUBLE: 1e-12, SINGLE: 1e-4}  # what exp, log and the reading of constants may differ by, relative above 1
ROUGH = 1e-2  # for boards with fewer digits
SHOWN = 8  # differences in words
FIRST, LAST = "selftest 1", "selftest ends"


@dataclass(frozen=True)
class BoardDifference:
    """A number that a board has otherwise."""

    tick: int
    robot: int
    field: str
    board: float
    reference: float

    def __str__(self) -> str:
        """The difference in words."""
        where = f"tick {self.tick}, robot {self.robot}, {self.field}"
        return f"{where}: {self.board:.9g} on the board, {self.reference:.9g} in the reference"


@dataclass(repr=False)
class Comparison(Answer):
    """A board's self-test and the reference."""

    brain: str
    bits: int  # binary digits of the board's numbers
    numbers: int  # compared
    equal: int  # of these, to the bit
    largest: float  # difference, relative above 1
    allowed: float
    wrong: tuple[BoardDifference, ...]  # beyond what is allowed
    datagrams: int  # compared
    datagrams_equal: int

    @property
    def miscoded(self) -> int:
        """Datagrams that differ although all numbers are equal; a number that differs a little may change a code."""
        return self.datagrams - self.datagrams_equal if self.equal == self.numbers else 0

    @property
    def code(self) -> int:  # type: ignore[override]
        """0 if all numbers are close enough, and all datagrams equal if all numbers are; else 2."""
        return 2 if self.wrong or self.miscoded else 0

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """Whether the board computes what it should, and what was compared."""
        verdict = "the board computes what it should"
        if self.wrong:
            verdict = f"FAIL: more than {self.allowed:g} apart"
        elif self.miscoded:
            verdict = f"FAIL: {self.miscoded:,} datagrams differ, although all numbers are equal"
        return [
            verdict, f"{self.brain}: {self.bits} binary digits on the board, and in the reference",
            f"largest difference {self.largest:.1e}, relative above 1",
            f"{counted(self.numbers, 'number')} compared, {self.equal:,} equal to the bit",
            f"{self.datagrams:,} datagrams compared, {self.datagrams_equal:,} equal",
            *map(str, self.wrong[:SHOWN]), *[f"... and {len(self.wrong) - SHOWN:,} more"] * (len(self.wrong) > SHOWN),
        ]  # fmt: skip

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """The same numbers, and all differences."""
        return {**json_value(self), "passes": not self.code}


def compare(output: str, folder: Path) -> Comparison:
    """Compare what a board printed with the reference for the files in `folder`. Raises InputError."""
    lines = _lines(output)
    settings = _settings(folder / "settings.py")
    name, mark, bits = _head(lines[0])
    if (name, mark) != (settings["BRAIN"], settings["MARK"]):
        both = f"the brain {name!r} with the mark {mark}, the folder {folder} of {settings['BRAIN']!r}"
        right = f"with {settings['MARK']}: give the folder whose files are on the board"
        raise InputError(f"the output is of {both} {right}", file=folder)
    brain = brains.load(str(folder / "brain.py"))
    for ours in (Path(codec.__file__), Path(runtime.__file__), BOARDS / "selftest.py"):
        path = folder / ours.name
        if ast.dump(_parsed(path)) != ast.dump(_parsed(ours)):  # the reference runs ours
            other = f"{path} is not the one of this swarmcensus: deploy into a new folder, and copy it again"
            raise InputError(other, file=path)
    try:
        with brains.returning([brain]):
            expected = _lines(reference(brain, settings, single=bits < DOUBLE))
    except BrainError:
        raise
    except Exception as error:  # whatever settings that are no longer ours make it raise
        raise InputError.of(folder / "settings.py", f"the self-test cannot run with these settings: {error}") from error
    fields = [*(slot for field in sorted(brain.lengths) for slot in slots({field: brain.lengths[field]})), "estimate"]
    there, here = list(_values(lines)), list(_values(expected))
    if [row[0] for row in there] != [row[0] for row in here]:
        raise InputError("the output is not whole: it lacks lines of the self-test")
    if any(len(row[2]) != len(fields) for row in there):
        raise InputError(f"the output has lines without the {len(fields)} numbers that they should have")
    allowed = CLOSE.get(bits, ROUGH)
    numbers = equal = same = 0
    largest, wrong = 0.0, []
    for ((tick, robot), said, values), (_, expected_said, expected_values) in zip(there, here, strict=True):
        same += said == expected_said
        for field, x, y in zip(fields, values, expected_values, strict=True):
            numbers += 1
            equal += x == y
            apart = 0.0 if x == y else abs(x - y) / max(1.0, abs(y))
            largest = max(largest, apart) if not math.isnan(apart) else math.inf
            if not apart <= allowed:
                wrong.append(BoardDifference(tick, robot, field, x, y))
    return Comparison(name, bits, numbers, equal, largest, allowed, tuple(wrong), len(there), same)


def reference(brain: brains.Brain, settings: Mapping[str, Any], single: bool) -> str:
    """What the self-test prints in CPython, in double or single precision; `settings` are those of a folder."""
    given = dict(settings)
    if single:
        brain = brain.with_numbers(Numbers(precision="single"))
        given |= {"PARAMETERS": in_single(given["PARAMETERS"]), **in_single({key: given[key] for key in ("B", "W")})}
    settings_module = types.SimpleNamespace(**given)
    modules = {"brain": brain.functions, "settings": settings_module, "codec": codec_of(single)[3]}
    modules["runtime"] = _module(Path(runtime.__file__), modules)
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        _module(BOARDS / "selftest.py", modules)
    text = printed.getvalue()
    return text.replace(f"bits {DOUBLE}", f"bits {SINGLE}") if single else text


def _module(path: Path, modules: Mapping[str, Any]) -> types.ModuleType:
    """A file run as a board runs it: it finds only `modules` and those of Python."""

    def find(name: str, *rest: Any) -> Any:
        if rest and rest[-1] == 1 and not name:  # from . import
            raise ImportError
        return modules[name] if name in modules else builtins.__import__(name, *rest)

    made = types.ModuleType(path.stem)
    made.__dict__["__builtins__"] = {**vars(builtins), "__import__": find}
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), made.__dict__)
    return made


def _lines(output: str) -> list[str]:
    """The self-test's lines; what a terminal printed around them is left out."""
    lines = [line.strip() for line in output.splitlines()]
    begins = [k for k, line in enumerate(lines) if line.startswith(FIRST)]
    if not begins:
        raise InputError(f"the output has no line that begins with {FIRST!r}: run selftest.py on the board")
    lines = lines[begins[-1] :]
    if LAST not in lines:
        raise InputError(f"the output is not whole: the line {LAST!r} is missing")
    return lines[: lines.index(LAST)]


def _head(line: str) -> tuple[str, int, int]:
    words = line.removeprefix(FIRST).split()
    try:
        *name, mark, _, bits = words
        return " ".join(name), int(mark), int(bits)
    except ValueError:
        raise InputError(f"the output's first line is {line!r}: it should name a brain, a mark and bits") from None


def _values(lines: list[str]) -> Iterator[tuple[tuple[int, int], str, list[float]]]:
    """The tick and robot, the datagram and the numbers of each line."""
    for line in lines:
        if line.startswith("tick "):
            try:
                _, tick, robot, said, *values = line.split()
                numbers = [struct.unpack(">d", bytes.fromhex(value))[0] for value in values]
                yield (int(tick), int(robot)), said, numbers
            except (ValueError, struct.error):
                raise InputError(f"the output has a damaged line: {line[:60]!r}") from None


def _settings(path: Path) -> dict[str, Any]:
    """The constants of a settings file, which is not run. Raises InputError."""
    found = {}
    for node in _parsed(path).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            try:
                found[node.targets[0].id] = ast.literal_eval(node.value)
            except ValueError:
                raise InputError(f"{path}, line {node.lineno}: should be a plain value", file=path) from None
    missing = [key for key in ("BRAIN", "B", "W", "PARAMETERS", "LENGTHS", "PLAN", "MARK") if key not in found]
    if missing:
        raise InputError.of(path, f"{missing[0]} is missing: the file is made by `swarmcensus deploy`")
    return found


def _parsed(path: Path) -> ast.Module:
    try:
        return ast.parse(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError.of(
            path, f"{error.strerror}: the folder should be one made by `swarmcensus deploy`, for MicroPython"
        ) from None
    except (SyntaxError, UnicodeDecodeError) as error:
        raise InputError.of(path, f"not Python: {error}") from None
