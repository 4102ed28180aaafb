"""The nearest plan on lines small enough to reckon by hand: A, a loop L and B, each run 300 s, a stop 20 s."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import pytest

from plan.arranging import model
from plan.arranging.arrange import nearest_plan
from plan.arranging.problem import (
    Arranged,
    ByStanding,
    Leg,
    PrintedMove,
    RunSeconds,
    Standing,
    TrainToArrange,
    Visit,
)

NONE = ByStanding(0, 0)
RUN = RunSeconds(300, 290, 290, 280)
NOON = 43_200


def _visit(
    station: str, arrival_s: int | None = None, departure_s: int | None = None, **more: object
) -> Visit:
    found = Visit(station, Standing.ALWAYS, arrival_s, departure_s, 20, RUN, None, (f"{station}.1",))
    return replace(found, **more)


def _train(number: str, *visits: Visit, **more: object) -> TrainToArrange:
    """A train whose legs hold what lies between its stations, as long as it is there."""
    legs = [
        replace(there, leg=Leg(("-".join(sorted((here.station_id, there.station_id))),), NONE, NONE))
        for here, there in pairwise(visits)
    ]
    return replace(TrainToArrange(number, (replace(visits[0], run=None), *legs)), **more)


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
    plan = nearest_plan([[_down(), _up(NOON + 270)]], limit_s=300)[1]
    assert plan.moves == (PrintedMove("2", "L", "departure", NOON + 270, 30),)
    assert plan.proven
    assert plan.bound_s == pytest.approx(30.0, abs=0.5)


def test_without_exclusion_nothing_is_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model, "EXCLUSIVE", False)
    assert nearest_plan([[_down(), _up(NOON + 270)]], limit_s=300)[1].moves == ()


def test_what_can_not_be_within_the_limit_is_told_by_the_least_that_would_do() -> None:
    plan = nearest_plan([[_down(), _up(NOON + 270)]], limit_s=10)[1]
    beyond = [move for move in plan.moves if move.by_s > 10]
    assert beyond == [PrintedMove("2", "L", "departure", NOON + 270, 30)]


def test_a_time_that_is_not_printed_costs_nothing() -> None:
    plan = nearest_plan([[_down(), _up(NOON, loop=_visit("L", tracks=("L.2",)))]], limit_s=300)[1]
    assert plan.moves == ()
    assert _times(plan, "2", "L")[1] >= NOON + 300


def test_a_train_without_an_arrival_comes_when_it_can_run() -> None:
    plan = nearest_plan([[_down()]], limit_s=300)[1]
    arrives_s, departs_s = _times(plan, "1", "L")
    assert (arrives_s, departs_s) == (NOON + 300, NOON + 400) or NOON + 300 <= arrives_s <= departs_s - 20
    assert _times(plan, "1", "B")[0] >= NOON + 700


def test_trains_stand_at_a_signal_station_only_where_they_meet_there() -> None:
    through = replace(_visit("L", tracks=("L.1",)), standing=Standing.MAY, stay_s=10)
    alone = nearest_plan([[_down(through)]], limit_s=300)[1]
    assert not alone.visits["1"][1].stands
    met = nearest_plan(
        [[_down(through), _up(NOON + 500, loop=replace(through, tracks=("L.2",)))]], limit_s=300
    )[1]
    # The up train would be through L 10 s before noon, and has to let the down train come: 290 s to a stand.
    assert met.visits["2"][1].stands
    assert met.moves == ()


def test_a_train_that_came_down_goes_back_up_on_the_track_on_which_it_stands() -> None:
    both = ("B.1", "B.2")
    down = _train("1", _visit("A", departure_s=NOON), _visit("B", tracks=both))
    back = _train(
        "3", _visit("B", departure_s=NOON + 330, tracks=both[::-1]), _visit("A"), follows="1", turn_s=60
    )
    plan = nearest_plan([[down, back]], limit_s=300)[1]
    assert plan.moves == (PrintedMove("3", "B", "departure", NOON + 330, 30),)
    assert plan.visits["1"][-1].track == plan.visits["3"][0].track


def test_more_sets_than_tracks_are_refused() -> None:
    sets: Sequence[TrainToArrange] = [
        _train(str(n), _visit("A", departure_s=NOON + 3600 * n), _visit("B", tracks=(f"B.{n}",)))
        for n in (1, 2)
    ]
    with pytest.raises(model.NoRoomError):
        nearest_plan([sets], limit_s=300)
