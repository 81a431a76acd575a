"""The command `doctor`: what is installed, what is missing, and the completion of shells."""

import platform
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from swarmcensus.cli.app import app
from swarmcensus.cli.help import COMMANDS
from swarmcensus.support.answers import Answer
from swarmcensus.support.cores import cores
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.version import __version__

LIBRARIES = (
    "numpy", "numba", "llvmlite", "xarray", "h5netcdf", "h5py", "pydantic", "rich", "matplotlib", "networkx",
    "pillow", "cyclopts", "jinja2", "packaging",
)  # fmt: skip


def doctor(
    *, completion: Annotated[Literal["bash", "zsh", "fish"] | None, Parameter(metavar="SHELL")] = None
) -> Answer | str:
    """Show what is installed, and what is missing.

    Args:
        completion: print a script for bash (~/.local/share/bash-completion/completions/swarmcensus), zsh
            (_cyclopts_swarmcensus in a folder of $fpath) or fish (~/.config/fish/completions/swarmcensus.fish)
    """
    if completion:
        return app(*COMMANDS).generate_completion(shell=completion)
    cache = _cache()
    try:
        from swarmcensus.gpu import examine

        card = examine() | {"usable": True}
    except (ImportError, InputError) as error:  # libraries may be missing
        card = {"usable": False, "why": str(error)}
    found = [*parts(cache, card)]
    faults = [f"{part}: {what}" for part, works, what in found if not works and part in (*LIBRARIES, "cache")]
    rows = [dict(zip(("part", "works", "found"), one, strict=True)) for one in found]
    fields = {"python": platform.python_version(), "cores": cores(), "cache": cache, "card": card}
    said = faults or ["all that is required works"]
    return Answer(sentences=said, rows=rows, fields=fields, code=2 if faults else 0)


def parts(cache: Mapping[str, Any], card: Mapping[str, Any]) -> Iterator[tuple[str, bool, str]]:
    """The parts of this installation, whether each works, and what was found; libraries are not imported."""
    yield "swarmcensus", True, __version__
    yield "Python", True, f"{platform.python_version()}, {sys.executable}"
    yield "system", True, f"{platform.platform()}, {counted(cores(), 'core')}"
    for name in LIBRARIES:
        yield name, bool(_version(name)), _version(name) or "not installed: pip install swarmcensus"
    state = f"{cache['brains']:,} pieces of compiled code, {cache['bytes'] / 1e6:.0f} MB"
    unusable = "no compiled code can be stored there, every run compiles: set $SWARMCENSUS_CACHE to another folder"
    yield "cache", cache["usable"], f"{cache['folder']}: {state if cache['usable'] else unusable}"
    for name, installed in _extras().items():
        how = "installed" if installed else f"not installed: pip install 'swarmcensus[{name}]'"
        yield f"extra {name}", installed, how
    state = "{name}, driver for CUDA {cuda}, {gigabytes:.0f} GB free: a small program runs on it"
    yield "graphics card", card["usable"], (state if card["usable"] else "not usable: {why}").format(**card)


def _cache() -> dict[str, Any]:
    """The folder of compiled code, and what it holds."""
    from swarmcensus.engine import cache_root, keeps

    try:
        folder, usable = str(cache_root()), keeps()
    except OSError:
        folder, usable = "no home folder", False
    kept = [path for path in Path(folder).iterdir() if path.is_dir()] if usable else []
    sizes = [file.stat().st_size for one in kept for file in one.rglob("*") if file.is_file()]
    return {"folder": folder, "usable": usable, "brains": len(kept), "bytes": sum(sizes)}


def _extras() -> dict[str, bool]:
    """Whether what each extra of swarmcensus needs is installed, in a version that it takes."""
    from importlib.metadata import distributions

    from packaging.requirements import Requirement

    found = [*distributions(name="swarmcensus")][:1]  # none where a checkout is used as it is
    every = [Requirement(text) for one in found for text in one.requires or ()]

    def installed(extra: str) -> bool:
        needed = [one for one in every if one.marker and one.marker.evaluate({"extra": extra})]
        fits = (bool(v := _version(one.name)) and one.specifier.contains(v, True) for one in needed)
        return all(fits) and all(installed(name) for one in needed for name in one.extras if one.name == "swarmcensus")

    return {extra: installed(extra) for one in found for extra in one.metadata.get_all("Provides-Extra") or ()}


def _version(name: str) -> str:
    import importlib.metadata  # slow, and other commands import this module too

    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""
