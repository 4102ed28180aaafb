"""What is taken with a figure at the end of its range can be run: it ends, with a code that means something."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

import pytest

from study.outcome import Outcome
from tests.nightly import others_nightly
from tests.system.damaged import attempt
from tests.system.damaged.attempt import GOOD, put, told
from tests.system.damaged.bundles import SCENARIO
from tests.system.damaged.damages import Case, case_of

SLICE: Final = (0,)
NUMBER: Final = 50
LOOKED_AT: Final = 1500
CPU_S_MAX: Final = 120.0  # of a run, a hundred times what one of this line takes


@pytest.fixture(scope="module")
def at_an_end() -> Callable[[int], Case]:
    """The first case of each kind of quantity that lies just inside its range, by number, as they are asked for."""
    found: dict[str, Case] = {}
    cases = map(case_of, range(LOOKED_AT))

    def of(index: int) -> Case:
        while len(found) <= index:
            case = next(cases)
            if case.inside and case.place is not None:
                found.setdefault(case.place.quantity.name, case)
        return list(found.values())[index]

    return of


@pytest.mark.parametrize("index", others_nightly(range(NUMBER), SLICE))
def test_it_runs(
    index: int, at_an_end: Callable[[int], Case], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = at_an_end(index)
    put(case, tmp_path)
    if told(SCENARIO.arguments, tmp_path)[0] != GOOD:
        return  # two figures say together what this one does not: `test_ranges` has those
    monkeypatch.setattr(attempt, "CPU_S_MAX", CPU_S_MAX)
    code, out, err = told(("run", "s.toml", "--out", "run", "--json"), tmp_path)
    assert code in (GOOD, Outcome.BROKEN.code), (case.number, case.what, code, err)
    assert out.count("\n") == 1
    assert (tmp_path / "run" / "summary.json").is_file()
