import importlib
import importlib.util
import re
from pathlib import Path
from types import ModuleType
from typing import get_args

import pytest

from documents.interlocking import TableLine, document, invariant_of, merged_rows, table
from documents.interlocking_defects import CAUGHT, GuardedRule
from documents.interlocking_hazards import HAZARDS
from onboard.authority import machine as authority
from onboard.authority.records import Event as AuthorityEvent
from onboard.duty import machine as duty
from onboard.duty.records import Event as DutyEvent
from radio.table import TableCell, rows
from simulation.judge.checkers import Checker
from study.drilling.drill import shipped_drills

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def defects() -> ModuleType:
    spec = importlib.util.spec_from_file_location("defects", ROOT / "tests/system/test_defects.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:  # dataclasses look their module up there
        patch.setitem(importlib.import_module("sys").modules, "defects", module)
        spec.loader.exec_module(module)
    return module


def test_the_document_is_what_the_code_writes() -> None:
    written = (ROOT / "docs/interlocking.md").read_text(encoding="utf-8")
    assert written == document(), "run `make docs`"


def test_the_document_names_no_place_of_a_machine() -> None:
    assert "/work" not in (ROOT / "docs/interlocking.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("machine", "events"), [(duty, DutyEvent), (authority, AuthorityEvent)])
def test_every_row_of_the_units_tables_says_what_happens(machine: ModuleType, events: object) -> None:
    """And every event that a party can put to the machine is named by one."""
    found = rows(machine.TABLE)
    assert all(re.fullmatch(r"[A-Z].*[.]", row.outcome, re.DOTALL) for row in found)
    assert {row.event for row in found} == {kind.__name__ for kind in get_args(events)}


def test_rows_with_the_same_outcome_are_one_line() -> None:
    rows = (
        TableCell("free", "Go", "f", "x"),
        TableCell("busy", "Go", "g", "y"),
        TableCell("held", "Go", "f", "x"),
    )
    assert merged_rows(rows) == (TableLine(("free", "held"), "Go", "x"), TableLine(("busy",), "Go", "y"))


def test_a_cell_may_have_a_bar() -> None:
    assert table(("a",), [("x | y",)]) == "| a |\n| --- |\n| x \\| y |"


def test_a_module_without_an_invariant_is_refused() -> None:
    with pytest.raises(ValueError, match=r"network\.units"):
        invariant_of("network.units")


def test_hazards_name_what_exists(defects: ModuleType) -> None:
    named = {name for hazard in HAZARDS for name in hazard.drills}
    assert named <= set(shipped_drills())
    assert {name for hazard in HAZARDS for name in hazard.defects} == {d.name for d in defects.DEFECTS}
    for module in {name for hazard in HAZARDS for name in hazard.modules}:
        importlib.import_module(module)


@pytest.mark.parametrize("caught", CAUGHT, ids=[caught.rule for caught in CAUGHT])
def test_a_rule_taken_away_names_its_module_and_a_test_that_exists(caught: GuardedRule) -> None:
    importlib.import_module(caught.module)
    file, _, function = caught.test.partition("::")
    assert f"def {function}(" in (ROOT / "tests" / file).read_text()


def test_every_drill_of_the_papers_line_shows_some_hazard() -> None:
    shown = {name for hazard in HAZARDS for name in hazard.drills}
    assert {name for name in shipped_drills() if name.startswith("rtri/")} <= shown


def test_every_checker_watches_some_hazard() -> None:
    assert {checker for hazard in HAZARDS for checker in hazard.watched_by} == set(Checker)


def test_every_hazard_is_shown_but_that_of_the_carrier() -> None:
    bare = [hazard for hazard in HAZARDS if not (hazard.drills or hazard.defects)]
    assert [hazard.watched_by for hazard in bare] == [(Checker.NO_JUMP,)]
    assert all(re.fullmatch(r"[A-Z].*[^.]", hazard.hazard) for hazard in HAZARDS)
