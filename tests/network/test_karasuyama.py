"""The shipped line and its timetables: complete, plausible, runnable, and what the importers make."""

import tomllib
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from exchange.geometry import curve_speed_kmh, equilibrium_cant_mm
from network.alignment import positions
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.graph import find_route
from network.model import Direction, Line, Position, SectionKind, TagPurpose
from network.tag_layout import TagRule, lay_tags, tags_toml
from network.timetable import Timetable, TimetableTrain, load_timetable
from network.train_fit import validate_train_fits

DAYS = ["karasuyama_weekday", "karasuyama_holiday"]
OGANE_REVERSE = {Direction.DOWN: "OGN.21", Direction.UP: "OGN.11"}
TRAIN_M = 40.0
MINUTE_S = 60.0


@pytest.fixture(scope="module")
def line() -> Line:
    return load_line(shipped_line("karasuyama"))


@pytest.fixture(scope="module", params=DAYS)
def day(request: pytest.FixtureRequest, line: Line) -> Timetable:
    return load_timetable(shipped_timetable(str(request.param)), line)


def test_stations_and_sections(line: Line) -> None:
    assert list(line.stations) == ["HSK", "SHN", "NIT", "KNY", "OGN", "KBN", "TAK", "KRS"]
    assert [s.id for s in line.stations.values() if s.is_halt] == ["SHN", "NIT", "KNY", "KBN", "TAK"]
    assert line.stations["KRS"].position_m == pytest.approx(20_390.0, rel=0.01)
    kinds = {kind: {s.id for s in line.sections.values() if s.kind is kind} for kind in SectionKind}
    assert kinds[SectionKind.PORTAL] == {"HSK.MD", "HSK.MU"}
    assert kinds[SectionKind.BETWEEN] == {"HSK-OGN", "OGN-KRS"}
    assert kinds[SectionKind.TRACK] == {"HSK.1", "OGN.1", "OGN.2", "KRS.1"}
    assert all(line.pieces[name].length_m >= 250.0 for name in kinds[SectionKind.PORTAL])
    assert {p.terminal_id for p in line.points.values()} == {"HSK-S", "OGN-W", "OGN-E"}


@pytest.mark.parametrize(
    ("start", "goal", "direction", "points"),
    [
        ("HSK.MD", "HSK.1", Direction.DOWN, (("HSK.21", Position.REVERSE),)),
        ("HSK.1", "OGN.1", Direction.DOWN, (("OGN.11", Position.NORMAL),)),
        ("OGN.1", "KRS.1", Direction.DOWN, (("OGN.21", Position.REVERSE),)),
        ("KRS.1", "OGN.2", Direction.UP, (("OGN.21", Position.NORMAL),)),
        ("OGN.2", "HSK.1", Direction.UP, (("OGN.11", Position.REVERSE),)),
        ("HSK.1", "HSK.MU", Direction.UP, (("HSK.21", Position.NORMAL),)),
    ],
)
def test_routes_of_left_hand_running(
    line: Line, start: str, goal: str, direction: Direction, points: tuple[tuple[str, Position], ...]
) -> None:
    route = find_route(line, start, goal, direction)
    assert route is not None
    assert route.points == points


def test_gradients_are_gentle(line: Line) -> None:
    main = line.alignments["main"]
    assert max(abs(g.permille) for g in main.gradients) <= 25.0
    for station in line.stations.values():
        at = [
            g
            for g in main.gradients
            if g.from_m < station.position_m + 60 and g.to_m > station.position_m - 60
        ]
        assert max(abs(g.permille) for g in at) <= 3.0, station.id
    ends = positions(main, np.array([main.from_m, main.to_m]))[:, 2]
    assert ends == pytest.approx([148.0, 86.0], abs=1.0)


def test_curves_are_limited_and_canted_by_rule(line: Line) -> None:
    main = line.alignments["main"]
    for curve in main.curves:
        at_m = 0.5 * (curve.from_m + curve.to_m)
        limits = [x.speed_mps for x in main.limits if x.from_m <= at_m <= x.to_m]
        speed_mps = min([*limits, line.max_speed_mps])
        assert speed_mps * 3.6 <= curve_speed_kmh(curve.radius_m) + 1e-9
        assert curve.cant_mm <= min(105.0, curve.transition_m / 0.4)
        assert equilibrium_cant_mm(speed_mps * 3.6, curve.radius_m) - curve.cant_mm <= 60.0


def test_coverage_reaches_every_approach_and_every_station_with_points(line: Line) -> None:
    main = line.alignments["main"]
    for tag in line.tags.values():
        if tag.purpose in {
            TagPurpose.APPROACH,
            TagPurpose.ARRIVAL,
            TagPurpose.CONTROL_START,
            TagPurpose.PORTAL,
        }:
            assert any(c.from_m <= tag.position_m <= c.to_m for c in main.coverage), tag
    assert sum(c.to_m - c.from_m for c in main.coverage) < 0.5 * (main.to_m - main.from_m)


def test_tags_are_laid_by_the_rule(line: Line) -> None:
    assert tuple(line.tags.values()) == lay_tags(line)


def test_tags_let_the_rear_clear_and_the_train_stop(line: Line) -> None:
    rule = TagRule()
    for tag in line.tags.values():
        piece = line.pieces[tag.piece_id]
        for direction in tag.directions:
            behind_m = (
                tag.position_m - (piece.from_m if direction is Direction.DOWN else piece.to_m)
            ) * direction
            if tag.purpose in {TagPurpose.ARRIVAL, TagPurpose.DEPARTED}:
                assert behind_m > TRAIN_M
            if tag.purpose is TagPurpose.APPROACH:
                # v^2 / (2 b) from 65 km/h at 0.7 m/s2
                assert piece.length_m - behind_m > (65 / 3.6) ** 2 / 1.4
    # 65 km/h: 233 m to stop and 181 m in 10 s; 85 km/h: 398 m and 236 m
    assert rule.approach_m(65 / 3.6) == 450.0
    assert rule.approach_m(85 / 3.6) == 650.0


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        (TagRule(train_length_m=150.0), "has not cleared the rear end"),
        (TagRule(reaction_s=60.0), "too short for its approach tag"),
    ],
)
def test_a_line_too_short_for_the_rule_is_named(line: Line, rule: TagRule, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        lay_tags(line, rule)


def test_tags_are_written_as_they_are_read(line: Line) -> None:
    text = tags_toml(line, line.tags.values())
    rows = tomllib.loads(text)["tags"]
    assert [row["id"] for row in rows] == list(line.tags)
    assert all(("section" in row) != ("piece" in row) for row in rows)


def test_tags_of_one_direction_are_read_one_at_a_time(line: Line) -> None:
    for direction in Direction:
        places: dict[str, list[float]] = {}
        for tag in line.tags.values():
            if direction in tag.directions:
                places.setdefault(tag.piece_id, []).append(tag.position_m)
        for piece_id, at_m in places.items():
            assert np.all(np.diff(np.sort(at_m)) >= 5.0), piece_id


def test_27_trains_and_one_empty(day: Timetable) -> None:
    assert sum(t.revenue for t in day.trains.values()) == 27
    assert sum(t.revenue and t.direction is Direction.DOWN for t in day.trains.values()) == 14
    assert [t.number for t in day.trains.values() if not t.revenue] == ["E346M"]
    assert [d.stock_id for d in day.diagrams] == ["V1", "V2", "V3", "V4"]


def test_platforms_hold_the_trains(line: Line, day: Timetable) -> None:
    validate_train_fits(line, {f"V{i}": TRAIN_M for i in range(1, 5)}, day, "timetable")


def test_karasuyama_holds_one_train_at_a_time(day: Timetable) -> None:
    stays = []
    for diagram in day.diagrams:
        for number in diagram.train_numbers:
            calls = day.trains[number].calls
            if calls[0].station_id == "KRS":
                stays.append((calls[0].last_s, -1))
            if calls[-1].station_id == "KRS":
                stays.append((calls[-1].first_s, 1))
    standing = 1  # the set of the first train
    for _, change in sorted(stays):
        standing += change
        assert standing in {0, 1}
    assert standing == 1


def _speed_limit_mps(line: Line, direction: Direction, at_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Limit for a front at `at_m`, while any of the train is within; reverse legs at Ogane included."""
    points = line.points[OGANE_REVERSE[direction]]
    leg = line.pieces[points.reverse_piece]
    ranges = [(leg.from_m, leg.to_m, points.diverging_limit_mps)]
    ranges += [
        (x.from_m, x.to_m, x.speed_mps) for x in line.alignments["main"].limits if direction in x.directions
    ]
    limit = np.full_like(at_m, line.max_speed_mps)
    for low_m, high_m, speed_mps in ranges:
        behind_m = (TRAIN_M, 0.0) if direction is Direction.UP else (0.0, TRAIN_M)
        inside = (at_m >= low_m - behind_m[0]) & (at_m <= high_m + behind_m[1])
        limit[inside] = np.minimum(limit[inside], speed_mps)
    return limit


def _running_time_s(line: Line, direction: Direction, from_m: float, to_m: float) -> float:
    """Shortest run between two marks with 0.7 m/s2 up and 0.8 m/s2 down."""
    at_m = np.linspace(from_m, to_m, int(abs(to_m - from_m) / 2.0) + 1)
    step_m = abs(at_m[1] - at_m[0])
    squared = _speed_limit_mps(line, direction, at_m) ** 2
    squared[0] = squared[-1] = 0.0
    for i in range(1, len(squared)):
        squared[i] = min(squared[i], squared[i - 1] + 2 * 0.7 * step_m)
    for i in range(len(squared) - 2, -1, -1):
        squared[i] = min(squared[i], squared[i + 1] + 2 * 0.8 * step_m)
    speed_mps = np.sqrt(squared)
    return float(np.sum(2.0 * step_m / (speed_mps[1:] + speed_mps[:-1])))


def _runs(line: Line, train: TimetableTrain) -> Iterator[tuple[str, float, float, float]]:
    """Name, planned time from departure to arrival, shortest run, and planned time to the next departure."""
    marks = {name: station.tracks[0].marks_m[train.direction] for name, station in line.stations.items()}
    for before, after in pairwise(train.calls):
        run_s = _running_time_s(line, train.direction, marks[before.station_id], marks[after.station_id])
        name = f"{train.number} {before.station_id}-{after.station_id}"
        yield name, after.first_s - before.last_s, run_s, after.last_s - before.last_s


def test_timetable_can_be_kept(line: Line, day: Timetable) -> None:
    # times are whole minutes: a run may use up to a minute more than the figures say, a whole trip too
    for train in day.trains.values():
        shortest_s = 0.0
        for name, planned_s, run_s, _ in _runs(line, train):
            assert run_s < planned_s + MINUTE_S, name
            shortest_s += run_s + (day.head.dwell_min_s if shortest_s else 0.0)
        planned_s = train.calls[-1].first_s - train.calls[0].last_s
        assert shortest_s < planned_s + MINUTE_S, train.number
