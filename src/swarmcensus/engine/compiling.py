"""How a function of the engine becomes machine code."""

import types
from collections.abc import Callable
from typing import Any

from swarmcensus.engine.code_cache import sealed

# Numba makes two more functions around each, for calls from C and from CPython, which takes a fifth of the time of
# compiling. Nothing calls from C. CPython crashes if it calls a function that has no wrapper for it.
NOT_FROM_C: Any = {"no_cfunc_wrapper": True}
INSIDE: Any = NOT_FROM_C | {"no_cpython_wrapper": True}


def compiled(function: types.FunctionType, checked: bool = False) -> Any:
    """Compile a function that machine code calls, without the GIL. As in CPython, division by zero is an error.

    With `checked`, so is an index beyond a vector's ends, which would read or write other memory.
    """
    import numba

    return numba.njit(nogil=True, error_model="python", forceinline=True, boundscheck=checked or None, **INSIDE)(
        function
    )


def entry(function: types.FunctionType) -> Any:
    """Compile a function that CPython calls, without the GIL, and cache it on disk."""
    import numba

    return sealed(numba.njit(nogil=True, error_model="python", cache=True, **NOT_FROM_C)(function), function)


def loop(from_cpython: bool = False, **options: Any) -> Callable[[types.FunctionType], Any]:
    """Compile a function that makes no array, without the GIL: it counts no references, which saves time.

    Machine code calls it, and CPython too if `from_cpython`.
    """
    import numba

    calls = NOT_FROM_C if from_cpython else INSIDE
    return numba.njit(nogil=True, _nrt=False, **options, **calls)  # type: ignore[call-overload, no-any-return]
