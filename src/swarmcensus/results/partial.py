"""Partial results: what a run has finished so far, read from the shards next to its output.

After its first second, a run also writes the dataset of its study without trials. Reading takes no lock and changes
nothing, so it works during the run and after it was killed.
"""

import logging
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus.results import structure
from swarmcensus.results.existing_files import folder_of
from swarmcensus.results.store import checked, load_packed, read
from swarmcensus.results.values import Values, missing_value
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted

LOG = logging.getLogger(__name__)


def open_partial(path: str | Path) -> xr.Dataset:
    """Open a results file, or what its run has finished so far, as files keep it. Raises InputError."""
    path = Path(path)
    if path.exists():
        return load_packed(path)
    from swarmcensus.results import shards

    sketch = folder_of(path) / shards.SKETCH
    if not sketch.is_file():
        return load_packed(path)  # raises the right error
    try:
        data = _filled(_widened(read(sketch), sketch), shards.shard_files(sketch.parent))
    except InputError:
        if path.exists():  # the run has just ended
            return load_packed(path)
        raise
    done = int(Values.of(data).done().sum())  # local estimates may still be missing
    has = f"this is what its run has so far, {done:,} of {counted(data.attrs['trials_total'], 'trial')}"
    LOG.info("%s is not written yet: %s", path, has)
    return data


def say_partial(data: xr.Dataset, path: Path) -> None:
    """Log how many trials a results file has, if it is not complete."""
    lacking = data.attrs["trials_total"] - data.attrs["trials_done"] - len(structure.failed_pairs(data))
    if lacking > 0 and path.exists():
        done, total = data.attrs["trials_done"], data.attrs["trials_total"]
        LOG.info("%s: %s of %s trials done", path, f"{done:,}", f"{total:,}")


def _widened(data: xr.Dataset, path: Path) -> xr.Dataset:
    """Add an empty trial to a dataset without trials, and check it. Raises InputError if it was changed."""
    if data.sizes.get("trial") == 0 and "trial" in data.indexes:
        arrays = {name: array for name, array in data.data_vars.items() if "trial" in array.dims}
        missing = {name: array.dtype.type(missing_value(array.dtype)) for name, array in arrays.items()}
        data = data.reindex(trial=[0], fill_value=missing)
        for name, array in arrays.items():
            data[name].encoding = array.encoding
    return checked(data, path)


def _filled(sketch: xr.Dataset, paths: list[Path]) -> xr.Dataset:
    """The dataset filled with the trials in the shards; damaged shards are left out."""
    from swarmcensus.results import shards

    values = Values.of(sketch)
    numbers = {str(mark): k for k, mark in enumerate(sketch["fingerprint"].values)}
    checkpoints = sketch["checkpoint"].values.tolist()
    for shard in filter(None, map(shards.read, paths)):
        for part in shard.found:
            columns = {name: taken for name, taken in part.columns.items() if name in values.arrays}
            fits = shard.about["checkpoints"] == checkpoints or part.local
            if part.setting in numbers and columns and fits:
                trial = values.kinds[next(iter(columns))][0].index("trial") - 1
                values.grow(part.first + next(iter(columns.values())).shape[trial])
                values.put(numbers[part.setting], part.first, columns)
    data = sketch.drop_dims("trial").assign_coords(trial=np.arange(values.trials))
    for name, array in values.arrays.items():
        data[name] = (values.kinds[name][0], array, sketch[name].attrs, sketch[name].encoding)
    data.attrs["trials_done"] = int(structure.finished_trials(data).sum())
    data.attrs["trials_total"] = max(data.attrs["trials_total"], data.attrs["trials_done"])
    if wrong := structure.fault_of(data):
        raise InputError(f"what a run keeps next to its output is damaged or changed: {wrong}")
    return data
