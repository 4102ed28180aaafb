"""What is compiled when it is called: its caller holds nothing of it and calls it by address."""

import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import numpy as np
import pytest

from network.code_store import CodeStore
from tests.vehicle.test_compiled import compilations
from vehicle import compiled as decorator
from vehicle.record import dtype_of

pytestmark = pytest.mark.skipif(decorator.INTERPRETED, reason="nothing is compiled")

LAWS = """
from vehicle.compiled import compiled, compiled_when_called

GAIN = 2.0


@compiled_when_called
def brisk(own, speeds, share) -> float:
    own.calls += 1
    if share > 1.0:
        raise ValueError("a share above 1")
    return GAIN * speeds[1] * share


@compiled_when_called
def gentle(own) -> int:
    return own.calls + 7


@compiled_when_called
def forget(own) -> None:
    own.calls = 0


@compiled_when_called
def broken(own) -> float:
    return own.nothing


@compiled_when_called
def another_result(own) -> int:
    return 1.5


@compiled
def ask(number, own, speeds, share):
    if number == 0:
        return brisk(own, speeds, share)
    if number == 1:
        return float(gentle(own))
    if number == 2:
        forget(own)
    if number == 3:
        return broken(own)
    if number == 4:
        return float(another_result(own))
    return 0.0
"""


class CallsRow(Protocol):
    calls: int


SPEEDS = np.array([1.0, 3.0])
Load = Callable[..., Any]


@pytest.fixture
def load(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Load:
    """The laws as another process would have them, some of their text replaced."""
    monkeypatch.setattr(decorator, "STORE", CodeStore(tmp_path))

    def loaded(before: str = "", after: str = "") -> Any:  # noqa: ANN401 - a module
        assert before in LAWS
        module = ModuleType("laws_called_late")
        monkeypatch.setitem(sys.modules, module.__name__, module)
        exec(LAWS.replace(before, after), module.__dict__)
        return module

    return loaded


@pytest.fixture
def own() -> CallsRow:
    return np.zeros(1, dtype_of(CallsRow)).view(np.recarray)[0]


def test_a_late_function_gets_its_arguments_and_returns_its_result(load: Load, own: CallsRow) -> None:
    laws = load()
    assert [laws.ask(0, own, SPEEDS, 0.5) for _ in range(2)] == [3.0, 3.0]
    assert own.calls == 2
    assert laws.ask(1, own, SPEEDS, 0.5) == 9.0
    assert laws.ask(2, own, SPEEDS, 0.5) == 0.0
    assert own.calls == 0
    assert laws.brisk(own, SPEEDS, 1.0) == 6.0, "and Python may call it itself"


def test_what_nothing_calls_is_not_compiled(load: Load, own: CallsRow) -> None:
    laws = load()
    laws.ask(1, own, SPEEDS, 0.5)
    names = (laws.ask, laws.brisk, laws.gentle, laws.forget)
    assert [compilations(each) for each in names] == [1, 0, 1, 0]


def test_a_changed_law_is_taken_and_its_caller_stays(load: Load, own: CallsRow) -> None:
    assert load().ask(0, own, SPEEDS, 0.5) == 3.0
    changed = load("GAIN = 2.0", "GAIN = 4.0")
    assert changed.ask(0, own, SPEEDS, 0.5) == 6.0
    assert (compilations(changed.ask), compilations(changed.brisk)) == (0, 1)
    as_before = load()
    assert as_before.ask(0, own, SPEEDS, 0.5) == 3.0
    assert (compilations(as_before.ask), compilations(as_before.brisk)) == (0, 0)


def test_another_annotation_or_late_law_compiles_the_caller(load: Load, own: CallsRow) -> None:
    load().ask(1, own, SPEEDS, 0.5)
    fractions = load(
        "gentle(own) -> int:\n    return own.calls + 7", "gentle(own) -> float:\n    return own.calls + 0.5"
    )
    assert fractions.ask(1, own, SPEEDS, 0.5) == 0.5
    assert compilations(fractions.ask) == 1
    other = load("return float(gentle(own))", "return brisk(own, speeds, share)")
    assert other.ask(1, own, SPEEDS, 0.5) == 3.0


def test_other_types_of_arguments_are_compiled_apart(load: Load, own: CallsRow) -> None:
    laws = load()
    assert laws.ask(0, own, SPEEDS, 0.5) == 3.0
    assert laws.ask(0, own, SPEEDS.astype(np.int64), 1) == 6.0
    assert len(laws.brisk.overloads) == 2


def test_an_exception_of_a_late_function_reaches_python(load: Load, own: CallsRow) -> None:
    laws = load()
    with pytest.raises(ValueError, match="a share above 1"):
        laws.ask(0, own, SPEEDS, 1.5)
    assert laws.ask(0, own, SPEEDS, 0.5) == 3.0


@pytest.mark.parametrize(
    ("number", "name", "why"), [(3, "broken", "nothing"), (4, "another_result", "not as annotated")]
)
def test_what_cannot_be_compiled_is_named(
    load: Load, own: CallsRow, capfd: pytest.CaptureFixture[str], number: int, name: str, why: str
) -> None:
    laws = load()
    with pytest.raises(RuntimeError, match=rf"laws_called_late\.{name} could not be compiled"):
        laws.ask(number, own, SPEEDS, 0.5)
    assert why in capfd.readouterr().err
    assert laws.ask(0, own, SPEEDS, 0.5) == 3.0


def test_a_result_that_no_stub_returns_is_refused(load: Load, own: CallsRow) -> None:
    laws = load("gentle(own) -> int", "gentle(own) -> str")
    with pytest.raises(TypeError, match=r"gentle returns str; .* float, int, None"):
        laws.ask(1, own, SPEEDS, 0.5)
