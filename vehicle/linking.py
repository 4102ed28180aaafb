"""How numba compiles here: a function that Python calls, with all that it calls, once and as one piece.

numba optimises every function and makes machine code of it, then does so again inside each of its callers. Here a
function that compiled code calls is typed and written as LLVM's intermediate code alone; only an entry, a function
that Python calls, is optimised and made into machine code, with the code of all that it reaches linked in. A function
may be both. This file, `vehicle.lazy_binding` and `vehicle.entries` are all that rests on what numba does not document;
`tests/vehicle/test_linking.py` says on what, and fails on another numba.
"""

from __future__ import annotations

import llvmlite.binding as ll
from numba.core import codegen, compiler, typed_passes
from numba.core.compiler_machinery import LoweringPass, PassManager, register_pass

from vehicle.code_key import key_of
from vehicle.compiling import note_linked


class InnerLibrary(codegen.JITCodeLibrary):
    """The intermediate code of one function, which entries link in; never optimised, never made into machine code."""

    def _optimize_functions(self, ll_module: ll.ModuleRef) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        """Nothing is to be done before an entry links it in."""
        self._finalized = True

    def _get_module_for_linking(self) -> ll.ModuleRef:
        return self._final_module


class EntryLibrary(codegen.JITCodeLibrary):
    """An entry and all that it reaches, which no other entry sees."""

    def finalize(self) -> None:
        """Link everything in, callers before what they call, then optimise and make machine code."""
        note_linked()
        self._linking_libraries = _reached(self._linking_libraries)
        super().finalize()

    def _optimize_final_module(self) -> None:
        inner = {
            function.name
            for library in self._linking_libraries
            if isinstance(library, InnerLibrary)
            for function in library._final_module.functions
            if not function.is_declaration and function.linkage is ll.Linkage.external
        }
        for function in self._final_module.functions:
            if function.name in inner:
                function.linkage = "internal"
        super()._optimize_final_module()

    def _get_module_for_linking(self) -> ll.ModuleRef:
        """The names of what it has alone: nobody links an entry."""
        empty = ll.parse_assembly(f'target triple = "{self._final_module.triple}"')
        names = [function.name for function in self.get_defined_functions()]
        lines = [f'define void @"{name}"() {{\n  unreachable\n}}' for name in names]
        empty.link_in(ll.parse_assembly("\n".join(lines)))
        return empty


def _reached(libraries: list[codegen.JITCodeLibrary]) -> list[codegen.JITCodeLibrary]:
    """These libraries and all that inner ones among them link, each once."""
    found: dict[codegen.JITCodeLibrary, None] = {}
    left = list(reversed(libraries))
    while left:
        library = left.pop()
        if library in found:
            continue
        found[library] = None
        if isinstance(library, InnerLibrary):
            left.extend(reversed(library._linking_libraries))
    return sorted(found, key=lambda library: not isinstance(library, InnerLibrary))


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerInner(LoweringPass):
    """Write a function as intermediate code that others can link in."""

    _name = "lower_inner"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: compiler.StateDict) -> bool:
        """Lower as numba does, into a library of our own."""
        state.library = InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = state.flags.no_cpython_wrapper = state.flags.no_cfunc_wrapper = True
        typed_passes.NativeLowering().run_pass(state)
        key = object()  # callers find the function under it, where numba has the address of its machine code
        state.targetctx.insert_user_function(key, state["cr"].fndesc, [state.library])
        state["cr"] = state["cr"]._replace(cfunc=key)
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerEntry(LoweringPass):
    """Write an entry as intermediate code, then make machine code of it and all that it reaches."""

    _name = "lower_entry"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: compiler.StateDict) -> bool:
        """Lower as numba does, into a library of our own; other code of the same name has another key."""
        state.func_id.unique_id = key_of(state.func_id.func)
        state.library = EntryLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.no_cfunc_wrapper = True
        return bool(typed_passes.NativeLowering().run_pass(state))


def _pipeline(state: compiler.StateDict, lower: type[LoweringPass]) -> list[PassManager]:
    """numba's own passes, the last of them changed; notes for people on types are left out."""
    build = compiler.DefaultPassBuilder
    passes = PassManager(lower._name)
    passes.passes.extend(build.define_untyped_pipeline(state).passes)
    passes.passes.extend(build.define_typed_pipeline(state).passes)
    passes.add_pass(typed_passes.NoPythonSupportedFeatureValidation, "only what can be compiled")
    passes.add_pass(typed_passes.IRLegalization, "legal before it is lowered")
    passes.add_pass(lower, "lower")
    passes.add_pass(typed_passes.NoPythonBackend, "result")
    passes.finalize()
    return [passes]


class InnerCompiler(compiler.CompilerBase):
    """Compiles for linking."""

    def define_pipelines(self) -> list[PassManager]:
        """The passes."""
        return _pipeline(self.state, LowerInner)


class EntryCompiler(compiler.CompilerBase):
    """Compiles for calls from Python."""

    def define_pipelines(self) -> list[PassManager]:
        """The passes."""
        return _pipeline(self.state, LowerEntry)
