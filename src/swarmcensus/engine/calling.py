"""How the engine's loops, compiled once on a machine, call functions that are compiled for each brain.

A brain's functions are called by address. Arrays are passed as the addresses of their first items: so a call costs a
few nanoseconds, and the loops need not know the type of a state. With Numba switched off, the same code passes
CPython's functions and arrays.
"""

import contextlib
import ctypes
import itertools
import struct
import threading
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.compiler_lock import global_compiler_lock
from numba.extending import intrinsic
from numba.np.arrayobj import np_cfarray

from swarmcensus.engine.code_cache import not_compiled
from swarmcensus.engine.compiling import INSIDE, counting_nothing, whole

ARRAY, REAL, WHOLE = types.voidptr, types.float64, types.uint64
_COUNTING = threading.Lock()
NOT_COMPILED = "a function is called that was not compiled for this use"


def passed_as(kind):
    """The type that an argument of this Numba type is passed as: an address, a whole number or a real one."""
    if isinstance(kind, types.Array):
        if kind.layout != "C":
            raise TypeError(f"{kind} is not contiguous, so that its address alone does not describe it")
        return ARRAY
    if kind == ARRAY:
        return ARRAY
    return REAL if isinstance(kind, types.Float) else WHOLE


@intrinsic
def _machine_call(typing, function, *arguments):
    targets = [passed_as(kind) for kind in arguments]

    def generate(context, builder, signature, values):
        given = []
        for kind, target, value in zip(arguments, targets, cgutils.unpack_tuple(builder, values[1]), strict=True):
            if isinstance(kind, types.Array):
                data = context.make_array(kind)(context, builder, value).data
                given.append(builder.bitcast(data, cgutils.voidptr_t))
            else:
                given.append(context.cast(builder, value, kind, target))
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, values[0])):
            context.call_conv.return_user_exc(builder, SystemError, (NOT_COMPILED,))
        shape = context.call_conv.get_function_type(types.void, targets)
        callee = builder.inttoptr(values[0], shape.as_pointer())
        status, _ = context.call_conv.call_function(builder, callee, types.void, targets, given)
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return context.get_dummy_value()

    return types.void(types.uint64, types.StarArgTuple(arguments)), generate


@intrinsic
def _machine_blank(typing, dtype):
    record = dtype.dtype

    def generate(context, builder, signature, values):
        kind = ir.ArrayType(ir.IntType(8), record.size)
        place = cgutils.alloca_once(builder, kind)
        builder.store(ir.Constant(kind, None), place)
        return builder.bitcast(place, context.get_value_type(record))

    return record(dtype), generate


@intrinsic
def _machine_place(typing, items, first):
    passed_as(items)

    def generate(context, builder, signature, values):
        data = context.make_array(items)(context, builder, values[0]).data
        place = builder.gep(data, [context.cast(builder, values[1], first, types.intp)])
        return builder.bitcast(place, cgutils.voidptr_t)

    return ARRAY(items, first), generate


@intrinsic
def _machine_view(typing, items, shape, dtype):
    dimensions = len(shape) if isinstance(shape, types.BaseTuple) else 1
    return types.Array(dtype.dtype, dimensions, "C")(items, shape, dtype), np_cfarray


@intrinsic
def _machine_gate(typing, address):
    def generate(context, builder, signature, values):
        builder.call(builder.inttoptr(values[0], ir.FunctionType(ir.VoidType(), []).as_pointer()), [])
        return context.get_dummy_value()

    return types.void(address), generate


@intrinsic
def _machine_count_up(typing, address):
    def generate(context, builder, signature, values):
        place = builder.inttoptr(values[0], ir.IntType(64).as_pointer())
        builder.atomic_rmw("add", place, ir.Constant(ir.IntType(64), 1), "seq_cst")
        return context.get_dummy_value()

    return types.void(address), generate


@intrinsic
def _machine_counted(typing, address):
    def generate(context, builder, signature, values):
        return builder.load_atomic(builder.inttoptr(values[0], ir.IntType(64).as_pointer()), "seq_cst", 8)

    return types.int64(address), generate


def _plain_count_up(address):
    with _COUNTING:
        ctypes.c_int64.from_address(int(address)).value += 1


@intrinsic
def _machine_packed(typing, group, kind):
    if group != kind.instance_type:
        raise TypeError(f"{group} is not the {kind.instance_type} that machine code expects")

    def generate(context, builder, signature, values):
        place = cgutils.alloca_once(builder, context.get_value_type(group))
        builder.store(values[0], place)
        return builder.bitcast(place, cgutils.voidptr_t)

    return ARRAY(group, kind), generate


@intrinsic
def _machine_unpacked(typing, place, kind):
    def generate(context, builder, signature, values):
        shape = context.get_value_type(kind.instance_type).as_pointer()
        is_number = isinstance(place, types.Integer)  # from CPython
        return builder.load((builder.inttoptr if is_number else builder.bitcast)(values[0], shape))

    return kind.instance_type(place, kind), generate


@intrinsic
def _machine_word(typing, words, place):
    def generate(context, builder, signature, values):
        first = builder.bitcast(values[0], ir.IntType(64).as_pointer())
        return builder.load(builder.gep(first, [context.cast(builder, values[1], place, types.intp)]))

    return types.uint64(words, place), generate


def _plain_view(items, shape, dtype):
    size = np.prod(shape, dtype=int) * np.dtype(dtype).itemsize // items.itemsize  # the rest belongs to other robots
    view = items.reshape(-1)[:size].view(dtype)
    return view.reshape(shape) if isinstance(shape, tuple) else view


# call(function, *arguments) calls by address; place(items, first) passes an array from an item on, without making a
# view; seen_as(items, shape, dtype) makes what was passed an array again; word_at(words, k) reads one uint64 of it,
# without making an array; packed(group, kind) passes a NamedTuple of this Numba type, and unpacked(place, kind) makes
# it one again, in functions that count no references; pass_gate(address) calls a function of C without arguments;
# count_up(address) adds one to an int64 that several threads see, and counted(address) reads it; blank_state(record) is
# a state of zeros on the stack, which the compiler keeps in registers
PLAIN = not_compiled()
call = (lambda function, *arguments: function(*arguments)) if PLAIN else _machine_call
seen_as = _plain_view if PLAIN else _machine_view
blank_state = (lambda dtype: np.zeros(1, dtype)[0]) if PLAIN else _machine_blank
place = (lambda items, first: items.reshape(-1)[int(first) :]) if PLAIN else _machine_place
word_at = (lambda words, k: np.frombuffer(words, np.uint64, 1, 8 * int(k))[0]) if PLAIN else _machine_word
packed = (lambda group, kind: group) if PLAIN else _machine_packed
unpacked = (lambda group, kind: group) if PLAIN else _machine_unpacked
pass_gate = (lambda address: ctypes.CFUNCTYPE(None)(int(address))()) if PLAIN else _machine_gate
count_up = _plain_count_up if PLAIN else _machine_count_up
counted = (lambda address: ctypes.c_int64.from_address(int(address)).value) if PLAIN else _machine_counted


@contextlib.contextmanager
def _one_at_a_time() -> Iterator[None]:
    """Switch off the vectorisation of loops: code handles one robot after the other.

    States lie in rows, and gathering a field of four of them takes longer than all that a brain then does with it.
    """
    usual = numba.config.LOOP_VECTORIZE
    numba.config.LOOP_VECTORIZE = 0
    try:
        yield
    finally:
        numba.config.LOOP_VECTORIZE = usual


def _laid_out(given: Any) -> Iterator[tuple[Any, str, tuple[Any, ...]]]:
    """Numbers and arrays, in groups, as machine code has them: of each its kind, formats of `struct`, and values."""
    if isinstance(given, tuple):
        for one in given:
            yield from _laid_out(one)
        yield (), "0q", ()
    elif isinstance(given, np.ndarray):
        array = 0, 0, given.size, given.itemsize, given.ctypes.data, *given.shape, *given.strides
        yield (given.dtype, given.ndim, given.flags.c_contiguous), f"{len(array)}q", array
    else:
        yield (kind := np.asarray(given).dtype.char), kind, (given,)


class Phase(NamedTuple):
    """A function that is called by its address, and the types of its arguments; or one that CPython calls."""

    function: Any
    takes: tuple[Any, ...]
    several: bool  # whether loops may handle several robots at once
    kinds: tuple[Any, ...] = ()  # of what CPython calls it with

    def __call__(self, *given: Any) -> Any:
        """Put what is given where machine code finds it, and call it with that address."""
        if PLAIN:
            return self.function(given)
        kinds, formats, values = zip(*_laid_out(given), strict=True)
        if kinds != self.kinds:
            raise TypeError(f"machine code is called with {kinds} in place of {self.kinds}")
        there = struct.pack("".join(formats), *itertools.chain(*values))
        return self.function(np.frombuffer(there, np.uint8).ctypes.data)

    def address(self) -> Any:
        """The address of its machine code, compiled or loaded now; the function itself if Numba is switched off."""
        if not hasattr(self.function, "compile"):
            return self.function
        # other threads compile loops as usual
        with global_compiler_lock, contextlib.nullcontext() if self.several else _one_at_a_time():
            self.function.compile(self.takes)
        made = self.function.overloads[self.takes]
        return made.library.get_pointer_to_function(made.fndesc.llvm_func_name)


def unpacking(*like: Any) -> Callable[[Any], Phase]:
    """Make a function that unpacks groups like these a Phase that CPython calls; it makes no array, and returns none.

    Numba's own code for arrays in groups, which CPython passes, takes half a second to compile.
    """
    kinds = tuple(kind for kind, *_ in _laid_out(like))
    return lambda function: Phase(counting_nothing(function), (types.int64,), several=True, kinds=kinds)


def phase(*takes: Any) -> Callable[[Any], Phase]:
    """Make a function a Phase, cached on disk. As in CPython, division by zero is an error."""

    def made(function: Any) -> Phase:
        return Phase(whole(function, **INSIDE), takes, several=False)

    return made


def apart(*takes: Any, unpacks: bool = False) -> Callable[[Any], Phase]:
    """Make a function of the engine a Phase: it is compiled once a machine, and only where it is needed.

    One that `unpacks` groups counts no references, and so cannot make arrays of addresses.
    """

    def made(function: Any) -> Phase:
        return Phase(whole(function, **{"_nrt": False} if unpacks else {}, **INSIDE), takes, several=True)

    return made
