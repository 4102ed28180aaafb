class Type:
    name: str

class BaseTuple(Type):
    types: tuple[Type, ...]

class BaseNamedTuple(BaseTuple):
    instance_class: type

def unliteral(lit_type: Type) -> Type: ...
