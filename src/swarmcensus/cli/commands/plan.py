"""The command `plan`. Imports wait until the command needs them."""

import contextlib
import json
import re
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from swarmcensus.cli.messages import reporting
from swarmcensus.cli.parameters import (
    ASSIGNMENTS,
    COUNT,
    FILE,
    WHOLE,
    Device,
    Jobs,
    Plot,
    known,
    once,
    parameter,
    path,
    takes,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import OptionError, StudyError
from swarmcensus.support.formatting import elapsed
from swarmcensus.support.options import option, option_conflict

INSTEAD = {  # keys of the file that an option replaces in addition to its own
    "side": ("area", "density"), "area": ("side", "density"), "density": ("side", "area"),
    "half_width": ("right", "margin"), "right": ("half_width",),
}  # fmt: skip
NEEDED = {  # keys of messages about what a mission lacks, and the options of which one gives it
    "known.accuracy": ("accuracy",), "wanted": ("half_width", "right"), "area": ("side", "area", "density"),
    "free": ("robots", "minutes"),
}  # fmt: skip
EXAMPLE = "such as in swarmcensus plan --side 5 --robots 20 --accuracy 0.7 --half-width 0.02"


def amount(text: str) -> Any:
    """A number, a range LOW:HIGH, or a value of TOML."""
    from swarmcensus.support.toml_text import read_toml

    with contextlib.suppress(ValueError):
        ends = [_number(part) for part in text.split(":", 1)]
        return ends if len(ends) > 1 else ends[0]
    try:
        return read_toml(f"value = {text}", "")["value"]
    except StudyError:
        raise ValueError("should be a number, or a range such as 10:100") from None


def one_amount(text: str) -> Any:
    """The same without a range, for an option that may be repeated."""
    if isinstance(value := amount(text), list):
        raise ValueError("should be a number; to give several, repeat the option")
    return value


def word(text: str) -> Any:
    """The same, or plain words without quotation marks."""
    try:
        return amount(text)
    except ValueError:
        return text


def _number(text: str) -> float:
    try:
        return int(text)
    except ValueError:
        return float(text)


def brain_with_parameters(text: str) -> str | dict[str, Any]:
    """A brain, perhaps with values as a plan prints them: mine.py gain=1."""
    file, *given = re.split(r"\s+(?=\w+=\S)", text)
    values = [parameter(re.sub(r"[()\[\]]", "", one)) for one in given]
    return {"file": file, **once("brain", values)} if given else text


AMOUNT, RANGE = takes(amount, "X"), takes(amount, "X|LOW:HIGH")
WORD, WORDS = takes(word, "WHAT"), takes(word, "WHAT", several=True)
BRAINS = takes(brain_with_parameters, "BRAIN", several=True)


def plan(
    mission: Annotated[Path | None, takes(path, "MISSION.toml")] = None, /, *,
    side: Annotated[Any, AMOUNT] = None, area: Annotated[Any, AMOUNT] = None, floor: Annotated[Any, WORD] = None,
    accuracy: Annotated[Sequence[Any], WORDS] = (), fill_ratio: Annotated[Any, RANGE] = None,
    link_success: Annotated[Any, AMOUNT] = None, precision: Literal["double", "single"] | None = None,
    message: Annotated[Any, WORD] = None, failing: Annotated[Any, AMOUNT] = None,
    lying: Annotated[Any, AMOUNT] = None, lie: Annotated[Sequence[Any], WORDS, known("brains.adversary")] = (),
    half_width: Annotated[Any, AMOUNT] = None, right: Annotated[Any, WORD] = None,
    margin: Annotated[Any, AMOUNT] = None, confidence: Annotated[Any, AMOUNT] = None,
    truth: Literal["floor", "nominal"] | None = None,
    robots: Annotated[Any, RANGE] = None, minutes: Annotated[Any, RANGE] = None,
    topology: Annotated[Sequence[Any], WORDS, known("worlds.wiring")] = (),
    density: Annotated[Sequence[Any], takes(one_amount, "X", several=True)] = (),
    observations_per_round: Annotated[Any, AMOUNT] = None, round_seconds: Annotated[Any, AMOUNT] = None,
    brain: Annotated[Sequence[Any], BRAINS, known("brains.brain", or_file=True)] = (),
    body: Annotated[Sequence[tuple[str, str]], ASSIGNMENTS] = (), schema: bool = False,
    trials: Annotated[int | None, COUNT] = None, seed: Annotated[int | None, WHOLE] = None, jobs: Jobs = None,
    device: Device = "cpu", out: Annotated[Path | None, FILE] = None, plot: Plot = None,
) -> Answer | str:  # fmt: skip
    """Find how many robots, or minutes, a mission needs.

    Args:
        mission: what the swarm should do; options below replace its keys
        side: metres: side of the square in which robots move
        area: square metres, in place of --side
        floor: such as tiles (default), half, or {clusters = 0.2}
        accuracy: of sensors: 0.7, U(0.525,0.975), {black = 0.9, white = 0.6} ...; may be repeated
        fill_ratio: black share; of a range, its worst (default: 0:1)
        link_success: share of messages that arrive (default: 1)
        precision: arithmetic of robots: double (default) or single
        message: double (default), float32, float16, ratio16 or ratio8
        failing: share that may fail before the start (default: 0)
        lying: share of robots that may lie (default: 0)
        lie: adversary (default: shouter); may be repeated
        half_width: largest error that counts as right, such as 0.02
        right: or instead: majority, or a number of bins
        margin: least distance of f from their edges, such as 0.02
        confidence: share that should be right (default: 0.95)
        truth: floor (default if robots move) or nominal
        robots: number of robots, or a range
        minutes: duration, or a range
        topology: moving (default), ring ...; may be repeated
        density: in place of --side, which follows; may be repeated
        observations_per_round: on fixed networks (default: 10)
        round_seconds: on fixed networks (default: 0.1 per observation)
        brain: census, 'mine.py gain=1' ...; may be repeated
        body: such as speed=0.1; may be repeated
        schema: print the JSON schema of missions, for editors
        trials: of each simulation that confirms (default: 200)
        seed: seed of all random numbers (default: 0)
        out: file of the plan: .json or .toml
    """
    keys = dict(locals())
    from swarmcensus.search import check_lines, load_mission, mission_of, plan as plan_of
    from swarmcensus.support.files import check_output

    if schema:
        from swarmcensus.search import schema as schema_of_missions

        if mission or out or plot or tables_of(keys, {}):
            why = "goes with no other option: swarmcensus plan --schema > mission.schema.json"
            raise option_conflict("schema", None, why)
        return json.dumps(schema_of_missions(), indent=2, ensure_ascii=False) + "\n"
    inputs = [mission] if mission else []
    where, base = (f"mission file {mission}", mission.parent) if mission else ("mission", Path())
    tables = tables_of(keys, load_mission(mission) if mission else {})
    if not mission:
        _check_options(keys, tables)
    check_output("out", out, (".json", ".toml"), *inputs)
    if plot:
        check_output("plot", plot, (".png", ".svg", ".pdf"), *inputs)
        check_lines(mission_of(tables, where, base))
    begun = time.monotonic()
    with reporting(str(tables.get("name", "mission"))) as progress:
        found = plan_of(tables, jobs, progress, where=where, base=base, device=device)
    if plot:
        from swarmcensus.figures import draw_plan, save

        save(draw_plan(found), plot)
    if out:
        found.write(out)
    found.files = dict.fromkeys((file for file in (out, plot) if file), elapsed(time.monotonic() - begun))
    return found


def _check_options(keys: Mapping[str, Any], tables: dict[str, Any]) -> None:
    """Raise OptionError that names the option which is missing, where no file has the mission."""
    from swarmcensus.search import mission_of

    try:
        mission_of(tables, "mission", Path())
    except StudyError as error:
        groups = [needed for of, needed in NEEDED.items() if of != "area" or not keys["topology"]]
        lacks = [needed for needed in groups if all(keys[key] in (None, ()) for key in needed)]
        if error.key not in NEEDED or not lacks:
            raise
        names = "; ".join(" or ".join(map(option, needed)) for needed in lacks)
        verb = "is" if len(lacks) == 1 else "are"
        raise OptionError(f"{names} {verb} missing: {EXAMPLE}", key=lacks[0][0]) from None


def tables_of(keys: Mapping[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
    """The tables of a mission, with values replaced by those of `keys`. Raises InputError.

    A value that should be a table and is none stays as it is: `mission_of` refuses it and names the file.
    """
    from swarmcensus.search import TABLES

    merged = {key: dict(value) if isinstance(value, dict) else value for key, value in tables.items()}

    def put(table: str, key: str, value: Any) -> None:
        entries = merged.setdefault(table, {})
        if isinstance(entries, dict):
            entries[key] = value

    for key, table in TABLES.items():
        value = keys.get(key)
        if key == "brain" or value is None or value == ():
            continue
        put(table, key, value[0] if isinstance(value, list) and len(value) == 1 else value)
        for other in INSTEAD.get(key, ()):
            entries = merged.get(TABLES[other])
            if keys[other] in (None, ()) and isinstance(entries, dict):
                entries.pop(other, None)
    if keys["brain"]:
        free = merged.get("free")
        given = free.get("brain") if isinstance(free, dict) else None
        swept = [one for one in (given if isinstance(given, list) else [given]) if isinstance(one, dict)]
        # by its name alone, a brain has the values that the mission file gives it
        brains = [[one for one in swept if one.get("file") == asked] or [asked] for asked in keys["brain"]]
        put("free", "brain", [one for several in brains for one in several])
    for name, text in once("body", keys["body"]).items():
        try:
            put("body", name, amount(text))
        except ValueError as error:
            raise OptionError(f"--body {name}={text}: {error}", key=name, value=text) from None
    return merged | {key: keys[key] for key in ("trials", "seed") if keys[key] is not None}
