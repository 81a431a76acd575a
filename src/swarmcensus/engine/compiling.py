"""How a function of the engine becomes machine code."""

import types
from collections.abc import Callable
from typing import Any

from swarmcensus.engine.code_cache import sealed

# Of what machine code alone calls: no way in for CPython or C is made, which takes a fifth of the time of compiling.
# CPython that calls such a function all the same ends without a word.
INSIDE: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


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

    return sealed(numba.njit(nogil=True, error_model="python", cache=True)(function), function)


def loop(from_cpython: bool = False, **options: Any) -> Callable[[types.FunctionType], Any]:
    """Make machine code without the GIL of a loop that makes no array: it counts no references, which takes time.

    Machine code calls it, and so does CPython where it may: `from_cpython`.
    """
    import numba

    return numba.njit(nogil=True, _nrt=False, **options, **({} if from_cpython else INSIDE))  # type: ignore[call-overload, no-any-return]
