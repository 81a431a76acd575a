"""The table of `explain`: what can be explained, one row per setting, and how many agree with theory."""

import math
from collections import Counter
from typing import TYPE_CHECKING

import xarray as xr

from swarmcensus.results import NOTHING, coordinate_columns, varied_and_same
from swarmcensus.support import terminal
from swarmcensus.support.formatting import counted
from swarmcensus.support.printed_tables import FEW, NUMBER, Column, Table, with_ends

if TYPE_CHECKING:
    from swarmcensus.analysis import Agreement, Interval, SettingAgreement

MEANS = {
    "measured": "root mean squared error of x - f after the last round",
    "theory": "its expected value, where that is exact",
    "ratio": "measured by theory, robot by robot, with its 99.9 % interval over trials; they agree if it contains 1",
    "efficiency": "bound of the whole swarm divided by the mean squared error",
    "limit": "the largest part of the error",
}


def show(agreement: "Agreement", data: xr.Dataset, title: str, again: str, limit: int) -> None:
    """Print what can be explained, then the first `limit` settings (0: all) of `data`, and how many of all agree.

    `again` is the command's line.
    """
    shown = agreement.settings[: limit or None]
    varied, same = varied_and_same(data.sel(setting=[row.setting for row in agreement.settings]))
    left = [Column("setting", [str(row.setting) for row in shown]), *coordinate_columns(varied, len(shown))]
    columns = _columns(shown, [*reasons_of(agreement)], agreement.exact > 0)
    known = [head for column in columns for head in (column.head, column.interval_head)]
    more = f"{len(shown):,} of {counted(len(agreement.settings), 'setting')}; show all: {again} --limit 0"
    terminal.show(Table(
        [*left, *columns], title="\n".join([title, *coverage(agreement)]), above=same,
        notes=lambda left_out: [f"{k}: {means}" for k, means in MEANS.items() if k in {*known} - {*left_out}],
        more=more * (len(shown) < len(agreement.settings)),
    ))  # fmt: skip
    if agreement.exact:
        terminal.console().print(verdict_of(agreement))


def reasons_of(agreement: "Agreement") -> dict[str, int]:
    """Why settings have no verdict, each reason with its number of settings."""
    return dict(Counter(row.why for row in agreement.settings if row.why))


def coverage(agreement: "Agreement") -> list[str]:
    """How many settings can be compared with exact theory, and why the others cannot; empty if all can."""
    reasons = reasons_of(agreement)
    if not reasons:
        return []
    some = f"{agreement.exact:,} of" if agreement.exact else "none of these"
    settings = counted(len(agreement.settings), "setting")
    first = (
        f"a verdict on theory can be given for {some} {settings}; of each, the table has the error and what limits it"
    )
    return [first] + [
        f"[{number}] no verdict for {counted(count, 'setting')}: {why}"
        for number, (why, count) in enumerate(reasons.items(), start=1)
    ]


def verdict_of(agreement: "Agreement") -> str:
    """How many settings agree, and how many are expected to differ by chance."""
    return (
        f"{agreement.agree:,} of {counted(agreement.exact, 'setting')} with exact theory agree (by chance "
        f"{agreement.by_chance:.2g} would differ; the probability that any does is at most "
        f"{100 * agreement.by_chance:.2g} %)"
    )


def _columns(shown: "list[SettingAgreement]", reasons: list[str], exact: bool) -> list[Column]:
    """The columns next to the coordinates, without empty ones; `exact` is whether any has a verdict."""
    columns = [
        Column("measured", [_number(row.measured) for row in shown], spare=FEW),
        Column("theory", [_number(row.expected) for row in shown], spare=NUMBER + 1),
        Column(
            "ratio",
            [_ratio(row.ratio[0]) for row in shown],
            spare=FEW if exact else NUMBER + 2,
            intervals=[_ends(row.ratio) for row in shown],
            interval_head="[99.9 %]",
        ),
        Column("efficiency", [_share(row.efficiency[0]) for row in shown], spare=NUMBER),
        Column("limit", [row.limit or NOTHING for row in shown], number=False, spare=FEW),
    ]
    if exact or len(reasons) > 1:
        verdicts = [f"[{reasons.index(row.why) + 1}]" if row.why else row.verdict for row in shown]
        columns.append(Column("verdict", verdicts, number=False, spare=FEW - 1))
    return [column for column in columns if {*column.cells} - {NOTHING, ""}]


def _share(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else NOTHING


def records(agreement: "Agreement") -> list[dict[str, object]]:
    """A flat record for each setting; intervals have the ends `_low` and `_high`."""
    return [with_ends(row._asdict()) for row in agreement.settings]


def _number(value: float) -> str:
    return f"{value:.5f}" if math.isfinite(value) else NOTHING


def _ratio(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else NOTHING


def _ends(interval: "Interval") -> str:
    return f"[{interval[1]:.3f}, {interval[2]:.3f}]" if math.isfinite(interval[1]) else ""
