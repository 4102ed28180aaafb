"""A day in a few figures: against the plan, and what never came, or never ran, is not on time."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.files.timetable_schema import HeadTable
from network.model import Direction
from network.timetable import Call, Diagram, Stabled, Timetable, TimetableTrain
from simulation.result import StopRecord
from study.measures import day_figures
from study.measures.day_figures import figures_of_stops
from study.sweep.figures import FIGURES


def stop(number: str, station: str, planned_s: float | None, arrival_s: float | None) -> StopRecord:
    return StopRecord("K1", number, True, station, "1", planned_s, None, arrival_s=arrival_s)


def plan(trains: dict[str, list[tuple[str, int | None, int | None]]]) -> Timetable:
    """Trains by their calls: station, arrival and departure."""
    made = {
        number: TimetableTrain(
            number,
            Direction.DOWN,
            True,
            tuple(Call(at, None, a, d) for at, a, d in calls),
            Stabled(),
            Stabled(),
        )
        for number, calls in trains.items()
    }
    return Timetable(HeadTable(id="t", line="l"), made, (Diagram("K1", tuple(made)),))


THREE = plan(
    {
        "1": [("A", None, 0), ("B", 100, 110), ("C", 200, None)],
        "2": [("C", 50, 60), ("B", 100, 110), ("A", 300, None)],
        "3": [("A", None, 400), ("B", 500, None)],
    }
)


ONE: list[tuple[str, int | None, int | None]] = [("A", None, 0), ("B", 100, 110), ("C", 200, None)]
OF_CROSSINGS = ("closed_road_min", "least_warned_s")  # of the journal, tests/system/test_crossings.py
END_S = 500.0 + 3600.0  # an hour after the last planned time


def test_lateness_punctuality_and_what_is_missing() -> None:
    figures = figures_of_stops(
        [
            stop("1", "A", None, None),
            stop("1", "B", 100.0, 130.0),
            stop("1", "C", 200.0, 400.0),
            stop("2", "C", 50.0, None),
            stop("2", "B", 100.0, 90.0),
        ],
        THREE,
    )
    assert (figures.planned_trains, figures.arrived_trains, figures.missing) == (3, 1, ("2", "3"))
    assert (figures.planned_arrivals, figures.arrivals) == (5, 3)
    assert figures.within == (0.4, 0.4, 0.6)
    never_s = (END_S - 300.0, END_S - 500.0)  # 2 at A, 3 at B
    assert figures.mean_late_s == pytest.approx((30 + 200 - 10 + sum(never_s)) / 5, abs=1e-3)
    assert figures.mean_delay_s == pytest.approx((30 + 200 + sum(never_s)) / 5, abs=1e-3)
    assert (figures.median_late_s, figures.worst_late_s) == (200.0, never_s[0])
    assert (figures.worst_train, figures.worst_station) == ("2", "A")
    assert figures.lost_train_minutes == pytest.approx((200 + sum(never_s)) / 60, abs=1e-3)


def test_a_day_without_trains() -> None:
    figures = figures_of_stops([], plan({}))
    assert (figures.planned_trains, figures.within, figures.mean_late_s) == (0, (0.0, 0.0, 0.0), None)


def test_a_day_on_which_nothing_ran_is_not_punctual() -> None:
    figures = figures_of_stops([], THREE)
    assert (figures.planned_arrivals, figures.arrivals, figures.within) == (5, 0, (0.0, 0.0, 0.0))
    assert figures.missing == ("1", "2", "3")
    assert figures.mean_late_s == pytest.approx(END_S - (100 + 200 + 100 + 300 + 500) / 5)


@given(st.data())
def test_no_figure_is_better_for_arrivals_that_do_not_come(data: st.DataObject) -> None:
    """However late they were, and whichever of them are left out."""
    late_s = st.one_of(st.floats(-200, 20_000), st.none())
    stops = [
        stop(number, call.station_id, float(call.arrival_s), None if late is None else call.arrival_s + late)
        for number, train in THREE.trains.items()
        for call in train.calls
        if call.arrival_s is not None
        for late in [data.draw(late_s)]
    ]
    fewer = [one for one in stops if data.draw(st.booleans())]
    before, after = figures_of_stops(stops, THREE), figures_of_stops(fewer, THREE)
    for name, figure in FIGURES.items():
        if name in OF_CROSSINGS or name == "recovery_mean_s":  # of stops alone no delay is known
            continue
        was, is_now = figure.of(before), figure.of(after)
        assert was is not None and is_now is not None, name
        assert is_now <= was if figure.more_is_better else is_now >= was, name


def test_lateness_of_what_came_alone_is_better_for_trains_that_do_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The rule switched off: who never came counts as if he had come by the last planned time."""
    monkeypatch.setattr(day_figures, "latest_end_s", lambda timetable: 500.0)
    late = [stop(n, at, due_s, due_s + 900.0) for n, at, due_s in (("1", "B", 100.0), ("3", "B", 500.0))]
    assert figures_of_stops([], THREE).mean_late_s == (400 + 300 + 400 + 200 + 0) / 5
    assert figures_of_stops(late, THREE, END_S).mean_late_s > 5 * figures_of_stops([], THREE).mean_late_s


def test_of_a_part_of_a_day_what_is_due_by_its_end_is_planned() -> None:
    """At 250 s train 1 has come to C 20 s late, 2 stands beyond its time at B; 2 at A and 3 are not due."""
    stops = [stop("1", "B", 100.0, 130.0), stop("1", "C", 200.0, 220.0), stop("2", "C", 50.0, None)]
    figures = figures_of_stops(stops, THREE, 250.0)
    assert (figures.planned_trains, figures.arrived_trains, figures.missing) == (1, 1, ())
    assert (figures.planned_arrivals, figures.arrivals) == (3, 2)
    assert figures.mean_late_s == pytest.approx((30 + 20 + (250 - 100)) / 3, abs=1e-3)
    assert (figures.worst_train, figures.worst_late_s) == ("2", 150.0)
    assert figures.lost_train_minutes == pytest.approx(20 / 60, abs=1e-3)


def test_who_is_ended_at_a_station_has_come_there() -> None:
    """1 comes to B 40 s late and is ended there: its departure from B and C are cancelled, an hour late."""
    cut = [replace(stop("1", "B", None, None), stated_late_s=3600.0)]
    cut.append(replace(stop("1", "C", 200.0, None), stated_late_s=3600.0))
    figures = figures_of_stops([stop("1", "B", 100.0, 140.0), *cut], plan({"1": ONE}))
    assert (figures.arrivals, figures.within[0], figures.mean_late_s) == (1, 0.5, (40 + 3600) / 2)
    assert (figures.shortened, figures.missing) == (("1",), ())


def test_who_begins_later_by_order_and_never_comes_to_its_end_is_missing() -> None:
    """1 begins at B, as the scenario's hour late at A; it never comes to C."""
    begun = [replace(stop("1", "A", None, None), stated_late_s=3600.0), stop("1", "B", None, None)]
    figures = figures_of_stops(begun, plan({"1": ONE}), 5000.0)
    assert (figures.missing, figures.shortened) == (("1",), ("1",))
    assert figures.worst_late_s == 5000.0 - 100.0
    came = [begun[0], stop("1", "B", 100.0, 100.0), stop("1", "C", 200.0, 200.0)]
    assert (
        figures_of_stops(came, plan({"1": ONE})).lost_train_minutes == 60.0
    )  # as stated, though it ends in time


def test_a_train_that_calls_but_once_has_arrived_when_it_leaves() -> None:
    once = plan({"1": [("A", None, 100)]})
    left = replace(stop("1", "A", None, None), planned_departure_s=100.0, departure_s=110.0)
    assert (figures_of_stops([left], once).arrived_trains, figures_of_stops([left], once).missing) == (1, ())
    assert figures_of_stops([replace(left, departure_s=None)], once).missing == ("1",)
