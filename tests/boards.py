"""What tests of robots share: MicroPython on Node, and swarms of runtimes that hear each other in one process."""

import json
import os
import shutil
import subprocess
import textwrap
from pathlib import Path

import pytest

from swarmcensus.brains.packing import Numbers
from swarmcensus.robot import runtime

ROOT = Path(__file__).parents[1]
PACKAGE = "@micropython/micropython-webassembly-pyscript"
FOLDER = "MICROPYTHON_MODULES"  # the environment's variable that names the folder of Node's packages, or the one above
HEAP = 64 * 1024 * 1024
ROBOT = ROOT / "src" / "swarmcensus" / "robot"

RUNNER = """
import { readFileSync } from "node:fs";
const [module, heap, files] = process.argv.slice(2);
const { loadMicroPython } = await import(module);
const board = await loadMicroPython({ heapsize: Number(heap), linebuffer: true, stdout: (line) => console.log(line) });
const texts = JSON.parse(readFileSync(files, "utf8"));
for (const [name, text] of Object.entries(texts)) board.FS.writeFile("/" + name, text);
board.runPython("import sys\\nsys.path.append('/')\\nimport main\\nSTEPS = getattr(main, 'STEPS', 0)");
const steps = board.globals.get("STEPS");
for (let step = 0; step < steps; step++) board.runPython("main.step()"); // garbage is collected between them only
"""


def micropython():
    """The path of MicroPython's module for Node; None if it, or Node, is absent."""
    folders = [Path(os.environ[FOLDER])] if FOLDER in os.environ else []
    for folder in [*folders, *(folder / "node_modules" for folder in (*folders, Path(), ROOT))]:
        module = folder / PACKAGE / "micropython.mjs"
        if module.is_file() and shutil.which("node"):
            return module.resolve()
    return None


needs_micropython = pytest.mark.skipif(
    micropython() is None,
    reason=f"needs Node and MicroPython: npm install {PACKAGE} here, or ${FOLDER} naming a folder that has it",
)


def on_board(tmp_path, files, heap=HEAP):
    """What a board prints that has these files, texts by name, and runs main.py."""
    (tmp_path / "runner.mjs").write_text(RUNNER)
    (tmp_path / "files.json").write_text(json.dumps({name: textwrap.dedent(text) for name, text in files.items()}))
    command = ["node", tmp_path / "runner.mjs", micropython(), str(heap), tmp_path / "files.json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def robot_files():
    """The files of every robot, without its brain."""
    return {name: (ROBOT / name).read_text() for name in ("codec.py", "runtime.py")}


def messages_of(brain, message="ratio16", mark=0xBEEF, checked=True, feedback=True):
    """The runtime's messages of a brain."""
    plan = brain.with_numbers(Numbers(message=message)).parts
    return runtime.Messages(tuple(brain.message.values()), plan, mark, checked, feedback)


class Air:
    """A radio of which each datagram reaches all others, unless `loses(sender, receiver)`."""

    def __init__(self, loses=lambda sender, receiver: False):
        self.loses = loses
        self.boxes = []

    def radio(self):
        self.boxes.append([])
        return Ear(self, len(self.boxes) - 1)


class Ear:
    def __init__(self, air, own):
        self.air, self.own = air, own

    def send(self, datagram):
        for k, box in enumerate(self.air.boxes):
            if k != self.own and not self.air.loses(self.own, k):
                box.append(datagram)

    def receive(self):
        box = self.air.boxes[self.own]
        return box.pop(0) if box else None


class Readings:
    """A sensor of given readings."""

    def __init__(self, readings):
        self.readings = iter(readings)
        self.started = 0

    def start(self):
        self.started += 1

    def read(self):
        return next(self.readings)


class Clock:
    def __init__(self):
        self.now = 0

    def __call__(self):
        return self.now
