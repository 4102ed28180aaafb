from collections.abc import Sequence

from numba.core.compiler import Signature

def make_concrete_template(name: str, key: object, signatures: Sequence[Signature]) -> type: ...
