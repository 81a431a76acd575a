"""What an installation is made of: versions, cores, the cache of compiled brains, and which extras are there."""

import importlib.metadata
import importlib.util
import os
import platform
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus.basics.counting import counted
from swarmcensus.basics.version import __version__

LIBRARIES = (
    "numpy", "numba", "llvmlite", "xarray", "h5netcdf", "h5py", "pydantic", "rich", "matplotlib", "networkx",
    "filelock", "pillow", "shtab",
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
