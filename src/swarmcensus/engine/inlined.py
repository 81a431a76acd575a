"""Functions that become machine code only inside the functions that call them, which saves a fifth of compiling.

Numba by itself makes machine code of each function before it becomes part of its callers. It also optimises functions
that are only declared, and one that becomes no part of others twice: alone, and then with its parts. All else is done
as Numba does it: code that is optimised less before it becomes part of its callers is up to a third slower.
"""

import inspect
import types
from typing import Any

import numba
from numba.core.codegen import CPUCodegen, JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher

# older versions of Numba optimise in another way: they compile as they do by themselves
IS_KNOWN = "llvm_module" not in inspect.signature(CPUCodegen._function_pass_manager).parameters


class _Library(JITCodeLibrary):
    """What LLVM knows of a function and of those that it calls."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Leave all to the passes over the whole: with these alone LLVM takes a seventh less."""
        ll_module.data_layout = self._codegen._data_layout


class _Part(_Library):
    """The same, not loaded."""

    codegen = types.SimpleNamespace(set_env=lambda *_: None)  # Numba's environment is for calls of CPython

    def _optimize_functions(self, ll_module: Any) -> None:
        """Optimise what is not only declared."""
        super()._optimize_functions(ll_module)
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager()
                passes.run(function, builder)

    def finalize(self) -> None:
        """Put together what callers need, and optimise it."""
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._optimize_final_module()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Null: nobody calls a part by its address."""
        self._ensure_finalized()
        return 0


class Whole(Compiler):
    """How Numba compiles a function that is called by CPython or by its address."""

    kind = _Library

    def define_pipelines(self) -> Any:
        """Numba's own steps, for another kind of library."""
        if IS_KNOWN:
            self.state.library = self.kind(self.state.targetctx.codegen(), "engine")
            self.state.library.enable_object_caching()
        return super().define_pipelines()


class Inside(Whole):
    """How Numba compiles a function that machine code calls."""

    kind = _Part


class AlsoFromCpython(CPUDispatcher):
    """A function that machine code calls, and CPython too: for those calls it is compiled apart."""

    def __init__(self, function: types.FunctionType, options: dict[str, Any]) -> None:
        """Compile nothing yet."""
        super().__init__(function, targetoptions=options, pipeline_class=Inside)
        self._apart = numba.jit(**options)(function)

    def __call__(self, *given: Any) -> Any:
        """Call the one that has a wrapper for it."""
        return self._apart(*given)
