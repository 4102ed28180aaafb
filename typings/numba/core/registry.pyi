from collections import Counter
from collections.abc import Mapping
from types import FunctionType
from typing import Any, NamedTuple

from numba.core.compiler import CompilerBase, CompileResult
from numba.core.cpu import CPUContext
from numba.core.types import Type

class Stats(NamedTuple):
    cache_path: str
    cache_hits: Counter[object]
    cache_misses: Counter[object]

class CPUTarget:
    target_context: CPUContext

cpu_target: CPUTarget

class CPUDispatcher:
    _cache: Any
    overloads: dict[tuple[Type, ...], CompileResult]
    py_func: Any
    stats: Stats
    targetctx: CPUContext
    targetoptions: dict[str, object]

    def __init__(
        self,
        py_func: FunctionType,
        locals: dict[str, Any],  # noqa: A002 - numba's name
        targetoptions: Mapping[str, object],
        pipeline_class: type[CompilerBase],
    ) -> None: ...
    def add_overload(self, cres: CompileResult) -> None: ...
    def compile(self, sig: tuple[Type, ...]) -> object: ...
    def fold_argument_types(
        self, args: tuple[Type, ...], kws: dict[str, Type]
    ) -> tuple[object, tuple[Type, ...]]: ...
    def get_call_template(self, args: tuple[Type, ...], kws: dict[str, Type]) -> object: ...
    def get_overload(self, sig: tuple[Type, ...]) -> object: ...
