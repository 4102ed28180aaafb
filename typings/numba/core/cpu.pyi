from llvmlite.ir import Function, IRBuilder, Module
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.funcdesc import FunctionDescriptor

class CPUCallConv:
    def return_user_exc(
        self, builder: IRBuilder, exc: type[Exception], exc_args: tuple[object, ...]
    ) -> None: ...

class CPUContext:
    call_conv: CPUCallConv

    def codegen(self) -> JITCPUCodegen: ...
    def declare_function(self, module: Module, fndesc: FunctionDescriptor) -> Function: ...
    def insert_user_function(self, func: object, fndesc: object, libs: list[JITCodeLibrary]) -> None: ...
