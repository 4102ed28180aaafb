"""Whom people bar and unbar: by what the journal shows of claims that are not so."""

from typing import Final

import pytest

from simulation.events import WORLD, Commissioned, Event, FaultBegan, FaultOver, JournalEntry
from simulation.faults.script import ActKind
from simulation.mad_units import MadUnits
from wayside.config import MANAGER_ID
from wayside.said import Accepted, Barred, Contradicted, Freed, Started, Unbarred

PATIENCE_S: Final = 10.0
BEGAN = FaultBegan(kind="false_claims", target="K1", parameters={"section": "7"})
OVER = FaultOver(kind="false_claims", target="K1", parameters={"section": "7"})
AGAINST = Contradicted(unit_id="K1", section_ids=("7",), other_id="K2")
TAKEN = Accepted(unit_id="K1", section_ids=("3", "7"), token=5, was="reported")
TRUE = Accepted(unit_id="K1", section_ids=("3",), token=5, was="reported")
FREED = Freed(unit_id="K1", section_ids=("7",), token=5)
BAR, UNBAR = (ActKind.BAR_UNIT, "K1"), (ActKind.UNBAR_UNIT, "K1")


def after(*events: Event, who: str = MANAGER_ID) -> MadUnits:
    """What people know whom these entries have shown, a second each; K1 stands in 3 and holds no more."""
    units = MadUnits({"K1": 0, "K2": 1}, lambda _slot: ("3",))
    for t_s, event in enumerate(events):
        units.see(
            JournalEntry(float(t_s), WORLD if isinstance(event, FaultBegan | FaultOver) else who, event)
        )
    return units


def due(units: MadUnits, t_s: float) -> list[tuple[ActKind, str]]:
    return list(units.due(t_s, PATIENCE_S))


@pytest.mark.parametrize("wrong", [AGAINST, TAKEN])
def test_what_the_register_has_wrongly_of_a_mad_unit_is_barred_after_a_time(wrong: Event) -> None:
    units = after(BEGAN, wrong)
    assert due(units, 1.0 + PATIENCE_S) == []
    assert due(units, 1.5 + PATIENCE_S) == [BAR]


@pytest.mark.parametrize("heals", [TRUE, FREED, Started(epoch=2)])
def test_not_where_that_has_put_itself_right(heals: Event) -> None:
    assert due(after(BEGAN, AGAINST, heals), 60.0) == []


def test_not_a_unit_whose_claims_are_its_own() -> None:
    assert due(after(AGAINST), 60.0) == []
    assert due(after(BEGAN, TRUE), 60.0) == []


def test_also_when_its_fault_is_over_and_the_register_still_has_it() -> None:
    assert due(after(BEGAN, TAKEN, OVER), 60.0) == [BAR]


def test_not_for_what_it_is_given_after_its_fault_is_over() -> None:
    """Persons have entered that for it; it gives it back itself."""
    assert due(after(BEGAN, OVER, TAKEN), 60.0) == []


def test_unbarred_when_its_fault_has_been_over_for_a_time_and_wherever_it_is_barred() -> None:
    units = after(BEGAN, AGAINST, Barred(unit_id="K1", by="Mori"))
    units.see(JournalEntry(3.0, "B-W", Barred(unit_id="K1", by="Mori")))
    assert due(units, 60.0) == []
    units.see(JournalEntry(60.0, WORLD, OVER))
    assert due(units, 61.0) == []
    assert due(units, 61.5 + PATIENCE_S) == [UNBAR]
    units.see(JournalEntry(80.0, MANAGER_ID, Unbarred(unit_id="K1", by="Mori")))
    assert due(units, 81.0) == [UNBAR], "a terminal that was off has not heard it"
    units.see(JournalEntry(90.0, "B-W", Unbarred(unit_id="K1", by="Mori")))
    assert due(units, 91.0) == []


def test_a_unit_in_order_that_somebody_had_barred_is_unbarred() -> None:
    units = after(Barred(unit_id="K1", by="Mori"), who="B-W")
    assert due(units, 0.0) == []
    assert due(units, 0.5 + PATIENCE_S) == [UNBAR]


def test_a_device_that_is_commissioned_anew_has_forgotten_whom_it_had_barred() -> None:
    units = after(Barred(unit_id="K1", by="Mori"))
    units.see(JournalEntry(1.0, "B-W", Barred(unit_id="K1", by="Mori")))
    units.see(JournalEntry(2.0, WORLD, Commissioned(device_id=MANAGER_ID, number=2)))
    assert [units.is_barred("K1", device) for device in (MANAGER_ID, "B-W")] == [False, True]
    assert not units.is_barred("K2")
    units.see(JournalEntry(3.0, WORLD, Commissioned(device_id="B-W", number=2)))
    assert due(units, 60.0) == due(units, 120.0) == [], "nobody is left to unbar it"
