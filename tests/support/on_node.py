"""MicroPython on this machine: its WebAssembly package, run by Node. Its floats have 8 bytes, its pointers 4."""

import os
import shutil
from pathlib import Path

PACKAGE = "@micropython/micropython-webassembly-pyscript"
FOLDER = "MICROPYTHON_MODULES"  # the environment's variable that names the folder of Node's packages, or the one above
NEEDED = f"Node and MicroPython: npm install {PACKAGE} here, or ${FOLDER} naming a folder that has it"


def micropython() -> Path | None:
    """The path of MicroPython's module for Node; None if it, or Node, is absent."""
    folders = [Path(os.environ[FOLDER])] if FOLDER in os.environ else []
    for folder in [*folders, *(folder / "node_modules" for folder in (*folders, Path()))]:
        module = folder / PACKAGE / "micropython.mjs"
        if module.is_file() and shutil.which("node"):
            return module.resolve()
    return None
