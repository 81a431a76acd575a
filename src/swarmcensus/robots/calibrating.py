"""Sensors' accuracies from readings on a black and a white strip: b and w of each robot, and how sure they are.

Robots' shares are compared by a chi-squared test of all strips. Each robot's share is drawn towards that of all
robots, the more the less they differ; how much they may differ without being seen is an upper bound, so that intervals
cover the robots' own shares on average over robots, and less often that of one robot among equal ones.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist

import numpy as np

from swarmcensus import theory
from swarmcensus.robots.strips import FORM, LEVEL, SIDES, Dependence, Part, dependences, parts_of_logs, parts_of_table
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Z95, share_interval
from swarmcensus.support.printed_tables import ASKED, REST, Column, Table
from swarmcensus.worlds import read_robots, write_robots

UNSEEN = 0.1  # the probability that robots differ by more than is taken for possible
TINY = 1e-6  # the smallest p-value that is told
WIDTH = 0.02  # of an interval, unless another one is wanted


@dataclass(frozen=True)
class Side:
    """b or w of one sensor, from `right` of `readings`; a share that was drawn towards that of others has parts."""

    right: float
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
        return (high - low) / (2.0 * Z95)

    def more(self, width: float) -> int:
        """How many readings more the interval needs to be as narrow as `width`: Wilson's ends, solved for their number.

        With the half width h and the share p, h^2 (n + z^2)^2 = z^2 (p (1 - p) n + z^2 / 4).
        """
        half2, z2, share = (width / 2.0) ** 2, Z95 * Z95, self.right / self.readings
        middle = z2 * (share * (1.0 - share) - 2.0 * half2)
        wanted = (middle + math.sqrt(middle**2 + half2 * z2**2 * (1.0 - 4.0 * half2))) / (2.0 * half2)
        return max(0, math.ceil((wanted - self.effective) * self.readings / self.effective))


def difference(sides: Sequence[Side]) -> tuple[float, int]:
    """The chi-squared statistic of equal shares in all of these, and its degrees of freedom."""
    n = np.array([side.effective for side in sides])
    share = np.array([side.right / side.readings for side in sides])
    mean = float(n @ share / n.sum())
    if not 0.0 < mean < 1.0:
        return 0.0, len(sides) - 1
    return float(n @ (share - mean) ** 2 / (mean * (1.0 - mean))), len(sides) - 1


def _weights(sides: Sequence[Side]) -> tuple[np.ndarray, np.ndarray, float]:
    """Robots' readings, the weight of all in the share of each, and 1 / k.

    Robots' shares have the largest variance that fits the statistic, p (1 - p) / k with the share p of all.
    """
    statistic, freedom = difference(sides)
    n = np.array([side.effective for side in sides])
    if not freedom:
        return n, np.zeros(1), 0.0
    total, spread = float(n.sum()), 2.0 / (9.0 * freedom)
    least = freedom * max(0.0, 1.0 - spread + NormalDist().inv_cdf(UNSEEN) * math.sqrt(spread)) ** 3
    between = max(0.0, statistic / max(least, TINY) - 1.0) * freedom / (total - float(n @ n) / total)
    return n, 1.0 / (1.0 + n * between), between


def drawn(sides: Sequence[Side]) -> list[Side]:
    """Each share drawn towards that of all: what all robots say counts as k readings more of each."""
    (n, weights, between), total = _weights(sides), sum(side.effective for side in sides)
    if len(sides) == 1:
        return [*sides]
    own = np.array([side.right / side.readings for side in sides])
    shares, effective = own + weights * (n @ own / total - own), 1.0 / (between * weights + weights**2 / total)
    return [Side(p * side.readings, side.readings, k) for p, side, k in zip(shares, sides, effective, strict=True)]


def chi_squared_p(statistic: float, freedom: int) -> float:
    """The probability of a larger statistic, by the cube root of Wilson and Hilferty, 1931."""
    spread = 2.0 / (9.0 * freedom)
    return 1.0 - NormalDist().cdf(((statistic / freedom) ** (1.0 / 3.0) - 1.0 + spread) / math.sqrt(spread))


def calibrate(
    files: Sequence[str | Path] = (), *, black: Path | None = None, white: Path | None = None,
    width: float = WIDTH, out: Path | None = None,
) -> Answer:  # fmt: skip
    """b and w of robots' sensors from tables of counts or readings, and from folders of logs on each strip.

    `width` is that of an interval for which readings are missing; `out` is the file of robots to write. Each robot's b
    and w are drawn towards those of all, the more the less robots may differ. Raises InputError.
    """
    places = [Path(file).resolve() for file in files]
    if twice := [file for file, place in zip(files, places, strict=True) if places.count(place) > 1]:
        raise InputError(f"{twice[-1]} is given twice", file=twice[-1])
    parts = [part for file in files for part in parts_of_table(Path(file))]
    for strip, folder in (("black", black), ("white", white)):
        parts += parts_of_logs(folder, strip) if folder else []
    if not parts:
        raise InputError(f"no readings: give tables with {FORM}, or robots' logs with --black and --white")
    depends = dependences(parts)
    source = ", ".join(str(one) for one in (*files, black, white) if one)
    shares = dict.fromkeys(sorted({part.robot for part in parts}), depends.share) | depends.alone
    robots = {number: _sides(parts, number, share, source) for number, share in shares.items()}
    by_strip = [[sides[strip] for sides in robots.values()] for strip in SIDES]
    tests = zip(*map(difference, by_strip), strict=True)
    p_robots = chi_squared_p(*map(sum, tests)) if len(robots) > 1 else math.nan
    used = [dict(zip(SIDES, one, strict=True)) for one in zip(*map(drawn, by_strip), strict=True)]
    rows = [_row(*one, width) for one in zip(robots, robots.values(), used, strict=True)]
    if out:
        _write(out, rows)
    return _answer(rows, [*robots.values()], depends, p_robots, width, out)


def _write(out: Path, rows: Iterable[Mapping[str, float]]) -> None:
    """Write a file of robots; ports and addresses of an older one stay, and robots that are not in this calibration."""
    old = read_robots(out, calibrated=False) if out.exists() else []
    found = {one.number: one.model_dump(exclude_unset=True) for one in old}
    for number, row in ((int(row["robot"]), row) for row in rows):
        measured = {key: row[key] for key in ("b", "w", "b_error", "w_error")}
        found[number] = found.get(number, {"number": number}) | measured
    about = "robots of a swarm, as swarmcensus calibrate measured them: b and w with standard errors"
    write_robots(out, [found[number] for number in sorted(found)], about)


def _sides(parts: Iterable[Part], number: int, scale: float, source: str) -> dict[str, Side]:
    """The sides of a robot. Raises InputError if it lacks one."""
    found = {}
    for strip in SIDES:
        own = [part for part in parts if part.robot == number and part.strip == strip]
        n, blacks = sum(part.readings for part in own), sum(part.black for part in own)
        if not n:
            raise InputError.of(source, f"robot {number} has no readings on the {strip} strip", "strip", strip)
        found[strip] = Side(blacks if strip == "black" else n - blacks, n, n * scale)
    return found


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
    rows: Sequence[Mapping[str, float]], robots: Sequence[Mapping[str, Side]], depends: Dependence, p_robots: float,
    width: float, out: Path | None,
) -> Answer:  # fmt: skip
    worst = max(row["error"] for row in rows)
    of_swarm = min(worst, _of_swarm(rows, robots))  # a mean is no larger, but is rounded in another way
    more = [int(max(row[f"{strip}_more"] for row in rows)) for strip in SIDES]
    level = f"level {100 * LEVEL:g} %"
    of_row, of_robots = (f"p < {TINY}" if p < TINY else f"p = {p:.2g}" for p in (depends.p, p_robots))
    differ = p_robots < LEVEL or len(rows) == 1
    in_a_row = f"a reading does not depend on the one before, as far as these show ({of_row}, {level})"
    if math.isnan(depends.p):
        in_a_row = "whether readings depend on the one before is unknown: counts lack `changes`, or all are equal"
    elif depends.share < 1.0:
        count = f"1,000 count as {1000 * depends.share:.0f}"
        in_a_row = f"readings depend on the one before ({of_row}, {level}): {count}; move faster, or read less often"
    each = _robots([f"{number} (1,000 count as {1000 * one:.0f})" for number, one in depends.alone.items()])
    stands = f"readings depend on the one before, as where a robot stands still: {each}; move faster"
    others = f"of the others, {in_a_row}" if depends.alone else in_a_row
    said = [stands] * bool(depends.alone) + [others] * (len(depends.alone) < len(rows))
    found = "robots differ" if differ else "no difference between robots was found"
    several = f"{found} ({of_robots}, {level}): b and w of each are drawn towards those of all, as far as may be right"
    narrow = "every interval is as narrow as"
    if any(more):
        narrow = f"up to {more[0]:,} readings more on black and {more[1]:,} on white would make each robot's interval"
    blind = [f"{row['robot']:g}" for row in rows if row["b_low"] + row["w_low"] <= 1.0 <= row["b_high"] + row["w_high"]]
    inverse = [f"{row['robot']:g}" for row in rows if row["b_high"] + row["w_high"] < 1.0]
    return Answer(
        Table([*_columns(rows)]), title=f"b and w of {counted(len(rows), 'robot')}", rows=rows,
        sentences=[
            *[several] * (len(rows) > 1), *said, f"{narrow} {width:g} wide",
            f"the uncertainty of b and w adds to an estimate's error {_error(worst)} in a robot alone, "
            f"{_error(of_swarm)} in the whole swarm (standard deviations, at the worst f)",
        ],
        cautions=[
            *[f"{_robots(blind)}: b + w may be 1, with which readings say nothing"] * bool(blind),
            *[f"{_robots(inverse)}: b + w is below 1: is black taken for white?"] * bool(inverse),
        ],
        files={out: counted(len(rows), "robot")} if out else {},
        fields={
            "p_dependence": depends.p, "effective_share": depends.share, "alone": depends.alone,
            "p_difference": p_robots, "differ": differ, "error_alone": worst, "error_swarm": of_swarm, "width": width,
        },
    )  # fmt: skip


def _robots(which: Sequence[str]) -> str:
    return f"robot{'s' * (len(which) > 1)} {', '.join(which)}"


def _of_swarm(rows: Sequence[Mapping[str, float]], robots: Sequence[Mapping[str, Side]]) -> float:
    """The error that calibration adds at the worst f to a swarm that pools all readings, with shares drawn together.

    A robot's own share errs independently of others', and moves the shares of all that are drawn towards it.
    """
    b, w = (np.array([row[name] for row in rows]) for name in SIDES.values())
    information = theory.information(0.5, b, w)  # that of a middle f: at an end a perfect sensor has all of it
    if not information.any():
        return math.inf
    gains = information / np.maximum(np.abs(b + w - 1.0), TINY) / information.sum()
    errors = []
    for sides in ([one[strip] for one in robots] for strip in SIDES):
        (n, weights, between), error = _weights(sides), np.array([side.error for side in sides])
        moved = float(gains @ weights) * n / n.sum()  # all, by a robot
        apart = (moved - gains * weights) * np.sqrt(n * between)  # because robots differ
        errors.append(np.linalg.norm([gains * (1.0 - weights) + moved, apart] * error))
    return float(max(errors))


def _error(error: float) -> str:
    return f"{error:.4f}" if error < 1.0 else "1 or more"  # an estimate is a share


def _columns(rows: Sequence[Mapping[str, float]]) -> Iterator[Column]:
    yield Column("robot", [f"{row['robot']:g}" for row in rows], name="robot")
    for name in SIDES.values():
        ends = [f"[{row[f'{name}_low']:.3f}, {row[f'{name}_high']:.3f}]" for row in rows]
        yield Column(name, [f"{row[name]:.4f}" for row in rows], intervals=ends, rank=ASKED, name=name)
    says = "standard deviation that the uncertainty of b and w adds to this robot's estimate, at the worst f"
    yield Column("error", [*map(_error, (row["error"] for row in rows))], rank=ASKED, name="error", meaning=says)
    for key, head in (("readings", "readings on"), ("effective", "independent on"), ("more", "more on")):
        cells = [", ".join(f"{row[f'{strip}_{key}']:,.0f}" for strip in SIDES) for row in rows]
        yield Column(f"{head} {', '.join(SIDES)}", cells, rank=REST)
