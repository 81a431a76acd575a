"""How notebooks show results and traces: the table of the summary, and the curves of a trial.

Both are xarray datasets. xarray's own view of them follows, folded. Other datasets look as usual.
"""

import base64
import io
from pathlib import Path
from typing import Any

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.templates import render

MOST_SETTINGS = 20


def register(shell: Any) -> None:
    """Make an IPython shell show datasets this way, without importing xarray. An existing formatter is kept."""
    formatter = shell.display_formatter.formatters["text/html"]
    dataset = "xarray.core.dataset", "Dataset"
    if dataset not in formatter.deferred_printers:
        formatter.for_type_by_name(*dataset, shown)


def shown(data: Any) -> str:
    """A dataset as HTML."""
    try:
        values = _curves(data) if {"round", "robot"} <= {*data.dims} else _summary(data)
    except Exception:  # the dataset is then shown as usual
        values = {}
    dataset = str(data._repr_html_())
    return render(Path(__file__).with_name("notebook.html.jinja"), dataset=dataset, **values) if values else dataset


def _curves(trace: Any) -> dict[str, Any]:
    """The picture of a trace's estimates by round, for the template; empty if there are no estimates."""
    if "estimate" not in trace:
        return {}
    from swarmcensus.figures.kinds.curves import curves

    buffer = io.BytesIO()
    curves(trace).savefig(buffer, format="png", dpi=110)
    return {"picture": base64.b64encode(buffer.getvalue()).decode()}


def _summary(data: Any) -> dict[str, Any]:
    """The title, counts and table of results, for the template; empty for datasets that are not results."""
    if "swarmcensus_version" not in data.attrs or "setting" not in data.dims:
        return {}
    from swarmcensus.figures.coordinates import varies
    from swarmcensus.results.summaries import done, medians_in, table_of

    count = data.sizes["setting"]
    frame = table_of(data.isel(setting=slice(0, MOST_SETTINGS)))
    measured = [name for name in (*medians_in(data), "correct", "coverage", "interval_width") if name in frame]
    table = frame[["setting", *varies(data), "trials"]].copy()
    if frame["failed"].any():
        table["failed"] = frame["failed"]
    for name in measured:
        ends = zip(frame[name], frame[f"{name}_low"], frame[f"{name}_high"], strict=True)
        table[name.replace("_", " ")] = [_with_interval(*value_and_ends) for value_and_ends in ends]
    return {
        "title": str(data.attrs.get("title", "")),
        "trials": f"{counted(int(done(data).sum()), 'trial')} of {counted(count, 'setting')}",
        "shortened": count > MOST_SETTINGS,
        "shown": MOST_SETTINGS,
        "table": table.to_html(index=False, border=0, na_rep="", float_format=lambda value: f"{value:g}"),
    }


def _with_interval(value: float, low: float, high: float) -> str:
    """A value and its interval as text; NaN is left out."""
    if value != value:
        return ""
    return f"{value:.3g}" + ("" if low != low else f" [{low:.3g}, {high:.3g}]")
