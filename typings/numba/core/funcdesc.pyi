from collections.abc import Sequence

from numba.core.types import Type

class FunctionDescriptor:
    llvm_func_name: str

    def __init__(
        self,
        native: bool,
        modname: str,
        qualname: str,
        unique_name: str,
        doc: str,
        typemap: None,
        restype: Type,
        calltypes: None,
        args: Sequence[str],
        kws: Sequence[str],
        argtypes: tuple[Type, ...],
        uid: object,
    ) -> None: ...
