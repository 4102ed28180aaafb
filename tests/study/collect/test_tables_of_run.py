"""From hand-made leavings of a run to its tables: figures that can be checked on paper."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.graph import find_route
from network.model import Direction, Line
from network.path import path_of
from onboard.notes import AbleToLeave, Intervention, Moving, UnableToLeave
from radio.noted import TelegramDropped
from simulation.events import MANAGER, WORLD, Collision, Left
from simulation.journal import Journal
from simulation.result import Ending, RunResult, StopRecord, TraceSpan
from simulation.world.records import TRACE
from study.collect.energy import StockMake
from study.collect.tables_of_run import tables_of
from study.measures.register_holds import section_holds
from study.record.tables import RunTables
from tests.study.collect.crossed import crossed
from vehicle.train_file import RegenerationReceiver
from wayside.said import Accepted, Freed, Granted, Refused

LINE = load_line(shipped_line("rtri_test_line"))
LENGTH_M = 40.0
SPEED_MPS = 10.0
HEAD_M = 100.0  # the front stands this far into its path at first


def span(slot: int, from_step: int, number: str, start: str, end: str, direction: Direction) -> TraceSpan:
    route = find_route(LINE, start, end, direction)
    assert route is not None
    path = path_of(LINE, route.piece_ids, direction)
    return TraceSpan(
        slot,
        from_step,
        number,
        int(direction),
        tuple(step.start_m for step in path.steps),
        path.piece_ids,
        tuple(step.entry_m for step in path.steps),
    )


def rows(slot: int, from_step: int, run_s: int, *, head_m: float = HEAD_M) -> list[tuple[float, ...]]:
    """A row a second of a train that starts at `from_step` and runs 10 m/s from the first moment."""
    made = []
    for second in range(1, run_s + 1):
        row = dict.fromkeys(TRACE.names or (), 0.0)
        row |= {"step": from_step + 10 * second, "slot": slot, "speed_mps": SPEED_MPS}
        row["position_m"] = head_m + SPEED_MPS * second
        made.append(tuple(row.values()))
    return made


def result(
    *,
    spans: Sequence[TraceSpan] = (),
    trace: Sequence[tuple[float, ...]] = (),
    journal: Journal | None = None,
    stops: Sequence[StopRecord] = (),
    telegrams: dict[tuple[str, str, str], Counter[str]] | None = None,
) -> RunResult:
    return RunResult(
        name="made up",
        seed=1,
        link="simulated",
        stock_ids=("K1", "K2"),
        begin_step=0,
        end_step=10_000,
        trains_planned=(),
        trains_arrived=(),
        empty_planned=(),
        empty_arrived=(),
        stops=list(stops),
        energy=[],
        waiting=[],
        violations=(),
        collisions=(),
        telegrams=telegrams or {},
        trace=np.array(sorted(trace), dtype=TRACE),
        spans=list(spans),
        journal=journal or Journal(),
        ended_because=Ending.FINISHED,
    )


def tables(made: RunResult, line: Line = LINE) -> RunTables:
    stocks = ("K1", "K2")
    holds = section_holds(made, line, dict.fromkeys(stocks, LENGTH_M))
    return tables_of(made, line, dict.fromkeys(stocks, StockMake(2, RegenerationReceiver.BATTERY)), holds)


def grant(journal: Journal, t_s: float, unit: str, *sections: str, token: int = 1) -> None:
    granted = Granted(unit_id=unit, section_ids=sections, token=token, route_id="r")
    journal.write(t_s, MANAGER, granted)


def accept(journal: Journal, t_s: float, unit: str, *sections: str) -> None:
    accepted = Accepted(unit_id=unit, section_ids=sections, token=1, was="outside")
    journal.write(t_s, MANAGER, accepted)


def free(journal: Journal, t_s: float, unit: str, *sections: str) -> None:
    journal.write(t_s, MANAGER, Freed(unit_id=unit, section_ids=sections))


def occupation(made: RunTables) -> dict[tuple[str, str], tuple[Any, ...]]:
    columns = ("granted_s", "entered_s", "cleared_s", "released_s")
    return {
        (row["section"], row["unit"]): tuple(row[name] for name in columns)
        for row in made.blocks.iter_rows(named=True)
    }


def test_a_front_on_a_crossing_is_that_of_the_train_that_its_unit_then_is() -> None:
    """K1 is T1, and T2 from 3650 s on."""
    spans = [span(0, at, number, "3", "8", Direction.DOWN) for at, number in ((0, "T1"), (36_500, "T2"))]
    made = tables(result(spans=spans, journal=crossed()))
    assert [(row["unit"], row["train"]) for row in made.warnings.iter_rows(named=True)] == [
        ("K1", "T1"),
        ("K2", ""),
        ("K1", "T2"),
        ("K2", ""),
        ("K2", ""),
        ("K1", "T2"),
    ]
    assert made.crossings["closed_s"].to_list()[:4] == [20.0, 156.0, 10.0, 40.0]


def test_an_empty_run_has_empty_tables() -> None:
    made = tables(result())
    for name in ("trajectory", "stops", "blocks", "telegrams", "energy", "crossings", "warnings", "events"):
        assert getattr(made, name).is_empty()


@pytest.mark.parametrize(
    ("direction", "start", "end", "first_km", "last_km"),
    [(Direction.DOWN, "3", "8", 0.36, 1.05), (Direction.UP, "9", "4", 1.05, 0.36)],
)
def test_kilometrage_runs_with_the_direction(
    direction: Direction, start: str, end: str, first_km: float, last_km: float
) -> None:
    """690 m from the far end of section 3 to that of section 8, as the line file has it."""
    made = tables(
        result(spans=[span(0, 0, "T1", start, end, direction)], trace=rows(0, 0, 58, head_m=110.0))
    ).trajectory
    assert made["kilometrage_m"][0] == pytest.approx(first_km * 1000 + direction * 120.0)
    assert made["kilometrage_m"][-1] == pytest.approx(last_km * 1000)
    assert made["t_s"].to_list() == [float(s) for s in range(1, 59)]
    for km_m, piece in zip(made["kilometrage_m"], made["piece"], strict=True):
        assert LINE.pieces[piece].from_m - 1e-6 <= km_m <= LINE.pieces[piece].to_m + 1e-6
    assert set(made["train"]) == {"T1"}
    assert set(made["direction"]) == {int(direction)}


def test_a_slot_is_the_train_that_it_was_at_that_time() -> None:
    """K1 runs as T1 and, from 100 s on, back as T2; K2 runs T3 all the while."""
    spans = [
        span(0, 0, "T1", "3", "8", Direction.DOWN),
        span(1, 0, "T3", "9", "4", Direction.UP),
        span(0, 1000, "T2", "8", "3", Direction.UP),
    ]
    made = tables(
        result(spans=spans, trace=[*rows(0, 0, 50), *rows(0, 1000, 20), *rows(1, 0, 30)])
    ).trajectory
    counts = dict(made.group_by("unit", "train").len().select("train", "len").iter_rows())
    assert counts == {"T1": 50, "T2": 20, "T3": 30}
    assert made.filter(made["train"] == "T2")["t_s"].min() == 101.0


def test_blocks_are_entered_by_the_front_and_cleared_by_the_rear() -> None:
    """Front at 100 m + 10 m/s t; section 5 spans 110 to 170 m of the path, section 6 from there to 520 m."""
    journal = Journal()
    accept(journal, 0.0, "K1", "3")
    grant(journal, 0.5, "K1", "5", "6", "7", "8", token=7)
    free(journal, 6.2, "K1", "3")
    free(journal, 12.5, "K1", "5")
    one = span(0, 0, "T1", "3", "8", Direction.DOWN)
    found = occupation(tables(result(spans=[one], trace=rows(0, 0, 20), journal=journal)))
    assert found["5", "K1"] == pytest.approx((0.5, 1.0, 11.0, 12.5))
    assert found["3", "K1"][2:] == pytest.approx((5.0, 6.2))
    assert found["6", "K1"][:2] == pytest.approx((0.5, 7.0))
    assert found["6", "K1"][2:] == (None, None)  # the train is still in it
    assert found["8", "K1"] == (0.5, None, None, None)  # granted, not reached
    assert found["3", "K1"][0] == 0.0
    blocks = tables(result(spans=[one], trace=rows(0, 0, 20), journal=journal)).blocks
    assert dict(zip(blocks["section"], blocks["token"], strict=True))["5"] == 7
    assert set(blocks["train"]) == {"T1"}


def test_a_train_that_turns_back_keeps_its_section_until_it_has_left_it() -> None:
    """T1 ends in section 8 at 12 s; T2 leaves it from 100 s on: 110 m long, front 40 m from its end at first."""
    journal = Journal()
    grant(journal, 0.0, "K1", "8", token=2)
    free(journal, 120.0, "K1", "8")
    spans = [span(0, 0, "T1", "3", "8", Direction.DOWN), span(0, 1000, "T2", "8", "3", Direction.UP)]
    trace = [*rows(0, 0, 12, head_m=500.0), *rows(0, 1000, 15, head_m=70.0)]
    found = occupation(tables(result(spans=spans, trace=trace, journal=journal)))
    # the front comes to 580 m, where section 8 begins, at 8 s; the rear is past 110 m when the front is at 150 m
    assert found["8", "K1"] == pytest.approx((0.0, 8.0, 108.0, 120.0))


def test_a_train_that_leaves_the_line_clears_where_it_stood() -> None:
    journal = Journal()
    grant(journal, 0.0, "K1", "8", token=2)
    journal.write(90.0, WORLD, Left(unit_id="K1"))
    free(journal, 90.3, "K1", "8")
    one = span(0, 0, "T1", "3", "8", Direction.DOWN)
    found = occupation(tables(result(spans=[one], trace=rows(0, 0, 12, head_m=500.0), journal=journal)))
    assert found["8", "K1"] == pytest.approx((0.0, 8.0, 90.0, 90.3))


def test_the_same_section_twice_is_two_rows() -> None:
    journal = Journal()
    for first_s in (0.0, 1000.0):
        grant(journal, first_s, "K1", "5", token=int(first_s) + 1)
        free(journal, first_s + 30.0, "K1", "5")
    spans = [span(0, 0, "T1", "3", "8", Direction.DOWN), span(0, 10_000, "T2", "3", "8", Direction.DOWN)]
    made = tables(result(spans=spans, trace=[*rows(0, 0, 60), *rows(0, 10_000, 60)], journal=journal)).blocks
    assert made["granted_s"].to_list() == [0.0, 1000.0]
    assert made["entered_s"].to_list() == pytest.approx([1.0, 1001.0])
    assert made["cleared_s"].to_list() == pytest.approx([11.0, 1011.0])
    assert made["train"].to_list() == ["T1", "T2"]


@given(
    planned_s=st.none() | st.integers(0, 100_000),
    late_s=st.floats(-600.0, 600.0).map(lambda s: round(s, 1)),
    came=st.booleans(),
)
def test_lateness_is_fact_less_plan_where_there_are_both(
    planned_s: int | None, late_s: float, came: bool
) -> None:
    fact_s = (planned_s or 0) + late_s if came else None
    stop = StopRecord("K1", "T1", True, "B", "1", planned_s, planned_s, fact_s, fact_s, 0.25)
    row = tables(result(stops=[stop])).stops.row(0, named=True)
    expected = late_s if came and planned_s is not None else None
    for name in ("late_arrival_s", "late_departure_s"):
        assert row[name] == (None if expected is None else pytest.approx(expected, abs=1e-6))
    assert (row["stop_error_m"], row["arrival_s"]) == (0.25, fact_s)


def test_telegrams_count_what_the_air_lost_and_the_receiver_dropped() -> None:
    journal = Journal()
    terms = {"epoch": 1, "sequence": 3, "correlation": 2}
    journal.write(
        1.0, "B-W", TelegramDropped(source="K1", receiver="B-W", kind="PointsCommand", why="stale", **terms)
    )
    journal.write(
        2.0,
        "K1",
        TelegramDropped(source=MANAGER, receiver="K1", kind="RouteGranted", why="repeated", **terms),
    )
    counted = {
        ("K1", "B-W", "PointsCommand"): Counter(sent=5, delivered=4, lost=1, bytes=400),
        ("block-manager", "K1", "RouteGranted"): Counter(sent=2, delivered=3, lost=0, bytes=262),
    }
    made = tables(result(journal=journal, telegrams=counted)).telegrams
    assert made["sent"].to_list() == [5, 2]
    assert made["lost"].to_list() == [1, 0]
    assert made["dropped"].to_list() == [1, 1]
    assert made["bytes"].sum() == 662


def test_events_are_what_a_person_should_hear_of() -> None:
    journal = Journal()
    journal.write(1.0, "K1", Moving())
    journal.write(2.0, "K1", Intervention(level=2))
    journal.write(3.0, MANAGER, Refused(unit_id="K2", section_ids=("5", "6"), why="HELD"))
    journal.write(4.0, WORLD, Collision(text="K1 with K2"))
    journal.write(5.0, "K1", UnableToLeave(station="A", why="a pull"))
    journal.write(6.0, "K1", AbleToLeave(station="A"))
    made = tables(result(journal=journal)).events
    assert made["t_s"].to_list() == [2.0, 3.0, 4.0, 5.0, 6.0]
    kinds = ["intervention", "refusal", "unsafe", "unable to leave", "able to leave"]
    assert made["kind"].to_list() == kinds
    assert made["text"][0] == "emergency brake"
    assert "sections 5 6" in made["text"][1]
    assert "K1 with K2" in made["text"][2]
