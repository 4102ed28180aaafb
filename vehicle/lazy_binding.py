"""Functions that compiled code calls by address: entries of their own, compiled when they are first called.

Driving laws, sensors and readers are many, and a run uses few. Their callers hold a stub in their place, as programs
do for a shared library: it calls the address in a cell of memory; while that is 0, it has Python put the address there.
So what nothing calls is not compiled, and a change of it leaves the code of its callers as it is.
"""

from __future__ import annotations

import ctypes
import traceback
from collections.abc import Callable, Sequence
from hashlib import blake2b
from importlib import import_module
from types import FunctionType
from typing import Final, NamedTuple

import llvmlite.binding as ll
from llvmlite import ir
from numba.core import codegen, funcdesc, types
from numba.core.cpu import CPUContext

from vehicle.code_key import type_text
from vehicle.linking import InnerLibrary
from vehicle.uncompiled import LATE

PREFIX: Final = "branchline.cell."  # of the names of cells in compiled code
BIND: Final = "branchline.bind"
RETURNED: Final[dict[str, types.Type]] = {"float": types.float64, "int": types.int64, "None": types.none}

Types = tuple[types.Type, ...]


class LateFunction:
    """A function called by address: its name, what it returns, and what compiles it for types of arguments.

    TypeError if its annotation names another result than float, int or None.
    """

    def __init__(self, function: FunctionType, address: Callable[[Types], int]) -> None:
        self.name = f"{function.__module__}.{function.__qualname__}"
        self.parameters = function.__code__.co_varnames[: function.__code__.co_argcount]
        self.address = address
        annotation = function.__annotations__.get("return", "nothing that it says")
        returned = getattr(annotation, "__name__", str(annotation))
        if returned not in RETURNED:
            raise TypeError(
                f"{self.name} returns {returned}; called by address it must return {', '.join(RETURNED)}"
            )
        self.returns = RETURNED[returned]


class Cell(NamedTuple):
    """Where the address of a function for some types of arguments stands; 0 before its first call."""

    function: LateFunction
    args: Types
    address: ctypes.c_int64


CELLS: Final[dict[str, Cell]] = {}  # by the name that compiled code has for it


def _cell(name: str, args: Types) -> str:
    """The name of the cell of a function for these arguments; a function that replaces another takes its cell over."""
    text = "".join(type_text(each) for each in args)
    symbol = f"{PREFIX}{name}.{blake2b(text.encode(), digest_size=8).hexdigest()}"
    function: LateFunction = LATE[name].made.late
    if symbol not in CELLS:
        CELLS[symbol] = Cell(function, args, ctypes.c_int64())
        ll.add_symbol(symbol, ctypes.addressof(CELLS[symbol].address))
    elif CELLS[symbol].function is not function:
        CELLS[symbol] = CELLS[symbol]._replace(function=function)
        CELLS[symbol].address.value = 0
    return symbol


def late_calls_in(library: codegen.JITCodeLibrary) -> list[tuple[str, Types]]:
    """Names and arguments of the functions that this code calls by address."""
    names = [each.name for each in library._final_module.global_variables]
    cells = [CELLS[name] for name in names if name.startswith(PREFIX)]
    return [(cell.function.name, cell.args) for cell in cells]


def make_cells(reached: Sequence[tuple[str, Types]]) -> None:
    """Make the cells of code that calls these functions, before it is loaded."""
    for name, args in reached:
        import_module(name.rpartition(".")[0])
        _cell(name, args)


def _bind(place: int) -> None:
    """Put the address of a function into its cell: compile it, or take it from the store."""
    try:
        (cell,) = [each for each in CELLS.values() if ctypes.addressof(each.address) == place]
        cell.address.value = cell.function.address(cell.args)
    except BaseException:
        traceback.print_exc()


_CALLED_BACK: Final = ctypes.PYFUNCTYPE(None, ctypes.c_int64)(_bind)
ll.add_symbol(BIND, ctypes.cast(_CALLED_BACK, ctypes.c_void_p).value)


def stub_for(function: LateFunction, args: Types, target: CPUContext) -> object:
    """A function with this signature that calls what is in the cell; the key under which callers find it."""
    symbol = _cell(function.name, args)
    module_name, _, name = function.name.rpartition(".")
    described = funcdesc.FunctionDescriptor(
        native=True,
        modname=module_name,
        qualname=name,
        unique_name=symbol,
        doc="",
        typemap=None,
        restype=function.returns,
        calltypes=None,
        args=function.parameters,
        kws=(),
        argtypes=args,
        uid="stub",
    )
    library = InnerLibrary(target.codegen(), symbol)
    module = library.create_ir_module(symbol)
    word = ir.IntType(64)
    zero = ir.Constant(word, 0)
    here = target.declare_function(module, described)
    cell = ir.GlobalVariable(module, word, symbol)
    bind = ir.Function(module, ir.FunctionType(ir.VoidType(), [word]), BIND)
    builder = ir.IRBuilder(here.append_basic_block())
    with builder.if_then(builder.icmp_unsigned("==", builder.load(cell), zero), likely=False):
        builder.call(bind, [builder.ptrtoint(cell, word)])
        with builder.if_then(builder.icmp_unsigned("==", builder.load(cell), zero), likely=False):
            why = f"{function.name} could not be compiled: see above"
            target.call_conv.return_user_exc(builder, RuntimeError, (why,))
    there = builder.inttoptr(builder.load(cell), here.type)
    builder.ret(builder.call(there, here.args))
    library.add_ir_module(module)
    library.finalize()
    key = object()
    target.insert_user_function(key, described, [library])
    return key
