"""The paper's line model: figures 3 and 5, table 3 (Sugiyama, Fukuda, Kitano)."""

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.graph import find_route, routes_from
from network.model import Direction, Position, SectionKind, Tag, TagPurpose
from network.path import path_of
from network.profile import profile_of
from network.timetable import Stabled, load_timetable, platform_of
from network.train_fit import validate_train_fits

LINE = load_line(shipped_line("rtri_test_line"))
TRAIN_LENGTH_M = 40.0
SPEED_MPS = 45 / 3.6


def tags(purpose: TagPurpose, direction: Direction) -> list[Tag]:
    return [tag for tag in LINE.tags.values() if tag.purpose is purpose and direction in tag.directions]


def test_two_stations_and_three_stretches_between() -> None:
    kinds = [section.kind for section in LINE.sections.values()]
    assert [section.id for section in LINE.sections.values()][1:-1] == [str(i) for i in range(1, 12)]
    assert kinds.count(SectionKind.BETWEEN) == 3
    assert kinds.count(SectionKind.TRACK) == 4
    assert kinds.count(SectionKind.POINTS) == 4
    assert list(LINE.stations) == ["A", "B"]
    assert {points.terminal_id for points in LINE.points.values()} == {"A-W", "A-E", "B-W", "B-E"}


def test_the_run_of_section_5_goes_from_section_3_to_section_8() -> None:
    route = find_route(LINE, "3", "8", Direction.DOWN)
    assert route is not None
    assert route.section_ids == ("5", "6", "7", "8")
    assert route.points == (("P5", Position.NORMAL), ("P7", Position.NORMAL))
    limit = profile_of(LINE, path_of(LINE, route.piece_ids, Direction.DOWN))["limit_mps"]
    assert limit == pytest.approx(SPEED_MPS)
    assert not profile_of(LINE, path_of(LINE, route.piece_ids, Direction.DOWN))["turn_rad"].any()


def test_the_reverse_legs_lead_to_the_second_tracks() -> None:
    positions = {route.to_section: route.points[-1][1] for route in routes_from(LINE, "3", Direction.DOWN)}
    assert positions == {"8": Position.NORMAL, "9": Position.REVERSE}


@pytest.mark.parametrize("direction", list(Direction))
def test_every_track_has_tags_1_and_2_in_the_order_of_table_3(direction: Direction) -> None:
    for station in LINE.stations.values():
        for track in station.tracks:
            piece, mark_m = LINE.pieces[track.piece_id], track.marks_m[direction]
            entry_m = piece.from_m if direction is Direction.DOWN else piece.to_m
            (arrival,) = [t for t in tags(TagPurpose.ARRIVAL, direction) if t.piece_id == piece.id]
            (start,) = [t for t in tags(TagPurpose.CONTROL_START, direction) if t.piece_id == piece.id]
            clear_m = (arrival.position_m - entry_m) * direction - TRAIN_LENGTH_M
            assert clear_m > 5.0  # the whole train is past the rear points
            assert (start.position_m - arrival.position_m) * direction > 0.0
            assert 0.0 < (mark_m - start.position_m) * direction <= 5.0


@pytest.mark.parametrize("direction", list(Direction))
def test_tags_3_and_4_between_the_stations(direction: Direction) -> None:
    braking_m = SPEED_MPS**2 / (2 * 0.7)
    for points in LINE.points.values():
        stem = LINE.pieces[points.stem_piece]
        outer_m = stem.from_m if points.faces is Direction.DOWN else stem.to_m
        if points.faces is direction:
            near = min(tags(TagPurpose.APPROACH, direction), key=lambda t: abs(t.position_m - outer_m))
            assert (outer_m - near.position_m) * direction > braking_m + SPEED_MPS * points.throw_time_s
        else:
            near = min(tags(TagPurpose.DEPARTED, direction), key=lambda t: abs(t.position_m - outer_m))
            assert 0.0 < (near.position_m - outer_m) * direction <= 10.0
        assert LINE.sections[LINE.pieces[near.piece_id].section_id].kind is SectionKind.BETWEEN


@pytest.mark.parametrize("direction", list(Direction))
@pytest.mark.parametrize("distance_m", [300.0, 100.0, 15.0])
def test_position_tags_before_every_mark_on_every_way_to_it(direction: Direction, distance_m: float) -> None:
    starts = ("PW", "3", "4") if direction is Direction.DOWN else ("PE", "8", "9")
    for start in starts:
        for route in routes_from(LINE, start, direction):
            if route.to_section.startswith("P"):
                continue
            path = path_of(LINE, route.piece_ids, direction)
            station = LINE.sections[route.to_section].station_id
            assert station is not None
            (track,) = [t for t in LINE.stations[station].tracks if t.section_id == route.to_section]
            mark_m = path.to_path_m(track.piece_id, track.marks_m[direction])
            before_m = [
                mark_m - path.to_path_m(tag.piece_id, tag.position_m)
                for tag in tags(TagPurpose.POSITION, direction)
                if tag.piece_id in path
            ]
            assert any(abs(d - distance_m) < 0.001 for d in before_m), (route.id, before_m)


def test_a_two_car_train_reaches_line_speed_and_stops() -> None:
    """0.8 m/s2 up to 45 km/h and 0.7 m/s2 down again take less than the way between the marks."""
    start_m = LINE.stations["A"].tracks[0].marks_m[Direction.DOWN]
    stop_m = LINE.stations["B"].tracks[0].marks_m[Direction.DOWN]
    assert stop_m - start_m > SPEED_MPS**2 / 2 * (1 / 0.8 + 1 / 0.7)


def test_portals_have_a_tag_for_trains_that_enter() -> None:
    assert [tag.piece_id for tag in tags(TagPurpose.PORTAL, Direction.DOWN)] == ["PW"]
    assert [tag.piece_id for tag in tags(TagPurpose.PORTAL, Direction.UP)] == ["PE"]


def test_timetable_of_the_run() -> None:
    timetable = load_timetable(shipped_timetable("rtri_test_line"), LINE)
    train = timetable.trains["T1"]
    assert (train.begins, train.ends) == (Stabled(), Stabled())
    assert [platform_of(LINE, call, train.direction).section_id for call in train.calls] == ["3", "8"]
    assert timetable.diagrams[0].stock_id == "K1"
    validate_train_fits(LINE, {"K1": TRAIN_LENGTH_M}, timetable, "rtri_test_line.toml")
    assert any("distances" in item for item in LINE.assumed)
