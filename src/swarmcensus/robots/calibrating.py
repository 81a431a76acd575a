"""Sensors' accuracies from readings on a black and a white strip: b and w of each robot, and how sure they are.

Readings in a row may depend on each other, as where a robot stands still. Then there are fewer changes from black to
white than in a random order (Wald and Wolfowitz, 1940), and a chain with this share of changes says how many
independent readings count as much. Robots' shares are compared by a chi-squared test of all strips.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from swarmcensus import theory
from swarmcensus.robots.logs.folders import logs_in, without_logs
from swarmcensus.robots.logs.logs import read_log
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import share_interval
from swarmcensus.support.printed_tables import ASKED, REST, Column, Table
from swarmcensus.support.read_table import read_table
from swarmcensus.worlds import read_robots, write_robots

LEVEL = 0.01  # of both tests
Z = 1.959963984540054  # of intervals of 95 %
TINY = 1e-6  # the smallest p-value that is told
WIDTH = 0.02  # of an interval, unless another one is wanted
SIDES = {"black": "b", "white": "w"}
NAMES = {  # of columns, as they may be written
    "robot": ("robot", "number"), "strip": ("strip", "floor", "side"), "readings": ("readings", "looks"),
    "black": ("black", "blacks"), "changes": ("changes",), "reading": ("reading", "observation", "value"),
}  # fmt: skip
FORM = "columns robot,strip,readings,black,changes with counts, or robot,strip,reading with single readings in order"
COLOURS = {"black": 1.0, "white": 0.0, "true": 1.0, "false": 0.0}


class Part(NamedTuple):
    """Readings of a robot on one strip, in one row."""

    robot: int
    strip: str
    readings: int
    black: int
    changes: int | None = None  # from black to white or back; None if their order is not known


@dataclass(frozen=True)
class Side:
    """b or w of one sensor, or of several that are alike, from `right` of `readings`."""

    right: int
    readings: int
    effective: float  # independent readings that say as much

    @property
    def interval(self) -> tuple[float, float, float]:
        """The value and the ends of its 95 % interval; a value is never 0 or 1, which no number of readings shows."""
        scale = self.effective / self.readings
        _, low, high = share_interval(self.right * scale, self.effective)
        return (self.right * scale + 0.5) / (self.effective + 1.0), low, high

    @property
    def error(self) -> float:
        """The standard error."""
        _, low, high = self.interval
        return (high - low) / (2.0 * Z)

    def more(self, width: float) -> int:
        """How many readings more the interval needs to be as narrow as `width`: Wilson's ends, solved for their number.

        With the half width h and the share p, h^2 (n + z^2)^2 = z^2 (p (1 - p) n + z^2 / 4).
        """
        half2, z2, share = (width / 2.0) ** 2, Z * Z, self.right / self.readings
        middle = z2 * (share * (1.0 - share) - 2.0 * half2)
        wanted = (middle + math.sqrt(middle**2 + half2 * z2**2 * (1.0 - 4.0 * half2))) / (2.0 * half2)
        return max(0, math.ceil((wanted - self.effective) * self.readings / self.effective))


def dependence(parts: Iterable[Part]) -> tuple[float, float]:
    """The p-value of readings in a row that are more alike than by chance, and the correlation of neighbours.

    Both are NaN if no part tells its changes, or all of its readings are alike.
    """
    known = [part for part in parts if part.changes is not None and 0 < part.black < part.readings]
    black, n, changes = (np.array([getattr(part, name) for part in known], np.float64) for name in
                         ("black", "readings", "changes"))  # fmt: skip
    if not known:
        return math.nan, math.nan
    expected = 2.0 * black * (n - black) / n
    variance = expected * (expected - 1.0) / (n - 1.0)
    spread = math.sqrt(max(float(variance.sum()), 1e-12))
    p = NormalDist().cdf(float(changes.sum() - expected.sum()) / spread)
    return p, max(0.0, 1.0 - float(changes.sum() / expected.sum()))


def difference(sides: Sequence[Side]) -> tuple[float, int]:
    """The chi-squared statistic of equal shares in all of these, and its degrees of freedom."""
    n = np.array([side.effective for side in sides])
    share = np.array([side.right / side.readings for side in sides])
    mean = float(n @ share / n.sum())
    if not 0.0 < mean < 1.0:
        return 0.0, len(sides) - 1
    return float(n @ (share - mean) ** 2 / (mean * (1.0 - mean))), len(sides) - 1


def chi_squared_p(statistic: float, freedom: int) -> float:
    """The probability of a larger statistic, by the cube root of Wilson and Hilferty, 1931."""
    spread = 2.0 / (9.0 * freedom)
    return 1.0 - NormalDist().cdf(((statistic / freedom) ** (1.0 / 3.0) - 1.0 + spread) / math.sqrt(spread))


def calibrate(
    files: Sequence[str | Path] = (), *, black: Path | None = None, white: Path | None = None,
    width: float = WIDTH, out: Path | None = None,
) -> Answer:  # fmt: skip
    """b and w of robots' sensors from tables of counts or readings, and from folders of logs on each strip.

    `width` is that of an interval for which readings are missing; `out` is the file of robots to write. Where the test
    finds no difference between robots, all get the b and w of all readings. Raises InputError.
    """
    parts = [part for file in files for part in parts_of_table(Path(file))]
    for strip, folder in (("black", black), ("white", white)):
        parts += parts_of_logs(folder, strip) if folder else []
    if not parts:
        raise InputError(f"no readings: give tables with {FORM}, or robots' logs with --black and --white")
    p_row, correlation = dependence(parts)
    depends = p_row < LEVEL
    scale = (1.0 - correlation) / (1.0 + correlation) if depends else 1.0
    robots = {number: _sides(parts, number, scale) for number in sorted({part.robot for part in parts})}
    tests = [difference([sides[strip] for sides in robots.values()]) for strip in SIDES]
    p_robots = chi_squared_p(*map(sum, zip(*tests, strict=True))) if len(robots) > 1 else math.nan
    differ = p_robots < LEVEL or len(robots) == 1
    together = {strip: _sum([sides[strip] for sides in robots.values()]) for strip in SIDES}
    rows = [_row(number, sides, sides if differ else together, width) for number, sides in robots.items()]
    if out:
        _write(out, rows)
    return _answer(rows, (p_row, scale), (p_robots, differ), width, out)


def _write(out: Path, rows: Iterable[Mapping[str, float]]) -> None:
    """Write a file of robots; the ports and addresses of an older one stay."""
    places = {
        one.number: {"port": one.port, "address": one.address} for one in (read_robots(out) if out.exists() else ())
    }
    sensors = ({key: row[key] for key in ("b", "w", "b_error", "w_error")} for row in rows)
    numbers = [int(row["robot"]) for row in rows]
    found = [{"number": n, **one, **places.get(n, {})} for n, one in zip(numbers, sensors, strict=True)]
    write_robots(out, found, "robots of a swarm, as swarmcensus calibrate measured them: b and w with standard errors")


def _sides(parts: Iterable[Part], number: int, scale: float) -> dict[str, Side]:
    """The sides of a robot. Raises InputError if it lacks one."""
    found = {}
    for strip in SIDES:
        own = [part for part in parts if part.robot == number and part.strip == strip]
        n, blacks = sum(part.readings for part in own), sum(part.black for part in own)
        if not n:
            raise InputError(f"robot {number} has no readings on the {strip} strip", key="strip", value=strip)
        found[strip] = Side(blacks if strip == "black" else n - blacks, n, n * scale)
    return found


def _sum(sides: Sequence[Side]) -> Side:
    return Side(*(sum(getattr(side, name) for side in sides) for name in ("right", "readings", "effective")))


def _row(number: int, own: Mapping[str, Side], used: Mapping[str, Side], width: float) -> dict[str, float]:
    row: dict[str, float] = {"robot": number}
    for strip, name in SIDES.items():
        value, low, high = used[strip].interval
        row |= {name: round(value, 5), f"{name}_low": low, f"{name}_high": high}
        row[f"{name}_error"] = float(f"{used[strip].error:.3g}")
    worst = [theory.calibration_error(f, row["b"], row["w"], row["b_error"], row["w_error"]) for f in (0.0, 1.0)]
    row["error"] = float(max(worst))
    for strip, side in own.items():
        row |= {f"{strip}_readings": side.readings, f"{strip}_effective": side.effective}
        row[f"{strip}_more"] = side.more(width)
    return row


def _answer(
    rows: Sequence[Mapping[str, float]], row_test: tuple[float, float], robot_test: tuple[float, bool],
    width: float, out: Path | None,
) -> Answer:  # fmt: skip
    (p_row, scale), (p_robots, differ) = row_test, robot_test
    worst, of_swarm = _added(rows, common=not differ)
    more = [int(max(row[f"{strip}_more"] for row in rows)) for strip in SIDES]
    level = f"level {100 * LEVEL:g} %"
    of_row, of_robots = (f"p < {TINY}" if p < TINY else f"p = {p:.2g}" for p in (p_row, p_robots))
    in_a_row = f"a reading does not depend on the one before, as far as these show ({of_row}, {level})"
    if math.isnan(p_row):
        in_a_row = "whether readings depend on the one before is unknown: counts lack `changes`, or all are alike"
    elif scale < 1.0:
        in_a_row = (
            f"readings depend on the one before ({of_row}, {level}): 1,000 count as {1000 * scale:.0f}; "
            "move faster, or read less often"
        )
    alike = f"no difference between robots was found ({of_robots}, {level}): all get b and w of all readings"
    several = f"robots differ ({of_robots}, {level}): each has its own b and w" if differ else alike
    narrow = "every interval is as narrow as"
    if any(more):
        narrow = f"up to {more[0]:,} readings more on black and {more[1]:,} on white would make each robot's interval"
    blind = [f"{row['robot']:g}" for row in rows if row["b_low"] + row["w_low"] <= 1.0 <= row["b_high"] + row["w_high"]]
    inverse = [f"{row['robot']:g}" for row in rows if row["b_high"] + row["w_high"] < 1.0]
    return Answer(
        Table([*_columns(rows)]), title=f"b and w of {counted(len(rows), 'robot')}", rows=rows,
        sentences=[
            *[several] * (len(rows) > 1), in_a_row, f"{narrow} {width:g} wide",
            f"because b and w are uncertain, an estimate errs by up to {worst:.4f} more in a robot alone, "
            f"{of_swarm:.4f} in the whole swarm (standard deviations, at the worst f)",
        ],
        cautions=[
            *[f"robots {', '.join(blind)}: b + w may be 1, with which readings say nothing"] * bool(blind),
            *[f"robots {', '.join(inverse)}: b + w is below 1: is black taken for white?"] * bool(inverse),
        ],
        files={out: counted(len(rows), "robot")} if out else {},
        fields={
            "p_dependence": p_row, "effective_share": scale, "p_difference": p_robots, "differ": differ,
            "error_alone": worst, "error_swarm": of_swarm, "width": width,
        },
    )  # fmt: skip


def _added(rows: Sequence[Mapping[str, float]], common: bool) -> tuple[float, float]:
    """The error that calibration adds at the worst f: of the worst robot, and of a swarm that pools all readings."""
    b, w, of_b, of_w = (np.array([row[name] for row in rows]) for name in ("b", "w", "b_error", "w_error"))
    weights = theory.information(0.5, b, w)  # that of a middle f: at an end a perfect sensor has all of it
    seeing, found = weights > 0.0, []
    for f in (0.0, 1.0):
        each = theory.calibration_error(f, b, w, of_b, of_w)
        together = np.hypot.reduce(weights[seeing] * each[seeing]) / weights.sum() if seeing.any() else np.inf
        found.append((float(each.max()), float(each.max() if common else together)))
    alone, pooled = zip(*found, strict=True)
    return max(alone), max(pooled)


def _columns(rows: Sequence[Mapping[str, float]]) -> Iterator[Column]:
    yield Column("robot", [f"{row['robot']:g}" for row in rows], name="robot")
    for name in SIDES.values():
        ends = [f"[{row[f'{name}_low']:.3f}, {row[f'{name}_high']:.3f}]" for row in rows]
        yield Column(name, [f"{row[name]:.4f}" for row in rows], intervals=ends, rank=ASKED, name=name)
    says = "standard deviation that the uncertainty of b and w adds to this robot's estimate, at the worst f"
    yield Column("error", [f"{row['error']:.4f}" for row in rows], rank=ASKED, name="error", meaning=says)
    for key, head in (("readings", "readings on"), ("effective", "independent on"), ("more", "more on")):
        for strip in SIDES:
            cells = [f"{row[f'{strip}_{key}']:,.0f}" for row in rows]
            yield Column(f"{head} {strip}", cells, rank=REST, name=f"{strip}_{key}")


# ---- readings


def parts_of_table(path: Path) -> list[Part]:
    """The parts of a table: a row of counts for each, or a row for each reading, in order. Raises InputError."""
    names = {name for spelled in NAMES.values() for name in spelled}
    table = read_table(path, lambda name: name in names)
    found = {key: table.column(key, None, spelled) for key, spelled in NAMES.items()}
    if not (found["robot"] and found["strip"] and (found["reading"] or (found["readings"] and found["black"]))):
        raise table.refused(f"should have {FORM}")
    robots, strips = table.whole(str(found["robot"])), table.values(str(found["strip"]), "black or white", COLOURS)
    sides = ["black" if strip == 1.0 else "white" for strip in strips]
    if found["reading"]:
        read = table.values(str(found["reading"]), "0 (white), 1 (black) or empty", COLOURS)
        places: dict[tuple[int, str], list[float]] = {}
        for robot, side, reading in zip(robots.tolist(), sides, read.tolist(), strict=True):
            places.setdefault((robot, side), []).append(reading)
        return [_part(robot, side, np.array(values)) for (robot, side), values in places.items()]
    n, black = (table.whole(str(found[key])).tolist() for key in ("readings", "black"))
    changes = table.whole(found["changes"]).tolist() if found["changes"] else [None] * len(n)
    parts = [*map(Part, robots.tolist(), sides, n, black, changes)]
    for row, part in enumerate(parts):
        if part.black > part.readings or (part.changes or 0) > 2 * min(part.black, part.readings - part.black):
            counts = f"{part.readings} readings, {part.black} black, {part.changes} changes"
            raise table.error(row, f"{counts}: so many there cannot be")
    return parts


def _part(robot: int, strip: str, readings: np.ndarray) -> Part:
    """Single readings, NaN where there is none, counted."""
    known = readings[np.isfinite(readings)]
    return Part(robot, strip, known.size, int(known.sum()), int(np.count_nonzero(np.diff(known))))


def parts_of_logs(folder: Path, strip: str) -> list[Part]:
    """The readings in robots' logs, all on one strip. Raises InputError."""
    parts = []
    for path in logs_in(folder):
        log = read_log(path)
        looks, blacks = (np.array([getattr(tick, name) for tick in log.ticks]) for name in ("looks", "blacks"))
        if looks.max(initial=0) <= 1:
            parts.append(_part(log.number, strip, blacks[looks > 0].astype(np.float64)))
        else:  # of several in a tick the order is not known
            parts.append(Part(log.number, strip, int(looks.sum()), int(blacks.sum())))
    if not parts:
        raise without_logs(folder)
    return parts
