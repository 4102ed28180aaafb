"""What is compiled is kept and found again, and a change of anything that it depends on is taken."""

import fcntl
import sys
from collections.abc import Callable
from cProfile import Profile
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import numpy as np
import pytest
from numba.core import config, registry

from network.code_store import KEPT, CodeStore
from vehicle import compiled as decorator
from vehicle import compiling, entries
from vehicle.code_key import UnknownValueError, key_of
from vehicle.compiling import Compilation
from vehicle.entries import Entry

pytestmark = pytest.mark.skipif(decorator.INTERPRETED, reason="nothing is compiled")

LAW = '''"""A law."""

from typing import NamedTuple

import limits
import numpy as np

from vehicle.compiled import compiled

OFFSET = 10.0
SHAPE = (1.0, 2.0)
TABLE = np.array([1.0, 2.0])
SPOT = np.dtype([("near", "f8"), ("far", "f8")])


class Pair(NamedTuple):
    first: float
    second: float


@compiled
def inner(x):
    """Inside."""
    return x * limits.FACTOR + OFFSET + SHAPE[1] * TABLE[1]


@compiled
def other(x):
    return x - 1.0


@compiled
def reads_pair(pair):
    return pair.first - pair.second


@compiled
def writes_spot(x):
    spots = np.zeros(2, SPOT)
    spots[0].far = x
    return spots.view(np.float64)[1]


@compiled
def outer(x):
    return inner(x) - 1.0


@compiled
def last(x):
    return inner(x) - 2.0
'''

Load = Callable[..., Any]


@pytest.fixture
def load(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Load:
    """The law as another process would have it, some of its text or the factor in the other module replaced."""
    monkeypatch.setattr(decorator, "STORE", CodeStore(tmp_path / "code"))

    def loaded(before: str = "", after: str = "", factor: float = 2.0) -> Any:  # noqa: ANN401 - a module
        assert before in LAW
        limits: Any = ModuleType("limits")
        limits.FACTOR = factor
        law = ModuleType("law")
        monkeypatch.setitem(sys.modules, "limits", limits)
        monkeypatch.setitem(sys.modules, "law", law)
        exec(LAW.replace(before, after), law.__dict__)
        return law

    return loaded


def compilations(function: Entry) -> int:
    return sum(function.stats.cache_misses.values())


def test_what_was_compiled_is_found_again(load: Load) -> None:
    first, again = load().outer, load().outer
    assert (first(3.0), compilations(first)) == (19.0, 1)
    assert (again(3.0), compilations(again)) == (19.0, 0)


def test_a_profiled_run_finds_it_too(load: Load) -> None:
    first, profiled = load(), load()
    first.inner(3.0)
    first.outer(3.0)
    with Profile():
        profiled.inner(3.0)
        assert (profiled.outer(3.0), compilations(profiled.outer)) == (19.0, 0)


@pytest.mark.parametrize(
    ("before", "after", "factor", "value"),
    [
        pytest.param("OFFSET = 10.0", "OFFSET = 11.0", 2.0, 20.0, id="constant"),
        pytest.param("", "", 3.0, 22.0, id="constant of another module"),
        pytest.param("(1.0, 2.0)", "(1.0, 4.0)", 2.0, 23.0, id="tuple"),
        pytest.param("[1.0, 2.0]", "[1.0, 5.0]", 2.0, 25.0, id="array"),
        pytest.param("x * limits", "x / limits", 2.0, 14.5, id="inner function"),
        pytest.param("inner(x) - 1.0", "other(x) - 1.0", 2.0, 1.0, id="another is called"),
    ],
)
def test_a_change_of_what_it_reaches_is_taken(
    load: Load, before: str, after: str, factor: float, value: float
) -> None:
    assert load().outer(3.0) == 19.0
    changed = load(before, after, factor).outer
    assert (changed(3.0), compilations(changed)) == (value, 1)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        pytest.param('"""Inside."""', '"""Within."""', id="docstring"),
        pytest.param('"""A law."""\n', '"""A law."""\n\n# of a kind\n', id="lines"),
        pytest.param("return x - 1.0", "return x - 2.0", id="a function beside it"),
    ],
)
def test_a_change_of_what_it_does_not_reach_compiles_nothing(load: Load, before: str, after: str) -> None:
    assert load().outer(3.0) == 19.0
    same = load(before, after).outer
    assert (same(3.0), compilations(same)) == (19.0, 0)


def test_the_order_of_a_named_tuple_is_taken(load: Load) -> None:
    law = load()
    assert law.reads_pair(law.Pair(first=5.0, second=2.0)) == 3.0
    swapped = load("first: float\n    second: float", "second: float\n    first: float")
    assert swapped.reads_pair(swapped.Pair(first=5.0, second=2.0)) == 3.0
    assert compilations(swapped.reads_pair) == 1


def test_the_layout_of_a_record_is_taken(load: Load) -> None:
    assert load().writes_spot(4.0) == 4.0, "far is the second number"
    swapped = load('("near", "f8"), ("far", "f8")', '("far", "f8"), ("near", "f8")')
    assert swapped.writes_spot(4.0) == 0.0, "near is"
    rows = [
        np.zeros(1, np.dtype([(name, "f8") for name in names])).view(np.recarray)[0] for names in ("ab", "ba")
    ]
    rows[0].a = rows[1].a = 4.0
    read = load("return x - 1.0", "return x.a").other
    assert [read(row) for row in rows] == [4.0, 4.0]
    assert compilations(read) == 2


def test_a_constant_patched_while_it_runs_is_taken(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was compiled inside one entry is not put into the next with its old constant, and not kept as such."""
    law = load()
    assert law.outer(3.0) == 19.0
    monkeypatch.setattr(law, "OFFSET", 110.0)
    assert law.last(3.0) == 118.0
    assert load().last(3.0) == 18.0
    assert load("OFFSET = 10.0", "OFFSET = 110.0").last(3.0) == 118.0


DAMAGED: Final[dict[str, Callable[[bytes, bytes], bytes]]] = {
    "cut short": lambda data, _: data[:-1],
    "a bit": lambda data, _: data[:99] + bytes([data[99] ^ 1]) + data[100:],
    "another's": lambda _, other: other,
    "empty": lambda _, __: b"",
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_damaged_or_foreign_file_is_as_good_as_none(load: Load, damage: str) -> None:
    law = load()
    law.outer(3.0)
    law.last(3.0)
    (file,) = decorator.STORE.folder.glob("law.outer-*")
    (other,) = decorator.STORE.folder.glob("law.last-*")
    file.write_bytes(DAMAGED[damage](file.read_bytes(), other.read_bytes()))
    again = load().outer
    assert (again(3.0), compilations(again)) == (19.0, 1)
    repaired = load().outer
    assert (repaired(3.0), compilations(repaired)) == (19.0, 0)


def test_a_folder_that_cannot_be_written_costs_only_time(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    (decorator.STORE.folder.parent / "code").write_text("a file where the folder should be")
    for _ in range(2):
        outer = load().outer
        assert (outer(3.0), compilations(outer)) == (19.0, 1)


@pytest.fixture
def ship(load: Load, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Compile the law for a processor into a folder as a wheel brings it, and then have another one."""

    def shipped(processor: str) -> Path:
        codegen = registry.cpu_target.target_context.codegen()
        triple, *_ = codegen.magic_tuple()
        with monkeypatch.context() as there:
            there.setattr(codegen, "magic_tuple", lambda: (triple, processor, ""))
            assert load().outer(3.0) == 19.0
        brought = decorator.STORE.folder.rename(tmp_path / "brought")
        monkeypatch.setattr(decorator, "STORE", CodeStore(tmp_path / "mine", [brought]))
        return brought

    return shipped


def test_code_for_any_processor_serves_on_this_one(load: Load, ship: Callable[[str], Path]) -> None:
    (file,) = ship("generic").glob("law.outer-*")
    was = file.stat().st_mtime_ns
    here = load().outer
    assert (here(3.0), compilations(here)) == (19.0, 0)
    assert file.stat().st_mtime_ns == was, "what a wheel brings is only read"
    assert not decorator.STORE.folder.exists()
    changed = load("OFFSET = 10.0", "OFFSET = 11.0").outer
    assert (changed(3.0), compilations(changed)) == (20.0, 1)


FOREIGN: Final[dict[str, Callable[[Path, pytest.MonkeyPatch], object]]] = {
    "compiler": lambda _, patch: patch.setattr(entries, "COMPILER", ("0.68.2", *entries.COMPILER[1:])),
    "optimiser": lambda _, patch: patch.setattr(config, "OPT", 1),
    "damaged": lambda file, _: file.write_bytes(file.read_bytes()[:-1]),
}


@pytest.mark.parametrize("foreign", FOREIGN)
def test_what_was_compiled_from_or_by_something_else_is_compiled_anew(
    load: Load, ship: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch, foreign: str
) -> None:
    (file,) = ship("generic").glob("law.outer-*")
    FOREIGN[foreign](file, monkeypatch)
    here = load().outer
    assert (here(3.0), compilations(here)) == (19.0, 1)


def test_code_for_another_processor_is_not_taken(load: Load, ship: Callable[[str], Path]) -> None:
    ship("znver9")
    here = load().outer
    assert (here(3.0), compilations(here)) == (19.0, 1)


def test_whoever_shows_it_is_told_what_is_compiled(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    pieces: list[Compilation] = []
    monkeypatch.setattr(compiling, "WATCHERS", [pieces.append])
    load().outer(3.0)
    assert pieces == [
        Compilation("law.outer", 2, 0, linked=False),
        Compilation("law.outer", 2, 1, linked=False),
        Compilation("law.outer", 2, 1, linked=True),
    ]
    pieces.clear()
    load().outer(3.0)
    assert pieces == []


def test_what_another_process_makes_meanwhile_is_not_made_again(
    load: Load, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    waits, others = load().outer, load().outer

    def made_meanwhile(*_: object) -> None:
        monkeypatch.setattr(fcntl, "flock", lambda *_: None)
        others(3.0)

    with CodeStore(tmp_path / "code").alone("law.outer"), (tmp_path / "code/law.outer.lock").open() as file:
        with pytest.raises(BlockingIOError):
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        monkeypatch.setattr(fcntl, "flock", made_meanwhile)
        waits(3.0)
    assert (compilations(waits), compilations(others)) == (0, 1)


def test_few_pieces_of_a_name_are_kept(tmp_path: Path) -> None:
    store = CodeStore(tmp_path)
    keys = [f"{number:032x}" for number in range(KEPT + 3)]
    for key in keys:
        store.write("law", key, b"code")
    store.write("law.inner", keys[0], b"code")
    assert len(list(tmp_path.glob("law-*"))) == KEPT
    assert store.read("law.inner", keys[0]) == b"code"


@pytest.mark.parametrize("state", ["object()", "lambda: 1"])
def test_code_that_reads_what_has_no_description_is_refused_by_name(state: str) -> None:
    names: dict[str, Any] = {"__name__": "law"}
    exec(f"STATE = {state}\ndef law(x):\n    return STATE\ndef field(x):\n    return x.STATE\n", names)
    with pytest.raises(UnknownValueError, match=r"law\.law reads STATE"):
        key_of(names["law"])
    assert key_of(names["field"])  # it reads a field of that name
