"""What the workflow does, at home: `nox` runs all, `nox -s tests-3.12` one; Pythons that are missing are skipped."""

import subprocess
import tarfile
import tempfile
import zipfile
from pathlib import Path

import nox

nox.options.error_on_missing_interpreters = False
PYTHONS = ["3.11", "3.12", "3.13", "3.14"]
IN_BOTH = ("LICENSE", "starters/study.toml", "starters/brain.py", "py.typed")  # ends of names
IN_WHEEL = {"src/swarmcensus/": "swarmcensus/", "studies/": "swarmcensus/shipped_studies/"}  # where files go


@nox.session(python=PYTHONS)
def tests(session: nox.Session) -> None:
    """All tests; what follows -- goes to pytest."""
    session.install("-c", "constraints.txt", ".[test]")
    session.run("pytest", "-n", "2", *session.posargs)


@nox.session(python=False)
def lowest(session: nox.Session) -> None:
    """The quick tests with the lowest versions of all extras; `nox -s lowest -- core`: main paths of the core alone."""
    session.run("bash", "tools/lowest.sh", *session.posargs, external=True)


@nox.session
def lint(session: nox.Session) -> None:
    """Style, types and the order of packages."""
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
    session.run("pytest", "tests/docs/test_site.py")


@nox.session
def package(session: nox.Session) -> None:
    """Wheel and source archive hold what they should, and a wheel that is installed alone runs its first study."""
    session.install("build", "twine")
    folder = Path(tempfile.mkdtemp())
    session.run("python", "-m", "build", "--outdir", str(folder))
    [wheel], [archive] = folder.glob("*.whl"), folder.glob("*.tar.gz")
    session.run("twine", "check", "--strict", str(wheel), str(archive))
    _check_contents(session, wheel, archive)
    session.run("python", "-m", "venv", str(folder / "alone"))
    scripts = folder / "alone" / ("Scripts" if (folder / "alone" / "Scripts").is_dir() else "bin")
    session.run(str(scripts / "python"), "-m", "pip", "install", "-c", "constraints.txt", str(wheel), external=True)
    session.chdir(folder)
    program = str(scripts / "swarmcensus")
    session.env["SWARMCENSUS_CACHE"] = str(folder / "cache")
    for words in ("--help", "doctor", "studies", "new study", "run my_study.toml --trials 2"):
        session.run(program, *words.split(), external=True)


def _check_contents(session: nox.Session, wheel: Path, archive: Path) -> None:
    """Fail where a file that git knows is missing, or one is there that has no place in a release."""
    known = subprocess.run(["git", "ls-files"], capture_output=True, text=True, check=True).stdout.splitlines()
    with zipfile.ZipFile(wheel) as file:
        wheeled = set(file.namelist())
    with tarfile.open(archive) as file:
        archived = {name.partition("/")[2] for name in file.getnames()}
    due = {place + name[len(here) :] for here, place in IN_WHEEL.items() for name in known if name.startswith(here)}
    faults = [f"{wheel.name} lacks {name}" for name in sorted(due - wheeled)]
    code = {name for name in wheeled if ".dist-info/" not in name}
    faults += [f"{wheel.name} has {name}" for name in sorted(code - due)]
    wanted = {name for name in known if not name.startswith(".ci/")}
    faults += [f"{archive.name} lacks {name}" for name in sorted(wanted - archived)]
    faults += [f"{archive.name} has {name}" for name in sorted(archived - wanted - {"PKG-INFO", ""})]
    for name, held in ((wheel.name, wheeled), (archive.name, archived)):
        faults += [f"{name} lacks {end}" for end in IN_BOTH if not any(one.endswith(end) for one in held)]
    if faults:
        session.error("\n".join(faults))
