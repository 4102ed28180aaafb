from itertools import pairwise

import pytest

from network.model import Direction, Line, Position, SectionKind, TagPurpose
from network.timetable import Call, Stabled, TimetableTrain
from onboard.mission import LEAVING_MARK_M, Mission, NoWay, plan_mission


def test_the_papers_run_from_section_3_to_section_8(mission: Mission) -> None:
    assert [span.section_id for span in mission.spans] == ["3", "5", "6", "7", "8"]
    assert [route.section_ids for route in mission.routes] == [("5", "6", "7", "8")]
    assert mission.path.length_m == pytest.approx(690.0)  # km 0.36 to km 1.05
    assert [(t.station_id, t.section_id) for t in mission.targets] == [("A", "3"), ("B", "8")]
    assert [t.mark_m for t in mission.targets] == pytest.approx([80.0, 660.0])  # km 0.44 and km 1.02
    points = [point for span in mission.spans for point in span.points]
    assert points == [("P5", Position.NORMAL, "A-E"), ("P7", Position.NORMAL, "B-W")]


def test_spans_lie_end_to_end(mission: Mission, through: Mission, back: Mission) -> None:
    for one in (mission, through, back):
        assert one.spans[0].start_m == 0.0
        assert one.spans[-1].end_m == pytest.approx(one.path.length_m)
        assert all(a.end_m == pytest.approx(b.start_m) for a, b in pairwise(one.spans))


def test_tags_are_those_of_the_direction_in_the_order_in_which_they_are_passed(
    rtri: Line, mission: Mission, back: Mission
) -> None:
    for one in (mission, back):
        positions = [tag.position_m for tag in one.tags]
        assert positions == sorted(positions)
        assert all(one.direction in rtri.tags[tag.tag_id].directions for tag in one.tags)
        for tag in one.tags:
            assert one.path.kilometrage_m(tag.position_m) == pytest.approx(rtri.tags[tag.tag_id].position_m)
    ids = [tag.tag_id for tag in mission.tags]
    assert ids == [301, 302, 303, 601, 602, 603, 701, 801, 802, 803]  # none on the legs to tracks 4 and 9
    purposes = {tag.tag_id: tag.purpose for tag in mission.tags}
    assert purposes[602] is TagPurpose.APPROACH
    assert purposes[803] is TagPurpose.CONTROL_START


def test_going_up_mirrors_marks_and_positions(back: Mission) -> None:
    assert back.direction is Direction.UP
    assert [span.section_id for span in back.spans] == ["8", "7", "6", "5", "4"]
    assert back.targets[0].mark_m == pytest.approx(1050.0 - 970.0)
    assert back.targets[1].mark_m == pytest.approx(1050.0 - 390.0)
    assert [p for span in back.spans for p in span.points] == [
        ("P7", Position.NORMAL, "B-W"),
        ("P5", Position.REVERSE, "A-E"),
    ]


def test_a_mission_over_the_whole_line_from_portal_to_portal(through: Mission) -> None:
    assert [route.id for route in through.routes] == ["PW>3", "3>8", "8>PE"]
    kinds = [span.kind for span in through.spans]
    assert kinds[0] is kinds[-1] is SectionKind.PORTAL
    first, last = through.targets[0], through.targets[-1]
    assert (first.station_id, first.mark_m) == (None, 60.0)
    assert last.station_id is None
    assert last.mark_m == pytest.approx(through.path.length_m - LEAVING_MARK_M)
    assert through.span_index("8") == [s.section_id for s in through.spans].index("8")
    with pytest.raises(ValueError, match="4"):
        through.span_index("4")


def train(*calls: Call, direction: Direction = Direction.DOWN) -> TimetableTrain:
    return TimetableTrain("X1", direction, True, calls, Stabled(), Stabled())


def test_no_way(rtri: Line) -> None:
    with pytest.raises(NoWay, match="no route from section 8 to 3 going down"):
        plan_mission(rtri, train(Call("B", "1", None, 0), Call("A", "1", 9, None)), "8", None, None)


def test_the_track_asked_for_is_taken_even_if_it_is_not_the_usual_one(rtri: Line) -> None:
    one = plan_mission(rtri, train(Call("A", "1", None, 0), Call("B", "2", 9, None)), "3", None, None)
    assert one.routes[-1].to_section == "9"
    usual = plan_mission(rtri, train(Call("A", None, None, 0), Call("B", None, 9, None)), "3", None, None)
    assert usual.routes[-1].to_section == "8"


def test_a_stock_that_stands_on_the_other_track_starts_from_there(rtri: Line) -> None:
    one = plan_mission(rtri, train(Call("A", None, None, 0), Call("B", None, 9, None)), "4", None, None)
    assert one.spans[0].section_id == "4"
    assert one.targets[0].section_id == "4"
