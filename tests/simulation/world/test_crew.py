"""The crew of a train on sight: where it stops, what it looks at, what it lets pass (Sugiyama, section 4.4 (3))."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Position
from network.timetable import load_timetable
from onboard.authority.machine import Authority, Held
from onboard.authority.stop_limit import points_of
from onboard.duty.mission import Mission, plan_mission
from onboard.notes import CrewCheckedPoints, CrewWaitsAtPoints
from onboard.unit import Phase
from simulation.journal import Journal
from simulation.world.crew import SEES_M, Crew, Seen
from simulation.world.point_machine import PointMachine


@pytest.fixture(scope="module")
def mission() -> Mission:
    line = load_line(shipped_line("rtri_test_line"))
    timetable = load_timetable(shipped_timetable("rtri_test_line"), line)
    return plan_mission(line, timetable.trains["T1"], "3", None, None)


class Cab:
    """One train on sight at `front_m` of the mission's path, its unit holding `sections`."""

    def __init__(self, mission: Mission, front_m: float, *sections: str) -> None:
        self.mission = mission
        held = tuple(Held(section, 1) for section in sections)
        self.unit: Any = SimpleNamespace(
            phase=Phase.RESTARTED,
            mission=mission,
            at=0,
            stands_at=None,
            authority=Authority("K1", "block-manager", held=held),
            facts=SimpleNamespace(unit_id="K1"),
        )
        self.truth: Any = SimpleNamespace(position_m=front_m, sight_m=math.inf)
        self.row: Any = SimpleNamespace(position_known=0)
        self.machine = PointMachine("P7", 6.0, Position.NORMAL)
        self.journal = Journal()
        trains: Any = SimpleNamespace(on_board=[self.unit], units=[self.row], truths=[self.truth])
        self.crew = Crew(trains, lambda _points_id: self.machine, self.journal)

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
    proven = points_of(mission.spans[mission.span_index("7")])
    cab.unit.authority = replace(cab.unit.authority, proven=proven)
    assert cab.sight_m() == pytest.approx(mission.targets[-1].mark_m + 2.0)


def test_it_does_not_leave_what_is_held(mission: Mission) -> None:
    cab = Cab(mission, 0.0, "3")
    cab.truth.position_m = mission.targets[0].mark_m
    assert cab.sight_m() < cab.start_m("5")


def test_a_unit_that_knows_where_it_is_drives_itself(mission: Mission) -> None:
    cab = Cab(mission, 100.0, "6", "7", "8")
    cab.row.position_known = 1
    assert cab.sight_m() == math.inf
    assert cab.crew.stand(0, 10.0) == Seen()


def standing_before_points(mission: Mission) -> Cab:
    cab = Cab(mission, 0.0, "6", "7", "8")
    cab.truth.position_m = cab.start_m("7") - SEES_M / 2.0
    return cab


def test_points_that_lie_right_and_locked_may_be_passed(mission: Mission) -> None:
    cab = standing_before_points(mission)
    seen = cab.crew.stand(0, 10.0)
    assert seen.passable is not None and seen.passable.points_id == "P7"
    assert isinstance(cab.journal.entries[-1].event, CrewCheckedPoints)


@pytest.mark.parametrize(
    "wrong", [{"position": Position.REVERSE}, {"locked": False}, {"position": None, "locked": False}]
)
def test_points_that_do_not_are_thrown_by_the_unit_and_looked_at_again(
    mission: Mission, wrong: dict[str, Any]
) -> None:
    cab = standing_before_points(mission)
    cab.machine = replace(cab.machine, **wrong)
    seen = cab.crew.stand(0, 10.0)
    assert seen.passable is None
    assert seen.to_throw is not None and seen.to_throw.points_id == "P7"
    assert isinstance(cab.journal.entries[-1].event, CrewWaitsAtPoints)


def test_points_under_the_train_are_looked_at_and_never_thrown(mission: Mission) -> None:
    cab = standing_before_points(mission)
    cab.truth.position_m = cab.start_m("7") + 5.0
    assert cab.sight_m() < cab.truth.position_m
    assert cab.crew.stand(0, 10.0).passable is not None
    cab.machine = replace(cab.machine, position=None, locked=False)
    assert cab.crew.stand(0, 10.0) == Seen()


def test_points_of_a_section_not_held_or_too_far_off_are_not_looked_at(mission: Mission) -> None:
    not_held = standing_before_points(mission)
    not_held.unit.authority = replace(not_held.unit.authority, held=(Held("6", 1),))
    far = standing_before_points(mission)
    far.truth.position_m -= 2.0 * SEES_M
    assert far.crew.stand(0, 10.0) == Seen()
    assert not_held.crew.stand(0, 10.0) == Seen()


def test_a_train_brought_to_the_mark_has_reached_it(mission: Mission) -> None:
    for beyond_m in (-5.0, 1.0, 25.0):  # no train sets back: overrun on its track it has arrived all the same
        cab = Cab(mission, mission.targets[-1].mark_m + beyond_m, "8")
        assert cab.crew.stand(0, 10.0) == Seen(target=len(mission.targets) - 1)
    short = Cab(mission, mission.targets[-1].mark_m - 20.0, "8")
    assert short.crew.stand(0, 10.0) == Seen()
