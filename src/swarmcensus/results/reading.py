"""Results as Python reads them: missing times are NaN, and accuracies are numbers, too.

Files, and runs while they are at work, keep such times as whole numbers, in which -1 means missing, and accuracies as
texts alone.
"""

import re
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.results.plugin_files import accuracies_in
from swarmcensus.results.values import ALL_VARIABLES, MISSING, ArrayStore
from swarmcensus.studies import NUMERIC
from swarmcensus.support.errors import InputError
from swarmcensus.worlds import parse_accuracy

NOT_RUN = "{}: no such robot, or not run"  # the attribute `comment` of times
WHOLE = tuple(name for name, (_, kind, *_) in ALL_VARIABLES.items() if np.issubdtype(kind, np.integer))
ORIGIN = "worked_out_from"  # an attribute
DRIFT = re.compile(r"drift=(\S+)")  # in the text of an accuracy


def readable(data: xr.Dataset, store: ArrayStore | None = None) -> xr.Dataset:
    """A dataset as Python reads it, from one as files keep it; `store` allocates its arrays, by default in memory."""
    variables: dict[str, Any] = {}
    for name in WHOLE:
        if name in data and (one := data.variables[name]).dtype.kind == "i":
            whole = one.values
            times = (store or ArrayStore()).full(whole.shape, np.nan, np.float64)
            np.copyto(times, whole, where=whole != MISSING)
            variables[name] = one.dims, times, one.attrs | {"comment": NOT_RUN.format("NaN")}
    data = data.assign(variables)
    if "accuracy" not in data.coords or NUMERIC.keys() & {*data.variables}:
        return data
    # the numbers of spreads in files of a user's are stored: opening results runs no file
    texts, moments = [str(text) for text in data["accuracy"].values.tolist()], accuracies_in(data)
    for text in {*texts} - {*moments}:
        try:
            moments[text] = parse_accuracy(text).start.moments
        except (ValueError, InputError):  # a text that no installed spread can read
            moments[text] = np.nan, np.nan, np.nan
    drifts = [float(found[1]) if (found := DRIFT.search(text)) else 0.0 for text in texts]
    numbers = [(*moments[text], drift) for text, drift in zip(texts, drifts, strict=True)]
    columns = zip(NUMERIC.items(), np.array(numbers).reshape(-1, 4).T, strict=True)
    return data.assign_coords(
        {name: ("setting", values, {"long_name": kind.meaning, ORIGIN: "accuracy"}) for (name, kind), values in columns}
    )


def packed(data: xr.Dataset) -> xr.Dataset:
    """A dataset as files keep it, from one as Python reads it. Times that are not whole numbers stay as they are."""
    variables: dict[str, Any] = {}
    for name in WHOLE:
        if name in data and data[name].dtype.kind == "f":
            times = data[name].values
            whole = np.full(times.shape, MISSING, ALL_VARIABLES[name][1])
            np.copyto(whole, times, where=np.abs(times) <= np.iinfo(whole.dtype).max, casting="unsafe")
            if not ((whole == times) | np.isnan(times)).all():
                continue
            about = data[name].attrs | {"comment": NOT_RUN.format(MISSING)}
            variables[name] = data[name].dims, whole, about
    added = [name for name in NUMERIC if name in data.coords and ORIGIN in data[name].attrs]
    return data.assign(variables).drop_vars(added)
