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
