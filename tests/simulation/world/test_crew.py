"""The crew of a train on sight: where it stops, what it looks at, what it lets pass (Sugiyama, section 4.4 (3))."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import msgspec
import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Position
from network.timetable import load_timetable
from onboard.duty.records import AtMark, DrivingCommand, EndOfHeld, PointsSeen, PointsWrong
from onboard.mission import Mission, plan_mission
from onboard.notes import CrewCheckedPoints, CrewWaitsAtPoints
from onboard.plan import plan_of
from simulation.journal import Journal
from simulation.world.crew import SEES_M, Crew
from simulation.world.point_machine import KeyBack, LockedByHand, PointMachine, step
from wayside.said import StartThrow

LENGTH_M = 40.0


@pytest.fixture(scope="module")
def mission() -> Mission:
    line = load_line(shipped_line("rtri_test_line"))
    timetable = load_timetable(shipped_timetable("rtri_test_line"), line)
    return plan_mission(line, timetable.trains["T1"], "3", None, None)


class Cab:
    """One train on sight that truly stands at `front_m` of the mission's path, its unit showing `sections` as held."""

    def __init__(self, mission: Mission, front_m: float, *sections: str) -> None:
        self.mission = mission
        self.plan = plan_of(mission, LENGTH_M)
        self.shown = DrivingCommand(on_sight=True, on_line=True, held=sections)
        self.on_sight = True
        self.truth: Any = SimpleNamespace(
            position_m=front_m, sight_m=math.inf, track_end_m=math.inf, active=1
        )
        self.occupied = False
        self.ahead_m = math.inf
        self.plant: Any = SimpleNamespace(speed_mps=0.0)
        self.journal = Journal()
        trains: Any = SimpleNamespace(
            stock_ids=("K1",),
            truths=[self.truth],
            plants=[self.plant],
            bodies=[SimpleNamespace(length_m=LENGTH_M)],
            duties=[SimpleNamespace(mission=mission)],
            stands_in=lambda _section_id: self.occupied,
            train_ahead_m=lambda _slot: self.ahead_m,
        )
        on_board: Any = SimpleNamespace(
            plan=lambda _slot: self.plan,
            shown_to_driver=lambda _slot: self.shown,
            drives_on_sight=lambda _slot: self.on_sight,
            unpowered=set[int](),
        )
        self.trains, self.duties = trains, trains.duties
        self.machine = PointMachine("P7", 6.0, Position.NORMAL)
        self.crossings: Any = SimpleNamespace(on_line=())
        self.crew = Crew(trains, on_board, cast("Any", self), self.journal)

    @property
    def machines(self) -> dict[str, PointMachine]:
        return {"P7": self.machine}

    def lock_by_hand(self, _step: int, _points_id: str, unit_id: str) -> None:
        self.machine = step(self.machine, LockedByHand(unit_id), 0.0)

    def give_key_back(self, _step: int, _points_id: str, unit_id: str) -> None:
        self.machine = step(self.machine, KeyBack(unit_id), 0.0)

    def sight_m(self) -> float:
        self.crew.look_ahead(0)
        return float(self.truth.sight_m)

    def start_m(self, section: str) -> float:
        return self.mission.spans[self.mission.span_index(section)].start_m


def test_it_stops_before_points_that_are_not_proven(mission: Mission) -> None:
    cab = Cab(mission, 0.0, "6", "7", "8")
    cab.truth.position_m = cab.start_m("6") + 50.0
    assert cab.sight_m() == cab.start_m("7")


def test_points_proven_or_looked_at_are_passed_to_the_mark(mission: Mission) -> None:
    cab = Cab(mission, 0.0, "6", "7", "8")
    cab.truth.position_m = cab.start_m("6") + 50.0
    proven = cab.plan.spans[mission.span_index("7")].points
    cab.shown = msgspec.structs.replace(cab.shown, proven=proven)
    assert cab.sight_m() == pytest.approx(mission.targets[-1].mark_m + 2.0)
    cab.shown = msgspec.structs.replace(cab.shown, within_section=True)
    assert cab.sight_m() == cab.start_m("7")


@pytest.mark.parametrize("beyond_m", [-0.9, -0.1, 0.5])
def test_a_mark_counts_until_the_driver_has_it_behind_him(mission: Mission, beyond_m: float) -> None:
    """Whatever makes him look again in the last metre: the train has not stopped there yet."""
    cab = Cab(mission, 0.0, "3", "5", "6", "7", "8", "10")
    mark_m = mission.targets[-1].mark_m
    cab.truth.position_m, cab.plant.speed_mps = mark_m + beyond_m, 0.3
    assert cab.sight_m() == pytest.approx(mark_m + 2.0)
    cab.truth.position_m = mark_m + 2.5
    assert cab.sight_m() > mark_m + 2.0


@pytest.mark.parametrize("beyond_m", [-1.5, 0.4, 3.0])
def test_who_stands_at_a_mark_goes_on_when_he_has_said_so(mission: Mission, beyond_m: float) -> None:
    """However far the train would still draw up, and whatever its unit would have it do."""
    cab = Cab(mission, 0.0, "3", "5", "6", "7", "8", "10")
    last = len(mission.targets) - 1
    cab.truth.position_m = mission.targets[-1].mark_m + beyond_m
    assert cab.sight_m() == cab.truth.position_m
    assert cab.crew.stand(0, 10.0) == [AtMark(last, 0.0)]
    cab.shown = msgspec.structs.replace(cab.shown, stands_at=last, at=last)
    assert cab.sight_m() > cab.truth.position_m + 2.0


def test_it_does_not_leave_what_is_held(mission: Mission) -> None:
    cab = Cab(mission, 0.0, "3")
    cab.truth.position_m = mission.targets[0].mark_m
    assert cab.sight_m() < cab.start_m("5")


def test_a_unit_that_knows_where_it_is_drives_itself(mission: Mission) -> None:
    cab = Cab(mission, 100.0, "6", "7", "8")
    cab.on_sight = False
    cab.shown = msgspec.structs.replace(cab.shown, on_sight=False)
    assert cab.sight_m() == math.inf
    assert cab.crew.stand(0, 10.0) == []


def test_who_is_still_moving_looks_at_nothing(mission: Mission) -> None:
    """Whatever the tachometer shows: the plant's own speed counts."""
    cab = standing_before_points(mission)
    cab.plant.speed_mps = 0.3
    assert cab.crew.stand(0, 10.0) == []
    assert not cab.journal.entries


def standing_before_points(mission: Mission) -> Cab:
    cab = Cab(mission, 0.0, "6", "7", "8")
    cab.truth.position_m = cab.start_m("7") - SEES_M / 2.0
    return cab


def test_points_that_lie_right_and_locked_may_be_passed(mission: Mission) -> None:
    cab = standing_before_points(mission)
    (needed,) = cab.plan.spans[mission.span_index("7")].points
    assert cab.crew.stand(0, 10.0) == [PointsSeen(needed)]
    assert isinstance(cab.journal.entries[-1].event, CrewCheckedPoints)


def test_what_it_has_seen_stays_so_until_the_rear_has_left(mission: Mission) -> None:
    cab = standing_before_points(mission)
    cab.crew.stand(0, 10.0)
    end_m = mission.spans[mission.span_index("7")].end_m
    for front_m in (cab.start_m("7") + 1.0, end_m, end_m + LENGTH_M - 0.1):
        cab.truth.position_m = front_m
        cab.crew.give_keys_back(0, 20.0)
        assert step(cab.machine, StartThrow("P7", Position.REVERSE), 20.0) == cab.machine
    cab.truth.position_m = end_m + LENGTH_M
    cab.crew.give_keys_back(0, 30.0)
    assert step(cab.machine, StartThrow("P7", Position.REVERSE), 30.0).target is Position.REVERSE


@pytest.mark.parametrize("goes_elsewhere", ["left the line", "another mission", "no longer its holder"])
def test_nothing_stays_locked_for_a_train_that_goes_elsewhere(mission: Mission, goes_elsewhere: str) -> None:
    cab = standing_before_points(mission)
    cab.crew.stand(0, 10.0)
    assert cab.machine.key == "K1"
    if goes_elsewhere == "left the line":
        cab.truth.active = 0
    elif goes_elsewhere == "another mission":
        cab.duties[0] = SimpleNamespace(mission=replace(mission, number="T2"))
    else:
        cab.shown = msgspec.structs.replace(cab.shown, held=("6",))
    cab.occupied = goes_elsewhere != "left the line"
    if cab.occupied:  # never under a train
        cab.crew.give_keys_back(0, 20.0)
        assert cab.machine.key == "K1"
    cab.occupied = False
    cab.crew.give_keys_back(0, 30.0)
    assert cab.machine.key == ""


def test_points_of_which_another_crew_has_the_key_are_waited_for(mission: Mission) -> None:
    cab = standing_before_points(mission)
    cab.machine = step(cab.machine, LockedByHand("K2"), 0.0)
    (needed,) = cab.plan.spans[mission.span_index("7")].points
    assert cab.crew.stand(0, 10.0) == [PointsWrong(needed)]
    assert cab.machine.key == "K2"


@pytest.mark.parametrize(
    "wrong", [{"position": Position.REVERSE}, {"locked": False}, {"position": None, "locked": False}]
)
def test_points_that_do_not_are_thrown_by_the_unit_and_looked_at_again(
    mission: Mission, wrong: dict[str, Any]
) -> None:
    cab = standing_before_points(mission)
    cab.machine = replace(cab.machine, **wrong)
    (needed,) = cab.plan.spans[mission.span_index("7")].points
    assert cab.crew.stand(0, 10.0) == [PointsWrong(needed)]
    assert isinstance(cab.journal.entries[-1].event, CrewWaitsAtPoints)


def test_points_under_the_train_are_looked_at_and_never_thrown(mission: Mission) -> None:
    cab = standing_before_points(mission)
    cab.truth.position_m = cab.start_m("7") + 5.0
    assert cab.sight_m() < cab.truth.position_m
    assert [type(found) for found in cab.crew.stand(0, 10.0)] == [PointsSeen]
    cab.machine = replace(cab.machine, position=None, locked=False)
    assert cab.crew.stand(0, 10.0) == []
    assert isinstance(cab.journal.entries[-1].event, CrewWaitsAtPoints)


def test_points_of_a_section_not_held_or_too_far_off_are_not_looked_at(mission: Mission) -> None:
    not_held = standing_before_points(mission)
    not_held.shown = msgspec.structs.replace(not_held.shown, held=("6",))
    far = standing_before_points(mission)
    far.truth.position_m -= 2.0 * SEES_M
    assert far.crew.stand(0, 10.0) == []
    assert not_held.crew.stand(0, 10.0) == [EndOfHeld(mission.span_index("6"))]
    assert not far.journal.entries and not not_held.journal.entries


def test_a_train_brought_to_the_mark_has_reached_it(mission: Mission) -> None:
    # No train sets back: overrun on its track it has arrived all the same, and says by how much to ten metres.
    for beyond_m, says_m in ((-5.0, 0.0), (1.0, 0.0), (24.0, 20.0)):
        cab = Cab(mission, mission.targets[-1].mark_m + beyond_m, "8")
        assert cab.crew.stand(0, 10.0) == [AtMark(len(mission.targets) - 1, says_m)]
    short = Cab(mission, mission.targets[-1].mark_m - 20.0, "8")
    assert short.crew.stand(0, 10.0) == []


def test_it_tells_the_unit_of_a_mark_once(mission: Mission) -> None:
    """The unit then shows the stop at which it stands, or that it has gone on from there."""
    last = len(mission.targets) - 1
    cab = Cab(mission, mission.targets[-1].mark_m + 1.0, "8")
    cab.shown = msgspec.structs.replace(cab.shown, stands_at=last, at=last - 1)
    assert cab.crew.stand(0, 10.0) == []
    cab.shown = msgspec.structs.replace(cab.shown, stands_at=None, at=last)
    assert cab.crew.stand(0, 10.0) == []


def test_it_watches_points_that_may_yet_come_to_lie_right(mission: Mission) -> None:
    cab = Cab(mission, 0.0, "6", "7", "8")
    cab.truth.position_m = cab.start_m("7") - SEES_M + 1.0
    cab.machine = PointMachine("P7", 6.0, Position.REVERSE)
    assert cab.crew.watches(0)
    cab.machine = PointMachine("P7", 6.0, Position.NORMAL)  # it goes on at its next look
    assert not cab.crew.watches(0)


def test_it_watches_nothing_that_is_not_held_or_too_far_away_to_be_seen(mission: Mission) -> None:
    for away_m, held in ((SEES_M - 1.0, ("6",)), (SEES_M + 1.0, ("6", "7", "8"))):
        cab = Cab(mission, 0.0, *held)
        cab.truth.position_m = cab.start_m("7") - away_m
        cab.machine = PointMachine("P7", 6.0, Position.REVERSE)
        assert not cab.crew.watches(0)


class RoadAhead:
    """A path on which the road of a crossing C1, by radio and open, begins at `road_m`."""

    def __init__(self, road_m: float) -> None:
        self.road_m = road_m

    def __contains__(self, _piece_id: str) -> bool:
        return True

    def to_road_m(self, _crossing: object) -> float:
        return self.road_m


@pytest.mark.parametrize("found", [False, True])
def test_leave_to_creep_ends_where_the_unit_asks_the_crossing_again(mission: Mission, found: bool) -> None:
    """Given to a train on sight whose unit then finds its position: on sight again there, another day, it stops."""
    cab = Cab(mission, 0.0, "6", "7", "8")
    cab.truth.position_m = cab.start_m("6") + 50.0
    road_m = cab.truth.position_m + 5.0
    cab.trains.true_path = lambda _slot: RoadAhead(road_m)
    cab.crossings.on_line = (SimpleNamespace(id="C1", piece_id="6", by_radio=True),)
    cab.crossings.is_blocked = cab.crossings.is_closed = lambda _id: False
    cab.crossings.creeps_over = lambda *_: None
    assert cab.sight_m() == road_m - 5.0
    assert cab.crew.waits_at_crossing(0) == "C1"
    cab.crew.creep(0, 10.0)
    assert cab.sight_m() > road_m
    if found:
        cab.on_sight = False
        cab.sight_m()
        cab.on_sight = True
    assert (cab.sight_m() == road_m - 5.0) is found
