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
    """Machine code for machine code, without the GIL, that divides as CPython does: by zero is an error, not infinity.

    Where it is `checked`, so is an index beyond a vector's ends, which would be somebody else's memory.
    """
    import numba

    return numba.njit(nogil=True, error_model="python", forceinline=True, boundscheck=checked or None, **INSIDE)(
        function
    )


def entry(function: types.FunctionType) -> Any:
    """The same, kept on disk: what CPython calls."""
    import numba

    return sealed(numba.njit(nogil=True, error_model="python", cache=True, **NOT_FROM_C)(function), function)


def loop(from_cpython: bool = False, **options: Any) -> Callable[[types.FunctionType], Any]:
    """Make machine code without the GIL of a loop that makes no array: it counts no references, which takes time.

    Machine code calls it, and so does CPython where it may: `from_cpython`.
    """
    import numba

    calls = NOT_FROM_C if from_cpython else INSIDE
    return numba.njit(nogil=True, _nrt=False, **options, **calls)  # type: ignore[call-overload, no-any-return]
