"""Files of topologies, floors and spreads that results name: they are run only if they are here as they were."""

import contextlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from swarmcensus.support.errors import InputError
from swarmcensus.support.plugins import PluginFile, name_what_runs, not_run, read_source


def plugin_files_in(data: Any) -> dict[str, dict[str, str]]:
    """The files of a dataset by kind and name, such as "topology mine.py": `sha256` and `source`."""
    return dict(json.loads(data.attrs.get("plugin_files", "{}")))


def accuracies_in(data: Any) -> dict[str, tuple[float, float, float]]:
    """The numbers of accuracies that files of spreads give, by their texts (see `Accuracy.moments`)."""
    return {text: (b, w, sd) for text, (b, w, sd) in json.loads(data.attrs.get("accuracies", "{}")).items()}


def plugin_files_of(data: Any, given: Iterable[Path], *, run: bool) -> list[PluginFile]:
    """The files of a dataset, to be read only; or with `run`, to be run.

    Raises InputError then for a file that is neither given nor found below the current folder.
    """
    files = []
    for title, stored in plugin_files_in(data).items():
        kind, _, name = title.partition(" ")
        source = stored["source"]
        here = [path for path in given if run and path.is_file() and read_source(kind, path) == source]
        here += [Path(name)] if run and not here and may_run(kind, name, source) else []
        if run and not here:
            raise not_run(kind, name)
        files.append(PluginFile(kind, name, source, here[0] if here else None))
    return files


def may_run(kind: str, name: str, source: str) -> bool:
    """Whether a file of this name and source lies below the current folder; a line on stderr says that it is run."""
    here = False
    with contextlib.suppress(OSError, ValueError, InputError):
        place = Path(name).resolve()
        small = place.is_file() and place.stat().st_size <= 2 * len(source.encode()) + 3  # line ends, a byte mark
        here = small and place.is_relative_to(Path.cwd().resolve()) and read_source(kind, place) == source
    if here:
        name_what_runs(kind, place)
    return here
