"""Two thousand damaged inputs: each is taken as it is or refused in one line, and no nonsense is taken.

`pytest -m nightly` tries all; every change a slice. A case is `case_of(number)`, so what fails is found again.
"""

import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Final

import pytest

from network.files.quantities import ALL
from tests.nightly import others_nightly
from tests.system.damaged.attempt import GOOD, faults_of, told
from tests.system.damaged.bundles import GEOMETRY, RANGED, SCENARIO, SWEEP, TIMETABLE
from tests.system.damaged.damages import case_of
from tests.system.damaged.places import places_of

NUMBER: Final = 2000
CHUNK: Final = 10  # cases of a test; the first are the slice of every run
Record = Callable[[str, object], None]


@pytest.fixture(scope="module", autouse=True)
def _warm() -> None:
    """What is compiled and imported once is no work of a case."""
    for bundle in (SCENARIO, GEOMETRY, TIMETABLE, SWEEP):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in bundle.written().items():
                (Path(folder) / name).write_bytes(content)
            assert told(bundle.arguments, Path(folder))[0] == GOOD


def _try(low: int, high: int, tmp_path: Path, record: Record) -> None:
    kinds: Counter[str] = Counter()
    wrong: list[str] = []
    for number in range(low, high):
        folder = tmp_path / str(number)
        folder.mkdir()
        case = case_of(number)
        faults = faults_of(case, folder)
        kinds["inside" if case.inside else "outside" if case.place else "damaged"] += 1
        wrong += [f"case {number}, {case.file}, {case.what}: {fault}" for fault in faults]
    record("figures", f"damaged inputs {low} to {high - 1}: {dict(kinds)}, {len(wrong)} wrong")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("low", others_nightly(range(0, NUMBER, CHUNK), [0]))
def test_damaged_inputs(low: int, tmp_path: Path, record_property: Record) -> None:
    _try(low, low + CHUNK, tmp_path, record_property)


def test_cases_are_the_same_whenever_they_are_drawn() -> None:
    assert [case_of(n).files for n in range(20)] == [case_of(n).files for n in range(20)]


def test_every_quantity_is_drawn() -> None:
    """A quantity whose table no file of the bundle has would never be tried: put it there."""
    found = {
        place.quantity.name
        for bundle in RANGED
        for name, model in bundle.models.items()
        for place in places_of(model, bundle.files[name])  # type: ignore[type-var]
    }
    assert {quantity.name for quantity in ALL} - found == set()
