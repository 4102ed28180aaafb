"""Where a train that runs through is at what time, in the day as it is played through."""

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Direction, Line
from network.timetable import Call, CallKind, Diagram, Stabled, TimetableTrain, no_trains
from simulation.setup import Setup
from study.feasibility.check import feasibility
from study.feasibility.finding import FindingKind
from study.feasibility.planned import planned_day
from study.feasibility.rehearsal import Rehearsal
from vehicle.train_file import load_train, train_named

BEGINS_S = 36_000


def _running_through(line: Line, passes_s: list[int], arrives_s: int) -> Setup:
    """A train up from the end of a line that stops nowhere, and is at each station at these times."""
    first, *between, last = sorted(line.stations.values(), key=lambda station: -station.position_m)
    calls = (
        Call(first.id, None, None, BEGINS_S),
        *(Call(s.id, None, None, at_s, CallKind.PASS) for s, at_s in zip(between, passes_s, strict=True)),
        Call(last.id, None, arrives_s, None),
    )
    train = TimetableTrain("1", Direction.UP, False, calls, Stabled(), Stabled())
    no_day = no_trains(line, 20.0)
    day = type(no_day)(no_day.head, {"1": train}, (Diagram("1", ("1",)),))
    return Setup("through", line, day, {"1": load_train(train_named("br642"))})


def test_a_train_that_runs_through_at_the_times_of_its_driving_is_on_time() -> None:
    """Kururi's line is slow in the hills and fast in the plain: each part takes what it takes."""
    line = load_line(shipped_line("kururi"))
    slow = _running_through(line, [BEGINS_S + 600 * i for i in range(1, 13)], BEGINS_S + 7800)
    _, there = planned_day(slow).trains["1"][0].stands
    driven = [BEGINS_S + round(at_s) for at_s in there.passes_s]
    setup = _running_through(line, driven, BEGINS_S + round(there.run_s))
    late_s = [one.late_s for one in Rehearsal(setup, planned_day(setup)).late if not one.leaves]
    assert len(late_s) == 1
    assert abs(late_s[0]) < 5.0  # by even speed on the whole way: 19 s


def test_a_train_is_late_at_a_halt_though_it_is_on_time_at_the_next_track() -> None:
    """90 s too few to the first halt, and 200 s to stand there."""
    line = load_line(shipped_line("karasuyama"))
    first, halt, *_, last = sorted(line.stations.values(), key=lambda station: -station.position_m)

    def stopping(at_halt_s: int) -> Setup:
        calls = (
            Call(first.id, None, None, BEGINS_S),
            Call(halt.id, None, at_halt_s, at_halt_s + 200),
            Call(last.id, None, BEGINS_S + 3600, None),
        )
        train = TimetableTrain("1", Direction.UP, False, calls, Stabled(), Stabled())
        no_day = no_trains(line, 20.0)
        day = type(no_day)(no_day.head, {"1": train}, (Diagram("1", ("1",)),))
        return Setup("halts", line, day, {"1": load_train(train_named("br642"))})

    _, there, *_ = planned_day(stopping(BEGINS_S + 1000)).trains["1"][0].stands
    setup = stopping(BEGINS_S + round(there.run_s) - 90)
    late = Rehearsal(setup, planned_day(setup)).late
    at_halt = [one.late_s for one in late if one.station_id == halt.id]
    assert at_halt == [pytest.approx(90.0, abs=0.5), 0.0]  # on its arrival and as it leaves
    assert next(one.late_s for one in late if one.station_id == last.id) <= 0.0
    (found,) = (f for f in feasibility(setup).findings if f.kind is FindingKind.LATE)
    assert (found.place, found.short_s) == (halt.id, pytest.approx(90.0, abs=0.5))
