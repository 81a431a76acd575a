"""How a function of the engine becomes machine code."""

import types
from collections.abc import Callable
from typing import Any

from swarmcensus.engine.code_cache import not_compiled, sealed

# Numba makes two more functions around each, for calls from C and from CPython, which takes a fifth of the time of
# compiling. Nothing calls from C. CPython crashes if it calls a function that has no wrapper for it.
NOT_FROM_C: Any = {"no_cfunc_wrapper": True}
INSIDE: Any = NOT_FROM_C | {"no_cpython_wrapper": True}


def compiled(function: types.FunctionType, checked: bool = False) -> Any:
    """Compile a function that machine code calls, without the GIL. As in CPython, division by zero is an error.

    With `checked`, so is an index beyond a vector's ends, which would read or write other memory.
    """
    return inside(error_model="python", forceinline=True, boundscheck=checked or None)(function)


def entry(function: types.FunctionType) -> Any:
    """Compile a function that CPython calls, without the GIL, and cache it on disk."""
    return whole(function, **NOT_FROM_C)


def counting_nothing(function: types.FunctionType) -> Any:
    """Compile an entry that makes no array and returns none: it counts no references, which saves time."""
    return whole(function, _nrt=False, **NOT_FROM_C)


def whole(function: types.FunctionType, **options: Any) -> Any:
    """Compile a function that CPython calls, or machine code by its address, without the GIL; it is kept on disk."""
    import numba

    from swarmcensus.engine.inlined import Whole

    machine = numba.njit(nogil=True, error_model="python", cache=True, pipeline_class=Whole, **options)
    return sealed(machine(function), function)


def loop(from_cpython: bool = False, **options: Any) -> Callable[[types.FunctionType], Any]:
    """Compile a function that makes no array, without the GIL: it counts no references, which saves time.

    Machine code calls it, and CPython too if `from_cpython`.
    """
    return inside(from_cpython, _nrt=False, **options)


def inside(from_cpython: bool = False, **options: Any) -> Callable[[types.FunctionType], Any]:
    """Compile a function only as a part of those that call it, without the GIL; CPython calls it if `from_cpython`."""
    import numba

    from swarmcensus.engine.inlined import AlsoFromCpython, Inside

    def made(function: types.FunctionType) -> Any:
        if not_compiled():
            return function
        if from_cpython:
            return AlsoFromCpython(function, {"nopython": True, "nogil": True, **options, **NOT_FROM_C})
        return numba.njit(nogil=True, pipeline_class=Inside, **options, **INSIDE)(function)

    return made
