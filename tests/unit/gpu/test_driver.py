"""The driver of cards, with stand-ins for NVIDIA's libraries."""

import ctypes
import sys
import threading
from types import ModuleType, SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from swarmcensus.engine import cache_root
from swarmcensus.gpu import CardError, CardFull, CardLost, driver, examine, open_driver
from swarmcensus.gpu.cards import features_of
from swarmcensus.gpu.source import measures, source
from swarmcensus.simulation import inputs_of
from tests.support.small import study_of

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
    for module in (ModuleType("cuda"), ModuleType("cuda.bindings"), _driver(fake), _nvrtc(fake)):
        monkeypatch.setitem(sys.modules, module.__name__, module)
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

    kinds = SimpleNamespace(
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR=lambda: fake.capability[0],
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR=lambda: fake.capability[1],
        CU_DEVICE_ATTRIBUTE_MAX_SHARED_MEMORY_PER_BLOCK_OPTIN=lambda: 232_448,
    )
    module = ModuleType("cuda.bindings.driver")
    vars(module).update(
        CUdevice_attribute=kinds,
        CUfunction_attribute=SimpleNamespace(CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES="shared"),
        cuInit=lambda _: fake.answer("cuInit"),
        cuDriverGetVersion=lambda: fake.answer("cuDriverGetVersion", fake.version),
        cuDeviceGet=lambda n: fake.answer("cuDeviceGet", n),
        cuDeviceGetName=lambda size, _: fake.answer("cuDeviceGetName", b"Fake 1".ljust(size, b"\0")),
        cuDeviceGetAttribute=lambda about, _: fake.answer("cuDeviceGetAttribute", about()),
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
        nvrtcVersion=lambda: (0, 13, 0), nvrtcGetSupportedArchs=lambda: (0, [75, 90]),
        nvrtcCreateProgram=lambda source, *_: (0, source), nvrtcDestroyProgram=lambda _: (0,),
        nvrtcCompileProgram=lambda *_: fake.answer("nvrtcCompileProgram"),
        nvrtcGetProgramLogSize=lambda _: (0, len(fake.log) + 1), nvrtcGetProgramLog=write(lambda _: fake.log),
        nvrtcGetCUBINSize=lambda program: (0, len(code(program))), nvrtcGetCUBIN=write(code),
    )  # fmt: skip
    return module


GOING = np.zeros(1, np.uint8)
TWICE = 'struct Twice { double* values; }; extern "C" __global__ void twice(Twice given) { given.values[0] *= 2.0; }'


@pytest.fixture
def card(monkeypatch, tmp_path):
    monkeypatch.setenv("SWARMCENSUS_CACHE", str(tmp_path))
    return install(monkeypatch)


def test_kernels_change_what_was_uploaded(card):
    def twice(blocks, threads, shared, struct):
        assert (blocks, threads, shared) == (3, 64, 100_000)
        np.frombuffer(card.memory[ctypes.c_uint64.from_address(struct).value], np.float64)[:] *= 2.0

    card.kernels["twice"] = twice
    opened, found = open_driver(), np.empty(4)
    buffer = opened.upload(np.arange(8.0)[::2])
    opened.launch(opened.build(TWICE), "twice", 3, 64, 100_000, np.uint64(buffer.address).tobytes())
    assert opened.wait(GOING)
    opened.download(buffer, found)
    assert (found.tolist(), card.called.count("cuFuncSetAttribute")) == ([0.0, 4.0, 8.0, 12.0], 1)
    assert (opened.name, opened.shared) == ("Fake 1", 232_448)


def test_a_small_program_shows_that_a_card_works(card):
    def doubled(blocks, threads, _, struct):
        address = ctypes.c_uint64.from_address(struct).value
        np.frombuffer(card.memory[address], np.float64)[: card.reached] *= 2.0

    card.kernels["doubled"], card.reached = doubled, 64
    assert examine() == {"name": "Fake 1", "cuda": "13.0", "gigabytes": (card.size - 512) / 1e9}
    card.reached = 63
    with pytest.raises(CardError, match="Fake 1 computes wrongly"):
        examine()


def test_constants_get_their_values(card):
    given = np.zeros(1)
    card.constants[b"given"] = given.ctypes.data
    opened = open_driver()
    opened.set_global(opened.build("one"), "given", np.float64(0.25).tobytes())
    assert given == 0.25


def test_memory_is_freed_with_its_buffer(card):
    opened = open_driver()
    before, found = opened.free(), np.ones(5, np.uint8)
    buffer = opened.empty(5)
    opened.download(buffer, found)
    assert not found.any()
    assert opened.free() == before - 5
    del buffer
    assert opened.free() == before


def test_each_thread_gets_the_context(card):
    opened = open_driver()
    card.called.clear()
    thread = threading.Thread(target=opened.free)
    thread.start()
    thread.join()
    assert card.called == ["cuCtxSetCurrent", "cuMemGetInfo"]


def test_waiting_ends_when_stopped(card):
    opened, card.busy = open_driver(), 3
    assert opened.wait(GOING)
    assert card.busy == 0
    card.busy = 10**9
    assert not opened.wait(np.ones(1, np.uint8))


def test_machine_code_is_compiled_once_and_damaged_files_again(card):
    for _ in range(2):
        open_driver().build("one")
        opened = open_driver()
        assert opened.build("one") is opened.build("one")
        assert card.called.count("nvrtcCompileProgram") == 1
        [file] = cache_root().glob("*.cubin")
        file.write_bytes(file.read_bytes()[:-1])
        card.called.clear()
    card.capability = 7, 5
    assert open_driver().build("one").handle == b"code of one"  # another card has other code
    assert len([*cache_root().glob("*.cubin")]) == 2


def test_programs_are_compiled_together_and_loaded_by_the_thread_that_runs_them(card, monkeypatch):
    opened, both = open_driver(), threading.Barrier(2)
    monkeypatch.setattr(driver, "cores", lambda: 2)
    monkeypatch.setattr(opened._nvrtc, "nvrtcCompileProgram", lambda *_: (0 * both.wait(9),))
    opened.compile(["one", "two"])
    assert "cuModuleLoadData" not in card.called
    assert [opened.build(name).handle for name in ("one", "two")] == [b"code of one", b"code of two"]


def test_a_cache_that_cannot_be_written_is_done_without(card, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SWARMCENSUS_CACHE", str(tmp_path / "file" / "cache"))
    assert open_driver().build("one").handle == b"code of one"


@pytest.mark.parametrize(("library", "why"), [
    (str, r"NVRTC: pip install 'swarmcensus\[gpu\]'"), (Mock(side_effect=OSError), "NVIDIA's driver is not installed"),
])  # fmt: skip
def test_without_the_extra_its_name_is_said_where_there_is_a_driver(monkeypatch, library, why):
    for name in ("cuda.bindings", "cuda.bindings.driver", "cuda.bindings.nvrtc"):  # another test may have loaded them
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr(driver.ctypes, "CDLL", library)
    with pytest.raises(CardError, match=why):
        open_driver()


@pytest.mark.parametrize(("name", "said"), [
    ("cuInit", "NVIDIA's driver is not installed: this machine has no card"),
    ("nvrtcVersion", r"NVRTC cannot be loaded: pip install 'swarmcensus\[gpu\]'"),
])  # fmt: skip
def test_libraries_that_cannot_be_loaded(name, said, card, monkeypatch):
    module = sys.modules["cuda.bindings.driver" if name == "cuInit" else "cuda.bindings.nvrtc"]
    monkeypatch.setattr(module, name, Mock(side_effect=RuntimeError(f"no library of {name} was found")))
    with pytest.raises(CardError, match=said):
        open_driver()


@pytest.mark.parametrize(("state", "said"), [
    ({"fails": {"cuInit": 100}}, "this machine has no NVIDIA card, or CUDA_VISIBLE_DEVICES hides it"),
    ({"version": 12040}, r"driver of this card is for CUDA 12.4, and the compiler for CUDA 13: update.*\[gpu12\]"),
    ({"capability": (7, 0)}, "Fake 1 is sm_70, and the installed compiler writes code for sm_75, sm_90"),
])  # fmt: skip
def test_cards_that_cannot_be_used(state, said, card):
    vars(card).update(state)
    with pytest.raises(CardError, match=rf"^.*{said}.*\Z"):  # in one line
        open_driver()


def test_a_full_card(card):
    with pytest.raises(CardFull, match=r"^the memory of Fake 1 is full$"):
        open_driver().empty(card.size + 1)


def test_a_lost_card(card):
    opened = open_driver()
    program = opened.build("one")
    card.fails["cuStreamQuery"] = 700
    with pytest.raises(CardLost, match=r"Fake 1 was lost .CUDA_ERROR_ILLEGAL_ADDRESS.: finished work is kept"):
        opened.wait(GOING)
    card.fails = {"cuLaunchKernel": 701}  # what the card refuses, and survives
    with pytest.raises(CardError, match="cuLaunchKernel of Fake 1 fails with CUDA_ERROR_LAUNCH_OUT_OF_RESOURCES"):
        opened.launch(program, "one", 1, 1, 0, bytes(8))


def test_the_first_error_of_the_compiler_is_said(card):
    card.fails["nvrtcCompileProgram"] = 1
    card.log = b"kernels.cu(3): warning: a\nkernels.cu(7): error: b is undefined\nkernels.cu(9): error: c\n"
    with pytest.raises(CardError, match=r"^NVRTC cannot compile this for sm_90: kernels.cu\(7\): error: b is undef"):
        open_driver().build("one")
    assert not [*cache_root().glob("*")]


@pytest.fixture
def compile_for_a_card():
    """NVIDIA's own compiler, which needs no card."""
    nvrtc = pytest.importorskip("cuda.bindings.nvrtc", reason="NVIDIA's compiler is not installed")
    return lambda text: driver.compiled(nvrtc, text, "sm_90")


@pytest.mark.long
def test_the_real_compiler_writes_code_and_says_errors(compile_for_a_card):
    assert compile_for_a_card(TWICE).startswith(b"\x7fELF")
    with pytest.raises(CardError, match=r"kernels.cu\(1\): error"):
        compile_for_a_card(TWICE.replace("values[0]", "value[0]"))


@pytest.mark.long
@pytest.mark.parametrize("kernels", ["trials.cu", "crowds.cu", "alone.cu"])
@pytest.mark.parametrize("brain", ["commons", "three-state"])
def test_the_real_compiler_takes_the_kernels(compile_for_a_card, brain, kernels):
    setting = study_of(brain, link_success=0.8, message="ratio16", precision="single").settings()[0]
    features = features_of(setting, inputs_of(setting, 0, 0))
    assert compile_for_a_card(source(setting.brains, features, kernels, 128)).startswith(b"\x7fELF")
    assert compile_for_a_card(measures()).startswith(b"\x7fELF")
