"""When doors are shut on a late day: the plan's spare time is for passengers, and for no door that does not close."""

from types import SimpleNamespace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from simulation.late_day import DrawnStay
from simulation.platforms import Platforms, held_until
from simulation.setup import STEPS_PER_S
from simulation.subscribers import Subscribers

TIMES = st.floats(0.0, 600.0)


@given(TIMES, TIMES, TIMES, st.floats(-300.0, 300.0), st.booleans())
def test_doors_are_shut_last_and_never_before_the_train_could_leave(
    people_s: float, doors_s: float, dwell_s: float, early_s: float, begins: bool
) -> None:
    stood_s = 1000.0
    ready_s, boarded_s, until_s = held_until(
        DrawnStay(people_s, doors_s), stood_s, stood_s + early_s, dwell_s, begins=begins
    )
    assert stood_s <= ready_s <= boarded_s <= until_s == boarded_s + doors_s
    assert boarded_s - ready_s <= (0.0 if begins else people_s + 1e-9)
    if not begins and people_s + dwell_s <= early_s:
        assert boarded_s == ready_s  # the plan's stop takes it up


def test_spare_time_takes_up_what_passengers_need_and_not_the_doors() -> None:
    early = held_until(DrawnStay(30.0, 10.0), 1000.0, 1060.0, 20.0, begins=False)
    late = held_until(DrawnStay(30.0, 10.0), 1050.0, 1060.0, 20.0, begins=False)
    assert early == (1060.0, 1060.0, 1070.0)
    assert late == (1070.0, 1100.0, 1110.0)


def test_who_begins_there_has_had_its_passengers_on_before() -> None:
    assert held_until(DrawnStay(30.0, 10.0), 1000.0, 1060.0, 20.0, begins=True) == (1060.0, 1060.0, 1070.0)


def test_who_moves_off_with_doors_that_were_open_is_told_from_whom_they_open_on_as_it_does() -> None:
    """3 s are what it takes from power on until wheels turn."""
    world: Any = SimpleNamespace(
        **dict.fromkeys(("trains", "on_board", "books", "agenda", "journal")),
        setup=SimpleNamespace(unit=SimpleNamespace(dwell_min_s=20.0)),
    )
    cabs: Any = SimpleNamespace(vehicle_shows=lambda *_: None)
    doors = Platforms(world, cabs, SimpleNamespace(stays={}))  # type: ignore[arg-type]
    assert not doors.are_open(0, 0)
    doors.fault(0, 100, closed=False)
    doors.fault(0, 120, closed=False)
    assert [doors.are_open(0, 100 + seconds * STEPS_PER_S) for seconds in (0, 3, 4)] == [False, False, True]
    assert not doors.are_open(1, 200)
    doors.fault(0, 150, closed=True)
    assert not doors.are_open(0, 200)


def test_doors_that_were_open_are_shut_where_a_second_stand_comes_to_nothing() -> None:
    """It came to a stand anew at its stop, and its unit did not know that before the new time was over."""
    shown: list[tuple[int, bool]] = []
    due: list[tuple[int, str]] = []
    target = SimpleNamespace(station_id="A", departure_s=100.0, passengers=True)
    duty = SimpleNamespace(train=SimpleNamespace(number="1"), mission=SimpleNamespace(targets=[None, target]))
    mark = SimpleNamespace(at_mark=True, at=1)
    world: Any = SimpleNamespace(
        trains=SimpleNamespace(duties=[duty], slot_of={"K1": 0}, stock_ids=["K1"]),
        on_board=SimpleNamespace(shown_to_driver=lambda _slot: mark),
        books=SimpleNamespace(stands=Subscribers(), stands_at=lambda _slot: 1),
        agenda=SimpleNamespace(put=lambda step, _kind, subject: due.append((step, subject))),
        journal=SimpleNamespace(write=lambda *_: None),
        setup=SimpleNamespace(unit=SimpleNamespace(dwell_min_s=20.0)),
    )
    cabs: Any = SimpleNamespace(
        answers=lambda _slot: True,
        vehicle_shows=lambda _slot, step, _key, closed: shown.append((step, closed)),
    )
    day: Any = SimpleNamespace(stays={("1", "A"): DrawnStay(0.0, 10.0)})
    doors = Platforms(world, cabs, day)
    world.books.stands(0, 1, 50.0)  # could leave at 100 s; doors are shut at 110 s
    assert due == [(98 * STEPS_PER_S, "open K1")]
    doors.due(*due.pop())
    assert due == [(110 * STEPS_PER_S, "close K1")]
    world.books.stands(0, 1, 99.0)  # a second time: not before 119 s, and shut at 129 s
    mark.at_mark = False
    while due:
        due.sort(reverse=True)
        doors.due(*due.pop())
    assert shown == [(98 * STEPS_PER_S, False), (110 * STEPS_PER_S, True)]
