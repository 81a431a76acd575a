"""How a function of the engine becomes machine code."""

import types
from collections.abc import Callable
from typing import Any

from swarmcensus.engine.keeping import sealed


def compiled(function: types.FunctionType, checked: bool = False) -> Any:
    """Machine code without the GIL that divides as CPython does: by zero is an error, not infinity.

    Where it is `checked`, so is an index beyond a vector's ends, which would be somebody else's memory.
    """
    import numba

    return numba.njit(nogil=True, error_model="python", forceinline=True, boundscheck=checked or None)(function)


def entry(function: types.FunctionType) -> Any:
    """The same, kept on disk: what CPython calls."""
    import numba

    return sealed(numba.njit(nogil=True, error_model="python", cache=True)(function), function)


def loop(**options: Any) -> Callable[[types.FunctionType], Any]:
    """Make machine code without the GIL of a loop that makes no array: it counts no references, which takes time."""
    import numba

    return numba.njit(nogil=True, _nrt=False, **options)  # type: ignore[call-overload, no-any-return]


def not_compiled() -> bool:
    """Whether Numba is switched off, and CPython runs all of the engine."""
    import numba

    return bool(numba.config.DISABLE_JIT)  # type: ignore[attr-defined]
