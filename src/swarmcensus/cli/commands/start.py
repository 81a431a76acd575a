"""The commands to start with: `new`, `studies` and `doctor`. Imports wait until a command needs them."""

import argparse
import importlib.util
import itertools
import os
import platform
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus.cli.options import Command, Group, add_shared
from swarmcensus.cli.output import answer, print_schema, wrote
from swarmcensus.support.errors import InputError, OptionError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command, misplaced, wrong_option
from swarmcensus.support.version import __version__

STARTERS = {"study": "study.toml", "brain": "brain.py"}
NEXT = {"study": "run", "brain": "brains --check"}  # the command to use the new file with


def add_new_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `new`."""
    sub.add_argument("what", choices=("study", "brain"), metavar="study|brain", help="kind of file")
    sub.add_argument(
        "file",
        type=Path,
        nargs="?",
        metavar="FILE",
        help="file to write (default: my_study.toml or my_brain.py in this folder, with a number if that exists)",
    )


def new(options: argparse.Namespace) -> int:
    """Write a commented study or brain to start from."""
    from swarmcensus.support.files import atomic_write

    starter = Path(__file__).parents[1] / "starters" / STARTERS[options.what]
    out = options.file or _free(Path(f"my_{starter.name}"))
    if out.suffix != starter.suffix:
        raise InputError.of(out, f"a {options.what} is a {starter.suffix} file")
    _not_there(out)
    text = starter.read_text(encoding="utf-8").replace("THIS_FILE", out.name)
    with atomic_write(out) as temporary:
        temporary.write_text(text.replace('name   = "mine"', f'name   = "{_plain(out.stem)}"'), encoding="utf-8")
    wrote(f"{out}: next, swarmcensus {NEXT[options.what]} {command(out)}")
    return 0


def add_studies_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `studies`."""
    what = sub.add_mutually_exclusive_group()
    what.add_argument("name", nargs="?", metavar="NAME", help="copy this study, with the files that it uses")
    add_shared(what, "schema")
    sub.add_argument(
        "--out", type=Path, metavar="FILE.toml", help="file of the copy (default: NAME.toml in this folder)"
    )


def studies(options: argparse.Namespace) -> int:
    """List the studies that come with swarmcensus, copy one with the files that it uses, or print their schema."""
    from swarmcensus.support.files import shipped_studies
    from swarmcensus.support.hints import did_you_mean

    if options.schema:
        return _schema(options)
    known = shipped_studies()
    if options.name is None:
        if options.out:
            raise misplaced("out", options.out, "needs the name of a study to copy")
        from swarmcensus.support.printed_tables import Table
        from swarmcensus.support.terminal import show

        rows = [(name, _first_words(path)) for name, path in known.items()]
        if options.json:
            answer("studies", {"studies": [{"name": name, "what": what} for name, what in rows]})
            return 0
        show(Table.of_rows({"study": False, "what it is": False}, rows))
        return 0
    if options.json:
        raise OptionError(f"--json goes with the list of studies only, not with {options.name}", key="json")
    name = options.name.removesuffix(".toml")
    if name not in known:
        hint = did_you_mean(name, known)
        there = f"{hint}`swarmcensus studies` lists them"
        raise InputError.of(options.name, f"no such study comes with swarmcensus: {there}")
    _copy(known[name], options.out or Path(known[name].name))
    return 0


def _schema(options: argparse.Namespace) -> int:
    from swarmcensus.studies import schema

    if options.out:
        raise wrong_option("out", options.out, "a schema is printed: swarmcensus studies --schema > study.schema.json")
    print_schema(schema())
    return 0


def _copy(study: Path, out: Path) -> None:
    """Copy a study and the files that it uses to one folder, and adapt their names in the study."""
    from swarmcensus.support.files import atomic_write, check_output

    check_output("out", out, (".toml",))

    text = study.read_text(encoding="utf-8")
    _not_there(out)
    copies = {name: _free(out.parent / Path(name).name, study.parent / name) for name in _files_of(study)}
    missing = {name: copy for name, copy in copies.items() if not copy.exists()}
    for name, copy in missing.items():
        with atomic_write(copy) as temporary:
            shutil.copyfile(study.parent / name, temporary)
    for name, copy in copies.items():
        text = text.replace(f'"{name}"', f'"{copy.name}"')
    with atomic_write(out) as temporary:
        temporary.write_text(text, encoding="utf-8")
    wrote(out)
    for name, copy in missing.items():
        usual = Path(name).name
        wrote(copy if copy.name == usual else f"{copy}: a different {usual} exists, and is kept")


def _files_of(study: Path) -> list[str]:
    """The files that a study uses, such as brains, metrics or links, as it names them."""
    import tomllib

    def strings(value: object) -> list[str]:
        if isinstance(value, dict):
            value = list(value.values())
        if isinstance(value, list):
            return [text for item in value for text in strings(item)]
        return [value] if isinstance(value, str) else []

    texts = dict.fromkeys(strings(tomllib.loads(study.read_text(encoding="utf-8"))))
    return [text for text in texts if (study.parent / text).is_file()]


def _free(path: Path, like: Path | None = None) -> Path:
    """The path, or the first with a number that does not exist yet or equals the file `like`."""
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in itertools.count(2))
    return next(candidate for candidate in itertools.chain([path], numbered) if _usable(candidate, like))


def _usable(path: Path, like: Path | None) -> bool:
    if not path.exists() and not path.is_symlink():
        return True
    import filecmp

    return like is not None and path.is_file() and filecmp.cmp(path, like, shallow=False)


def _not_there(path: Path) -> None:
    if path.exists() or path.is_symlink():
        raise InputError(f"{path} already exists: name another file", file=path)


def _plain(stem: str) -> str:
    """A name that a study may have, from the stem of a file."""
    return "".join(c if c.isalnum() or c in "-_" else "-" for c in stem)


def _first_words(study: Path) -> str:
    """The first sentence of the comment that a study begins with."""
    lines = []
    for line in study.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    words = re.split(r"(?<!Sec)[.?] (?=[A-Z`])|: (?=`)", " ".join(lines))[0]
    return words.rstrip(".:")


def doctor(options: argparse.Namespace) -> int:
    """Show what is installed and what is missing; the exit code is 2 if something required is."""
    installation = health()
    if options.json:
        answer("installation", installation.as_dict | {"faults": installation.faults})
    else:
        from swarmcensus.support.printed_tables import Table
        from swarmcensus.support.terminal import show

        show(Table.of_rows({"part": False, "found": False}, [(k, str(v)) for k, v in installation.lines()]))
        for fault in installation.faults:
            print(f"\n{fault}")
    return 2 if installation.faults else 0


LIBRARIES = (
    "numpy", "numba", "llvmlite", "xarray", "h5netcdf", "h5py", "pydantic", "rich", "matplotlib", "networkx",
    "filelock", "pillow", "shtab", "jinja2",
)  # fmt: skip
EXTRAS = {
    "parquet": ("pyarrow",),
    "film": ("imageio_ffmpeg",),
    "cluster": ("distributed", "dask_jobqueue"),
    "tune": ("cma",),
    "watch": ("starlette", "uvicorn", "websockets"),
    "ros": ("mcap", "rosbags"),
}  # the modules of each extra in pyproject.toml


@dataclass(frozen=True)
class Health:
    """What an installation consists of, as data for JSON, and its faults, a sentence each."""

    as_dict: dict[str, Any]
    faults: list[str]

    def lines(self) -> Iterator[tuple[str, Any]]:
        """The parts of the installation and their state, as rows of a table."""
        yield "swarmcensus", self.as_dict["swarmcensus"]
        yield "Python", f"{self.as_dict['python']}, {self.as_dict['executable']}"
        yield "system", f"{self.as_dict['system']}, {counted(self.as_dict['cores'], 'core')}"
        yield from self.as_dict["libraries"].items()
        cache = self.as_dict["cache"]
        state = f"{cache['brains']:,} pieces of compiled code, {cache['bytes'] / 1e6:.0f} MB"
        yield "cache", f"{cache['folder']}: {state if cache['usable'] else 'cannot be used'}"
        for name, installed in self.as_dict["extras"].items():
            yield f"extra {name}", "installed" if installed else f"not installed: pip install 'swarmcensus[{name}]'"
        card = self.as_dict["card"]
        usable = "{name}, driver for CUDA {cuda}, {gigabytes:.0f} GB free: a small program runs on it"
        yield "graphics card", usable.format(**card) if card["usable"] else f"not usable: {card['why']}"


def health() -> Health:
    """Examine this installation, without importing the libraries."""
    from swarmcensus.engine import cache_root, keeps

    faults = []
    libraries = {name: _version(name) for name in LIBRARIES}
    faults += [
        f"{name} is not installed: pip install swarmcensus" for name, version in libraries.items() if not version
    ]
    try:
        folder, usable = str(cache_root()), keeps()
    except OSError:
        folder, usable = "no home folder", False
    if not usable:
        faults.append(
            f"{folder}: compiled brains cannot be stored there, so that every run compiles again: "
            "set $SWARMCENSUS_CACHE to a folder that can be written"
        )
    kept = [path for path in Path(folder).iterdir() if path.is_dir()] if usable else []
    sizes = [file.stat().st_size for folder_ in kept for file in folder_.rglob("*") if file.is_file()]
    as_dict = {
        "swarmcensus": __version__,
        "python": platform.python_version(),
        "executable": sys.executable,
        "system": platform.platform(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "libraries": libraries,
        "cache": {"folder": folder, "usable": usable, "brains": len(kept), "bytes": sum(sizes)},
        "extras": {name: all(map(importlib.util.find_spec, parts)) for name, parts in EXTRAS.items()},
        "card": _card(),
    }
    return Health(as_dict, faults)


def _card() -> dict[str, Any]:
    """The graphics card and its driver, or why none can be used."""
    try:
        from swarmcensus.gpu import examined

        return examined() | {"usable": True}
    except (ImportError, InputError) as error:  # libraries may be missing
        return {"usable": False, "why": str(error)}


def _version(name: str) -> str:
    import importlib.metadata  # slow, and other commands import this module too

    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""


COMMANDS = (
    Command(
        "new", "Write a study or a brain to start from, with every line explained.",
        Group.STUDIES, new, add_new_options, json=False,
    ),
    Command(
        "studies", "List the studies that come with swarmcensus, copy one, or print their schema.",
        Group.STUDIES, studies, add_studies_options,
    ),
    Command(
        "doctor", "Show which versions are installed, and what is missing.",
        Group.SETUP, doctor,
    ),
)  # fmt: skip
