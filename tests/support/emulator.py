"""A driver for a processor: it compiles the kernels' text with g++ and runs the threads of a block one by one."""

import ctypes
import hashlib
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from swarmcensus.engine import cache_root
from swarmcensus.gpu.kernel_arguments import Given
from swarmcensus.support.files import atomic_write

FLAGS = ("-std=c++17", "-ffp-contract=off", "-fPIC", "-shared", "-w")


class Memory:
    def __init__(self, array):
        self.array, self.size, self.address = array, array.nbytes, array.ctypes.data


class Emulator:
    """A `gpu.driver.Cuda` that needs no card."""

    name, about, shared = "Emulator", "Emulator", 1 << 17

    def __init__(self, memory=1 << 32, level="-O0"):  # compiles in .3 s, -O1 in .7; as quick for few robots
        self.memory, self.flags = memory, (*FLAGS, level)
        self.launches = 0

    def free(self):
        return self.memory

    def compile(self, sources):
        self.compiled = {*sources}

    def build(self, source):
        digest = hashlib.sha256("\0".join((*self.flags, source)).encode()).hexdigest()[:32]
        library = cache_root() / f"{digest}.so"
        if not library.is_file():
            with tempfile.TemporaryDirectory() as folder:
                text, made = Path(folder) / "kernels.cpp", Path(folder) / "kernels.so"
                text.write_text(source)
                done = subprocess.run(["g++", *self.flags, "-o", made, text], capture_output=True, text=True)
                assert done.returncode == 0, done.stderr
                with atomic_write(library) as temporary:
                    shutil.copy(made, temporary)
        return ctypes.CDLL(str(library))

    def set_global(self, program, name, values):
        ctypes.memmove((ctypes.c_char * len(values)).in_dll(program, name), values, len(values))

    def get_global(self, program, name, size):
        return bytes((ctypes.c_char * size).in_dll(program, name))

    def upload(self, array):
        return Memory(array.copy())

    def empty(self, size):
        return Memory(np.zeros(-(-size // 8), np.uint64))

    def clear(self, buffer, size):
        buffer.array.view(np.uint8)[:size] = 0

    def download(self, buffer, into):
        into.reshape(-1).view(np.uint8)[:] = buffer.array.reshape(-1).view(np.uint8)[: into.nbytes]

    def launch(self, program, kernel, blocks, threads, shared, arguments):
        self.launches += 1
        function = program[kernel]
        function.argtypes = [Given, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p]
        given = Given.from_buffer_copy(arguments)
        assert threads in range(32, 1025, 32)
        room = np.full(max(shared, 8), 0xA5, np.uint8)  # nobody may rely on zeros
        for block in range(blocks):
            function(given, block, threads, room.ctypes.data)

    def wait(self, stop):
        return not stop[0]
