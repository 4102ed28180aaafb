from numba.core.compiler import Signature

class Type:
    name: str

    def __call__(self, *args: Type) -> Signature: ...

class BaseTuple(Type):
    types: tuple[Type, ...]

class BaseNamedTuple(BaseTuple):
    instance_class: type

def unliteral(lit_type: Type) -> Type: ...

float64: Type
int64: Type
none: Type
