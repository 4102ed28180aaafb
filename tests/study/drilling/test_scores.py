"""Lateness and the time back to normal, from what happened and the stops."""

import polars as pl
import pytest

from simulation.faults.devices import PowerCut
from simulation.faults.script import Act, ActKind, ItemCourse, ScriptedFault, Trigger
from study.drilling.scores import ON_TIME_S, healed_at_s, score
from study.record.figure import schema_of
from study.record.tables import ROWS, make_table

FAULT = ScriptedFault(PowerCut(target="B-W"), Trigger(at_s=100.0))
ACT = Act(ActKind.REENTER_ASSISTED, "", Trigger(at_s=300.0))


def stops(*departures: tuple[float, float]) -> pl.DataFrame:
    """A table of stops from (planned, actual) departures."""
    rows = [
        {"planned_departure_s": planned, "departure_s": actual, "late_departure_s": actual - planned}
        | {"revenue": True, "unit": "K1", "train": "T1"}
        for planned, actual in departures
    ]
    return make_table("stops", {name: [row.get(name) for row in rows] for name in schema_of(ROWS["stops"])})


@pytest.mark.parametrize(
    ("departures", "normal_after_s"),
    [
        ([], 0.0),
        ([(150.0, 250.0)], 0.0),  # late, but before the heal
        ([(150.0, 400.0)], 100.0),
        ([(350.0, 350.0 + ON_TIME_S)], 0.0),  # on time to the tolerance
        ([(150.0, 400.0), (450.0, 455.0), (500.0, 600.0), (700.0, 700.0)], 300.0),
    ],
)
def test_normal_again_from_the_last_late_departure_after_the_last_heal(
    departures: list[tuple[float, float]], normal_after_s: float
) -> None:
    courses = (ItemCourse(FAULT, 100.0, 200.0), ItemCourse(ACT, 300.0))
    scores = score(courses, stops(*departures), 100.0, all_arrived=True)
    assert (scores.healed_s, scores.normal_after_s, scores.late_s_max) == (300.0, normal_after_s, 100.0)


def test_a_departure_that_is_cancelled_is_not_back_to_normal() -> None:
    """Planned 20 s after the heal, it counts as leaving 600 s late."""
    table = stops((320.0, 920.0)).with_columns(
        departure_s=pl.lit(None, pl.Float64), cancelled=pl.lit(value=True)
    )
    courses = (ItemCourse(FAULT, 100.0, 300.0),)
    assert score(courses, table, 600.0, all_arrived=True).normal_after_s == 620.0


def test_a_fault_that_lasts_heals_never() -> None:
    assert healed_at_s((ItemCourse(FAULT, 100.0), ItemCourse(ACT, 300.0))) is None
    assert healed_at_s(()) is None
    assert healed_at_s((ItemCourse(FAULT, 100.0, 400.0), ItemCourse(ACT, 300.0))) == 400.0


@pytest.mark.parametrize(
    ("courses", "all_arrived", "why"),
    [
        ((), True, "nothing was disturbed"),
        ((ItemCourse(FAULT, 100.0),), True, "a fault lasts to the end"),
        ((ItemCourse(FAULT, 100.0, 200.0),), False, "not every train arrived"),
    ],
)
def test_where_there_is_no_time_back_to_normal_it_says_why(
    courses: tuple[ItemCourse, ...], all_arrived: bool, why: str
) -> None:
    scores = score(courses, stops(), 0.0, all_arrived=all_arrived)
    assert (scores.normal_after_s, scores.why.en) == (None, why)
