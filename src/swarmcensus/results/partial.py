"""Partial results: what a run has finished so far, read from the shards next to its output.

After its first second, a run also writes the dataset of its study without trials. Reading takes no lock and changes
nothing, so it works during the run and after it was killed.
"""

import logging
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus.results.existing_files import folder_of
from swarmcensus.results.store import load_packed
from swarmcensus.results.values import Values, failed_in, finished_trials
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
        data = _filled(load_packed(sketch), shards.shard_files(sketch.parent))
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
    lacking = data.attrs["trials_total"] - data.attrs["trials_done"] - len(failed_in(data))
    if lacking > 0 and path.exists():
        done, total = data.attrs["trials_done"], data.attrs["trials_total"]
        LOG.info("%s: %s of %s trials done", path, f"{done:,}", f"{total:,}")


def _filled(sketch: xr.Dataset, paths: list[Path]) -> xr.Dataset:
    """The dataset filled with the trials in the shards; damaged shards are left out."""
    from swarmcensus.results import shards

    values = Values.of(sketch)
    values.grow(1)
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
        data[name] = (values.kinds[name][0], array, sketch[name].attrs)
    data.attrs["trials_done"] = int(finished_trials(data).sum())
    data.attrs["trials_total"] = max(data.attrs["trials_total"], data.attrs["trials_done"])
    return data
