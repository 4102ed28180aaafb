"""Whose fault lateness was, when it was over, and who waits in a ring: small days made by hand."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.files.timetable_schema import HeadTable
from network.model import Direction
from network.timetable import (
    AtPortal,
    BecomesTrain,
    Call,
    Diagram,
    FromTrain,
    Stabled,
    Timetable,
    TimetableTrain,
)
from onboard.notes import PositionFault, Resumed
from radio.noted import Noted
from simulation.events import MANAGER, WORLD, CameLate, DoorsHeld, Entered, PowerOff
from simulation.journal import Journal
from simulation.result import Ending, RunResult, StopRecord, Waiting
from simulation.setup import Setup
from study.measures import delays
from study.measures.day_figures import day_figures
from study.measures.deadlock import deadlocked
from study.measures.delays import LatenessGrowth, delays_of
from study.measures.recovery import LateStretch, joined_stretches, late_stretches, recoveries_s
from vehicle.train_file import load_train, shipped_train
from wayside.said import Granted, Refused

CALLS = (Call("A", None, None, 1000), Call("B", None, 1200, 1230), Call("C", None, 1500, None))
BACK = (Call("C", None, None, 1800), Call("A", None, 2300, None))


STABLED = Stabled()


def timetable(begins: AtPortal | Stabled = STABLED) -> Timetable:
    trains = {
        "1": TimetableTrain("1", Direction.DOWN, True, CALLS, begins, BecomesTrain("2")),
        "2": TimetableTrain("2", Direction.UP, True, BACK, FromTrain("1"), Stabled()),
    }
    return Timetable(HeadTable(id="t", line="l"), trains, (Diagram("K1", ("1", "2")),))


def stop(
    number: str,
    station: str,
    planned: tuple[float | None, float | None],
    real: tuple[float | None, float | None],
) -> StopRecord:
    return StopRecord("K1", number, True, station, "1", *planned, *real)


def result(
    stops: Sequence[StopRecord],
    entries: Sequence[tuple[float, str, Noted]] = (),
    ending: Ending = Ending.FINISHED,
    waiting: Sequence[Waiting] = (),
) -> RunResult:
    journal = Journal()
    for t_s, who, event in entries:
        journal.write(t_s, who, event)
    none: list[object] = []
    return RunResult(
        "t", 1, "simulated", ("K1", "K2", "K3"), 0, 40_000, ("1", "2"), (), (), (), list(stops), [], list(waiting),
        (), (), dict[tuple[str, str, str], Counter[str]](), np.zeros(0), none, journal, ending,
    )  # fmt: skip


@pytest.fixture
def setup() -> Setup:
    line = load_line(shipped_line("rtri_test_line"))
    return Setup("test", line, timetable(), {"K1": load_train(shipped_train("ev_e301"))})


ON_TIME = [
    stop("1", "A", (None, 1000.0), (None, 1000.0)),
    stop("1", "B", (1200.0, 1230.0), (1190.0, 1230.0)),
    stop("1", "C", (1500.0, None), (1490.0, None)),
    stop("2", "C", (None, 1800.0), (None, 1800.0)),
    stop("2", "A", (2300.0, None), (2290.0, None)),
]


def split(found: Sequence[LatenessGrowth]) -> list[tuple[str, str, float, float, float]]:
    return [(d.number, d.station_id, d.primary_s, d.secondary_s, d.other_s) for d in found]


def test_a_day_to_plan_has_no_delays(setup: Setup) -> None:
    assert delays_of(result(ON_TIME), setup) == ()
    assert late_stretches(ON_TIME, setup.timetable) == ()


@pytest.mark.parametrize(("until_s", "waited_s"), [(1260.0, 60.0), (1240.0, 70.0)])
def test_doors_are_primary_and_waiting_secondary(setup: Setup, until_s: float, waited_s: float) -> None:
    """From B 100 s late: 30 s of passengers, refused for K2 after that (no more than is left), then nobody knows."""
    stops = [ON_TIME[0], stop("1", "B", (1200.0, 1230.0), (1190.0, 1330.0)), ON_TIME[2], *ON_TIME[3:]]
    held = DoorsHeld(unit_id="K1", train="1", station="B", until_s=until_s, people_s=30.0, doors_s=0.0)
    entries = [
        (1228.0, WORLD, held),
        (1200.0, MANAGER, Refused(unit_id="K1", other_id="K2", why="HELD")),
        (1320.0, MANAGER, Granted(unit_id="K1", section_ids=("s",), token=1, route_id="r")),
    ]
    assert split(delays_of(result(stops, entries), setup)) == [("1", "B", 30.0, waited_s, 70.0 - waited_s)]
    assert day_figures(result(stops, entries), setup).primary_delays == 0  # of a minute and more
    assert split(delays_of(result(stops, entries[:1]), setup)) == [("1", "B", 30.0, 0.0, 70.0)]
    assert split(delays_of(result(stops), setup)) == [("1", "B", 0.0, 0.0, 100.0)]


def test_a_refusal_before_the_departure_time_is_no_delay(setup: Setup) -> None:
    entries = [
        (1195.0, MANAGER, Refused(unit_id="K1", other_id="K2", why="HELD")),
        (1225.0, MANAGER, Granted(unit_id="K1", section_ids=("s",), token=1, route_id="r")),
    ]
    stops = [ON_TIME[0], stop("1", "B", (1200.0, 1230.0), (1190.0, 1240.0)), *ON_TIME[2:]]
    assert split(delays_of(result(stops, entries), setup)) == [("1", "B", 0.0, 0.0, 10.0)]


def test_lateness_is_counted_where_it_grows_and_once(setup: Setup) -> None:
    """100 s late from A, 80 s at C; the next train of the set leaves 90 s late: 10 s more."""
    stops = [
        stop("1", "A", (None, 1000.0), (None, 1100.0)),
        stop("1", "C", (1500.0, None), (1580.0, None)),
        stop("2", "C", (None, 1800.0), (None, 1890.0)),
        stop("2", "A", (2300.0, None), (2330.0, None)),
    ]
    assert [d.grown_s for d in delays_of(result(stops), setup)] == [100.0, 10.0]


def test_late_entry_is_primary_and_the_queue_outside_secondary(setup: Setup) -> None:
    own = replace(setup, timetable=timetable(AtPortal("P")))
    comes_s = 1000.0 - own.operation.portal_lead_s + 300.0
    stops = [stop("1", "A", (None, 1000.0), (None, 1200.0)), *ON_TIME[1:]]
    entries: list[tuple[float, str, Noted]] = [
        (comes_s, WORLD, CameLate(unit_id="K1", train="1", late_s=120.0)),
        (comes_s - 180.0 + 65.0, WORLD, Entered(unit_id="K1", train="1", edge_ids=("e",))),
    ]
    assert split(delays_of(result(stops, entries), own)) == [("1", "A", 120.0, 60.0, 20.0)]
    # Off before its portal it waits for nobody, and for ever that is its failure alone.
    off = (comes_s - 400.0, WORLD, PowerOff(device_id="K1"))
    assert split(delays_of(result(stops, [off, *entries]), own)) == [("1", "A", 200.0, 0.0, 0.0)]
    (never, *_) = delays_of(result((), [off]), own)
    assert (never.primary_s, never.secondary_s) == (never.grown_s, 0.0) and never.grown_s > 3600.0


def test_midnight_is_a_time_as_any_other(setup: Setup) -> None:
    """Its first departure at midnight, a train comes before it and waits for another; and a call at midnight that is
    cancelled is as late as stated from then.
    """

    def lost(by_s: int) -> list[tuple[float, float, float, float]]:
        calls = (replace(CALLS[0], departure_s=1000 - by_s), Call("B", None, 1200 - by_s, None))
        train = TimetableTrain("1", Direction.DOWN, True, calls, AtPortal("P"), Stabled())
        day = Timetable(HeadTable(id="t", line="l"), {"1": train}, (Diagram("K1", ("1",)),))
        stops = [stop("1", "A", (None, 1000.0 - by_s), (None, 1005.0 - by_s))]
        comes_s = 1000.0 - by_s - setup.operation.portal_lead_s
        entries: list[tuple[float, str, Noted]] = [
            (comes_s, WORLD, Entered(unit_id="K1", train="1", edge_ids=("e",))),
            (990.0 - by_s, MANAGER, Refused(unit_id="K1", other_id="K2", why="HELD")),
            (996.0 - by_s, MANAGER, Granted(unit_id="K1", section_ids=("s",), token=1, route_id="r")),
        ]
        found = delays_of(result(stops, entries), replace(setup, timetable=day))[:1]
        return [(d.at_s + by_s, d.primary_s, d.secondary_s, d.other_s) for d in found]

    assert lost(1000) == lost(0) == [(1005.0, 0.0, 5.0, 0.0)]
    cancelled = replace(stop("1", "B", (0.0, 30.0), (None, None)), stated_late_s=60.0)
    assert next(d.at_s for d in delays_of(result([cancelled]), setup)) == 60.0


def test_what_a_train_loses_on_sight_is_its_failures(setup: Setup) -> None:
    stops = [ON_TIME[0], stop("1", "B", (1200.0, 1230.0), (1500.0, 1521.0)), *ON_TIME[3:]]
    entries: list[tuple[float, str, Noted]] = [
        (1050.0, "K1", PositionFault(why="test")),
        (1490.0, "K1", Resumed(next_target=1)),
    ]
    assert split(delays_of(result(stops, entries), setup))[0] == ("1", "B", 300.0, 0.0, 0.0)
    assert split(delays_of(result(stops), setup))[0] == ("1", "B", 0.0, 0.0, 300.0)


def test_late_until_a_departure_on_time_the_last_stop_or_for_ever(setup: Setup) -> None:
    plan = setup.timetable
    one = [stop("1", "A", (None, 1000.0), (None, 1100.0)), *ON_TIME[1:]]
    assert late_stretches(one, plan) == (LateStretch(1060.0, 1230.0),)
    last = [
        *ON_TIME[:3],
        stop("2", "C", (None, 1800.0), (None, 1900.0)),
        stop("2", "A", (2300.0, None), (2350.0, None)),
    ]
    assert late_stretches(last, plan) == (LateStretch(1860.0, 2350.0),)
    assert late_stretches(last[:4], plan) == (LateStretch(1860.0, 5900.0, over=False),)  # it never comes to A
    never = [*ON_TIME[:3], stop("2", "C", (None, 1800.0), (None, None))]
    assert late_stretches(never, plan) == (LateStretch(1860.0, 5900.0, over=False),)
    assert late_stretches(ON_TIME[:3], plan) == (LateStretch(1860.0, 5900.0, over=False),)
    on_the_way = ON_TIME[:4]  # left to plan, and never came
    assert late_stretches(on_the_way, plan) == (LateStretch(2360.0, 5900.0, over=False),)
    to_b = [ON_TIME[0]]  # left A to plan, and came nowhere: late from 60 s after it should have left B
    assert late_stretches(to_b, plan) == (LateStretch(1290.0, 5900.0, over=False),)
    assert late_stretches(to_b, plan, 1280.0) == ()  # as far as the run has come
    begun = [replace(ON_TIME[0], stated_late_s=60.0), stop("1", "B", (None, 1230.0), (None, 1230.0))]
    assert late_stretches(begun, plan)[-1] == LateStretch(1560.0, 5900.0, over=False)  # by order from B


def test_what_is_cut_grows_to_what_is_stated_once(setup: Setup) -> None:
    """Train 1 comes to B 100 s late and ends there, 600 s late as stated; by order 2 begins at C and stays there."""
    cut = [
        ON_TIME[0],
        stop("1", "B", (1200.0, None), (1300.0, None)),
        replace(stop("1", "B", (None, 1230.0), (None, None)), stated_late_s=600.0),
        replace(stop("1", "C", (1500.0, None), (None, None)), stated_late_s=600.0),
        replace(stop("2", "C", (None, 1800.0), (None, None)), stated_late_s=60.0),
    ]
    ended = replace(result(cut), cut=("1",))
    never_s = 5900.0 - 2300.0 - 100.0  # by which its set was late already
    late = LateStretch(1230.0 + 60.0, 1500.0 + 600.0 + 60.0)
    assert late_stretches(cut, setup.timetable, 1850.0) == (late,)
    assert split(delays_of(ended, setup)) == [
        ("1", "B", 0.0, 0.0, 100.0),
        ("1", "B", 0.0, 500.0, 0.0),
        ("2", "C", 0.0, 60.0, 0.0),
        ("2", "A", never_s, 0.0, 0.0),
    ]
    both = replace(ended, cut=("1", "2"))
    assert split(delays_of(both, setup)) == split(delays_of(ended, setup))[:3]


def test_a_day_that_never_recovers_has_no_recovery_of_none(setup: Setup) -> None:
    """The unit fails before it has left, for ever: nothing arrives, of which the failure is the cause."""
    figures = day_figures(result([], [(900.0, WORLD, PowerOff(device_id="K1"))], Ending.STALLED), setup)
    assert (figures.primary_delays, figures.recovered) == (1, False)
    assert figures.recovery_mean_s == figures.primary_s == 5900.0 - 1200.0
    assert day_figures(result(ON_TIME), setup).recovery_mean_s is None  # and none that took no time
    set_out = delays_of(result(ON_TIME[:4]), setup)  # to plan, and it never came
    assert split(set_out) == [("2", "A", 5900.0 - 2300.0, 0.0, 0.0)]


def test_a_delay_is_over_when_the_stretch_in_which_it_came_is(setup: Setup) -> None:
    stretches = (LateStretch(100.0, 400.0), LateStretch(600.0, 700.0))
    assert recoveries_s([100.0, 650.0, 400.0], stretches) == (300.0, 50.0, 0.0)
    meets = LateStretch(400.0, 500.0, over=False)
    assert joined_stretches((*stretches, meets)) == (LateStretch(100.0, 500.0, over=False), stretches[1])


SPANS = st.lists(st.tuples(st.integers(0, 100), st.integers(0, 30)), max_size=8)


@given(SPANS)
def test_joined_stretches_cover_the_same_moments_once(spans: list[tuple[int, int]]) -> None:
    found = joined_stretches(LateStretch(float(at), float(at + length)) for at, length in spans)
    moments = {at + i for at, length in spans for i in range(length + 1)}
    assert {m for m in range(140) if any(one.from_s <= m <= one.to_s for one in found)} == moments
    assert all(before.to_s < after.from_s for before, after in pairwise(found))


def _ring(*pairs: tuple[str, str], freed: str = "") -> RunResult:
    entries: list[tuple[float, str, Noted]] = [
        (1.0, MANAGER, Refused(unit_id=unit, other_id=other, why="HELD")) for unit, other in pairs
    ]
    if freed:
        entries.append((2.0, MANAGER, Granted(unit_id=freed, section_ids=("s",), token=1, route_id="r")))
    waiting = [Waiting(unit, f"train of {unit}", "here", "route") for unit, _ in pairs]
    return result([], entries, Ending.STALLED, waiting)


def test_a_ring_of_trains_that_wait_for_one_another_is_a_deadlock() -> None:
    ring = ("train of K1", "train of K2", "train of K3")
    assert deadlocked(_ring(("K1", "K2"), ("K2", "K3"), ("K3", "K1"))) == ring
    assert deadlocked(_ring(("K1", "K2"), ("K2", "K3"))) == ()
    assert deadlocked(_ring(("K1", "K2"), ("K2", "K1"), freed="K2")) == ()
    assert deadlocked(_ring(("K3", "K1"), ("K1", "K2"), ("K2", "K1"))) == ring[:2]


def test_of_faults_at_once_each_second_counts_once() -> None:
    assert delays._overlap_s([(-5, 5), (0, 10), (2, 4), (25, 40)], 0.0, 30.0) == 15.0
