"""The commands to begin with: `new`, `studies` and `doctor`. Imports wait until needed."""

import argparse
import filecmp
import importlib.metadata
import importlib.util
import itertools
import os
import platform
import re
import shlex
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.version import __version__
from swarmcensus.cli.output import answer, wrote

STARTERS = {"study": "study.toml", "brain": "brain.py"}
NEXT = {"study": "run", "brain": "brains --check"}  # what to do with them


def add_new_options(sub: argparse.ArgumentParser) -> None:
    """Of `new`."""
    sub.add_argument("what", choices=("study", "brain"), metavar="study|brain", help="what to begin")
    sub.add_argument(
        "file",
        type=Path,
        nargs="?",
        metavar="FILE",
        help="default: my_study.toml or my_brain.py, here, with a number where that is taken",
    )


def new(options: argparse.Namespace) -> int:
    """Write a commented file to begin with."""
    from swarmcensus.basics.files import whole

    starter = Path(__file__).parent / "starters" / STARTERS[options.what]
    out = options.file or _free(Path(f"my_{starter.name}"))
    if out.suffix != starter.suffix:
        raise InputError(f"{out}: a {options.what} is a {starter.suffix} file")
    _not_there(out)
    text = starter.read_text(encoding="utf-8").replace("THIS_FILE", out.name)
    with whole(out) as beside:
        beside.write_text(text.replace('name   = "mine"', f'name   = "{_plain(out.stem)}"'), encoding="utf-8")
    wrote(f"{out}: now swarmcensus {NEXT[options.what]} {shlex.quote(str(out))}")
    return 0


def add_studies_options(sub: argparse.ArgumentParser) -> None:
    """Of `studies`."""
    what = sub.add_mutually_exclusive_group()
    what.add_argument("name", nargs="?", metavar="NAME", help="one to copy, with the files that it names")
    what.add_argument("--schema", action="store_true", help="print the JSON schema of study files, for editors")
    sub.add_argument("--out", type=Path, metavar="FILE.toml", help="default: its own name, here")


def studies(options: argparse.Namespace) -> int:
    """List the studies that come with swarmcensus, copy one with the files that it names, or print their schema."""
    from swarmcensus.basics.files import shipped_studies
    from swarmcensus.basics.hints import did_you_mean

    if options.schema:
        return _schema(options)
    known = shipped_studies()
    if options.name is None:
        if options.out:
            raise InputError(f"--out {options.out}: it goes with the name of a study, which is copied there")
        from swarmcensus.basics.terminal import console, table

        rows = [(name, _first_words(path)) for name, path in known.items()]
        if options.json:
            answer("studies", {"studies": [{"name": name, "what": what} for name, what in rows]})
            return 0
        console().print(table([("study", False), ("what it is", False)], rows))
        return 0
    if options.json:
        raise InputError(f"--json is of the list: it does not go with {options.name}, which is copied")
    name = options.name.removesuffix(".toml")
    if name not in known:
        hint = did_you_mean(name, known)
        raise InputError(
            f"{options.name}: no such study comes with swarmcensus: {hint}`swarmcensus studies` lists them"
        )
    _copy(known[name], options.out or Path(known[name].name))
    return 0


def _schema(options: argparse.Namespace) -> int:
    import json

    from swarmcensus.studies.schema import schema

    if options.out:
        raise InputError(f"--out {options.out}: a schema is printed: swarmcensus studies --schema > study.schema.json")
    print(json.dumps(schema(), indent=2, ensure_ascii=False))
    return 0


def _copy(study: Path, out: Path) -> None:
    """The files that a study names, then the study, which names them where they now lie: beside it."""
    if out.suffix != ".toml":
        raise InputError(f"--out {out}: a study is a .toml file")
    from swarmcensus.basics.files import whole

    text = study.read_text(encoding="utf-8")
    _not_there(out)
    copies = {name: _free(out.parent / Path(name).name, study.parent / name) for name in _named_by(study)}
    new = {name: copy for name, copy in copies.items() if not copy.exists()}
    for name, copy in new.items():
        with whole(copy) as beside:
            shutil.copyfile(study.parent / name, beside)
    for name, copy in copies.items():
        text = text.replace(f'"{name}"', f'"{copy.name}"')
    with whole(out) as beside:
        beside.write_text(text, encoding="utf-8")
    wrote(out)
    for name, copy in new.items():
        usual = Path(name).name
        wrote(copy if copy.name == usual else f"{copy}: there is another {usual} already, which stays as it is")


def _named_by(study: Path) -> list[str]:
    """Files that a study names, as brains, metrics or links."""
    import tomllib

    def words(value: object) -> list[str]:
        if isinstance(value, dict):
            return [word for one in value.values() for word in words(one)]
        if isinstance(value, list):
            return [word for one in value for word in words(one)]
        return [value] if isinstance(value, str) else []

    found = dict.fromkeys(words(tomllib.loads(study.read_text(encoding="utf-8"))))
    return [word for word in found if (study.parent / word).is_file()]


def _free(path: Path, like: Path | None = None) -> Path:
    """The path, or with a number the first that is not taken; one that holds what the file `like` does will do."""
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in itertools.count(2))
    return next(one for one in itertools.chain([path], numbered) if _will_do(one, like))


def _will_do(path: Path, like: Path | None) -> bool:
    if not path.exists() and not path.is_symlink():
        return True
    return like is not None and path.is_file() and filecmp.cmp(path, like, shallow=False)


def _not_there(path: Path) -> None:
    if path.exists() or path.is_symlink():
        raise InputError(f"{path} is there already: name another file")


def _plain(stem: str) -> str:
    """What a study may be called."""
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
    """Say what this installation is made of, and what is missing; 2 where compiled brains cannot be kept."""

    found = health()
    if options.json:
        answer("installation", found.told | {"faults": found.faults})
    else:
        from swarmcensus.basics.terminal import console, table

        console().print(table([("part", False), ("found", False)], [(k, str(v)) for k, v in found.lines()]))
        for fault in found.faults:
            print(f"\n{fault}")
    return 2 if found.faults else 0


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
}  # what each of pyproject's extras is imported as


@dataclass(frozen=True)
class Health:
    """What was found, as JSON takes it, and what is wrong, a sentence each."""

    told: dict[str, Any]
    faults: list[str]

    def lines(self) -> Iterator[tuple[str, Any]]:
        """What each thing is, and what of it there is."""
        yield "swarmcensus", self.told["swarmcensus"]
        yield "Python", f"{self.told['python']}, {self.told['executable']}"
        yield "system", f"{self.told['system']}, {counted(self.told['cores'], 'core')}"
        yield from self.told["libraries"].items()
        cache = self.told["cache"]
        state = f"{cache['brains']:,} pieces of compiled code, {cache['bytes'] / 1e6:.0f} MB"
        yield "cache", f"{cache['folder']}: {state if cache['usable'] else 'cannot be used'}"
        for name, there in self.told["extras"].items():
            yield f"extra {name}", "there" if there else f"not there: pip install 'swarmcensus[{name}]'"


def health() -> Health:
    """Look at this installation; nothing is imported that is only counted."""
    from swarmcensus.engine.code_cache import cache_root, keeps

    faults = []
    libraries = {name: _version(name) for name in LIBRARIES}
    faults += [f"{name} is not installed: pip install swarmcensus" for name, found in libraries.items() if not found]
    try:
        folder, usable = str(cache_root()), keeps()
    except OSError:
        folder, usable = "no home folder", False
    if not usable:
        faults.append(
            f"{folder}: brains cannot be kept there and are compiled anew by every run: let $SWARMCENSUS_CACHE name a "
            "folder that can be written"
        )
    kept = [path for path in Path(folder).iterdir() if path.is_dir()] if usable else []
    sizes = [file.stat().st_size for one in kept for file in one.rglob("*") if file.is_file()]
    told = {
        "swarmcensus": __version__,
        "python": platform.python_version(),
        "executable": sys.executable,
        "system": platform.platform(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "libraries": libraries,
        "cache": {"folder": folder, "usable": usable, "brains": len(kept), "bytes": sum(sizes)},
        "extras": {name: all(map(importlib.util.find_spec, parts)) for name, parts in EXTRAS.items()},
    }
    return Health(told, faults)


def _version(name: str) -> str:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""
