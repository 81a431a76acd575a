"""Who is on the board: the study of the shipped brains, and the same worlds for a brain of one's own."""

from pathlib import Path

from swarmcensus import brains
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.shipped import shipped_study
from swarmcensus.studies.study import Study
from swarmcensus.studies.toml_text import read_toml, to_toml

OFFICIAL = "shipped"  # what the shipped brains' results are called


def official() -> Study:
    """The study of all shipped brains. Raises InputError where it is missing."""
    return Study.load(shipped_study("leaderboard.toml"))


def of_file(file: Path) -> Study:
    """The same worlds for one brain file, by its path from here. Raises InputError, naming it and what is wrong."""
    path = shipped_study("leaderboard.toml")
    tables = read_toml(path.read_text(encoding="utf-8"), str(path))
    tables["swarm"]["brain"] = str(file)
    return Study.parse(to_toml(tables), where=f"leaderboard of {file}", context={"base": Path()})


def named(files: list[Path]) -> dict[str, Path]:
    """What each file's results are called. A file that is named twice is taken once.

    Raises InputError where two would be called the same, or one as ours.
    """
    names: dict[str, Path] = {}
    for file in files:
        if str(file) in brains.shipped():
            raise InputError(f"{file}: a shipped brain, which is on the board anyway: name a file of your own")
        if file.stem == OFFICIAL:
            raise InputError(f"{file}: results of this name are those of the shipped brains: call the file otherwise")
        if names.setdefault(file.stem, file).resolve() != file.resolve():
            raise InputError(f"{names[file.stem]} and {file}: both would be called {file.stem}: rename one of them")
    return names
