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
    global_variables: Iterable[ValueRef]
    triple: str

    def link_in(self, other: ModuleRef) -> None: ...

def add_symbol(name: str, address: int | None) -> None: ...
def parse_assembly(llvmir: str) -> ModuleRef: ...
