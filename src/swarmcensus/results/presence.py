"""Whether results are there at all: told before anything is imported that takes long."""

import os
from pathlib import Path

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import file_meant


def folder_of(out: Path) -> Path:
    """Where the shards of a run that writes `out` are: one folder for all links to one file."""
    out = Path(os.path.realpath(out)) if out.is_symlink() else out
    return out.with_name(out.name + ".parts")


def check_there(path: Path) -> None:
    """Raise InputError where there is neither a results file nor what its run has so far."""
    if path.is_file() or (path.name and folder_of(path).is_dir()):
        return
    what = "it is a folder" if path.is_dir() else "it is no file" if path.exists() else "there is no such file"
    hint = file_meant(path) if not path.exists() else ""
    raise InputError(f"results file {path}: {what}{': ' * bool(hint)}{hint.rstrip()}")
