"""What the workflow does, at home: `nox` runs all, `nox -s tests-3.12` one; Pythons that are missing are skipped."""

import tempfile
from pathlib import Path

import nox

nox.options.error_on_missing_interpreters = False
PYTHONS = ["3.11", "3.12", "3.13", "3.14"]


@nox.session(python=PYTHONS)
def tests(session: nox.Session) -> None:
    """All tests; what follows -- goes to pytest."""
    session.install("-c", "constraints.txt", ".[test]")
    session.run("pytest", "-n", "2", *session.posargs)


@nox.session
def lint(session: nox.Session) -> None:
    """Style, types and the order of rooms."""
    session.install("-c", "constraints.txt", ".[dev]")
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("mypy")
    session.run("lint-imports")


@nox.session
def docs(session: nox.Session) -> None:
    """The site is built, its tutorials run, and no link of it is dead."""
    session.install("-c", "constraints.txt", ".[docs,test]")
    session.run("mkdocs", "build", "--strict", *session.posargs)
    session.run("pytest", "tests/test_site.py", env={"SWARMCENSUS_SLOW": "1"})


@nox.session
def package(session: nox.Session) -> None:
    """The wheel and the source archive are built, and a wheel that is installed alone runs its first study."""
    session.install("build")
    folder = Path(tempfile.mkdtemp())
    session.run("python", "-m", "build", "--outdir", str(folder))
    [wheel] = folder.glob("*.whl")
    session.install("-c", "constraints.txt", str(wheel))
    session.chdir(folder)
    session.run("swarmcensus", "doctor")
    session.run("swarmcensus", "new", "study", "first.toml")
    session.run("swarmcensus", "run", "first.toml", "--trials", "2")
