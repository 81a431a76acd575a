"""A stand-in for NVIDIA's bindings: a card in the memory of this process, and a compiler that copies its source."""

import ctypes
import sys
from types import ModuleType, SimpleNamespace

NAMES = {0: "CUDA_SUCCESS", 2: "CUDA_ERROR_OUT_OF_MEMORY", 100: "CUDA_ERROR_NO_DEVICE", 600: "CUDA_ERROR_NOT_READY",
         700: "CUDA_ERROR_ILLEGAL_ADDRESS", 701: "CUDA_ERROR_LAUNCH_OUT_OF_RESOURCES"}  # fmt: skip


class Code(int):
    @property
    def name(self):
        return NAMES[self]


class Fake:
    """The state of the card. `fails` has the code that a function answers, by its name; `kernels` are called."""

    def __init__(self):
        self.fails, self.called, self.kernels, self.memory = {}, [], {}, {}
        self.version, self.capability, self.size, self.busy = 13000, (9, 0), 1 << 30, 0
        self.log, self.constants = b"", {}

    def answer(self, name, *values):
        self.called.append(name)
        return (Code(self.fails.get(name, 0)), *values)

    @property
    def free(self):
        return self.size - sum(map(len, self.memory.values()))


def install(monkeypatch):
    """Put a fake card where the bindings would be."""
    fake = Fake()
    packages = {name: ModuleType(name) for name in ("cuda", "cuda.bindings")}
    modules = {"driver": _driver(fake), "nvrtc": _nvrtc(fake)}
    for name, module in (packages | {f"cuda.bindings.{k}": m for k, m in modules.items()}).items():
        monkeypatch.setitem(sys.modules, name, module)
    return fake


def _driver(fake):
    def allocate(size):
        if size > fake.free:
            return (Code(2), None)
        memory = ctypes.create_string_buffer(size)
        fake.memory[ctypes.addressof(memory)] = memory
        return fake.answer("cuMemAlloc", ctypes.addressof(memory))

    def free(address):
        del fake.memory[int(address)]
        return fake.answer("cuMemFree")

    def copied(name):
        def copy(to, source, size):
            answer = fake.answer(name)
            if not answer[0]:
                ctypes.memmove(to, source, size)
            return answer

        return copy

    def fill(address, value, size):
        ctypes.memset(address, value, size)
        return fake.answer("cuMemsetD8")

    def launch(function, blocks, _y, _z, threads, _ty, _tz, shared, _stream, places, _extra):
        struct = ctypes.c_uint64.from_address(places).value
        answer = fake.answer("cuLaunchKernel")
        if not answer[0]:
            fake.kernels[function](blocks, threads, shared, struct)
        return answer

    def query(_):
        if fake.busy:
            fake.busy -= 1
            return (Code(600),)
        return fake.answer("cuStreamQuery")

    major, minor, shared = "MAJOR", "MINOR", "SHARED"
    kinds = SimpleNamespace(
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR=major, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR=minor,
        CU_DEVICE_ATTRIBUTE_MAX_SHARED_MEMORY_PER_BLOCK_OPTIN=shared,
    )  # fmt: skip
    about = {major: lambda: fake.capability[0], minor: lambda: fake.capability[1], shared: lambda: 232_448}
    module = ModuleType("cuda.bindings.driver")
    vars(module).update(
        CUdevice_attribute=kinds,
        CUfunction_attribute=SimpleNamespace(CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES="shared"),
        cuInit=lambda _: fake.answer("cuInit"),
        cuDriverGetVersion=lambda: fake.answer("cuDriverGetVersion", fake.version),
        cuDeviceGet=lambda n: fake.answer("cuDeviceGet", n),
        cuDeviceGetName=lambda size, _: fake.answer("cuDeviceGetName", b"Fake 1".ljust(size, b"\0")),
        cuDeviceGetAttribute=lambda kind, _: fake.answer("cuDeviceGetAttribute", about[kind]()),
        cuDevicePrimaryCtxRetain=lambda _: fake.answer("cuDevicePrimaryCtxRetain", "context"),
        cuCtxSetCurrent=lambda _: fake.answer("cuCtxSetCurrent"),
        cuMemGetInfo=lambda: fake.answer("cuMemGetInfo", fake.free, fake.size),
        cuMemAlloc=allocate, cuMemFree=free, cuMemcpyHtoD=copied("cuMemcpyHtoD"), cuMemcpyDtoH=copied("cuMemcpyDtoH"),
        cuMemsetD8=fill,
        cuModuleLoadData=lambda code: fake.answer("cuModuleLoadData", code),
        cuModuleGetFunction=lambda _, name: fake.answer("cuModuleGetFunction", name.decode()),
        cuModuleGetGlobal=lambda _, name: fake.answer("cuModuleGetGlobal", fake.constants[name], 8),
        cuFuncSetAttribute=lambda *_: fake.answer("cuFuncSetAttribute"),
        cuLaunchKernel=launch, cuStreamQuery=query,
    )  # fmt: skip
    return module


def _nvrtc(fake):
    def write(text):
        def into(_, room):
            ctypes.memmove(room, text(_), len(text(_)))
            return (0,)

        return into

    def code(program):
        return b"code of " + program

    module = ModuleType("cuda.bindings.nvrtc")
    vars(module).update(
        nvrtcVersion=lambda: (0, 13, 0),
        nvrtcGetSupportedArchs=lambda: (0, [75, 90]),
        nvrtcCreateProgram=lambda source, *_: (0, source),
        nvrtcCompileProgram=lambda *_: fake.answer("nvrtcCompileProgram"),
        nvrtcGetProgramLogSize=lambda _: (0, len(fake.log) + 1),
        nvrtcGetProgramLog=write(lambda _: fake.log),
        nvrtcGetCUBINSize=lambda program: (0, len(code(program))),
        nvrtcGetCUBIN=write(code),
        nvrtcDestroyProgram=lambda _: (0,),
    )
    return module
