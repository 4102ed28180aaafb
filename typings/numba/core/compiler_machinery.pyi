from collections.abc import Callable
from typing import Any, TypeVar

from numba.core.compiler import StateDict

PassT = TypeVar("PassT", bound=type[LoweringPass])

class LoweringPass:
    _name: str

    def __init__(self) -> None: ...
    def run_pass(self, state: StateDict) -> bool: ...

class PassManager:
    passes: list[Any]

    def __init__(self, pipeline_name: str) -> None: ...
    def add_pass(self, pss: type[LoweringPass], description: str) -> None: ...
    def finalize(self) -> None: ...

def register_pass(mutates_CFG: bool, analysis_only: bool) -> Callable[[PassT], PassT]: ...
