"""A command with a clock on each part of a first run: python benchmarks/where_seconds_go.py FILE WORDS...

Each process adds a line of JSON to the file: the seconds of a processor of each part, without those of parts inside it.
"""

import _frozen_importlib
import atexit
import functools
import json
import sys
import threading
import time
from collections import Counter

PASSES = {"nopython_type_inference": "type inference", "native_lowering": "writing LLVM's code"}
REST = "Numba's other passes"
PARTS = ["imports", *PASSES.values(), REST, "LLVM's passes", "machine code, linked", "cache", "the work itself"]

INSIDE = threading.local()  # how long the parts took that were inside each part that has not ended
SPENT = Counter()


def timed(function, part):
    """The same function; its seconds are those of a part, which may depend on its arguments."""

    @functools.wraps(function)
    def call(*given, **named):
        inner = INSIDE.__dict__.setdefault("seconds", [])
        inner.append(0.0)
        begun = time.thread_time()
        try:
            return function(*given, **named)
        finally:
            seconds = time.thread_time() - begun
            SPENT[part if isinstance(part, str) else part(*given)] += seconds - inner.pop()
            if inner:
                inner[-1] += seconds

    return call


def clock(owner, part, *names):
    """Put a clock on methods."""
    for name in names:
        setattr(owner, name, timed(getattr(owner, name), part))


def clock_numba():
    """Put clocks on all that compiles."""
    from numba.core import caching, codegen, compiler_machinery

    from swarmcensus.engine import inlined

    clock(compiler_machinery.PassManager, lambda _, index, one, state: PASSES.get(one.name(), REST), "_runPass")
    passes, final = ("_optimize_functions", "_optimize_final_module"), "_finalize_final_module"
    library = codegen.CPUCodeLibrary
    clock(library, "LLVM's passes", *passes)
    clock(inlined._Library, "LLVM's passes", *(name for name in passes if name in vars(inlined._Library)))
    clock(library, "machine code, linked", "add_ir_module", "finalize", "_get_module_for_linking", final)
    clock(inlined._Part, "machine code, linked", "finalize")
    clock(caching.Cache, "cache", "save_overload", "load_overload")


def write(path, begun):
    """Add what this process took since `begun`, in its seconds, to the file."""
    rest = time.process_time() - begun - SPENT.total()
    with open(path, "a", encoding="utf-8") as file:
        print(json.dumps(SPENT | Counter({PARTS[-1]: rest})), file=file)


def main(path, *words):
    """Run a command of swarmcensus."""
    find = timed(_frozen_importlib._find_and_load, "imports")

    def find_and_clock(name, importer):
        module = find(name, importer)
        if name == "swarmcensus.engine.inlined" and not hasattr(module, "clocked"):
            module.clocked = True
            clock_numba()
        return module

    _frozen_importlib._find_and_load = find_and_clock
    from swarmcensus.support import fork

    send = fork._send_result

    def send_with_clock(*given):
        SPENT.clear()
        INSIDE.__dict__.clear()
        begun = time.process_time()
        try:
            send(*given)
        finally:
            write(path, begun)

    fork._send_result = send_with_clock
    SPENT["imports"] += time.process_time()  # Python itself
    atexit.register(write, path, 0.0)
    sys.argv = ["swarmcensus", *words]
    from swarmcensus.cli.program import program

    program()


if __name__ == "__main__":
    main(*sys.argv[1:])
