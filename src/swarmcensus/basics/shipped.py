"""Study files that come with the package, whether it is installed or a source checkout."""

from pathlib import Path

from swarmcensus.basics.errors import InputError


def shipped_study(name: str) -> Path:
    """Where a study file, or a folder of them, is. Raises InputError where it is missing."""
    package = Path(__file__).parents[1]
    for place in (package / "shipped_studies" / name, package.parents[1] / "studies" / name):
        if place.exists():
            return place
    raise InputError(f"study files are missing: this installation has no {package / 'shipped_studies' / name}")


def shipped_studies() -> dict[str, Path]:
    """All of them by their names, as ring or paper/topologies. Raises InputError where they are missing."""
    root = shipped_study("")
    found = {path.relative_to(root).with_suffix("").as_posix(): path for path in root.rglob("*.toml")}
    return dict(sorted(found.items(), key=lambda item: (item[0].count("/"), item[0])))
