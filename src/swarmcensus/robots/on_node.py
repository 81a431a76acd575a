"""MicroPython on this machine: its WebAssembly package, run by Node. Its floats have 8 bytes, its pointers 4."""

import json
import os
import shutil
import subprocess
import textwrap
from collections.abc import Mapping
from pathlib import Path

from swarmcensus.support.errors import InputError
from swarmcensus.translation import piece

PACKAGE = "@micropython/micropython-webassembly-pyscript"
FOLDER = "MICROPYTHON_MODULES"  # the environment's variable that names the folder of Node's packages, or the one above
HEAP = 64 * 1024 * 1024
SECONDS = 600.0  # before a program is given up
NEEDED = f"Node and MicroPython: npm install {PACKAGE} here, or ${FOLDER} naming a folder that has it"


def micropython() -> Path | None:
    """The path of MicroPython's module for Node; None if it, or Node, is absent."""
    folders = [Path(os.environ[FOLDER])] if FOLDER in os.environ else []
    for folder in [*folders, *(folder / "node_modules" for folder in (*folders, Path()))]:
        module = folder / PACKAGE / "micropython.mjs"
        if module.is_file() and shutil.which("node"):
            return module.resolve()
    return None


def on_board(folder: Path, files: Mapping[str, str], heap: int = HEAP, module: Path | None = None) -> str:
    """What a board prints that has these files, texts by name, and runs main.py and its `step`, as often as STEPS says.

    `folder` takes the program that runs it. Raises InputError if MicroPython is absent, or with the board's last lines.
    """
    module = module or micropython()
    if module is None:
        raise InputError(f"needs {NEEDED}")
    runner, texts = folder / "runner.mjs", folder / "files.json"
    runner.write_text(piece("node.mjs"), encoding="utf-8")
    texts.write_text(json.dumps({name: textwrap.dedent(text) for name, text in files.items()}), encoding="utf-8")
    command = ["node", str(runner), str(module), str(heap), str(texts)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    if done.returncode:
        raise InputError(f"MicroPython stopped: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout
