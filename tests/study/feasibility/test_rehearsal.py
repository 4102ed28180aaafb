"""Where a train that runs through is at what time, in the day as it is played through."""

from __future__ import annotations

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Direction, Line
from network.timetable import Call, CallKind, Diagram, Stabled, TimetableTrain, no_trains
from simulation.setup import Setup
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
