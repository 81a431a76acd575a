"""The tables that commands print of results and traces."""

import json
import shlex
import sys
import tomllib
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from rich.table import Table
from rich.text import Text

from swarmcensus.basics.formatting import counted, decimals_for, grouped, rounded
from swarmcensus.basics.terminal import UNFOLDED, console, table
from swarmcensus.cli.output import answer
from swarmcensus.cli.source import MOST_ROWS
from swarmcensus.results.replaying import honest_in
from swarmcensus.results.summaries import SHORT, asked_anew, done, failed_trials, restated, summary
from swarmcensus.results.values import metrics_in, parameters_in
from swarmcensus.statistics.intervals import FEWEST
from swarmcensus.vocabulary.quantities import QUANTITIES
from swarmcensus.worlds.networks import MOVING

COLUMNS = {quantity.column: quantity for quantity in QUANTITIES.values() if quantity.column}
SURE = {
    name: quantity.name for name, quantity in COLUMNS.items() if name not in SHORT
}  # only with brains that state intervals
MOST_NAMED = 8  # settings in a note
TIMES = {name: 100.0 if quantity.share else 1.0 for name, quantity in COLUMNS.items()}
DECIMALS = {name: quantity.decimals for name, quantity in COLUMNS.items()}  # of a value without an interval
MOST_CHECKPOINTS = 8  # named in the legend
FOLDED = 12  # least width of the column that all coordinates of a setting share
MOST_DECIMALS = 6
DIGITS = {"K": 1}  # significant digits of an interval's width; 2 for other columns


def head(data: xr.Dataset, path: Path) -> str:
    """The title line of a results file: its study, its settings and how many trials are done."""
    made = f"seed {data.attrs['seed']}, swarmcensus {data.attrs['swarmcensus_version']}"
    trials = f"{int(done(data).sum()):,} of {counted(data.attrs['trials_total'], 'trial')} done"
    failed = len(failed_trials(data))
    return (
        f"{path}: {data.attrs['title']} ({made}): {counted(data.sizes['setting'], 'setting')}, {trials}"
        + f", {failed:,} failed" * (failed > 0)
    )


def settings(
    data: xr.Dataset,
    path: Path,
    limit: int = MOST_ROWS,
    checkpoint: int | None = None,
    title: str = "",
    again: str = "",
) -> None:
    """Print one row per setting, at most `limit` (0: all): medians over robots and trials, intervals over trials.

    `again` is the shell line of the command. On a narrow terminal intervals stand below their values, then the
    coordinates of a setting share one column, and at last each setting has several lines.
    """
    columns = coordinates(data)
    varied = [k for k, values in columns.items() if (values != values[0]).any()]
    same = [f"{k} {v[0]}" for k, v in columns.items() if k not in varied and v[0] != NOTHING]
    frame = summary(data.isel(setting=slice(limit or None)), checkpoint=checkpoint)
    out = console()
    unfolded = out.options.update(max_width=UNFOLDED)
    named = {"setting": frame["setting"].astype(str).tolist()} | {k: columns[k][: len(frame)] for k in varied}
    rows: Table | Text = _rows(named, _numbers(data, frame))
    if rows.__rich_measure__(out, unfolded).maximum > out.width:
        rows = _rows(named, _numbers(data, frame, below=True))
    if rows.__rich_measure__(out, unfolded).maximum > out.width:
        each = zip(*(columns[k][: len(frame)] for k in varied), strict=True)
        joined = [", ".join(f"{k} {v}" for k, v in zip(varied, values, strict=True) if v != NOTHING) for values in each]
        numbers = _numbers(data, frame, below=True)
        rows = _rows({"setting": named["setting"], "with": joined}, numbers)
        bare = _rows({"setting": named["setting"]}, numbers)
        if bare.__rich_measure__(out, unfolded).maximum + FOLDED > out.width:
            rows = _blocks(frame, joined, numbers)
    if title:
        out.print(title)
    out.print(rows)
    for line in [*_legend(data, frame), *([f"all with {', '.join(same)}"] if same else [])]:
        out.print(line, style="dim")
    if len(frame) < data.sizes["setting"]:
        out.print(
            f"{len(frame):,} of {counted(data.sizes['setting'], 'setting')}; show all: "
            f"{again or shlex.join(['swarmcensus', 'show', str(path)])} --limit 0",
            soft_wrap=True,  # to be copied
        )


NOTHING = "-"  # shown where a coordinate has no value


def coordinates(data: xr.Dataset) -> dict[str, np.ndarray]:
    """The coordinates of settings as text, without those that another one implies and links that lose nothing."""
    values_of = {str(k): c.values for k, c in data.coords.items() if c.dims == ("setting",) and k != "setting"}
    columns = {name: np.array([grouped(value) for value in values]) for name, values in values_of.items()}
    if (columns["assumed_accuracy"] == columns["accuracy"]).all():
        del columns["assumed_accuracy"]
    if (data["link_success"] == 1.0).all():
        del columns["link_success"]
    for name in restated(data):
        columns.pop(name, None)
    columns |= {k: np.where((v == "") | (v == "nan"), NOTHING, v) for k, v in columns.items()}
    for name in dict.fromkeys(chain.from_iterable(parameters_in(data).values())):
        columns[name] = _parameter(data[name].values)
        if len({*columns[name]} - {"-"}) == 1 and "-" in columns[name]:  # the same for all brains that have it
            del columns[name]
    return columns


def _parameter(values: np.ndarray) -> np.ndarray:
    """A parameter's values as text; "-" for brains without it."""
    if values.dtype.kind == "f":
        return np.array(["-" if np.isnan(value) else f"{value:g}" for value in values.tolist()])
    return np.array([value or "-" for value in values.tolist()])


def _numbers(data: xr.Dataset, frame: Any, below: bool = False) -> dict[str, list[str]]:
    """The columns of numbers of a summary, with intervals beside or below their values."""
    trials, watched = data.sizes["trial"], {name: name for name in metrics_in(data)}
    sure = {name: column for name, column in SURE.items() if column in frame}
    numbers = dict(_values(frame, name, column, below) for name, column in {**SHORT, **sure, **watched}.items())
    if "consensus_right" in frame:
        numbers["exit %"] = ["-" if np.isnan(share) else f"{100.0 * share:.1f}" for share in frame["consensus_right"]]
    if "done" in frame:
        numbers["done %"] = ["-" if np.isnan(share) else f"{100.0 * share:.1f}" for share in frame["done"]]
    if "half_width" in frame or (frame["trials"] < trials).any():
        numbers["trials"] = [f"{n:,}" for n in frame["trials"]]
    if frame["failed"].any():
        numbers["failed"] = [f"{n:,}" for n in frame["failed"]]
    if "half_width" in frame:
        decimals = decimals_for(frame["half_width"].min())
        numbers["+-"] = ["-" if np.isnan(width) else f"{width:.{decimals}f}" for width in frame["half_width"]]
    return numbers


def _rows(coordinates: Mapping[str, Sequence[str]], numbers: dict[str, list[str]]) -> Table:
    heads = [(name, name == "setting") for name in coordinates] + [(name, True) for name in numbers]
    return table(heads, zip(*coordinates.values(), *numbers.values(), strict=True))


def _blocks(frame: Any, labels: Sequence[str], numbers: dict[str, list[str]]) -> Text:
    """Several lines per setting, for terminals too narrow for the numbers side by side."""
    lines = []
    for k, setting in enumerate(frame["setting"]):
        lines.append(f"setting {setting}{': ' * bool(labels[k])}{labels[k]}")
        lines += [f"  {name.splitlines()[0]} {' '.join(cells[k].splitlines())}" for name, cells in numbers.items()]
    return Text("\n".join(lines))


def _values(frame: Any, name: str, column: str, below: bool) -> tuple[str, list[str]]:
    """The head and the cells of a column of values with intervals."""
    times, digits = TIMES.get(name, 1.0), DIGITS.get(name, 2)
    ends = [times * frame[column + end] for end in ("", "_low", "_high")]
    widths = (ends[2] - ends[1]).where(np.isfinite(ends[2]))
    usual = max(decimals_for(widths.median(), digits), int(times > 1.0))  # more for a narrow interval
    if name not in TIMES:  # values of a metric may be whole, infinite, or equal up to rounding
        finite = ends[0][np.isfinite(ends[0])]
        usual = 0 if widths.isna().all() and (finite == finite.round()).all() else min(usual, MOST_DECIMALS)
    texts = []
    for value, low, high in zip(*ends, strict=True):
        if np.isnan(low):
            form = f".{DECIMALS[name]}f" if name in DECIMALS else ",.5g"
            texts.append(("-" if np.isnan(value) else f"{value:{form}}", ""))
        else:
            finest = min(decimals_for(high - low, digits) - 1, MOST_DECIMALS) if np.isfinite(high - low) else 0
            texts.append(rounded(value, low, high, max(usual, finest)))
    head = f"{name} %" if times > 1.0 else name
    if not any(interval for _, interval in texts):
        return head, [value for value, _ in texts]
    if below:
        return f"{head}\n[95 %]", [f"{value}\n{interval}" for value, interval in texts]
    wide, wider = (max(map(len, column)) for column in zip((head, "[95 %]"), *texts, strict=True))
    return f"{head:>{wide}} {'[95 %]':{wider}}", [f"{value:>{wide}} {interval:{wider}}" for value, interval in texts]


def _legend(data: xr.Dataset, frame: Any) -> list[str]:
    checkpoints = {round_ for round_ in frame["checkpoint"] if round_ >= 0}
    unit = "tick" if (data["topology"].values == MOVING).all() else "round"
    when = f"after {unit} {checkpoints.pop():,}" if len(checkpoints) == 1 else "at the last checkpoint"
    known = frame["convergence_round_low"].notna().any()
    floor = ", f: the black share of the trial's own floor" if data.attrs["truth"] == "floor" else ""
    return [
        f"K: {unit} of convergence, error: |x - f| at K, final error: after the last {unit} "
        f"(medians over robots and trials){floor}",
        f"right: robots in the correct bin {when}; "
        + ("[95 %]: over trials" if known else f"no intervals: fewer than {FEWEST:,} trials"),
        *(
            [f"coverage: robots whose interval holds f, interval width: their mean (median over trials), both {when}"]
            if "coverage" in frame
            else []
        ),
        *(["exit: trials whose first consensus is on the right option"] if "consensus_right" in frame else []),
        *(["done: robots that had finished by the end"] if "done" in frame else []),
        *disturbances(data),
        *(["robots that are not honest are left out"] if "honest" in data else []),
        *([f"not anonymous: {', '.join(_named(data))}"] if _named(data) else []),
        *_clipped(data),
        *(f"{name}: {data[name].attrs['long_name']} ({data[name].attrs['units']})" for name in metrics_in(data)),
        *(_remeasured(data, key) for key in asked_anew(data)),
        *(
            [
                f"+-: half the interval of the rule {data['half_width'].attrs['rule']}: wider than those above, "
                "because the rule is checked repeatedly"
            ]
            if "half_width" in data
            else []
        ),
    ]


def _clipped(data: xr.Dataset) -> list[str]:
    """A sentence on settings with messages that their format could not hold."""
    if "messages_clipped" not in data:
        return []
    clipped, sent = (data[name].mean(("trial", "robot")).values for name in ("messages_clipped", "messages_sent"))
    numbers = data["setting"].values[clipped > 0.0]
    if not numbers.size:
        return []
    most = 100.0 * np.nanmax(clipped / np.maximum(sent, 1.0))
    which = ", ".join(map(str, numbers[:MOST_NAMED])) + ", ..." * (numbers.size > MOST_NAMED)
    return [
        f"setting {which}: a number was too large for the message format and was sent as the largest, in up to "
        f"{most:.3g} % of the messages (messages_clipped)"
    ]


def _named(data: xr.Dataset) -> list[str]:
    """The brains that use the names of their robots."""
    return list(dict.fromkeys(data["brain"].values[data["anonymous"].values == 0].tolist()))


def _remeasured(data: xr.Dataset, key: str) -> str:
    """What --bins or --delta recomputed from kept estimates."""
    if key == "bins":
        return f"bins {data.attrs['bins']}, recomputed: right counts these bins"
    known = data["checkpoint"].values.tolist()
    first = [str(k) for k in (known if len(known) <= MOST_CHECKPOINTS else known[: MOST_CHECKPOINTS - 1])]
    more = [] if len(first) == len(known) else ["...", str(known[-1])]
    return (
        f"delta {data.attrs['delta']:g}, recomputed: K is the first of the checkpoints {', '.join(first + more)} from "
        "which on all estimates stay within delta"
    )


def failures(data: xr.Dataset) -> int:
    """Print failed trials on stderr, a line per setting. Returns the exit code: 2 if any failed."""
    by_setting: dict[int, list[dict[str, Any]]] = {}
    for failure in failed_trials(data):
        by_setting.setdefault(failure["setting"], []).append(failure)
    for number, failed in list(by_setting.items())[:MOST_ROWS]:
        trials = ", ".join(str(failure["trial"]) for failure in failed[:8]) + (", ..." if len(failed) > 8 else "")
        print(f"setting {number}, trial {trials}: {failed[0]['why']}", file=sys.stderr)
    if len(by_setting) > MOST_ROWS:
        print(f"and trials of {counted(len(by_setting) - MOST_ROWS, 'more setting')}", file=sys.stderr)
    return 2 if by_setting else 0


def rounds(trace: xr.Dataset, json: bool = False) -> None:
    """Print the swarm's estimates at a few rounds of a trace, as a table or as JSON."""
    honest = honest_in(trace)
    estimates = trace["estimate"].values[:, honest]
    last = len(estimates) - 1
    at = sorted({0, last} | {m * 10**e for e in range(9) for m in (1, 2, 5) if m * 10**e < last})
    ends = [(k, estimates[k].min(), np.median(estimates[k]), estimates[k].max()) for k in at]
    if json:
        names = ("round", "lowest", "median", "highest")
        rows = [dict(zip(names, values, strict=True)) for values in ends]
        answer("trace", {"title": trace.attrs["title"], "robots": int(honest.sum()), "rounds": rows})
        return
    whose = "the robots'" if honest.all() else f"the {honest.sum():,} honest robots'"
    console().print(f"{trace.attrs['title']}: {whose} estimates")
    heads = [(name, True) for name in ("round", "lowest", "median", "highest")]
    console().print(table(heads, [(f"{k:,}", *(f"{value:.4f}" for value in values)) for k, *values in ends]))


def disturbances(data: xr.Dataset) -> list[str]:
    """A line for each kind of fault in the studies, and one for the adversaries in the settings."""
    texts = json.loads(data.attrs["merged"]) if "merged" in data.attrs else [data.attrs["study"]]
    faults = [_fault_text(fault) for text in texts for fault in tomllib.loads(text).get("faults", [])]
    liars = sorted({name for name in data["adversary"].values.tolist() if name}) if "adversary" in data.coords else []
    return [*dict.fromkeys(faults), *([f"adversaries among the robots: {', '.join(liars)}"] if liars else [])]


def _fault_text(fault: dict[str, Any]) -> str:
    """One fault as text, such as "faults: 3 robots stop sensing and talking, from 50 on"."""
    robots, stop, at = fault["robots"], fault["stop"], fault["at"]
    who = f"{100 * robots:g} % of robots stop" if isinstance(robots, float) else f"{counted(robots, 'robot')} stop"
    who = "1 robot stops" if robots == 1 and isinstance(robots, int) else who
    what = stop if isinstance(stop, str) else " and ".join(stop)
    until = f" until {fault['until']}" if "until" in fault else " on"
    return f"faults: {who} {what}, from {at}{until}"
