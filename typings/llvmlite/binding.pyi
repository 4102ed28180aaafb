from collections.abc import Iterable
from enum import Enum

class Linkage(Enum):
    external = 0
    internal = 7

class ValueRef:
    is_declaration: bool
    linkage: Linkage | str
    name: str

class ModuleRef:
    data_layout: str
    functions: Iterable[ValueRef]
    triple: str

    def link_in(self, other: ModuleRef) -> None: ...

def parse_assembly(llvmir: str) -> ModuleRef: ...
