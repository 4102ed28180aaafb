"""Lamps and barriers of a level crossing: their times by hand, what sticks, what their contacts show."""

import dataclasses

import pytest
from msgspec.structs import replace

from network.model import CrossingClass, CrossingControl, LevelCrossing
from radio.table import rows
from simulation.carriers.road_shown import CrossingShown
from simulation.events import BarrierState
from simulation.faults.crossings import CrossingCondition
from simulation.world.crossing_equipment import (
    TABLE,
    BarrierTimeOver,
    ConditionChanged,
    CrossingEquipment,
    EquipmentEvent,
    ObstacleDetected,
    detection,
    equipment_of,
    shown,
    step,
)
from wayside.crossing_said import CloseCrossing, CrossingDetected, OpenCrossing

LINE = LevelCrossing(
    "C", "C", CrossingClass.BARRIERS, CrossingControl.RADIO, "6", 700.0, 6.0, 8.0, 15.0, 20.0
)
CLOSE, OPENS, OVER = CloseCrossing("C"), OpenCrossing("C"), BarrierTimeOver()
RAISED, LOWERING, LOWERED, RISING = BarrierState
STUCK = ConditionChanged(CrossingCondition(stuck=True))
MENDED = ConditionChanged(CrossingCondition())


def after(*happened: tuple[float, EquipmentEvent]) -> CrossingEquipment:
    equipment = equipment_of(LINE)
    for at_s, event in happened:
        equipment = step(equipment, event, at_s)
    return equipment


def test_every_state_takes_every_event() -> None:
    events = (CloseCrossing, OpenCrossing, BarrierTimeOver, ConditionChanged, ObstacleDetected)
    assert set(TABLE) == {(state, event) for state in BarrierState for event in events}
    assert len(rows(TABLE)) == len(TABLE)


def test_barriers_are_down_when_the_line_says_so() -> None:
    """Lamps at once, 7 s of them alone, 8 s of lowering."""
    begun = after((100.0, CLOSE))
    assert (begun.lit, begun.barriers, begun.due_s) == (True, LOWERING, 115.0)
    assert after((100.0, CLOSE), (114.9, OVER)).barriers is LOWERING
    down = after((100.0, CLOSE), (115.0, OVER))
    assert (down.barriers, down.due_s) == (LOWERED, None)
    rising = after((100.0, CLOSE), (115.0, OVER), (130.0, OPENS))
    assert (rising.lit, rising.barriers, rising.due_s) == (False, RISING, 138.0)


def test_closed_anew_while_they_rise_it_takes_no_less() -> None:
    again = after((100.0, CLOSE), (115.0, OVER), (130.0, OPENS), (132.0, CLOSE))
    assert (again.barriers, again.due_s) == (LOWERING, 147.0)


@pytest.mark.parametrize(
    ("happened", "barriers", "due_s"),
    [
        ([(90.0, STUCK), (100.0, CLOSE)], RAISED, None),
        ([(100.0, CLOSE), (110.0, STUCK), (115.0, OVER)], LOWERING, None),
        ([(100.0, CLOSE), (110.0, STUCK), (120.0, MENDED)], LOWERING, 135.0),
        ([(100.0, CLOSE), (115.0, OVER), (116.0, STUCK), (130.0, OPENS)], LOWERED, None),
        ([(100.0, CLOSE), (115.0, OVER), (116.0, STUCK), (130.0, OPENS), (140.0, MENDED)], RISING, 148.0),
    ],
)
def test_what_sticks_stays_where_it_is_until_it_is_mended(
    happened: list[tuple[float, EquipmentEvent]], barriers: BarrierState, due_s: float | None
) -> None:
    found = after(*happened)
    assert (found.barriers, found.due_s) == (barriers, due_s)


DOWN = [(100.0, CLOSE), (115.0, OVER), (116.0, STUCK), (130.0, OPENS)]


@pytest.mark.parametrize(
    ("happened", "lit", "barriers", "due_s"),
    [
        ([*DOWN, (200.0, CLOSE)], True, LOWERED, None),
        ([*DOWN, (200.0, CLOSE), (240.0, MENDED)], True, LOWERED, None),
        (
            [(100.0, CLOSE), (110.0, STUCK), (120.0, OPENS), (200.0, CLOSE), (240.0, MENDED)],
            True,
            LOWERING,
            255.0,
        ),
        ([(90.0, STUCK), (100.0, CLOSE), (130.0, OPENS), (240.0, MENDED)], False, RAISED, None),
    ],
)
def test_what_sticks_is_commanded_all_the_same(
    happened: list[tuple[float, EquipmentEvent]], lit: bool, barriers: BarrierState, due_s: float | None
) -> None:
    """The next train's warning shines though they never rose; mended, they go where the last command has them."""
    found = after(*happened)
    assert (found.lit, found.barriers, found.due_s) == (lit, barriers, due_s)


def test_contacts_show_what_is_so_or_nothing() -> None:
    down = after((100.0, CLOSE), (115.0, OVER))
    assert detection(down) == CrossingDetected(lamps=True, lowered=True, raised=False)
    assert detection(equipment_of(LINE)) == CrossingDetected(lamps=False, lowered=False, raised=True)
    dark = step(down, ConditionChanged(CrossingCondition(lamps_dead=True)), 116.0)
    assert detection(dark) == CrossingDetected(lamps=False, lowered=True, raised=False)
    blocked = step(down, ObstacleDetected(present=True), 116.0)
    assert detection(blocked) == CrossingDetected(lamps=True, lowered=True, raised=False, obstacle=True)
    assert detection(step(blocked, ObstacleDetected(present=False), 117.0)) == detection(down)
    blind = step(down, ConditionChanged(CrossingCondition(detection_fault=True)), 116.0)
    assert detection(blind) == CrossingDetected(lamps=False, lowered=False, raised=False)


def test_without_barriers_lamps_are_all() -> None:
    lamps = equipment_of(dataclasses.replace(LINE, kind=CrossingClass.WARNING, closing_s=0.0, closed_s=30.0))
    lit = step(lamps, CLOSE, 100.0)
    assert (lit.lit, lit.barriers, lit.due_s) == (True, LOWERED, None)
    assert step(lit, OPENS, 130.0).barriers is RAISED


def test_drivers_see_lamps_and_barriers() -> None:
    """The class alone decides whether there are barriers to be seen."""
    assert shown(after((100.0, CLOSE))) == CrossingShown(LOWERING, lamps=True)
    assert shown(after((100.0, CLOSE), (115.0, OVER))) == CrossingShown(LOWERED, lamps=True)
    lamps = equipment_of(dataclasses.replace(LINE, kind=CrossingClass.WARNING, closing_s=0.0, closed_s=30.0))
    assert shown(step(lamps, CLOSE, 100.0)) == CrossingShown(RAISED, lamps=True)


@pytest.mark.parametrize(
    ("condition", "stands", "shown"),
    [
        (CrossingCondition(), False, False),
        (CrossingCondition(), True, True),
        (CrossingCondition(detector_blind=True), True, False),
        (CrossingCondition(detector_occupied=True), False, True),
    ],
)
def test_what_a_detector_shows_of_a_closed_road(
    condition: CrossingCondition, stands: bool, shown: bool
) -> None:
    down = replace(equipment_of(LINE), barriers=BarrierState.LOWERED, closes=True, has_detector=True)
    now = step(step(down, ObstacleDetected(stands), 0.0), ConditionChanged(condition), 1.0)
    assert detection(now).obstacle is shown


def test_a_detector_that_has_failed_says_nothing_of_an_open_road_nor_where_there_is_none() -> None:
    occupied = CrossingCondition(detector_occupied=True)
    up = replace(equipment_of(LINE), has_detector=True, condition=occupied)
    assert not detection(up).obstacle
    assert not detection(replace(up, barriers=BarrierState.LOWERED, has_detector=False)).obstacle


@pytest.mark.parametrize("barriers", list(BarrierState))
def test_a_button_is_there_whatever_the_barriers_do_and_their_contacts_show(barriers: BarrierState) -> None:
    pressed = CrossingCondition(button=True, detection_fault=True)
    assert detection(replace(equipment_of(LINE), barriers=barriers, condition=pressed)).button
    assert not detection(replace(equipment_of(LINE), barriers=barriers)).button
