"""What the workflow does, at home: `nox` runs all, `nox -s tests-3.12` one; Pythons that are missing are skipped."""

import shutil
import subprocess
import tarfile
import tempfile
import zipfile
from pathlib import Path

import nox

nox.options.error_on_missing_interpreters = False
PYTHONS = ["3.11", "3.12", "3.13", "3.14"]
LARGEST_WHEEL = 1_500_000  # bytes
USED = (  # by a user of the wheel: a command of each group that `swarmcensus --help` shows, and the main job
    "--help",
    "doctor",
    "list studies",
    "reproduce --out paper",
    "new study",
    "run my_study.toml --trials 2",
    "show my_study.nc",
    "plot my_study.nc --kind lines --x robots",
    "new brain",
    "brains --check my_brain.py",
    "plan --side 3 --half-width 0.05 --accuracy 0.8 --robots 20 --trials 40",
    "deploy my_brain.py robot --target udp --b 0.9 --w 0.85",
    "watch my_study.toml --out page.html",
)
IN_BOTH = ("LICENSE", "starters/study.toml", "starters/brain.py", "py.typed")  # ends of names
IN_WHEEL = {"src/swarmcensus/": "swarmcensus/", "studies/": "swarmcensus/shipped_studies/"}  # where files go


@nox.session(python=PYTHONS)
def tests(session: nox.Session) -> None:
    """All tests; what follows -- goes to pytest."""
    session.install("-c", "constraints.txt", ".[dev]")
    session.run("pytest", "-n", "2", *session.posargs)


@nox.session(python=False)
def lowest(session: nox.Session) -> None:
    """The quick tests with the lowest versions of all extras; `nox -s lowest -- core`: main paths of the core alone."""
    session.run("bash", "tools/lowest.sh", *session.posargs, external=True)


@nox.session
def lint(session: nox.Session) -> None:
    """Style, spelling, types and the order of packages."""
    session.install("-c", "constraints.txt", ".[dev]")
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("codespell")
    session.run("mypy")
    session.run("lint-imports")


@nox.session
def docs(session: nox.Session) -> None:
    """The site is built, its tutorials run, and no link of it is dead."""
    session.install("-c", "constraints.txt", ".[docs,test]")
    session.run("mkdocs", "build", "--strict", *session.posargs)
    session.run("pytest", "tests/docs/test_site.py")


@nox.session
def release(session: nox.Session) -> None:
    """Build the wheel and the source archive into dist/, check them, and use the wheel alone as a user would."""
    session.install("build", "twine")
    shutil.rmtree("dist", ignore_errors=True)
    session.run("python", "-m", "build")
    [wheel], [archive] = Path("dist").resolve().glob("*.whl"), Path("dist").resolve().glob("*.tar.gz")
    session.run("twine", "check", "--strict", str(wheel), str(archive))
    _check_contents(session, wheel, archive)
    folder = Path(tempfile.mkdtemp())
    session.run("python", "-m", "venv", str(folder / "alone"))
    scripts = folder / "alone" / ("Scripts" if (folder / "alone" / "Scripts").is_dir() else "bin")
    constraints = str(Path("constraints.txt").resolve())
    session.run(str(scripts / "python"), "-m", "pip", "install", "-c", constraints, str(wheel), external=True)
    session.env["SWARMCENSUS_CACHE"] = str(folder / "cache")
    session.chdir(folder)  # nothing of the source is in reach
    for words in USED:
        session.run(str(scripts / "swarmcensus"), *words.split(), external=True)
    shutil.rmtree(folder)


def _check_contents(session: nox.Session, wheel: Path, archive: Path) -> None:
    """Fail where a file that git knows is missing, or one is there that has no place in a release."""
    known = subprocess.run(["git", "ls-files"], capture_output=True, text=True, check=True).stdout.splitlines()
    with zipfile.ZipFile(wheel) as file:
        wheeled = set(file.namelist())
    with tarfile.open(archive) as file:
        archived = {name.partition("/")[2] for name in file.getnames()}
    due = {place + name[len(here) :] for here, place in IN_WHEEL.items() for name in known if name.startswith(here)}
    faults = [f"{wheel.name} lacks {name}" for name in sorted(due - wheeled)]
    if wheel.stat().st_size > LARGEST_WHEEL:
        faults.append(f"{wheel.name} has {wheel.stat().st_size:,} bytes, more than {LARGEST_WHEEL:,}")
    code = {name for name in wheeled if ".dist-info/" not in name}
    faults += [f"{wheel.name} has {name}" for name in sorted(code - due)]
    wanted = {name for name in known if not name.startswith(".ci/")}
    faults += [f"{archive.name} lacks {name}" for name in sorted(wanted - archived)]
    faults += [f"{archive.name} has {name}" for name in sorted(archived - wanted - {"PKG-INFO", ""})]
    for name, held in ((wheel.name, wheeled), (archive.name, archived)):
        faults += [f"{name} lacks {end}" for end in IN_BOTH if not any(one.endswith(end) for one in held)]
    if faults:
        session.error("\n".join(faults))
