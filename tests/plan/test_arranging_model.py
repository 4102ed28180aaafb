"""The nearest plan on lines small enough to reckon by hand: A, a loop L and B, each run 300 s, a stop 20 s."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from network.timetable import Call
from plan.arranging import model
from plan.arranging.draft import PrintedCall, stations_beside_another
from plan.arranging.nearest import NothingFoundError, nearest_plan
from plan.arranging.problem import (
    Arranged,
    ArrangedVisit,
    ByStanding,
    Leg,
    PrintedMove,
    SlowerTrack,
    Standing,
    TrainToArrange,
    Visit,
)
from plan.arranging.written import moves_of_day, soonest
from tests.plan.small_day import NOON, RUN, train_of


def _visit(
    station: str, arrival_s: int | None = None, departure_s: int | None = None, **more: object
) -> Visit:
    found = Visit(station, Standing.ALWAYS, arrival_s, departure_s, 20, RUN, None, (f"{station}.1",))
    return replace(found, **more)


def _train(number: str, *visits: Visit, **more: object) -> TrainToArrange:
    return replace(train_of(number, visits), **more)


def _down(loop: Visit | None = None) -> TrainToArrange:
    at_loop = loop or _visit("L", departure_s=NOON + 400, tracks=("L.1",))
    return _train("1", _visit("A", departure_s=NOON), at_loop, _visit("B", tracks=("B.1",)))


def _up(leaves_s: int, loop: Visit | None = None) -> TrainToArrange:
    at_loop = loop or _visit("L", departure_s=leaves_s, tracks=("L.2",))
    return _train(
        "2", _visit("B", departure_s=NOON - 300, tracks=("B.2",)), at_loop, _visit("A", tracks=("A.2",))
    )


def _times(plan: Arranged, number: str, station: str) -> tuple[int, int]:
    visit = next(v for v in plan.visits[number] if v.station_id == station)
    return visit.arrival_s, visit.departure_s


def test_one_departure_is_moved_by_30_s_where_that_is_the_least() -> None:
    # The down train is at the loop 300 s after noon, so that the up train cannot leave it at 270 s.
    plan = nearest_plan([[_down(), _up(NOON + 270)]], limit_s=300).arranged
    assert plan.moves == (PrintedMove("2", "L", "departure", NOON + 270, 30),)
    assert plan.proven
    assert plan.bound_s == pytest.approx(30.0, abs=0.5)


def test_without_exclusion_nothing_is_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model, "EXCLUSIVE", False)
    assert nearest_plan([[_down(), _up(NOON + 270)]], limit_s=300).arranged.moves == ()


def test_what_can_not_be_within_the_limit_is_told_by_the_least_that_would_do() -> None:
    plan = nearest_plan([[_down(), _up(NOON + 270)]], limit_s=10).arranged
    beyond = [move for move in plan.moves if move.by_s > 10]
    assert beyond == [PrintedMove("2", "L", "departure", NOON + 270, 30)]


def test_a_time_that_is_not_printed_costs_nothing() -> None:
    plan = nearest_plan([[_down(), _up(NOON, loop=_visit("L", tracks=("L.2",)))]], limit_s=300).arranged
    assert plan.moves == ()
    assert _times(plan, "2", "L")[1] >= NOON + 300


def test_a_train_without_an_arrival_comes_when_it_can_run() -> None:
    plan = nearest_plan([[_down()]], limit_s=300).arranged
    arrives_s, departs_s = _times(plan, "1", "L")
    assert (arrives_s, departs_s) == (NOON + 300, NOON + 400) or NOON + 300 <= arrives_s <= departs_s - 20
    assert _times(plan, "1", "B")[0] >= NOON + 700


def test_trains_stand_at_a_signal_station_only_where_they_meet_there() -> None:
    through = replace(_visit("L", tracks=("L.1",)), standing=Standing.MAY, stay_s=10)
    alone = nearest_plan([[_down(through)]], limit_s=300).arranged
    assert not alone.visits["1"][1].stands
    met = nearest_plan(
        [[_down(through), _up(NOON + 500, loop=replace(through, tracks=("L.2",)))]], limit_s=300
    ).arranged
    # The up train would be through L 10 s before noon, and has to let the down train come: 290 s to a stand.
    assert met.visits["2"][1].stands
    assert met.moves == ()


def test_a_train_that_came_down_goes_back_up_on_the_track_on_which_it_stands() -> None:
    both = ("B.1", "B.2")
    down = _train("1", _visit("A", departure_s=NOON), _visit("B", tracks=both))
    back = _train(
        "3", _visit("B", departure_s=NOON + 330, tracks=both[::-1]), _visit("A"), follows="1", turn_s=60
    )
    plan = nearest_plan([[down, back]], limit_s=300).arranged
    assert plan.moves == (PrintedMove("3", "B", "departure", NOON + 330, 30),)
    assert plan.visits["1"][-1].track == plan.visits["3"][0].track


def _against(limit_s: int) -> Arranged:
    """Down has the line until it comes, printed at 360 s and possible at 300; up is to leave at 330."""
    down = _train("1", _visit("A", departure_s=NOON), _visit("B", arrival_s=NOON + 360, tracks=("B.1",)))
    up = _train("2", _visit("B", departure_s=NOON + 330, tracks=("B.2",)), _visit("A", tracks=("A.2",)))
    return nearest_plan([[down, up]], limit_s).arranged


def test_an_arrival_before_its_print_counts_as_one_after_it() -> None:
    plan = _against(limit_s=300)
    assert sum(abs(move.by_s) for move in plan.moves) == 30
    assert plan.bound_s == pytest.approx(30.0, abs=0.5)


def test_of_two_plans_with_the_same_moves_the_one_that_keeps_to_the_minute() -> None:
    """Down 30 s early, or up 30 s late, which is in the minute that is printed."""
    assert _against(limit_s=300).moves == (PrintedMove("2", "B", "departure", NOON + 330, 30),)


def test_two_moves_within_the_limit_are_better_than_one_beyond_it() -> None:
    moves = {(move.number, move.by_s) for move in _against(limit_s=15).moves}
    assert moves == {("1", -15), ("2", 15)}


def test_no_run_is_shorter_than_it_is_for_a_train_that_starts_or_stops() -> None:
    """From a stand at A by L, where it passes, to a stand at B: 290 s and 290 s."""
    train = _train(
        "1",
        _visit("A", departure_s=NOON),
        replace(_visit("L", tracks=("L.1",)), standing=Standing.MAY),
        _visit("B", arrival_s=NOON + 570),
    )
    assert nearest_plan([[train]], limit_s=300).arranged.moves == (
        PrintedMove("1", "B", "arrival", NOON + 570, 10),
    )


@pytest.mark.parametrize(("standing", "moved_s"), [(Standing.ALWAYS, 65), (Standing.MAY, 65)])
def test_a_way_is_held_before_a_train_leaves_and_after_it_has_come(standing: Standing, moved_s: int) -> None:
    """Down is at the loop at 300 s and clear 15 s after; up, to leave there at 270 s, asks 20 s before it leaves."""
    held = Leg(("A-L",), ByStanding(20, 21), ByStanding(15, 16))

    def with_ways(train: TrainToArrange) -> TrainToArrange:
        visits = tuple(
            v if v.leg is None or "A-L" not in v.leg.section_ids else replace(v, leg=held)
            for v in train.visits
        )
        return replace(train, visits=visits)

    loop = _visit("L", departure_s=NOON + 270, standing=standing, tracks=("L.2",))
    plan = nearest_plan([[with_ways(_down()), with_ways(_up(NOON + 270, loop))]], limit_s=300).arranged
    assert plan.moves == (PrintedMove("2", "L", "departure", NOON + 270, moved_s),)


def test_what_is_moved_is_told_by_the_minute_and_for_each_printed_time() -> None:
    """Of five printed times four are moved: three are no longer in the minute that is printed."""
    moves = [PrintedMove("1", "A", "departure", NOON, by_s) for by_s in (-1, 59, 60, 120)]
    call = Call("A", None, NOON, NOON)
    printed = {"1": [PrintedCall(call, NOON, NOON)] * 2 + [PrintedCall(call, None, NOON)]}
    found = moves_of_day(printed, moves)
    assert (found.printed, found.moved, found.past_minute) == (5, 4, 3)
    assert (found.total_s, found.worst_s, found.mean_s) == (240, 120, 48.0)


def test_an_arrival_is_as_soon_as_it_can_be_but_not_before_its_print() -> None:
    for printed_s, comes_s in ((None, 300), (NOON + 400, 400)):
        train = _train("1", _visit("A", departure_s=NOON), _visit("B", arrival_s=printed_s))
        plan = (
            ArrangedVisit("A", NOON, NOON, True, "A.1"),
            ArrangedVisit("B", NOON + 500, NOON + 500, True, "B.1"),
        )
        assert soonest(train, plan, {})[1].arrival_s == NOON + comes_s


def test_more_sets_than_tracks_are_refused() -> None:
    sets: Sequence[TrainToArrange] = [
        _train(str(n), _visit("A", departure_s=NOON + 3600 * n), _visit("B", tracks=(f"B.{n}",)))
        for n in (1, 2)
    ]
    with pytest.raises(NothingFoundError):
        nearest_plan([sets], limit_s=300)


def _comes_in(train: TrainToArrange) -> TrainToArrange:
    """With leave to come in at L: from 40 s before it is there until 1 s after."""
    visits = [
        replace(
            v, leg=replace(v.leg, overlaps=("L overlap",), enters=ByStanding(40, 40), stood=ByStanding(1, 1))
        )
        if v.station_id == "L" and v.leg is not None
        else v
        for v in train.visits
    ]
    return replace(train, visits=tuple(visits))


def test_a_meet_is_moved_by_just_the_seconds_by_which_one_comes_in_later() -> None:
    """Both could be at L at noon + 300 and leave 20 s later. One comes 41 s after the other, and leaves 41 s later; the
    other can leave for where that came from when it has come, at noon + 341.
    """
    at_loop = _visit("L", departure_s=NOON + 320, tracks=("L.1",))
    visits = _visit("B", departure_s=NOON, tracks=("B.2",)), replace(at_loop, tracks=("L.2",))
    down, up = _down(at_loop), _train("2", *visits, _visit("A", tracks=("A.2",)))
    assert nearest_plan([[down, up]], limit_s=300).arranged.moves == ()
    plan = nearest_plan([[_comes_in(down), _comes_in(up)]], limit_s=300).arranged
    assert sorted(move.by_s for move in plan.moves) == [21, 41]
    assert plan.proven
    assert abs(_times(plan, "1", "L")[0] - _times(plan, "2", "L")[0]) >= 41


def _moves(*trains: TrainToArrange, limit_s: int = 300) -> dict[str, int]:
    """By how much each train's printed times are moved in all, s."""
    found = {train.number: 0 for train in trains}
    for move in nearest_plan([trains], limit_s).arranged.moves:
        found[move.number] += move.by_s
    return found


def test_a_train_stands_for_its_stay() -> None:
    """At the loop 300 s after noon, and 20 s there."""
    assert _moves(_down(_visit("L", departure_s=NOON + 310))) == {"1": 10}


def test_a_train_that_leaves_later_comes_as_much_later() -> None:
    """Up leaves the loop 30 s late, and is printed to come 300 s after it should have left."""
    up = _up(NOON + 270)
    late = replace(up, visits=(*up.visits[:2], replace(up.visits[2], arrival_s=NOON + 570)))
    assert _moves(_down(), late) == {"1": 0, "2": 60}


def test_a_train_that_would_have_to_dawdle_stops_instead() -> None:
    """It is to leave L at 600 s: running through it is there at 362 s at the latest, a quarter later than it could."""
    loop = replace(_visit("L", departure_s=NOON + 600, tracks=("L.1",)), standing=Standing.MAY)
    plan = nearest_plan([[_down(loop)]], limit_s=300).arranged
    assert plan.moves == ()
    assert plan.visits["1"][1].stands


def test_an_arrival_is_a_minute_early_at_most() -> None:
    """Down is printed to come at 500 s, and could at 300; up is to leave for where it comes from at 330 s."""
    down = _train("1", _visit("A", departure_s=NOON), _visit("B", arrival_s=NOON + 500, tracks=("B.1",)))
    up = _train("2", _visit("B", departure_s=NOON + 330, tracks=("B.2",)), _visit("A", tracks=("A.2",)))
    assert _moves(down, up, limit_s=100) == {"1": -60, "2": 110}


def _by_portal(number: str, leaves_s: int, other: str) -> TrainToArrange:
    """Over a portal at A, on a track and a way of its own."""
    visits = _visit("A", departure_s=leaves_s, tracks=(f"A.{number}",)), _visit(other)
    return _train(number, *visits, enters="P")


def test_a_portal_is_one_trains_at_a_time() -> None:
    """Each has it for the 180 s before it leaves A."""
    assert _moves(_by_portal("1", NOON, "L"), _by_portal("2", NOON + 60, "M")) == {"1": 0, "2": 120}


def test_a_portal_is_a_trains_until_it_has_gone() -> None:
    """One comes to A 300 s after noon and goes by the portal until 480 s; the other has it for 180 s from 420 s on."""
    leaves = _train(
        "1", _visit("L", departure_s=NOON), _visit("A", arrival_s=NOON + 300, tracks=("A.1",)), leaves="P"
    )
    assert _moves(leaves, _by_portal("2", NOON + 600, "M")) == {"1": 0, "2": 60}


def test_a_set_stands_where_it_waits_for_its_next_train() -> None:
    """It comes to the only track of B 300 s after noon, and leaves at 1000 s; the other is to leave A at 400 s, and can
    be there when the way is free again, and the track: its run begins when the set is back at A, at 1300 s.
    """
    down = _train("1", _visit("A", departure_s=NOON), _visit("B"))
    back = _train("3", _visit("B", departure_s=NOON + 1000), _visit("A", tracks=("A.2",)), follows="1")
    other = _train("2", _visit("A", departure_s=NOON + 400, tracks=("A.3",)), _visit("B"))
    assert _moves(down, back, other, limit_s=1200) == {"1": 0, "3": 0, "2": 900}


def test_a_set_that_ends_its_day_stands_there_for_the_night() -> None:
    trains = [
        _train(str(n), _visit("A", departure_s=NOON + 3600 * n, tracks=(f"A.{n}",)), _visit("B"))
        for n in (1, 2)
    ]
    with pytest.raises(NothingFoundError):
        nearest_plan([trains], limit_s=300)


@pytest.mark.parametrize("limit_s", [0, 300])
def test_nobody_waits_on_the_way_until_the_night_is_over(limit_s: int) -> None:
    """The second could wait at the loop, of which nothing is printed, but B has one track, and a set on it for good."""
    loop = _visit("L", tracks=("L.1",))
    trains = [
        _train(str(n), _visit("A", departure_s=NOON + 3600 * n, tracks=(f"A.{n}",)), loop, _visit("B"))
        for n in (1, 2)
    ]
    with pytest.raises(NothingFoundError):
        nearest_plan([trains], limit_s)


def test_a_train_takes_another_track_where_its_own_is_taken() -> None:
    """Two that end at B for the night, each with both tracks to choose from: not both on the usual one."""
    both = ("B.1", "B.2")
    trains = [
        _train(str(n), _visit("A", departure_s=NOON + 3600 * n, tracks=(f"A.{n}",)), _visit("B", tracks=both))
        for n in (1, 2)
    ]
    plan = nearest_plan([trains], limit_s=300).arranged
    assert {plan.visits[number][-1].track for number in ("1", "2")} == set(both)


def _follower(after_s: int, number: str = "2", usual: str = "L.1") -> TrainToArrange:
    at_loop = _visit("L", departure_s=NOON + after_s + 400, tracks=(usual, "L.3"))
    return _train(number, _visit("A", departure_s=NOON + after_s), at_loop, _visit("B"))


def _beside_at_loop(*trains: TrainToArrange, late_s: int = 300) -> list[str]:
    return [number for number, where in stations_beside_another(trains, late_s).items() if "L" in where]


def test_tracks_are_chosen_where_two_with_the_same_could_be_at_once() -> None:
    """The first leaves L 400 s after noon, has its track for the 300 s to B, and may be 300 s late: until 1,000 s. The
    second needs it from when it leaves A, 300 s before it comes.
    """
    assert sorted(_beside_at_loop(_follower(0, "1"), _follower(1000))) == ["1", "2"]
    assert _beside_at_loop(_follower(0, "1"), _follower(1001)) == []
    assert sorted(_beside_at_loop(_follower(0, "1"), _follower(1001), late_s=301)) == ["1", "2"]
    assert _beside_at_loop(_follower(0, "1"), _follower(0, usual="L.2")) == []


def test_by_print_alone_tracks_are_chosen_where_two_are_there_at_once() -> None:
    """The first is at L from 300 to 400 s after noon, the second comes 300 s after it leaves A."""
    assert sorted(_beside_at_loop(_follower(0, "1"), _follower(100), late_s=0)) == ["1", "2"]
    assert _beside_at_loop(_follower(0, "1"), _follower(101), late_s=0) == []


def test_an_opposing_train_with_the_same_track_may_take_another() -> None:
    assert sorted(_beside_at_loop(_follower(0, "1"), _up(NOON + 300, _visit("L")))) == ["1", "2"]


def test_who_stands_on_the_other_track_of_two_may_make_way() -> None:
    up = _up(NOON + 300, _visit("L", tracks=("L.2", "L.3")))
    assert sorted(_beside_at_loop(_follower(0, "1"), _follower(0, "3"), up)) == ["1", "2", "3"]


@pytest.mark.parametrize(("only", "moved_s"), [("L.1", 0), ("L.2", 12), ("both", 0)])
def test_a_run_takes_longer_on_a_slower_track(only: str, moved_s: int) -> None:
    """To stand on L.2 takes 5 s longer, and to go on from there 7 s; printed is what it takes by L.1."""
    slower = (SlowerTrack("L.2", ByStanding(5, 3), ByStanding(7, 2)),)
    tracks = ("L.1", "L.2") if only == "both" else (only, "L.3")
    loop = _visit("L", tracks=tracks, slower=slower)
    train = _train("1", _visit("A", departure_s=NOON), loop, _visit("B", arrival_s=NOON + 620))
    taken = [_train("2", _visit("A", departure_s=NOON - 900, tracks=("A.2",)), _visit("L", tracks=("L.3",)))]
    plan = nearest_plan([[train, *taken]], limit_s=300).arranged
    assert sum(move.by_s for move in plan.moves) == moved_s
    arrives_s = NOON + 300 + (5 if only == "L.2" else 0)
    assert soonest(train, plan.visits["1"], {})[1].arrival_s == arrives_s
