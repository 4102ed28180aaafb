"""Verdicts on expectations, from a made-up journal."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from network.model import Position
from onboard.notes import Departs, MissionBegun, Overran, Proven, Resumed, UnitRestarted
from simulation.events import Danger, Event, Unsafe
from simulation.faults.script import Expectation, Matcher, Property, Script
from simulation.journal import Journal
from simulation.judge.checkers import Violation
from simulation.result import Ending, RunResult, StopRecord, Waiting
from simulation.world.records import TRACE
from study.drilling.outcome_class import OutcomeKind, swept_run_of
from study.drilling.verdict import judge
from study.record.figure import schema_of
from study.record.tables import ROWS, RunTables, make_table

SLOW_MPS = 4.0  # 14.4 km/h


def result_of(*entries: tuple[float, str, Event], **changes: object) -> RunResult:
    journal = Journal()
    for entry in entries:
        journal.write(*entry)
    fields: dict[str, Any] = {
        "name": "made up",
        "seed": 1,
        "link": "simulated",
        "stock_ids": ("K1",),
        "begin_step": 0,
        "end_step": 1000,
        "trains_planned": ("T1",),
        "trains_arrived": ("T1",),
        "empty_planned": (),
        "empty_arrived": (),
        "stops": [],
        "energy": [],
        "waiting": [],
        "violations": (),
        "collisions": (),
        "telegrams": {("a", "b", "c"): Counter()},
        "trace": np.zeros(0, dtype=TRACE),
        "spans": [],
        "journal": journal,
        "ended_because": Ending.FINISHED,
        **changes,
    }
    return RunResult(**fields)


def tables(**rows: list[tuple[Any, ...]]) -> RunTables:
    frames = {}
    for name, row in ROWS.items():
        schema = schema_of(row)
        columns = list(zip(*rows[name], strict=True)) if rows.get(name) else [()] * len(schema)
        frames[name] = make_table(name, dict(zip(schema, map(list, columns), strict=True)))
    return RunTables(**frames)


NOTHING = tables()
A = Matcher("a", (UnitRestarted,), who="K1")
B = Matcher("b", (Resumed,), who="K1")
C = Matcher("c", (Proven,), who="K1")
RUN = result_of(
    (10.0, "K1", UnitRestarted(epoch=2)),
    (20.0, "K1", Proven(points_id="P7", position=Position.NORMAL, token=1)),
    (30.0, "K1", Resumed(next_target=1)),
)


def verdict(
    expectation: Expectation, result: RunResult = RUN, given: RunTables = NOTHING
) -> tuple[bool, str]:
    (found,) = judge((expectation,), result, given)
    return found.passed, found.happened


@pytest.mark.parametrize(
    ("expectation", "passed"),
    [
        (Expectation("t", C), True),
        (Expectation("t", C, by_s=15.0), False),
        (Expectation("t", C, after=A, within_s=10.0), True),
        (Expectation("t", C, after=A, within_s=9.9), False),
        (Expectation("t", C, after=B), False),
        (Expectation("t", C, after=A, until=B), True),
        (Expectation("t", C, absent=True), False),
        (Expectation("t", C, absent=True, after=B), True),
        (Expectation("t", Matcher("x", (Overran,))), False),
        (Expectation("t", Matcher("x", (Overran,)), absent=True), True),
    ],
)
def test_an_event_is_looked_for_in_its_stretch_of_time(expectation: Expectation, passed: bool) -> None:
    assert verdict(expectation)[0] is passed


def test_a_stretch_that_never_begins_or_ends_meets_nothing() -> None:
    never = Matcher("K1 overruns", (Overran,))
    for expectation in (
        Expectation("t", C, absent=True, after=never),
        Expectation("t", C, absent=True, until=never),
        Expectation("t", holds=Property.SPEED_AT_MOST, unit="K1", kmh=15.0, after=never),
    ):
        assert verdict(expectation) == (False, "'K1 overruns' never happened")
    ended_before = Expectation("t", C, after=B, until=A)
    assert verdict(ended_before) == (False, f"'{A.text}' did not happen after 00:00:30.0")


@pytest.mark.parametrize(
    "expectation",
    [
        Expectation("t", C, absent=True, after=B, by_s=25.0),
        Expectation("t", holds=Property.SPEED_AT_MOST, unit="K1", kmh=15.0, after=B, by_s=25.0),
    ],
)
def test_a_stretch_that_ends_before_it_begins_meets_nothing(expectation: Expectation) -> None:
    """Nothing happens in no time: that would meet whatever must not happen."""
    assert verdict(expectation) == (False, "the time given ends at 00:00:25.0, before it begins")


def test_a_train_number_is_that_of_the_moment() -> None:
    result = result_of(
        (1.0, "K1", MissionBegun(train="T1", direction="down")),
        (2.0, "K1", Departs(station="A")),
        (3.0, "K1", MissionBegun(train="T2", direction="down")),
        (4.0, "K1", Departs(station="B")),
    )
    event = Matcher("T2 departs B", (Departs,), train="T2", data={"station": "B"})
    assert verdict(Expectation("t", event), result) == (True, "at 00:00:04.0")
    wrong = Matcher("T1 departs B", (Departs,), train="T1", data={"station": "B"})
    assert not verdict(Expectation("t", wrong), result)[0]


def test_broken_invariants_and_collisions_are_not_passed_over() -> None:
    sound = Expectation("t", holds=Property.NO_INVARIANT_BROKEN)
    assert verdict(sound) == (True, "none broken")
    violation = Violation(5.0, "inside-holding", "K1 is in section 5")
    assert verdict(sound, result_of(violations=(violation,))) == (False, "inside-holding: K1 is in section 5")
    assert not verdict(sound, result_of(collisions=("K1 and K2",)))[0]
    unsafe = result_of((5.0, "world", Unsafe(unit_id="K1", danger=Danger.SET_AGAINST, points_id="P7")))
    assert verdict(sound, unsafe) == (False, "K1 ran through points P7 set against it")
    late = Violation(5.0, "everyone-arrives", "T1 has not arrived")
    assert verdict(sound, result_of(violations=(late,)))[0]


def test_where_persons_are_wrong_the_rules_that_are_named_are_broken_and_no_others() -> None:
    wrong = Expectation(
        "t", holds=Property.NO_INVARIANT_BROKEN, absent=True, rules=("inside-holding", "one-train-a-section")
    )
    named = Violation(5.0, "inside-holding", "K1 is in section 5")
    assert verdict(wrong, result_of(violations=(named,)))[0]
    assert verdict(wrong, result_of(violations=(named, Violation(6.0, "one-train-a-section", "K2"))))[0]
    assert not verdict(wrong)[0], "nothing shows"
    other = Violation(6.0, "no-double-grant", "section 5")
    assert not verdict(wrong, result_of(violations=(named, other)))[0]
    assert not verdict(wrong, result_of(violations=(named,), collisions=("K1 and K2",)))[0]
    assert verdict(replace(wrong, rules=()), result_of(violations=(named, other)))[0]


def test_what_is_outside_the_design_is_said_with_the_verdict_and_does_not_fail_it() -> None:
    apart = (Violation(5.0, "inside-holding", "K1 is in section 5"),)
    passed, happened = verdict(
        Expectation("t", holds=Property.NO_INVARIANT_BROKEN), result_of(outside_design=apart)
    )
    assert passed
    assert happened == "none broken; outside the design: 00:00:05 inside-holding: K1 is in section 5"


def test_every_train_must_arrive_empty_ones_too() -> None:
    all_arrive = Expectation("t", holds=Property.EVERYONE_ARRIVES)
    assert verdict(all_arrive)[0]
    assert verdict(all_arrive, result_of(empty_planned=("E2",))) == (False, "1 train did not arrive: E2")
    stuck = [Waiting("K1", "T1", "section 6", "route 6>8: undefined")]
    happened = verdict(all_arrive, result_of(trains_arrived=(), waiting=stuck))[1]
    assert "; T1 (K1) stands in section 6 and waits for route 6>8: the block manager" in happened


def test_who_should_have_left_must_have_left_and_the_run_must_have_reached_its_end() -> None:
    all_arrive = Expectation("t", holds=Property.EVERYONE_ARRIVES)
    stays = "K1 has not left the line and does not stand where its last duty ends"
    assert verdict(all_arrive, result_of(unfinished=("K1",))) == (False, stays)
    for because in (Ending.TIME_LIMIT, Ending.STALLED):
        passed, happened = verdict(all_arrive, result_of(ended_because=because))
        assert not passed
        assert because.value in happened


def trajectory(*points: tuple[float, float]) -> list[tuple[Any, ...]]:
    kinds = {"unit": "K1", "train": "T1", "direction": 1, "piece": "5", "intervention": 0}
    return [
        tuple(
            {**kinds, "t_s": t_s, "speed_mps": speed}.get(name, 0.0) for name in schema_of(ROWS["trajectory"])
        )
        for t_s, speed in points
    ]


def test_speed_is_judged_within_its_stretch_by_the_truth() -> None:
    slow = Expectation("t", holds=Property.SPEED_AT_MOST, unit="K1", kmh=15.0, after=A, until=B)
    fast_outside = tables(trajectory=trajectory((5.0, 20.0), (15.0, SLOW_MPS), (35.0, 20.0)))
    assert verdict(slow, RUN, fast_outside) == (True, "at most 14.4 km/h")
    fast_inside = tables(trajectory=trajectory((15.0, SLOW_MPS), (25.0, 5.0)))
    assert verdict(slow, RUN, fast_inside) == (False, "at most 18.0 km/h")
    # Less than a second lies between two rows; who has none is off the line, and no slower for it.
    moment = replace(slow, after=B, until=None, by_s=30.4)
    assert verdict(moment, RUN, tables(trajectory=trajectory((30.9, 20.0)))) == (False, "at most 72.0 km/h")
    for elsewhere in (NOTHING, tables(trajectory=trajectory((5.0, 20.0), (32.0, SLOW_MPS)))):
        assert verdict(slow, RUN, elsewhere) == (False, "was not on the line")


def stop_of(number: str, station: str, stated_late_s: float | None = None) -> StopRecord:
    return StopRecord("K1", number, True, station, "1", 0.0, None, stated_late_s=stated_late_s)


ENDED_AT_B = [stop_of("T1", "B"), stop_of("T1", "B", 90.0), stop_of("T1", "C", 90.0)]
BEGUN_AT_B = [stop_of("T2", "C", 60.0), stop_of("T2", "B", 60.0), stop_of("T2", "B")]


def test_of_trains_cut_by_order_it_is_not_said_that_all_arrived() -> None:
    everyone = Expectation("t", holds=Property.EVERYONE_ARRIVES)
    cut = {"stops": [*ENDED_AT_B, *BEGUN_AT_B], "trains_planned": ("T1", "T2"), "cut": ("T1",)}
    done = result_of(trains_arrived=("T2",), **cut)
    assert verdict(everyone, done) == (True, "all arrived but what was cancelled: T1")
    swept = swept_run_of(done, Script())
    assert (swept.kind, swept.late_s) == (OutcomeKind.LATE, 90.0)
    assert swept.label == "all arrive, late, but for what was cancelled"
    # T2 begins at B, as it was told to, and never comes to its end
    stuck = result_of(trains_arrived=(), **cut)
    assert verdict(everyone, stuck) == (False, "1 train did not arrive: T2")
