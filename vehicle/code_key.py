"""What the machine code of a function depends on: its own code and that of all it reaches, constants and records.

Two functions with the same key compile to the same code. The key is made of what is in memory, not of files: of
bytecode and of the values of the names that it reads. A comment, a docstring or a function beside it changes no key;
a constant does in whatever module it stands, also when a test has patched it.
"""

from __future__ import annotations

import dis
import inspect
from collections.abc import Iterator
from enum import Enum
from hashlib import blake2b
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, Final, cast

import numpy as np
from numba.core import types
from numpy.typing import NDArray

LIBRARIES: Final = ("math", "numpy")  # theirs is the compiler's, in its version
# all others numba clears under a profiler
FLAGS: Final = inspect.CO_VARARGS | inspect.CO_VARKEYWORDS | inspect.CO_GENERATOR
PLAIN: Final = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))


class UnknownValueError(TypeError):
    """Compiled code reads a name whose value has no description, so that a change of it would not be noticed."""


def key_of(function: FunctionType, *circumstances: object) -> str:
    """Key (32 hex digits) of the code of a Python function under these circumstances, which are told by their `repr`.

    Raises UnknownValueError.
    """
    digest = blake2b(repr(circumstances).encode(), digest_size=16)
    for text in Reached(function).texts:
        digest.update(b"\0" + text.encode())
    return digest.hexdigest()


class Reached:
    """A function and all that it reaches, numbered in the order in which they are found.

    A call is described by the number of what is called; so functions that call each other have an end.
    """

    def __init__(self, function: FunctionType) -> None:
        self.functions: list[FunctionType] = []
        self.texts: list[str] = []
        self._numbers: dict[FunctionType, int] = {}
        self._number_of(function)

    def _number_of(self, function: FunctionType) -> int:
        if function not in self._numbers:
            self._numbers[function] = len(self.functions)
            self.functions.append(function)
            self.texts.append("")
            self.texts[self._numbers[function]] = self._text(function)
        return self._numbers[function]

    def _text(self, function: FunctionType) -> str:
        """The function, by its bytecode and the names that it reads."""
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        given = (function.__defaults__, function.__kwdefaults__, cells)
        parts = [function.__module__, function.__qualname__, repr([self._value(value) for value in given])]
        parts += [_code_text(code, function.__doc__) for code in _codes(function.__code__)]
        names = dict.fromkeys(name for code in _codes(function.__code__) for name in code.co_names)
        for name in names:
            if name in function.__globals__:
                parts.append(f"{name}={self._global(function, name, names)}")
        return "\n".join(parts)

    def _global(self, function: FunctionType, name: str, names: dict[str, None]) -> str:
        value = function.__globals__[name]
        if isinstance(value, ModuleType):
            library = value.__name__.partition(".")[0] in LIBRARIES
            read = [] if library else [each for each in names if hasattr(value, each)]
            return f"{value.__name__}{[f'{each}={self._value(getattr(value, each))}' for each in read]}"
        try:
            return self._value(value)
        except UnknownValueError as error:
            if any(name in _globals_read(code) for code in _codes(function.__code__)):
                raise UnknownValueError(
                    f"{function.__module__}.{function.__qualname__} reads {name}: {error}"
                ) from None
            return "an attribute of the same name"

    def _value(self, value: Any) -> str:  # noqa: ANN401, PLR0911 - one for each kind that compiled code may read
        """A value, exactly."""
        if isinstance(value, PLAIN) and not isinstance(value, Enum):
            return f"{type(value).__name__} {value!r}"
        by_address = getattr(value, "reached_as", None)
        if by_address is not None:
            return str(by_address)
        function = getattr(value, "py_func", None)  # of what is compiled; other functions it cannot call
        if isinstance(function, FunctionType):
            return f"function {self._number_of(function)}"
        if isinstance(value, (tuple, list)):
            parts = cast("tuple[object, ...]", value)
            return f"{_class_text(type(parts))}[{', '.join(self._value(each) for each in parts)}]"
        if isinstance(value, dict):
            rows = cast("dict[object, object]", value).items()
            return f"{{{', '.join(f'{self._value(key)}: {self._value(each)}' for key, each in rows)}}}"
        if isinstance(value, frozenset):
            return f"frozenset {sorted(self._value(each) for each in cast('frozenset[object]', value))}"
        if isinstance(value, (np.ndarray, np.generic)):
            array = cast("NDArray[Any]", value)
            return f"array {_dtype_text(array.dtype)} {array.shape} {array.tobytes().hex()}"
        if isinstance(value, np.dtype):
            dtype = cast("Any", value)
            return _dtype_text(dtype)
        if isinstance(value, Enum):
            return f"{_class_text(type(value))}.{value.name}"
        if isinstance(value, type):
            return _class_text(value)
        if isinstance(value, (BuiltinFunctionType, np.ufunc)):
            return f"{getattr(value, '__module__', '')}.{value.__name__}"
        raise UnknownValueError(f"compiled code may not depend on a {type(value).__name__}")


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code and that of the functions inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _code_text(code: CodeType, doc: str | None) -> str:
    """Bytecode with its constants and names, without lines and documentation."""
    constants = [_constant_text(each) for each in code.co_consts if doc is None or each != doc]
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    counts = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags & FLAGS)
    return f"{code.co_code.hex()} {constants} {names} {counts}"


def _constant_text(constant: object) -> str:
    if isinstance(constant, CodeType):
        return constant.co_name  # its own text follows
    if isinstance(constant, frozenset):
        # their order is of this process alone
        return repr(sorted(map(repr, cast("frozenset[object]", constant))))
    return repr(constant)


def _globals_read(code: CodeType) -> set[str]:
    return {each.argval for each in dis.get_instructions(code) if each.opname in ("LOAD_GLOBAL", "LOAD_NAME")}


def _class_text(kind: type) -> str:
    """A class by its name, an enumeration and a named tuple with what they hold."""
    held: object = getattr(kind, "_fields", ())
    if issubclass(kind, Enum):
        held = [(each.name, each.value) for each in kind]
    return f"{kind.__module__}.{kind.__qualname__}{held}"


def _dtype_text(dtype: np.dtype[Any]) -> str:
    if dtype.subdtype is not None:
        base, shape = dtype.subdtype
        return f"{shape} of {_dtype_text(base)}"
    if dtype.fields is None:
        return dtype.str
    fields = [f"{name}@{place[1]}: {_dtype_text(place[0])}" for name, place in dtype.fields.items()]
    return f"record {dtype.itemsize} {dtype.alignment} {fields}"


def type_text(kind: types.Type) -> str:
    """An argument's type as the compiler names it, with the fields of named tuples, which it leaves out."""
    if isinstance(kind, types.BaseNamedTuple):
        parts = [type_text(each) for each in kind.types]
        return f"{_class_text(kind.instance_class)}{parts}"
    if isinstance(kind, types.BaseTuple):
        return f"{kind.name}{[type_text(each) for each in kind.types]}"
    return str(kind.name)
