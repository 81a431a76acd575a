"""Whether results exist: checked before anything slow is imported."""

import os
from pathlib import Path

from swarmcensus.support.errors import ResultsError
from swarmcensus.support.files import check_no_log
from swarmcensus.support.hints import did_you_mean_file
from swarmcensus.support.options import command


def folder_of(out: Path) -> Path:
    """The folder of the shards of a run that writes `out`; links to one file share it."""
    out = Path(os.path.realpath(out)) if out.is_symlink() else out
    return out.parent / f"{out.name}.parts"


def check_there(path: Path) -> None:
    """Raise InputError if there is neither a results file nor the shards of its run."""
    check_no_log(path)
    if path.suffix.lower() == ".toml" and path.is_file():
        first = command("swarmcensus", "run", path)
        raise ResultsError(f"{path} is a study, not results: first run it with {first}", file=path)
    if path.is_file() or folder_of(path).is_dir():
        return
    what = "it is a folder" if path.is_dir() else "it is no file" if path.exists() else "there is no such file"
    hint = did_you_mean_file(path, ".nc") if not path.exists() else ""
    raise ResultsError.within(f"results file {path}", f"{what}{': ' * bool(hint)}{hint.rstrip()}")
