"""The command `plan`. Imports wait until the command needs them."""

import argparse
import re
import time
from pathlib import Path
from typing import Any

from swarmcensus.cli.options import Command, Group, add_shared, assignment, once, parameter, positive

from swarmcensus.cli.output import present, print_schema, reporting, say
from swarmcensus.support.errors import OptionError, StudyError
from swarmcensus.support.formatting import elapsed
from swarmcensus.support.options import option

KEYS = {
    "side": ("area", "METRES", "side of the square in which robots move"),
    "area": ("area", "M2", "its area in square metres, in place of --side"),
    "floor": ("area", "KIND", "pattern of the floor, such as tiles, half, or {clusters = 0.2} (default: tiles)"),
    "accuracy": ("known", "A", "accuracy of the sensors, such as 0.7, U(0.525,0.975) or {black = 0.9, white = 0.6}"),
    "fill_ratio": ("known", "F", "fill ratio, or a range LOW:HIGH of which the worst is planned for (default: 0:1)"),
    "link_success": ("known", "SHARE", "share of messages that arrive (default: 1)"),
    "precision": ("known", "WHICH", "precision of the robots' arithmetic: double (default) or single"),
    "message": ("known", "FORMAT", "format of messages: float32, float16, ratio16 or ratio8 (default: double)"),
    "failing": ("known", "SHARE", "share of robots that may fail before the start (default: 0)"),
    "lying": ("known", "SHARE", "share of robots that may lie (default: 0)"),
    "lie": ("known", "NAME", "the adversary that liars follow (default: shouter)"),
    "half_width": ("wanted", "H", "largest error of an estimate that counts as right, such as 0.02"),
    "right": (
        "wanted",
        "WHAT",
        "in place of --half-width: majority, or a number of bins of which robots find the right one",
    ),
    "margin": ("wanted", "M", "least distance of f from the edges of these bins, such as 0.02"),
    "confidence": ("wanted", "SHARE", "share of robots that should be right (default: 0.95)"),
    "truth": (
        "wanted",
        "WHICH",
        "the true value: floor, the black share of the actual floor, or nominal, f (default: floor, if robots move)",
    ),
    "robots": ("free", "N", "number of robots, or a range LOW:HIGH"),
    "minutes": ("free", "T", "duration in minutes, or a range LOW:HIGH"),
    "topology": ("free", "NAME", "network: moving (default), ring, scale-free, or {networkx = ..., k = 4}"),
    "density": (
        "free",
        "D",
        "swarm density, in place of a side or an area, which then follow from the number of robots",
    ),
    "observations_per_round": ("free", "R", "observations per round on fixed networks (default: 10)"),
    "round_seconds": ("free", "S", "seconds per round on fixed networks (default: 0.1 per observation)"),
}  # by key: its table in a mission file, the placeholder of its value, and its help text
# keys whose text needs no quotation marks
TEXTS = ("right", "truth", "accuracy", "floor", "topology", "lie", "precision", "message")
SEVERAL = ("accuracy", "lie", "topology", "density")  # options that may be repeated
INSTEAD = {  # keys of the file that an option replaces in addition to its own
    "side": ("area", "density"),
    "area": ("side", "density"),
    "density": ("side", "area"),
    "half_width": ("right", "margin"),
    "right": ("half_width",),
}


NEEDED = {  # keys of messages about what a mission lacks, and the options of which one gives it
    "known.accuracy": ("accuracy",), "wanted": ("half_width", "right"), "area": ("side", "area", "density"),
    "free": ("robots", "minutes"),
}  # fmt: skip
EXAMPLE = "such as in swarmcensus plan --side 5 --robots 20 --accuracy 0.7 --half-width 0.02"


def add_plan_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `plan`: one for every key of a mission file, which replaces the value in the file."""
    sub.add_argument(
        "mission",
        type=Path,
        nargs="?",
        metavar="MISSION.toml",
        help="what the swarm should do; options below replace its keys",
    )
    for key, (_, placeholder, meaning) in KEYS.items():
        more = "; may be repeated" if key in SEVERAL else ""
        action = "append" if key in SEVERAL else "store"
        sub.add_argument(f"--{key.replace('_', '-')}", action=action, metavar=placeholder, help=meaning + more)
    sub.add_argument(
        "--brain",
        type=brain_with_parameters,
        action="append",
        metavar="BRAIN",
        help="a brain, such as census or 'mine.py gain=1'; one of the mission file keeps its values there; "
        "may be repeated (default: commons, minimalistic; with liars: steadfast, minimalistic)",
    )
    sub.add_argument(
        "--body",
        type=assignment,
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="property of the robots, such as speed=0.1 or radio_range=2; may be repeated",
    )
    add_shared(sub, "schema", "jobs", "device", seed="default: 0")
    sub.add_argument("--trials", type=positive, help="trials of each simulation that confirms the plan (default: 200)")
    sub.add_argument("--out", type=Path, metavar="FILE.json|toml", help="write the plan to a file")
    add_shared(sub, plot="the number of robots against minutes")


def plan(options: argparse.Namespace) -> int:
    """Plan a mission, or print the schema of mission files."""
    if options.schema:
        return _schema(options)
    from swarmcensus.cli.plan_table import show

    from swarmcensus.search import check_lines, check_out, load_mission, mission_of, plan as plan_of
    from swarmcensus.support.files import check_output

    inputs = [options.mission] if options.mission else []
    where = f"mission file {options.mission}" if options.mission else "mission"
    base = options.mission.parent if options.mission else Path()
    tables = tables_of(options, load_mission(options.mission) if options.mission else {})
    if not options.mission:
        _check_options(options, tables)
    if options.out:
        check_out(options.out, *inputs)
    if options.plot:
        check_output("plot", options.plot, (".png", ".svg", ".pdf"), *inputs)
        check_lines(mission_of(tables, where, base))
    begun = time.monotonic()
    with reporting(str(tables.get("name", "mission"))) as progress:
        plan = plan_of(tables, options.jobs, progress, where=where, base=base, device=options.device)
    present(options, "plan", lambda: plan.data, lambda: plan.records, lambda: show(plan))
    if options.plot:
        from swarmcensus.figures import draw_plan, save

        save(draw_plan(plan), options.plot)
    if options.out:
        plan.save(options.out)
    written = ", ".join(str(path) for path in (options.out, options.plot) if path)
    say(f"{written}{': ' * bool(written)}{elapsed(time.monotonic() - begun)}")
    return 0


def _check_options(options: argparse.Namespace, tables: dict[str, Any]) -> None:
    """Raise OptionError that names the option which is missing, where no file has the mission."""
    from swarmcensus.search import mission_of

    try:
        mission_of(tables, "mission", Path())
    except StudyError as error:
        groups = {of: keys for of, keys in NEEDED.items() if of != "area" or not options.topology}
        lacks = [keys for keys in groups.values() if all(getattr(options, key) is None for key in keys)]
        if error.key not in NEEDED or not lacks:
            raise
        names = "; ".join(" or ".join(map(option, keys)) for keys in lacks)
        right = KEYS[lacks[0][0]][2] if len(lacks) == 1 else EXAMPLE
        raise OptionError(f"{names} {'is' if len(lacks) == 1 else 'are'} missing: {right}", key=lacks[0][0]) from None


def _schema(options: argparse.Namespace) -> int:
    from swarmcensus.search import schema

    if options.mission or options.out or options.plot or tables_of(options, {}):
        why = "goes with no other option: swarmcensus plan --schema > mission.schema.json"
        raise OptionError(f"--schema {why}", key="schema")
    print_schema(schema())
    return 0


def tables_of(options: argparse.Namespace, tables: dict[str, Any]) -> dict[str, Any]:
    """The tables of a mission, with values replaced by options. Raises InputError.

    A value that should be a table and is none stays as it is: `mission_of` refuses it and names the file.
    """

    merged = {key: dict(value) if isinstance(value, dict) else value for key, value in tables.items()}

    def put(table: str, key: str, value: Any) -> None:
        entries = merged.setdefault(table, {})
        if isinstance(entries, dict):
            entries[key] = value

    for key, (table, *_) in KEYS.items():
        given = getattr(options, key)
        if given is None:
            continue
        values = [_value(key, text) for text in (given if key in SEVERAL else [given])]
        put(table, key, values if len(values) > 1 else values[0])
        for other in INSTEAD.get(key, ()):
            entries = merged.get(KEYS[other][0])
            if getattr(options, other) is None and isinstance(entries, dict):
                entries.pop(other, None)
    if options.brain:
        free = merged.get("free")
        known = free.get("brain") if isinstance(free, dict) else None
        swept = [one for one in (known if isinstance(known, list) else [known]) if isinstance(one, dict)]
        put("free", "brain", [one for asked in options.brain for one in _in_file(asked, swept)])
    for name, text in once("body", options.body).items():
        put("body", name, _value(name, text, f"--body {name}={text}"))
    for key in ("trials", "seed"):
        if getattr(options, key) is not None:
            merged[key] = getattr(options, key)
    return merged


def _in_file(asked: str | dict[str, Any], tables: list[dict[str, Any]]) -> list[str | dict[str, Any]]:
    """The brain that is asked for; by its name alone, with the values that the mission file's `tables` give it."""
    return [table for table in tables if table.get("file") == asked] or [asked]


def brain_with_parameters(text: str) -> str | dict[str, Any]:
    """A brain, perhaps with values as a plan prints them: mine.py gain=1. Raises ArgumentTypeError."""
    file, *given = re.split(r"\s+(?=\w+=\S)", text)
    values = [parameter(re.sub(r"[()\[\]]", "", one)) for one in given]
    return {"file": file, **once("brain", values)} if given else text


def _value(key: str, text: str, name: str = "") -> Any:
    """The value that an option means: a range has a colon, plain words need no quotation marks. Raises InputError."""
    from swarmcensus.studies import read_toml

    name = name or f"--{key.replace('_', '-')} {text}"
    wanted = "a number" + (f"; to give several, repeat --{key}" if key in SEVERAL else ", or a range such as 10:100")
    try:
        ends = [_number(part) for part in text.split(":", 1)]
        if key == "density" and len(ends) > 1:
            raise OptionError(f"{name}: should be {wanted}", key=key, value=text)
        return ends if len(ends) > 1 else ends[0]
    except ValueError:
        pass
    try:
        return read_toml(f"value = {text}", "")["value"]
    except StudyError:
        if key in TEXTS:
            return text
        raise OptionError(f"{name}: should be {wanted}", key=key, value=text) from None


def _number(text: str) -> float:
    try:
        return int(text)
    except ValueError:
        return float(text)


COMMANDS = (
    Command(
        "plan", "Find how many robots, or minutes, a mission needs.",
        Group.MISSIONS, 1, plan, add_plan_options, table=True,
    ),
)  # fmt: skip
