from typing import Any, NamedTuple, Self

from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler_machinery import PassManager
from numba.core.cpu import CPUContext
from numba.core.environment import Environment
from numba.core.funcdesc import FunctionDescriptor
from numba.core.types import Type

class Flags:
    no_cfunc_wrapper: bool
    no_compile: bool
    no_cpython_wrapper: bool

class FunctionIdentity:
    func: Any
    func_qualname: str
    unique_id: object

class Lowered(NamedTuple):
    fndesc: object
    cfunc: object

class StateDict(dict[str, Any]):
    flags: Flags
    func_id: FunctionIdentity
    library: JITCodeLibrary
    targetctx: CPUContext

class CompilerBase:
    state: StateDict

    def define_pipelines(self) -> list[PassManager]: ...

class DefaultPassBuilder:
    @staticmethod
    def define_untyped_pipeline(state: StateDict) -> PassManager: ...
    @staticmethod
    def define_typed_pipeline(state: StateDict) -> PassManager: ...

class Signature:
    args: tuple[Type, ...]
    return_type: Type

class CompileResult:
    codegen: JITCPUCodegen
    fndesc: FunctionDescriptor
    library: JITCodeLibrary
    signature: Signature

    @classmethod
    def _rebuild(cls, target_context: CPUContext, *reduced: object) -> Self: ...
    def _find_referenced_environments(self) -> list[Environment]: ...
    def _reduce(self) -> tuple[object, ...]: ...
