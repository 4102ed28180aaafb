"""What of numba `vehicle.linking` rests on, and what it is for: inner functions make no machine code of their own."""

import inspect
from importlib import import_module

import numba
import pytest
from numba.core import registry

from vehicle.compiled import INTERPRETED, compiled

# What numba does not document, where it defines it, and its parameters. typings/numba has the same.
RESTS_ON = (
    ("codegen", "CPUCodeLibrary", "_optimize_functions", ("self", "ll_module")),
    ("codegen", "CPUCodeLibrary", "_optimize_final_module", ("self",)),
    ("codegen", "CPUCodeLibrary", "_get_module_for_linking", ("self",)),
    ("codegen", "CPUCodeLibrary", "finalize", ("self",)),
    ("codegen", "JITCPUCodegen", "magic_tuple", ("self",)),
    ("codegen", "JITCPUCodegen", "set_env", ("self", "env_name", "env")),
    ("compiler", "CompileResult", "_reduce", ("self",)),
    ("compiler", "CompileResult", "_find_referenced_environments", ("self",)),
    ("compiler", "DefaultPassBuilder", "define_untyped_pipeline", ("state", "name")),
    ("compiler", "DefaultPassBuilder", "define_typed_pipeline", ("state", "name")),
    ("typed_passes", "NativeLowering", "run_pass", ("self", "state")),
    ("cpu", "CPUContext", "insert_user_function", ("self", "func", "fndesc", "libs")),
    ("cpu", "CPUContext", "declare_function", ("self", "module", "fndesc")),
    (
        "callconv",
        "CPUCallConv",
        "return_user_exc",
        ("self", "builder", "exc", "exc_args", "loc", "func_name"),
    ),
    ("runtime.nrt", "rtsys", "initialize", ("ctx",)),
    ("codegen", "JITCodeLibrary", "get_pointer_to_function", ("self", "name")),
    ("codegen", "CodeLibrary", "create_ir_module", ("self", "name")),
    ("codegen", "CPUCodeLibrary", "add_ir_module", ("self", "ir_module")),
    ("caching", "Cache", "load_overload", ("self", "sig", "target_context")),
    ("caching", "Cache", "save_overload", ("self", "sig", "data")),
    ("dispatcher", "Dispatcher", "add_overload", ("self", "cres")),
    ("dispatcher", "Dispatcher", "get_call_template", ("self", "args", "kws")),
    ("dispatcher", "Dispatcher", "get_overload", ("self", "sig")),
    ("dispatcher", "Dispatcher", "fold_argument_types", ("self", "args", "kws")),
)
LIBRARY_HAS = ("_linking_libraries", "_final_module", "_finalized", "_codegen")


def test_numba_is_the_one_that_linking_was_written_for() -> None:
    assert numba.__version__.startswith("0.68."), (
        f"numba {numba.__version__}: read vehicle/linking.py beside its compiler, codegen and dispatcher; "
        "then name this version here and in pyproject.toml"
    )


@pytest.mark.parametrize(("module", "owner", "name", "parameters"), RESTS_ON)
def test_numba_has_what_linking_rests_on(
    module: str, owner: str, name: str, parameters: tuple[str, ...]
) -> None:
    found = getattr(getattr(import_module(f"numba.core.{module}"), owner, None), name, None)
    assert callable(found), f"numba {numba.__version__} has no {owner}.{name}"
    assert tuple(inspect.signature(found).parameters) == parameters


def test_numbas_libraries_have_the_fields_that_linking_reads() -> None:
    library = registry.cpu_target.target_context.codegen().create_library("fields")
    assert [name for name in LIBRARY_HAS if not hasattr(library, name)] == []


@compiled
def inside(x: float) -> float:
    return x * 3.0 + 1.0 if x > 0.0 else inside_too(x)


@compiled
def inside_too(x: float) -> float:
    if x < -100.0:
        raise ValueError("too far out")
    return x - 7.5


@compiled
def outside(x: float) -> float:
    return inside(x) + inside_too(x)


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_an_entry_holds_what_it_calls_and_only_entries_are_machine_code() -> None:
    assert outside(2.0) == 7.0 - 5.5
    assert outside(-2.0) == 2 * -9.5
    defined = registry.cpu_target.target_context.codegen()._engine._defined_symbols
    here = {name for name in defined if "test_linking" in name and "NumbaEnv" not in name}
    assert any("outside" in name for name in here)
    assert not any("inside" in name for name in here)


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_an_exception_of_an_inner_function_reaches_python() -> None:
    with pytest.raises(ValueError, match="too far out"):
        outside(-200.0)


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")
def test_a_function_is_entry_and_inner_function_at_once() -> None:
    assert outside(2.0) == inside(2.0) + inside_too(2.0)
