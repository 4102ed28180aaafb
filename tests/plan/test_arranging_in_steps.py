"""Days that are too much as a whole: any plan, better ones in steps, and the tracks that lack, all reckoned by hand.

A, a loop L and B; each run takes 300 s, a stop 20 s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pytest

from network.files.timetable_schema import CallTable
from network.timetable import Call
from plan.arranging import nearest, search
from plan.arranging.draft import _printed
from plan.arranging.lacking import Day, Halts, MoreTracks, more_tracks
from plan.arranging.model import ANOTHER, Aim, ArrangeModel
from plan.arranging.nearest import NothingFoundError, nearest_plan
from plan.arranging.problem import (
    Arranged,
    ArrangedVisit,
    ByStanding,
    Leg,
    PrintedMove,
    RunSeconds,
    Standing,
    TrainToArrange,
    Visit,
)
from plan.arranging.search import gap_of, improved, with_fewer_tracks
from tests.plan.small_day import NOON, RUN, train_of

TRACKS: dict[str, tuple[str, ...]] = {"A": ("A.1", "A.2"), "L": ("L.1",), "B": ("B.1", "B.2")}


def _train(
    number: str, way: str, *departures_s: int, tracks: Mapping[str, tuple[str, ...]]
) -> TrainToArrange:
    """From station to station of `way`, with printed departures at all but the last."""
    visits = [
        Visit(name, Standing.ALWAYS, None, at_s, 20, RUN, None, tracks[name])
        for name, at_s in zip(way, (*departures_s, None), strict=True)
    ]
    return train_of(number, visits)


def _meet() -> list[TrainToArrange]:
    """Down is at the loop 300 s after noon; up is to leave there for where it comes from 30 s before."""
    down, up = {**TRACKS, "B": ("B.1",)}, {"A": ("A.2",), "L": ("L.2",), "B": ("B.2",)}
    return [
        _train("1", "ALB", NOON, NOON + 400, tracks=down),
        _train("2", "BLA", NOON - 300, NOON + 270, tracks=up),
    ]


LEAST = (PrintedMove("2", "L", "departure", NOON + 270, 30),)


def _late(by_s: int) -> Arranged:
    """A plan for the meet in which up leaves the loop by so much later than it must."""
    visits: dict[str, tuple[ArrangedVisit, ...]] = {
        "1": (
            ArrangedVisit("A", NOON, NOON, True, "A.1"),
            ArrangedVisit("L", NOON + 300, NOON + 400, True, "L.1"),
            ArrangedVisit("B", NOON + 700, NOON + 700, True, "B.1"),
        ),
        "2": (
            ArrangedVisit("B", NOON - 300, NOON - 300, True, "B.2"),
            ArrangedVisit("L", NOON, NOON + 300 + by_s, True, "L.2"),
            ArrangedVisit("A", NOON + 600 + by_s, NOON + 600 + by_s, True, "A.2"),
        ),
    }
    moves = (PrintedMove("2", "L", "departure", NOON + 270, 30 + by_s),)
    return Arranged(visits, moves, False, 0.0, 300, 0.0)


def test_a_bad_plan_becomes_the_least_in_steps() -> None:
    plan, spent = improved(_meet(), _late(by_s=200), 300, {}, work_max=0.5)
    assert plan.moves == LEAST
    assert spent > 0


def test_without_work_a_plan_stays_as_it_is() -> None:
    plan = _late(by_s=200)
    assert improved(_meet(), plan, 300, {}, work_max=0.0) == (plan, 0.0)


def test_only_the_trains_that_are_arranged_anew_move() -> None:
    """Down keeps its times, though it would be at the loop sooner: up waits for it until 340 s."""
    before = _late(by_s=0).visits
    loop = replace(before["1"][1], arrival_s=NOON + 340)
    kept = {"1": (replace(before["1"][0], departure_s=NOON + 40), loop, before["1"][2])}
    found = ArrangeModel(_meet(), 300, 300, settled=kept).solve(0.1)
    assert found.visits["1"] == kept["1"]
    assert found.moves == (PrintedMove("2", "L", "departure", NOON + 270, 70),)


def test_where_the_day_as_a_whole_is_too_much_the_answer_comes_in_steps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(nearest, "WHOLE_WORK", 0.0)
    arranged = nearest_plan([_meet()], 300).arranged
    assert (arranged.moves, arranged.proven) == (LEAST, False)


def test_what_is_done_is_told_as_it_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nearest, "WHOLE_WORK", 0.0)
    told: list[str] = []
    nearest_plan([_meet()], 300, tell_all=told.append)
    head = "moves by 300 s at most: "
    assert told[:2] == [f"{head}looking for the least", f"{head}looking for any plan"]
    assert any("better in steps of 60 min" in text for text in told)


def test_the_least_is_told_with_its_bound() -> None:
    told: list[str] = []
    plan = ArrangeModel(_meet(), 300, 300).solve(0.1, tell=told.append)
    assert plan.proven
    assert told[-1] == "moves of 30 s in all found, no plan with less than 30 s"


def test_how_far_a_plan_is_from_the_least_at_most() -> None:
    """230 s against a bound of 30 s; a second beyond a limit of 200 s as 1,000 more."""
    plan = replace(_late(by_s=200), bound_s=30.0)
    assert gap_of(_meet(), plan, 300) == (200.0, 200 / 230)
    assert gap_of(_meet(), plan, 200) == (30_200.0, 30_200 / 30_230)
    assert gap_of(_meet(), replace(plan, proven=True), 300) == (0.0, 0.0)


def test_a_stop_that_nobody_prints_counts_in_it_as_in_the_model() -> None:
    """A quarter of a second."""
    down, up = _meet()
    loop = replace(down.visits[1], standing=Standing.MAY)
    trains = [replace(down, visits=(down.visits[0], loop, down.visits[2])), up]
    assert gap_of(trains, replace(_late(by_s=0), bound_s=30.0), 300)[0] == 0.25


def test_a_stretch_in_which_next_to_nothing_is_gained_comes_last(monkeypatch: pytest.MonkeyPatch) -> None:
    """One in which each step gains a second is left for those of other lengths; it has the work that is left, then."""
    asked: list[int] = []
    told: list[str] = []

    def gains_a_second(*_given: object) -> tuple[Arranged, float]:
        asked.append(1)
        return _late(by_s=500 - len(asked)), 0.0

    monkeypatch.setattr(search, "_better", gains_a_second)
    improved(_meet(), _late(by_s=500), 300, {}, work_max=10 * search.BUILDING_WORK, tell=told.append)
    first = [text.split(",")[0] for text in told[:4]]
    assert first == [f"better in steps of {span} min" for span in (60, 120, 180, 60)]
    assert len(asked) > len(first)


def test_any_plan_keeps_trains_apart() -> None:
    plan = ArrangeModel(_meet(), 300, 300).solve(0.1, Aim.ANY)
    assert plan.visits["2"][1].departure_s >= plan.visits["1"][1].arrival_s >= NOON + 300
    assert not plan.proven


def _two_sets() -> list[TrainToArrange]:
    """Two sets that stand at A in the morning, where there is one track."""
    tracks = {"A": ("A.1",), "B": ("B.1", "B.2")}
    return [_train(str(n), "AB", NOON + 3600 * n, tracks=tracks) for n in (1, 2)]


def test_the_track_that_lacks_is_named() -> None:
    with pytest.raises(NothingFoundError) as why:
        nearest_plan([_two_sets()], 300)
    either = [MoreTracks({"A": 1}, 0, {"A": (number,)}) for number in ("1", "2")]
    assert why.value.lacking in either


def _by_a_halt() -> list[TrainToArrange]:
    """Those of the meet where L has no tracks."""
    through = replace(RUN, stop_stop=300)
    found: list[TrainToArrange] = []
    for train in _meet():
        first, loop, last = train.visits
        way = Leg(("A-B",), ByStanding(0, 0), ByStanding(0, 0))
        halt = replace(loop, tracks=(), leg=None, run=through)
        found.append(replace(train, visits=(first, halt, replace(last, leg=way))))
    return found


def _room(days: Sequence[Day], *, room: bool = True) -> Halts:
    along_m = {"A": 0.0, "L": 3000.0, "B": 6000.0}
    return Halts(frozenset({"L"}), along_m, lambda _: room, lambda at: days if tuple(at) == ("L",) else ())


def test_the_halt_at_which_trains_could_meet_is_named_with_them() -> None:
    """Down is to leave A at noon, where up comes 300 s after it has left L, 270 s after noon."""
    plan = nearest_plan([_by_a_halt()], 60, _room([_meet()]))
    assert max(move.by_s for move in plan.arranged.moves) == 570
    assert plan.lacking == MoreTracks({"L": 1}, 30, {"L": ("1", "2")})
    assert plan.none_within_s == 300


def test_of_many_trains_no_plan_is_looked_for_that_moves_times_far_where_a_track_would_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """570 s are the least, as above: not looked for beyond 300, but where 500 are allowed."""
    monkeypatch.setattr(nearest, "WIDE_TRAINS_MAX", 1)
    monkeypatch.setattr(nearest, "FAR_S", 300)
    with pytest.raises(
        NothingFoundError, match=r"^proven: no plan moves every time by 300 s or less$"
    ) as why:
        nearest_plan([_by_a_halt()], 60, _room([_meet()]))
    assert why.value.lacking == MoreTracks({"L": 1}, 30, {"L": ("1", "2")})
    plan = nearest_plan([_by_a_halt()], 500, _room([_meet()]))
    assert max(move.by_s for move in plan.arranged.moves) == 570


def test_a_train_of_which_no_arrival_is_printed_has_time_to_come() -> None:
    """It runs for 3,000 s after the last time that is printed of the day."""
    first, last = _train("1", "AB", NOON, tracks=TRACKS).visits
    late = replace(last, run=RunSeconds(3000, 3000, 3000, 3000))
    plan = ArrangeModel([train_of("1", (first, late))], 300, 300).solve(0.1)
    assert plan.visits["1"][-1].arrival_s == NOON + 3000


def _by_open_track() -> list[TrainToArrange]:
    """Those of the meet on a line without a place between A and B, which takes 600 s: they pass L's place at 280 s."""
    found: list[TrainToArrange] = []
    for train in _by_a_halt():
        first, _, last = train.visits
        run = RunSeconds(600, 590, 590, 560)
        found.append(replace(train, visits=(replace(first, departure_s=NOON), replace(last, run=run))))
    return found


def _by_the_middle() -> Halts:
    """Room for a signal station there, with which the meet is as with a loop."""
    laid: list[TrainToArrange] = []
    for train in _meet():
        first, loop, last = train.visits
        here = replace(loop, station_id="A.B", departure_s=None)
        laid.append(replace(train, visits=(replace(first, departure_s=NOON), here, last)))
    along_m = {"A": 0.0, "B": 6000.0, "A.B": 3000.0}
    return Halts(
        frozenset({"A.B"}),
        along_m,
        lambda _: True,
        lambda at: [laid] if tuple(at) == ("A.B",) else (),
        {frozenset(("A", "B")): "A.B"},
    )


def test_the_signal_station_where_trains_could_meet_is_named_with_them() -> None:
    """Both are to leave at noon, by a way of 600 s."""
    plan = nearest_plan([_by_open_track()], 60, _by_the_middle())
    assert max(move.by_s for move in plan.arranged.moves) == 600
    assert plan.lacking is not None
    assert (plan.lacking.by_station, plan.lacking.trains) == ({"A.B": 1}, {"A.B": ("1", "2")})


def test_tracks_that_the_line_with_a_second_track_lacks_besides_are_named_too() -> None:
    """Laid with a loop, L's day still has a third set at A, which has two tracks: one more is for it."""
    days = [*_meet(), _train("3", "AB", NOON + 7200, tracks={**TRACKS, "A": ("A.2",)})]
    found = more_tracks([_by_a_halt()], _room([days]), 60)
    assert found is not None
    assert found.by_station == {"L": 1, "A": 1}


def test_half_a_way_takes_half_its_time_and_a_stop_more() -> None:
    """280 s through, 10 s more for a start and for a stop: 140 s to the middle, 150 and 160 s with one and both."""
    assert RUN.half() == RunSeconds(160, 150, 150, 140)


def test_a_halt_without_room_for_a_second_track_is_not_named() -> None:
    assert nearest_plan([_by_a_halt()], 60, _room([_meet()], room=False)).lacking is None


def test_a_second_track_that_does_not_hold_on_the_line_with_it_is_not_named() -> None:
    """What the choice leaves out: here that nobody can leave L before 400 s, so that up is moved by 130 s there."""
    late = [replace(train, visits=train.visits) for train in _meet()]
    first, loop, last = late[0].visits
    late[0] = replace(late[0], visits=(first, replace(loop, run=replace(RUN, stop_stop=400)), last))
    assert nearest_plan([_by_a_halt()], 60, _room([late])).lacking is None


def test_a_track_that_nobody_needs_is_not_asked_for() -> None:
    """Of two sets that begin at the two tracks of A one is thought to stand on a third."""
    trains = [_train(str(n), "AB", NOON + 3600 * n, tracks=TRACKS) for n in (1, 2)]
    visits: dict[str, tuple[ArrangedVisit, ...]] = {
        str(n): (
            ArrangedVisit("A", NOON + 3600 * n, NOON + 3600 * n, True, track),
            ArrangedVisit("B", NOON + 3600 * n + 300, NOON + 3600 * n + 300, True, f"B.{n}"),
        )
        for n, track in ((1, "A.1"), (2, ANOTHER))
    }
    plan, _ = with_fewer_tracks(trains, Arranged(visits, (), False, 0.0, 300, 0.0, {"A": 1}), 300, 0.5)
    assert plan.more_tracks == {}
    assert {own[0].track for own in plan.visits.values()} == {"A.1", "A.2"}


@pytest.mark.parametrize(
    ("place", "printed"),
    [({"first": True}, (None, NOON)), ({"last": True}, (NOON - 840, None)), ({}, (NOON - 840, NOON))],
)
def test_what_is_printed_for_before_and_after_the_line_counts_for_nothing(
    place: dict[str, bool], printed: tuple[int | None, int | None]
) -> None:
    """A train from another line stands 14 min where this one begins: it is nobody's move that it leaves from there."""
    call = Call("A", None, NOON - 840, NOON)
    found = _printed(call, CallTable(station="A"), True, **{"first": False, "last": False, **place})
    assert (found.arrival_s, found.departure_s) == printed
