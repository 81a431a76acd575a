"""The command `doctor`: what is installed, what is missing, and the completion of shells."""

import argparse
import platform
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus.cli.completion import SHELLS, completion
from swarmcensus.cli.options import Command, Group

from swarmcensus.cli.output import answer
from swarmcensus.support.cores import cores
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import misplaced
from swarmcensus.support.version import __version__


def add_doctor_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `doctor`."""
    sub.add_argument(
        "--completion",
        choices=SHELLS,
        metavar="SHELL",
        help="print the script that makes bash, zsh, fish or tcsh complete commands, options and names; bash reads it "
        "from the file ~/.local/share/bash-completion/completions/swarmcensus",
    )


def doctor(options: argparse.Namespace) -> int:
    """Show what is installed and what is missing; the exit code is 2 if something required is."""
    if options.completion:
        if options.json:
            raise misplaced("json", None, "does not go with --completion, which prints a script")
        from swarmcensus.cli.commands import parser

        print(completion(parser(), options.completion))
        return 0
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
    "pillow", "shtab", "jinja2", "packaging",
)  # fmt: skip
TOOLS = {  # programs that some commands call or name, and what for
    "cc": "make check, in what deploy --target c writes",
    "avr-gcc": "brains --cost, and the flash of Kilobots",
    "simavr": "brains --cost",
}


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
        for name, found in self.as_dict["tools"].items():
            yield f"tool {name}", found or f"not found: it is for {TOOLS[name]}"
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
        "cores": cores(),
        "libraries": libraries,
        "cache": {"folder": folder, "usable": usable, "brains": len(kept), "bytes": sum(sizes)},
        "extras": _extras(),
        "tools": {name: shutil.which(name) for name in TOOLS},
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


def _extras() -> dict[str, bool]:
    """Whether what each extra of swarmcensus needs is installed, in a version that it takes."""
    from importlib.metadata import metadata

    from packaging.requirements import Requirement

    about = metadata("swarmcensus")
    every = [Requirement(text) for text in about.get_all("Requires-Dist") or ()]

    def installed(extra: str) -> bool:
        needed = [one for one in every if one.marker and one.marker.evaluate({"extra": extra})]
        versions = [_version(one.name) for one in needed]
        fits = (bool(v) and one.specifier.contains(v, True) for one, v in zip(needed, versions, strict=True))
        return all(fits) and all(installed(name) for one in needed for name in one.extras if one.name == "swarmcensus")

    return {extra: installed(extra) for extra in about.get_all("Provides-Extra") or ()}


def _version(name: str) -> str:
    import importlib.metadata  # slow, and other commands import this module too

    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""


COMMANDS = (
    Command("doctor", "Show what is installed, and what is missing.", Group.SETUP, 2, doctor, add_doctor_options),
)
