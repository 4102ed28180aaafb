"""A day in a few figures: against the plan, and what never came, or never ran, is not on time."""

from __future__ import annotations

import pytest

from network.model import Direction
from network.timetable import Call, Diagram, Stabled, Timetable, TimetableTrain
from simulation.result import StopRecord
from study.measures.day_figures import figures_of_stops


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
    return Timetable("t", "t", "l", 20.0, made, (Diagram("K1", tuple(made)),))


THREE = plan(
    {
        "1": [("A", None, 0), ("B", 100, 110), ("C", 200, None)],
        "2": [("C", 50, 60), ("B", 100, 110), ("A", 300, None)],
        "3": [("A", None, 400), ("B", 500, None)],
    }
)


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
    assert figures.mean_late_s == pytest.approx((30 + 200 - 10) / 3, abs=1e-3)
    assert (figures.median_late_s, figures.worst_late_s) == (30.0, 200.0)
    assert (figures.worst_train, figures.worst_station) == ("1", "C")
    assert figures.lost_train_minutes == pytest.approx(200 / 60, abs=1e-3)


def test_a_day_without_trains() -> None:
    figures = figures_of_stops([], plan({}))
    assert (figures.planned_trains, figures.within, figures.mean_late_s) == (0, (0.0, 0.0, 0.0), None)


def test_a_day_on_which_nothing_ran_is_not_punctual() -> None:
    figures = figures_of_stops([], THREE)
    assert (figures.planned_arrivals, figures.arrivals, figures.within) == (5, 0, (0.0, 0.0, 0.0))
    assert figures.missing == ("1", "2", "3")
