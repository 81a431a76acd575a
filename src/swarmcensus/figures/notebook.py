"""What a notebook shows of results and of a trace: a summary's table, a trial's curves.

Both are xarray's datasets, and what xarray shows of them is folded under it. All other datasets stay as they are.
"""

import base64
import html
import io
from typing import Any

from swarmcensus.basics.formatting import counted

MOST_SETTINGS = 20


def register(shell: Any) -> None:
    """Have an IPython shell show them so, without importing xarray. Where a person has chosen otherwise, that stays."""
    formatter = shell.display_formatter.formatters["text/html"]
    place = "xarray.core.dataset", "Dataset"
    if place not in formatter.deferred_printers:
        formatter.for_type_by_name(*place, shown)


def shown(data: Any) -> str:
    """A dataset in HTML."""
    try:
        ours = _curves(data) if {"round", "robot"} <= {*data.dims} else _summary(data)
    except Exception:  # what cannot be drawn is still a dataset
        ours = ""
    whole = str(data._repr_html_())
    return f"<div>{ours}<details><summary>the dataset</summary>{whole}</details></div>" if ours else whole


def _curves(trace: Any) -> str:
    if "estimate" not in trace:
        return ""
    from swarmcensus.figures.kinds.curves import curves

    buffer = io.BytesIO()
    curves(trace).savefig(buffer, format="png", dpi=110)
    return f"<img src='data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}' alt='estimates by round'/>"


def _summary(data: Any) -> str:
    if "swarmcensus_version" not in data.attrs or "setting" not in data.dims:
        return ""
    from swarmcensus.figures.coordinates import varies
    from swarmcensus.results.summaries import done, medians_in, summary

    count = data.sizes["setting"]
    frame = summary(data.isel(setting=slice(0, MOST_SETTINGS)))
    measured = [name for name in (*medians_in(data), "correct", "coverage", "interval_width") if name in frame]
    told = frame[["setting", *varies(data), "trials"]].copy()
    if frame["failed"].any():
        told["failed"] = frame["failed"]
    for name in measured:
        ends = zip(frame[name], frame[f"{name}_low"], frame[f"{name}_high"], strict=True)
        told[name.replace("_", " ")] = [_with_interval(*three) for three in ends]
    title = html.escape(str(data.attrs.get("title", "")))
    trials = f"{counted(int(done(data).sum()), 'trial')} of {counted(count, 'setting')}"
    more = f", the first {MOST_SETTINGS} here: sc.summary has all" if count > MOST_SETTINGS else ""
    note = "medians over robots and trials, of shares means, with 95 % intervals over trials"
    table = told.to_html(index=False, border=0, na_rep="", float_format=lambda value: f"{value:g}")
    scrolled = f"<div style='overflow-x: auto; white-space: nowrap'>{table}</div>"
    return f"<b>{title}</b>: {trials}{more}{scrolled}<small>{note}</small>"


def _with_interval(value: float, low: float, high: float) -> str:
    if value != value:
        return ""
    return f"{value:.3g}" + ("" if low != low else f" [{low:.3g}, {high:.3g}]")
