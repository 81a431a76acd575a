"""What the terminal shows: results, traces and brains as short tables."""

import json
import sys
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from swarmcensus.conformance import Check
from swarmcensus.panels import told

MOST_SETTINGS = 40


def _table(*columns: tuple[str, bool]) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name, right in columns:
        table.add_column(name, justify="right" if right else "left", overflow="fold")
    return table


def summary(data: xr.Dataset) -> None:
    """Medians over robots and trials of each setting, where the settings are few."""
    console = Console()
    rule = "half_width" in data  # then what each setting needed is what the run was for
    if data.sizes["setting"] > MOST_SETTINGS and not rule:
        return
    columns = {str(k): c.values.astype(str) for k, c in data.coords.items() if c.dims == ("setting",)}
    if (columns["assumed_accuracy"] == columns["accuracy"]).all():
        del columns["assumed_accuracy"]
    columns.pop(told(data), None)
    shown = [k for k, values in columns.items() if k != "setting" and len(np.unique(values)) > 1]
    table = _table(
        ("setting", True),
        *((k.replace("_", " "), False) for k in shown),
        ("K", True),
        ("error", True),
        ("right", True),
        *([("trials", True), ("+-", True)] if rule else []),
    )
    for k in range(data.sizes["setting"]):
        one = data.isel(setting=k)
        done = one["convergence_round"].values >= 0
        rounds = one["rounds"].values
        reached = np.flatnonzero(data["checkpoint"].values <= rounds)
        correct = one["correct"].values[reached[-1]] if reached.size else np.full(1, np.nan)
        right = f"{100 * np.nanmean(correct):.1f} %" if np.isfinite(correct).any() else "-"
        table.add_row(
            str(one["setting"].values),
            *(escape(str(one[c].values)) for c in shown),
            f"{np.median(one['convergence_round'].values[done]):.0f}" if done.any() else "-",
            f"{np.median(one['convergence_error'].values[done]):.4f}" if done.any() else "-",
            right,
            *([str(done[:, 0].sum()), f"{one['half_width'].values:.2g}"] if rule else []),
        )
    console.print(table)
    console.print(
        "K: round of convergence, error: |x - f| at K (medians over robots and trials); "
        "right: robots in the correct bin after the last round"
        + (f"; +-: half the interval of {data['half_width'].attrs['rule']}" if rule else ""),
        style="dim",
    )


def failures(data: xr.Dataset) -> int:
    """What failed, a line a setting; the exit code: 2 if anything did."""
    failed = json.loads(data.attrs.get("failed", "[]"))
    by_setting: dict[int, list[dict[str, Any]]] = {}
    for one in failed:
        by_setting.setdefault(one["setting"], []).append(one)
    for number, several in list(by_setting.items())[:MOST_SETTINGS]:
        trials = ", ".join(str(one["trial"]) for one in several[:8]) + (", ..." if len(several) > 8 else "")
        print(f"setting {number}, trial {trials}: {several[0]['why']}", file=sys.stderr)
    return 2 if failed else 0


def rounds(trace: xr.Dataset) -> None:
    """The swarm's estimates at a few rounds of a trace."""
    console = Console()
    estimates = trace["estimate"].values
    last = len(estimates) - 1
    table = _table(("round", True), ("lowest", True), ("median", True), ("highest", True))
    for k in sorted({0, last} | {m * 10**e for e in range(9) for m in (1, 2, 5) if m * 10**e < last}):
        row = estimates[k]
        table.add_row(str(k), f"{row.min():.4f}", f"{np.median(row):.4f}", f"{row.max():.4f}")
    console.print(f"{trace.attrs['title']}: the robots' estimates", highlight=False, markup=False)
    console.print(table)


def shipped() -> None:
    """The brains that come with swarmcensus, with their sizes on a robot."""
    from swarmcensus import brains

    table = _table(("brain", False), ("memory", True), ("message", True), ("what it does", False))
    for name in brains.shipped():
        brain = brains.load(name)
        what = (brain.functions.__doc__ or "").strip().splitlines()[0]
        table.add_row(name, f"{brain.memory_bytes} bytes", f"{brain.message_bytes} bytes", what)
    Console().print(table)


def checks(path: Any, found: list[Check]) -> bool:
    """What the conformance suite found; whether the brain passed."""
    console = Console(highlight=False)
    for one in found:
        mark = "[green]pass[/]" if one.fault is None else "[red bold]FAIL[/]"
        console.print(f"{mark}  {one.name}", markup=True)
        if one.fault is not None:
            console.print(f"      {one.fault}", markup=False, soft_wrap=True)
    good = all(one.fault is None for one in found)
    console.print(f"{path}: {'conforms' if good else 'does not conform'}", markup=False, soft_wrap=True)
    return good
