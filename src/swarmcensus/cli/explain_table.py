"""The table of `explain`: one row per setting, why some have no verdict, and how many agree with theory."""

import math
from typing import TYPE_CHECKING

import xarray as xr
from rich.table import Table

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.terminal import UNFOLDED, console, table
from swarmcensus.cli.tables import NOTHING, coordinates

if TYPE_CHECKING:
    from swarmcensus.explaining.agreement import Agreement, SettingAgreement
    from swarmcensus.explaining.one_setting import Interval

MEANS = (
    "measured: root mean squared error of x - f after the last round; theory: its expected value, where that is exact",
    "ratio: measured by theory, robot by robot, with its 99.9 % interval over trials; they agree if it contains 1",
    "efficiency: bound of the whole swarm divided by the mean squared error; limit: the largest part of the error",
)


def show(agreement: "Agreement", data: xr.Dataset, title: str, again: str, limit: int) -> None:
    """Print the first `limit` settings (0: all) of `data`, and how many of all agree. `again`: the command's line."""
    from swarmcensus.explaining.agreement import UNKNOWN

    shown = agreement.settings[: limit or None]
    shown_data = data.sel(setting=[row.setting for row in shown])
    all_of = coordinates(data.sel(setting=[row.setting for row in agreement.settings]))
    varied = [name for name, values in all_of.items() if (values != values[0]).any()]
    same = [f"{name} {values[0]}" for name, values in all_of.items() if name not in varied and values[0] != NOTHING]
    texts = coordinates(shown_data)
    left = {name: texts[name].tolist() for name in varied if name in texts}
    reasons = list(dict.fromkeys(row.why for row in shown if row.verdict == UNKNOWN))
    out = console()
    page = _rows(left, shown, reasons)
    if page.__rich_measure__(out, out.options.update(max_width=UNFOLDED)).maximum > out.width:
        each = zip(*left.values(), strict=True)
        joined = [", ".join(f"{k} {v}" for k, v in zip(left, values, strict=True) if v != NOTHING) for values in each]
        page = _rows({"with": joined} if left else {}, shown, reasons, narrow=True)
    out.print(title)
    out.print(page)
    for line in (*MEANS, *([f"all with {', '.join(same)}"] if same else [])):
        out.print(line, style="dim")
    for number, why in enumerate(reasons, start=1):
        out.print(f"[{number}] no verdict: {why}")
    if len(shown) < len(agreement.settings):
        out.print(
            f"{len(shown):,} of {counted(len(agreement.settings), 'setting')}; show all: {again} --limit 0",
            soft_wrap=True,
        )
    out.print(verdict_of(agreement))


def verdict_of(agreement: "Agreement") -> str:
    """How many settings agree, and how many are expected to differ by chance."""
    if not agreement.exact:
        return "no verdict for any of these settings: theory is not exact, or there are too few trials"
    return (
        f"{agreement.agree:,} of {counted(agreement.exact, 'setting')} with exact theory agree (by chance "
        f"{agreement.by_chance:.2g} would differ; the probability that any does is at most "
        f"{100 * agreement.by_chance:.2g} %)"
    )


def _rows(
    left: dict[str, list[str]], shown: "list[SettingAgreement]", reasons: list[str], narrow: bool = False
) -> Table:
    heads = [("setting", True), *((name, False) for name in left)]
    heads += [(name, True) for name in ("measured", "theory", "ratio", *([] if narrow else ["[99.9 %]"]))]
    heads += [("efficiency", True), ("limit", False), ("verdict", False)]
    rows = []
    for k, row in enumerate(shown):
        numbers = [_number(row.measured), _number(row.expected), _ratio(row.ratio[0])]
        numbers += [] if narrow else [_ends(row.ratio)]
        verdict = f"[{reasons.index(row.why) + 1}]" if row.why else row.verdict
        efficiency = f"{row.efficiency[0]:.3g}" if math.isfinite(row.efficiency[0]) else NOTHING
        labels = [values[k] for values in left.values()]
        rows.append([str(row.setting), *labels, *numbers, efficiency, row.limit or NOTHING, verdict])
    return table(heads, rows)


def _number(value: float) -> str:
    return f"{value:.5f}" if math.isfinite(value) else NOTHING


def _ratio(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else NOTHING


def _ends(interval: "Interval") -> str:
    return f"[{interval[1]:.3f}, {interval[2]:.3f}]" if math.isfinite(interval[1]) else ""
