"""The stub of libsumo names what the installed package has: a name that is not there would pass every type check."""

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path

import libsumo
import pytest

STUB = Path(__file__).resolve().parents[2] / "typings" / "libsumo" / "__init__.pyi"


def functions() -> Iterator[tuple[str, ast.FunctionDef]]:
    for node in ast.parse(STUB.read_text("utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node
        elif isinstance(node, ast.ClassDef):
            for part in node.body:
                if isinstance(part, ast.FunctionDef):
                    yield f"{node.name}.{part.name}", part


def real(path: str) -> object:
    found: object = libsumo
    for name in path.split("."):
        found = getattr(found, name)
    return found


@pytest.mark.parametrize(("path", "stub"), list(functions()), ids=[path for path, _ in functions()])
def test_each_function_takes_these_parameters(path: str, stub: ast.FunctionDef) -> None:
    function = real(path)
    assert callable(function)
    if path.startswith("_libsumo."):
        return  # compiled, and without a signature
    taken = list(inspect.signature(function).parameters)
    stated = [argument.arg for argument in stub.args.args]
    # Overloaded functions of the wrapper say only *args: their names cannot be compared.
    assert taken[0] == "args" if "args" in taken else taken[: len(stated)] == stated


def test_a_collision_has_these_fields() -> None:
    (stub,) = (
        node
        for node in ast.parse(STUB.read_text("utf-8")).body
        if isinstance(node, ast.ClassDef) and node.name == "TraCICollision"
    )
    fields = [part.target.id for part in stub.body if isinstance(part, ast.AnnAssign)]  # type: ignore[union-attr]
    assert fields
    assert all(hasattr(libsumo.TraCICollision, name) for name in fields)
