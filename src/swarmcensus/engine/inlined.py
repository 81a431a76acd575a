"""Functions that become machine code only inside the functions that call them, which saves a fifth of compiling.

Numba by itself makes machine code of each function before it becomes part of its callers. It also optimises functions
that are only declared, and one that becomes no part of others again and again: alone, with its parts, and with each
function that calls it. All else is done as Numba does it: code that is optimised less before it becomes part of its
callers is up to a third slower.
"""

import inspect
import operator
import types
from itertools import islice, product
from typing import Any

import numba
from numba.core import cgutils, ir, typed_passes, untyped_passes
from numba.core.codegen import CPUCodegen, JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import register_pass
from numba.core.registry import CPUDispatcher
from numba.cpython import builtins
from numba.extending import intrinsic

# other versions of Numba optimise in another way: they compile as they do by themselves
_ASKED = inspect.signature(CPUCodegen._function_pass_manager).parameters
IS_KNOWN = "llvm_module" not in _ASKED and hasattr(builtins, "do_minmax")

LARGE = 150  # instructions of a function that LLVM makes no part of its callers, unless it has to


class _Library(JITCodeLibrary):
    """What LLVM knows of a function and of those that it calls: they become parts of it now, or large ones later."""

    def __init__(self, *given: Any) -> None:
        """Know nothing yet."""
        super().__init__(*given)
        self.now: dict[Any, None] = {}
        self.later: dict[Any, None] = {}

    def add_linking_library(self, library: Any) -> None:
        """Add a function that this one calls."""
        library._ensure_finalized()
        self._reload_init.update(library._reload_init)
        self.later.update(getattr(library, "later", {}))
        (self.later if getattr(library, "is_large", False) else self.now)[library] = None

    def _optimize_functions(self, ll_module: Any) -> None:
        """Leave all to the passes over the whole: with these alone LLVM takes a seventh less."""
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        """Put together what is not large, and optimise it."""
        _link(self._final_module, self.now)
        super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        """Make machine code of the whole."""
        _link(self._final_module, self.later)
        super()._finalize_final_module()


def _link(module: Any, libraries: dict[Any, None]) -> None:
    for library in reversed(libraries):  # LLVM adds only what is called by what is there
        module.link_in(JITCodeLibrary._get_module_for_linking(library), preserve=True)


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
        """Optimise the function, and see how large it has become."""
        self._optimize_final_module()
        self._finalized = True
        made = [function for function in self._final_module.functions if not function.is_declaration]
        lines = (line for function in made for block in function.blocks for line in block.instructions)
        forced = any(b"alwaysinline" in b" ".join(function.attributes) for function in made)
        self.is_large = not forced and any(islice(lines, LARGE, None))

    def _get_module_for_linking(self) -> Any:
        """The function with large ones that it calls, for code that is not the engine's."""
        module = super()._get_module_for_linking()
        if self.later:
            module = module.clone()
            _link(module, self.later)
        return module

    def get_pointer_to_function(self, name: str) -> int:
        """Null: nobody calls a part by its address."""
        self._ensure_finalized()
        return 0


def _of_several(its: Any, compare: Any) -> Any:
    """`min` or `max` of several numbers as instructions: Numba compiles a function for each kind of numbers."""

    @intrinsic
    def chosen(typing: Any, *numbers: Any) -> Any:
        def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
            return builtins.do_minmax(context, builder, numbers, cgutils.unpack_tuple(builder, values[0]), compare)

        if not all(isinstance(one, (numba.types.Number, numba.types.Boolean)) for one in numbers):
            typing.resolve_function_type(typing.resolve_value_type(its), numbers, {})  # which says that there is none
        return (kind := typing.unify_types(*numbers)) and (kind(numba.types.StarArgTuple(numbers)), generate)

    return chosen


LEAST_AND_MOST = {min: _of_several(min, operator.lt), max: _of_several(max, operator.gt)}


@register_pass(mutates_CFG=False, analysis_only=False)
class _Names(untyped_passes.IRProcessing):  # type: ignore[misc]
    """Put LEAST_AND_MOST in the place of what Numba has, where they are called with several arguments."""

    _name = "names"

    def run_pass(self, state: Any) -> bool:
        blocks = state.func_ir.blocks.values()
        made = {one.target.name: one for block in blocks for one in block.find_insts(ir.Assign)}
        calls = [c for block in blocks for c in block.find_exprs("call") if len(c.args) > 1 and not c.kws]
        for named, (its, own) in product((made[call.func.name] for call in calls), LEAST_AND_MOST.items()):
            # what has a name of its own may be called in other ways, too
            if named.target.is_temp and isinstance(named.value, ir.Global) and named.value.value is its:
                named.value = ir.Global(named.value.name, own, named.loc)
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class _OfArrays(typed_passes.NopythonRewrites):  # type: ignore[misc]
    """Put operations on whole arrays together to one loop, as Numba does, only where there are some."""

    _name = "expressions of arrays"

    def run_pass(self, state: Any) -> bool:
        made = (of for one, of in state.calltypes.items() if getattr(one, "op", "") in ("unary", "binop", "call"))
        is_any = any(of and isinstance(of.return_type, numba.types.Array) for of in made)
        return is_any and bool(super().run_pass(state))


OWN = {untyped_passes.IRProcessing: _Names, typed_passes.NopythonRewrites: _OfArrays}
OF_FUNCTIONS = untyped_passes.InlineClosureLikes, untyped_passes.MakeFunctionToJitFunction  # passes for those inside it


class Whole(Compiler):
    """How Numba compiles a function that is called by CPython or by its address."""

    kind = _Library

    def define_pipelines(self) -> Any:
        """Numba's own steps without those that have nothing to do, for another kind of library."""
        pipelines = super().define_pipelines()
        if IS_KNOWN:
            self.state.library = self.kind(self.state.targetctx.codegen(), "engine")
            self.state.library.enable_object_caching()
            holds_functions = any(isinstance(value, types.CodeType) for value in self.state.func_id.code.co_consts)
            passes = [one for one in pipelines[0].passes if holds_functions or one[0] not in OF_FUNCTIONS]
            pipelines[0].passes = [(OWN.get(one, one), name) for one, name in passes]
            pipelines[0].finalize()
        return pipelines


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
