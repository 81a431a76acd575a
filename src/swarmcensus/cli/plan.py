"""The command `plan`: how many robots, and how many minutes, a mission takes. Imports wait until needed."""

import argparse
import time
from pathlib import Path
from typing import Any

from swarmcensus.cli.options import from_zero, positive
from swarmcensus.cli.output import answer, reporting, say

KEYS = {
    "side": ("area", "METRES", "side of the square that robots move in"),
    "area": ("area", "M2", "or how large it is, in square metres"),
    "floor": ("area", "KIND", "what lies on it, as tiles, half, or {clusters = 0.2} (default: tiles)"),
    "accuracy": ("known", "A", "of the sensors, as 0.7, U(0.525,0.975) or {black = 0.9, white = 0.6}"),
    "fill_ratio": ("known", "F", "or a range LOW:HIGH; the worst one in it is planned for (default: 0:1)"),
    "link_success": ("known", "SHARE", "of messages that get through (default: 1)"),
    "failing": ("known", "SHARE", "of robots that may fail before they begin (default: 0)"),
    "lying": ("known", "SHARE", "of robots that may lie (default: 0)"),
    "lie": ("known", "NAME", "what liars do, an adversary (default: shouter)"),
    "half_width": ("wanted", "H", "how near robots should be to the truth, as 0.02"),
    "right": ("wanted", "WHAT", "or majority, or a number of bins of which to find the right one"),
    "margin": ("wanted", "M", "how far f is from the edges of these, as 0.02"),
    "confidence": ("wanted", "SHARE", "of robots that should be so (default: 0.95)"),
    "truth": ("wanted", "WHICH", "floor, its own share of black, or nominal (default: floor, where robots move)"),
    "robots": ("free", "N", "or a range LOW:HIGH"),
    "minutes": ("free", "T", "or a range LOW:HIGH"),
    "topology": ("free", "NAME", "moving (default), ring, scale-free, or {networkx = ..., k = 4}"),
    "density": ("free", "D", "swarm density, in place of a side or an area, which follow from it and the robots"),
    "observations_per_round": ("free", "R", "of fixed networks (default: 10)"),
    "round_seconds": ("free", "S", "how long a round of fixed networks takes (default: 0.1 a reading)"),
}  # the table that each key is in, what stands for its value, and its meaning
TEXTS = ("right", "truth", "accuracy", "floor", "topology", "lie")  # that need no quotation marks
SEVERAL = ("accuracy", "lie", "topology", "density")  # of which there may be more than one
INSTEAD = {  # what a file says of the same, and an option replaces
    "side": ("area", "density"),
    "area": ("side", "density"),
    "density": ("side", "area"),
    "half_width": ("right", "margin"),
    "right": ("half_width",),
}


def add_plan_options(sub: argparse.ArgumentParser) -> None:
    """Of `plan`: every key of a mission file has an option, which replaces what the file says."""
    sub.add_argument("mission", type=Path, nargs="?", metavar="MISSION.toml")
    for key, (_, shown, meaning) in KEYS.items():
        more = "; several: once for each" if key in SEVERAL else ""
        action = "append" if key in SEVERAL else "store"
        sub.add_argument(f"--{key.replace('_', '-')}", action=action, metavar=shown, help=meaning + more)
    sub.add_argument(
        "--brain",
        action="append",
        metavar="NAME",
        help="a brain; several: once for each (default: commons, minimalistic; among liars: steadfast, minimalistic)",
    )
    sub.add_argument(
        "--body", action="append", default=[], metavar="KEY=VALUE", help="of the robot, as speed=0.1 or radio_range=2"
    )
    sub.add_argument("--schema", action="store_true", help="print the JSON schema of mission files, for editors")
    sub.add_argument("--trials", type=positive, help="of each simulation that confirms (default: 200)")
    sub.add_argument("--seed", type=from_zero, help="default: 0")
    sub.add_argument("--jobs", type=positive, help="threads (default: one a core); the numbers do not depend on it")
    sub.add_argument("--out", type=Path, metavar="FILE.json|toml", help="write the plan")
    sub.add_argument("--plot", type=Path, metavar="FILE.png|svg|pdf", help="draw robots against minutes")


def plan(options: argparse.Namespace) -> int:
    """Plan a mission, or print the schema of mission files."""
    if options.schema:
        return _schema(options)
    from swarmcensus.basics.errors import InputError
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli.plan_table import show
    from swarmcensus.planning.mission import load_mission, mission_of
    from swarmcensus.planning.planning import plan as plan_of
    from swarmcensus.planning.plans import check_lines, check_out

    inputs = [options.mission] if options.mission else []
    where = f"mission file {options.mission}" if options.mission else "mission"
    base = options.mission.parent if options.mission else Path()
    tables = tables_of(options, load_mission(options.mission) if options.mission else {})
    if options.out:
        check_out(options.out, *inputs)
    if options.plot:
        if options.plot.suffix not in (".png", ".svg", ".pdf"):
            raise InputError(f"--plot {options.plot}: a figure is written as .png, .svg or .pdf")
        check_writable(options.plot, *inputs)
        check_lines(mission_of(tables, where, base))
    begun = time.monotonic()
    with reporting(str(tables.get("name", "mission"))) as progress:
        found = plan_of(tables, options.jobs, progress, where=where, base=base)
    if options.json:
        answer("plan", found.data)
    else:
        show(found)
    if options.plot:
        from swarmcensus.figures.files import save
        from swarmcensus.figures.plan_lines import draw_plan

        save(draw_plan(found), options.plot)
    if options.out:
        found.save(options.out)
    written = ", ".join(str(path) for path in (options.out, options.plot) if path)
    say(f"{written}{': ' * bool(written)}{time.monotonic() - begun:.1f} s")
    return 0


def _schema(options: argparse.Namespace) -> int:
    import json

    from swarmcensus.basics.errors import InputError
    from swarmcensus.planning.mission import schema

    if options.mission or options.out or options.plot or tables_of(options, {}):
        raise InputError("--schema goes alone: swarmcensus plan --schema > mission.schema.json")
    print(json.dumps(schema(), indent=2, ensure_ascii=False))
    return 0


def tables_of(options: argparse.Namespace, tables: dict[str, Any]) -> dict[str, Any]:
    """A mission's tables with the options in place of what they say. Raises InputError.

    What should be a table and is none stays as it is: `mission_of` refuses it, and names the file.
    """
    from swarmcensus.basics.errors import InputError

    found = {key: dict(value) if isinstance(value, dict) else value for key, value in tables.items()}

    def put(table: str, key: str, value: Any) -> None:
        there = found.setdefault(table, {})
        if isinstance(there, dict):
            there[key] = value

    for key, (table, *_) in KEYS.items():
        given = getattr(options, key)
        if given is None:
            continue
        values = [_value(key, text) for text in (given if key in SEVERAL else [given])]
        put(table, key, values if len(values) > 1 else values[0])
        for other in INSTEAD.get(key, ()):
            there = found.get(KEYS[other][0])
            if getattr(options, other) is None and isinstance(there, dict):
                there.pop(other, None)
    if options.brain:
        put("free", "brain", options.brain)
    for pair in options.body:
        name, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"--body {pair}: should be such as speed=0.1")
        put("body", name, _value(name, text, f"--body {pair}"))
    for key in ("trials", "seed"):
        if getattr(options, key) is not None:
            found[key] = getattr(options, key)
    return found


def _value(key: str, text: str, told: str = "") -> Any:
    """A value as in a mission file: a range has a colon, and plain words need no quotation marks. Raises InputError."""
    import tomllib

    from swarmcensus.basics.errors import InputError

    told = told or f"--{key.replace('_', '-')} {text}"
    wanted = "a number" + (
        f"; for several give --{key} once for each" if key in SEVERAL else ", or a range such as 10:100"
    )
    try:
        ends = [_number(part) for part in text.split(":", 1)]
        if key == "density" and len(ends) > 1:
            raise InputError(f"{told}: should be {wanted}")
        return ends if len(ends) > 1 else ends[0]
    except ValueError:
        pass
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        if key in TEXTS:
            return text
        raise InputError(f"{told}: should be {wanted}") from None


def _number(text: str) -> float:
    try:
        return int(text)
    except ValueError:
        return float(text)
