"""The only file that knows a CUDA library: opens a card, compiles, copies, launches and waits.

The library is NVIDIA's `cuda-bindings` with the wheel of its compiler NVRTC: 66 MB, and no toolkit. CuPy takes 70 MB
and needs the toolkit's headers besides, for arrays that nothing here uses. `cuda.core` wraps the same bindings in
classes that nothing here needs. The bindings have the same names for CUDA 12 and 13.
"""

import contextlib
import ctypes
import hashlib
import importlib
import re
import sys
import threading
import time
from collections.abc import Iterable
from concurrent.futures import Future
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from swarmcensus.engine import LeavableThreads, cache_root
from swarmcensus.support.cores import cores
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write

EXTRA = "pip install 'swarmcensus[gpu]'"
OPTIONS = (  # the bits of the host: a * b + c is rounded twice, quotients and roots once, and small numbers are kept
    "--fmad=false", "--prec-div=true", "--prec-sqrt=true", "--ftz=false", "-default-device", "-std=c++17",
)  # fmt: skip
FREELY_SHARED = 48 * 1024  # bytes of shared memory that a kernel may have without asking
NO_DRIVER = "NVIDIA's driver is not installed: this machine has no card that can be used"
OLDEST = (7, 0)  # the compute capability that kernels need
FIRST_PAUSE, LONGEST_PAUSE = 2e-5, 1e-3  # seconds between two looks at whether a card is ready
FULL, NO_DEVICE, NOT_READY = 2, 100, 600
LOST = {  # after these no call of this process succeeds
    4, 46, 214, 220, 226, 700, 702, 709, 710, 714, 715, 716, 717, 718, 719, 721, 999,
}  # fmt: skip


class CardError(InputError):
    """A card that cannot be used, or cannot run a setting; unlike a failing trial, it ends a run."""


class CardFull(CardError):
    """The card's memory is full."""


class CardLost(CardError):
    """The card no longer answers, and this process cannot use it again."""


class Program:
    """A compiled source on the card, and its kernels by name."""

    def __init__(self, handle: Any) -> None:
        """Keep the module's handle."""
        self.handle, self.kernels = handle, dict[str, Any]()


class Buffer:
    """Memory of a card, which is freed when this is collected."""

    def __init__(self, cuda: "Cuda", size: int) -> None:
        """Allocate so many bytes. Raises CardError."""
        self.cuda, self.size, self.address = cuda, size, int(cuda.call("cuMemAlloc", max(size, 1)))

    def __del__(self) -> None:
        """Free it."""
        if hasattr(self, "address"):
            with contextlib.suppress(Exception):  # a lost card, or Python ends
                self.cuda.call("cuMemFree", self.address)


class Cuda:
    """The first card that CUDA_VISIBLE_DEVICES names, in any thread of this process."""

    def __init__(self, driver: ModuleType, nvrtc: ModuleType) -> None:
        """Open the card. Raises CardError."""
        self._driver, self._nvrtc = driver, nvrtc
        self._context, self._lock = None, threading.Lock()
        self._codes, self._modules = dict[str, bytes](), dict[str, Program]()
        try:
            self.call("cuInit", 0)
            number = self.call("cuDriverGetVersion")
            major, minor = _of_compiler(nvrtc, "nvrtcVersion")
        except (CardError, RuntimeError, OSError, AttributeError) as error:  # the bindings load libraries when called
            raise _opening_error(error) from None
        self.cuda = f"{number // 1000}.{number % 1000 // 10}"
        if number // 1000 < major:
            both = f"the driver of this card is for CUDA {self.cuda}, and the compiler for CUDA {major}"
            older = ", or pip install 'swarmcensus[gpu12]'" * (major == 13)
            raise CardError(f"{both}: update the driver{older}")
        device = self.call("cuDeviceGet", 0)
        self.name = self.call("cuDeviceGetName", 256, device).split(b"\0")[0].decode()
        about = {"MAX_SHARED_MEMORY_PER_BLOCK_OPTIN": 0, "COMPUTE_CAPABILITY_MAJOR": 0, "COMPUTE_CAPABILITY_MINOR": 0}
        for name in about:
            kind = getattr(driver.CUdevice_attribute, f"CU_DEVICE_ATTRIBUTE_{name}")
            about[name] = int(self.call("cuDeviceGetAttribute", kind, device))
        self.shared, *capability = about.values()
        self.target = "sm_{}{}".format(*capability)
        if tuple(capability) < OLDEST:
            raise CardError(f"{self.name} is too old: cards of 2017 (Volta) or later are right")
        known = [f"sm_{number}" for number in _of_compiler(nvrtc, "nvrtcGetSupportedArchs")]
        if self.target not in known:
            raise CardError(
                f"{self.name} is {self.target}, and the installed compiler writes code for {', '.join(known)}: another "
                "version of CUDA may know it (pip install 'swarmcensus[gpu12]' is for older cards)"
            )
        self._mark = " ".join((self.target, *OPTIONS, f"NVRTC {major}.{minor}"))
        self.about = f"{self.name}, CUDA {self.cuda}, {self._mark}"
        self._context = self.call("cuDevicePrimaryCtxRetain", device)

    def call(self, name: str, *given: Any) -> Any:
        """Call a function of the driver in the card's context. Raises CardError."""
        if self._context is not None:
            self._answer("cuCtxSetCurrent", self._driver.cuCtxSetCurrent(self._context))
        return self._answer(name, getattr(self._driver, name)(*given))

    def free(self) -> int:
        """The bytes of memory that are free now."""
        return int(self.call("cuMemGetInfo")[0])

    def compile(self, sources: Iterable[str]) -> None:
        """Compile CUDA C++ for `build`, several at a time: NVRTC lets other threads run. Raises CardError."""
        begun = dict[str, Future[bytes]]()
        with LeavableThreads(cores()) as team:
            for source in sources:  # some take long to write
                begun[source] = begun.get(source) or team.submit(self._code_of, source)
            self._codes |= {source: future.result() for source, future in begun.items()}

    def build(self, source: str) -> Program:
        """Load what was compiled of CUDA C++, or compile it."""
        with self._lock:
            if source not in self._modules:
                code = self._codes.pop(source, None) or self._code_of(source)
                self._modules[source] = Program(self.call("cuModuleLoadData", code))
            return self._modules[source]

    def _code_of(self, source: str) -> bytes:
        """The machine code, from the cache on disk if it is there."""
        digest = hashlib.sha256(f"{self._mark}\0{source}".encode()).hexdigest()
        if (code := kept(digest)) is None:
            code = compiled(self._nvrtc, source, self.target)
            keep(digest, code)
        return code

    def set_global(self, program: Program, name: str, values: bytes) -> None:
        """Give a variable of a program its bytes, for the launches that follow."""
        array = np.frombuffer(values, np.uint8)
        self.call("cuMemcpyHtoD", self._place(program, name), array.ctypes.data, array.nbytes)

    def get_global(self, program: Program, name: str, size: int) -> bytes:
        """The bytes of a variable of a program, once all launches are over."""
        array = np.empty(size, np.uint8)
        self.call("cuMemcpyDtoH", array.ctypes.data, self._place(program, name), size)
        return array.tobytes()

    def _place(self, program: Program, name: str) -> Any:
        return self.call("cuModuleGetGlobal", program.handle, name.encode())[0]

    def upload(self, array: np.ndarray) -> Buffer:
        """Copy an array to the card."""
        array = np.ascontiguousarray(array)
        memory = Buffer(self, array.nbytes)
        if array.nbytes:
            self.call("cuMemcpyHtoD", memory.address, array.ctypes.data, array.nbytes)
        return memory

    def empty(self, size: int) -> Buffer:
        """So many bytes of the card, all 0."""
        memory = Buffer(self, size)
        self.clear(memory, size)
        return memory

    def clear(self, buffer: Buffer, size: int) -> None:
        """Set the first bytes of a buffer to 0."""
        if size:
            self.call("cuMemsetD8", buffer.address, 0, size)

    def download(self, buffer: Buffer, into: np.ndarray) -> None:
        """Copy memory of the card to a contiguous array, once all launches are over."""
        assert into.flags.c_contiguous
        if into.nbytes:
            self.call("cuMemcpyDtoH", into.ctypes.data, buffer.address, into.nbytes)

    def launch(self, program: Program, kernel: str, blocks: int, threads: int, shared: int, arguments: bytes) -> None:
        """Start a kernel after those before it; `arguments` are the bytes of the struct that it takes."""
        if kernel not in program.kernels:
            program.kernels[kernel] = self.call("cuModuleGetFunction", program.handle, kernel.encode())
        function = program.kernels[kernel]
        if shared > FREELY_SHARED:
            kind = self._driver.CUfunction_attribute.CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES
            self.call("cuFuncSetAttribute", function, kind, shared)
        struct = ctypes.create_string_buffer(arguments, len(arguments))
        places = np.array([ctypes.addressof(struct)], np.uint64)  # the driver copies the struct before it returns
        self.call("cuLaunchKernel", function, blocks, 1, 1, threads, 1, 1, shared, 0, places.ctypes.data, 0)

    def wait(self, stop: np.ndarray) -> bool:
        """Wait until all launches are over; False if `stop` (uint8, shape (1,)) was set meanwhile."""
        pause = FIRST_PAUSE
        self._answer("cuCtxSetCurrent", self._driver.cuCtxSetCurrent(self._context))
        while True:
            answer = self._driver.cuStreamQuery(0)
            if int(answer[0]) != NOT_READY:
                self._answer("cuStreamQuery", answer)
                return True
            if stop[0]:
                return False
            time.sleep(pause)
            pause = min(1.5 * pause, LONGEST_PAUSE)

    def _answer(self, name: str, answer: tuple[Any, ...]) -> Any:
        """What a function of the driver returned besides its code. Raises CardError."""
        code = int(answer[0])
        if code == 0:
            return answer[1] if len(answer) == 2 else answer[1:]
        said, card = getattr(answer[0], "name", f"error {code}"), getattr(self, "name", "the card")
        if code == FULL:
            raise CardFull(f"the memory of {card} is full")
        if code in LOST:
            raise CardLost(f"{card} was lost ({said}): finished work is kept; start again to go on")
        raise CardError(f"{name} of {card} fails with {said}")


def open_driver() -> Cuda:
    """Open the first card that CUDA_VISIBLE_DEVICES names. Raises CardError in one sentence."""
    try:
        driver, nvrtc = (importlib.import_module(f"cuda.bindings.{name}") for name in ("driver", "nvrtc"))
    except ImportError:
        try:
            ctypes.CDLL("nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1")
        except OSError:
            raise CardError(NO_DRIVER) from None
        raise CardError(f"a card needs NVIDIA's cuda-bindings and NVRTC: {EXTRA}") from None
    return Cuda(driver, nvrtc)


def compiled(nvrtc: ModuleType, source: str, target: str) -> bytes:
    """The machine code of a source for a target such as "sm_90". Raises CardError with the compiler's first error."""
    program = _of_compiler(nvrtc, "nvrtcCreateProgram", source.encode(), b"kernels.cu", 0, None, None)
    try:
        options = [option.encode() for option in (f"--gpu-architecture={target}", *OPTIONS)]
        if int(nvrtc.nvrtcCompileProgram(program, len(options), options)[0]):
            log = _text_of(nvrtc, "nvrtcGetProgramLog", program).decode(errors="replace").rstrip("\0")
            lines = [line.strip() for line in log.splitlines() if line.strip()]
            errors = [line for line in lines if re.search(r"\berror\b", line)] or lines or ["it gives no reason"]
            raise CardError(f"NVRTC cannot compile this for {target}: {errors[0]}")
        return _text_of(nvrtc, "nvrtcGetCUBIN", program)
    finally:
        nvrtc.nvrtcDestroyProgram(program)


def _text_of(nvrtc: ModuleType, name: str, program: Any) -> bytes:
    """What a function of the compiler writes."""
    text = bytes(_of_compiler(nvrtc, f"{name}Size", program))
    _of_compiler(nvrtc, name, program, text)  # it writes into these bytes
    return text


def _of_compiler(nvrtc: ModuleType, name: str, *given: Any) -> Any:
    code, *found = getattr(nvrtc, name)(*given)
    if int(code):
        raise CardError(f"{name} fails with {getattr(code, 'name', code)}")
    return found[0] if len(found) == 1 else found


def _opening_error(error: Exception) -> CardError:
    """Why there is no card, in a sentence."""
    text = str(error).strip()
    if isinstance(error, CardError) and "NO_DEVICE" not in text:
        return error
    if "nvrtc" in text.lower():
        return CardError(f"NVIDIA's compiler NVRTC cannot be loaded: {EXTRA}")
    if isinstance(error, CardError):
        return CardError("this machine has no NVIDIA card, or CUDA_VISIBLE_DEVICES hides it")
    return CardError(NO_DRIVER)


def kept(digest: str) -> bytes | None:
    """What the cache keeps by this digest; None if it is not there, or damaged."""
    try:
        data = _place(digest).read_bytes()
    except OSError:
        return None
    mark, text = data[:32], data[32:]
    return text if text and hashlib.sha256(text).digest() == mark else None


def keep(digest: str, data: bytes) -> None:
    """Keep machine code, or what was found of it, in the cache, where one can be written."""
    with contextlib.suppress(OSError, InputError), atomic_write(_place(digest)) as temporary:
        temporary.write_bytes(hashlib.sha256(data).digest() + data)


def _place(digest: str) -> Path:
    return cache_root() / f"{digest[:32]}.cubin"
