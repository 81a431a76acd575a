"""How notebooks show results and traces: the table of the summary, and the curves of a trial.

Both are xarray datasets. xarray's own view of them follows, folded. Other datasets look as usual.
"""

import base64
import io
from pathlib import Path
from typing import Any

from swarmcensus.support.templates import render


def register(shell: Any) -> None:
    """Make an IPython shell show datasets this way, without importing xarray. An existing formatter is kept."""
    formatter = shell.display_formatter.formatters["text/html"]
    dataset = "xarray.core.dataset", "Dataset"
    if dataset not in formatter.deferred_printers:
        formatter.for_type_by_name(*dataset, shown)


def shown(data: Any) -> str:
    """A dataset as HTML."""
    try:
        view = _view(data)
    except Exception:  # the dataset is then shown as usual
        view = ""
    dataset = str(data._repr_html_())
    return render(Path(__file__).with_name("notebook.html.jinja"), dataset=dataset, view=view) if view else dataset


def _view(data: Any) -> str:
    """The picture of a trace's estimates by round, or the table of results, as HTML; empty for other datasets."""
    if {"round", "robot"} <= {*data.dims} and "estimate" in data:
        from swarmcensus.figures.kinds.curves import curves

        buffer = io.BytesIO()
        curves(data).savefig(buffer, format="png", dpi=110)
        picture = base64.b64encode(buffer.getvalue()).decode()
        return f"<img src='data:image/png;base64,{picture}' alt='estimates by round'/>"
    if "swarmcensus_version" in data.attrs and "setting" in data.dims:
        from swarmcensus.summaries import Summary

        return Summary(data, data)._repr_html_()
    return ""
