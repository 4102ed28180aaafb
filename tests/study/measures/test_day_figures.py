"""A day in a few figures: against the plan, and what never came is not on time."""

from __future__ import annotations

import pytest

from simulation.result import StopRecord
from study.measures.day_figures import day_figures


def stop(number: str, station: str, planned_s: float | None, arrival_s: float | None) -> StopRecord:
    return StopRecord("K1", number, True, station, "1", planned_s, None, arrival_s=arrival_s)


def test_lateness_punctuality_and_what_is_missing() -> None:
    figures = day_figures(
        [
            stop("1", "A", None, None),
            stop("1", "B", 100.0, 130.0),
            stop("1", "C", 200.0, 400.0),
            stop("2", "C", 50.0, 40.0),
            stop("2", "A", 300.0, None),
        ]
    )
    assert (figures.planned_trains, figures.arrived_trains, figures.missing) == (2, 1, ("2",))
    assert (figures.planned_arrivals, figures.arrivals) == (4, 3)
    assert figures.within == (0.5, 0.5, 0.75)
    assert figures.mean_late_s == pytest.approx((30 + 200 - 10) / 3, abs=1e-3)
    assert (figures.median_late_s, figures.worst_late_s) == (30.0, 200.0)
    assert (figures.worst_train, figures.worst_station) == ("1", "C")
    assert figures.lost_train_minutes == pytest.approx(200 / 60, abs=1e-3)


def test_a_day_without_trains() -> None:
    figures = day_figures([])
    assert (figures.planned_trains, figures.within, figures.mean_late_s) == (0, (0.0, 0.0, 0.0), None)
