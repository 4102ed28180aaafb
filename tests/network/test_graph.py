import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.files.line_file import parse_line
from network.graph import (
    Graph,
    find_route,
    next_pieces,
    reachable_stops,
    required_position,
    required_positions,
    routes_from,
)
from network.model import Direction, Position, SectionKind
from tests.network.sample import LINE, SAMPLE, changed

STOPS = sorted(s.id for s in LINE.sections.values() if s.kind in (SectionKind.TRACK, SectionKind.PORTAL))


def test_two_pieces_follow_at_a_toe_normal_first_and_one_when_trailing() -> None:
    assert next_pieces(LINE, "A.11.stem", Direction.DOWN) == ("A.11.normal", "A.11.reverse")
    assert next_pieces(LINE, "A.11.reverse", Direction.UP) == ("A.11.stem",)
    assert next_pieces(LINE, "A.2", Direction.DOWN) == ("A.12.reverse",)
    assert next_pieces(LINE, "A.12.stem", Direction.UP) == ("A.12.normal", "A.12.reverse")
    assert next_pieces(LINE, "B.1", Direction.DOWN) == ()
    assert next_pieces(LINE, "P", Direction.DOWN) == ("A.11.stem",)


def test_graph_is_built_once_a_line() -> None:
    other = parse_line(SAMPLE, "sample.toml")
    assert Graph.of_line(LINE) is Graph.of_line(LINE)
    assert Graph.of_line(other) is not Graph.of_line(LINE)
    for _ in range(20):
        assert Graph.of_line(parse_line(SAMPLE, "sample.toml")).down == Graph.of_line(LINE).down


def test_route_over_facing_and_trailing_points() -> None:
    route = find_route(LINE, "A.2", "B.2", Direction.DOWN)
    assert route is not None
    assert route.id == "A.2>B.2"
    assert route.section_ids == ("A.E", "A-B", "B.W", "B.2")
    assert route.piece_ids == ("A.2", "A.12.reverse", "A.12.stem", "A-B", "B.11.stem", "B.11.reverse", "B.2")
    assert route.points == (("A.12", Position.REVERSE), ("B.11", Position.REVERSE))


def test_routes_in_order_normal_first() -> None:
    assert [r.to_section for r in routes_from(LINE, "P", Direction.DOWN)] == ["A.1", "A.2"]
    assert [r.id for r in routes_from(LINE, "B.2", Direction.UP)] == ["B.2>A.1", "B.2>A.2"]
    assert [r.to_section for r in routes_from(LINE, "A.1", Direction.UP)] == ["P"]


def test_no_route() -> None:
    assert find_route(LINE, "A.1", "B.1", Direction.UP) is None
    assert find_route(LINE, "P", "B.1", Direction.DOWN) is None  # not the next station
    assert routes_from(LINE, "P", Direction.UP) == ()
    assert routes_from(LINE, "B.1", Direction.DOWN) == ()


def test_routes_begin_on_tracks_and_portals_only() -> None:
    with pytest.raises(ValueError, match="A-B is between"):
        routes_from(LINE, "A-B", Direction.DOWN)
    with pytest.raises(KeyError):
        routes_from(LINE, "nowhere", Direction.DOWN)


def test_required_position() -> None:
    assert required_position(LINE, "A.11.stem") is None
    assert required_position(LINE, "A-B") is None
    assert required_position(LINE, "A.11.normal") == ("A.11", Position.NORMAL)
    assert required_positions(LINE, ["P", "A.11.stem", "A.11.reverse"]) == (("A.11", Position.REVERSE),)


def test_reachable_stops() -> None:
    assert reachable_stops(LINE, "P", Direction.DOWN) == ("A.1", "A.2", "B.1", "B.2")
    assert reachable_stops(LINE, "B.1", Direction.UP) == ("A.1", "A.2", "P")


def test_two_ways_between_the_same_tracks_have_two_ids() -> None:
    """A loop between stations: points next to points, and no stop on the loop."""
    old = '[[sections]]\nid = "B.W"'
    loop = """[[sections]]
id = "L.W"
kind = "points"
[[sections]]
id = "L.E"
kind = "points"
[[sections]]
id = "B-B"
kind = "between"
from_km = 2.3
to_km = 3.0
"""
    points = """
[[points]]
id = "L.1"
section = "L.W"
terminal = "L"
from_km = 2.0
toe_km = 2.05
to_km = 2.15
faces = "down"
stem = "A-B"
normal = "L.2.normal"
reverse = "L.2.reverse"
throw_time_s = 5
diverging_limit_kmh = 30
[[points]]
id = "L.2"
section = "L.E"
terminal = "L"
from_km = 2.15
toe_km = 2.25
to_km = 2.3
faces = "up"
stem = "B-B"
normal = "L.1.normal"
reverse = "L.1.reverse"
throw_time_s = 5
diverging_limit_kmh = 30
"""
    text = changed(old, loop + old).replace("from_km = 0.42\nto_km = 3.0", "from_km = 0.42\nto_km = 2.0")
    before, after = text.rsplit('stem = "A-B"', 1)
    line = parse_line(before + 'stem = "B-B"' + after + points, "loop.toml")
    ways = routes_from(line, "A.1", Direction.DOWN)
    assert [way.id for way in ways] == ["A.1>B.1", "A.1>B.2", "A.1>B.1#2", "A.1>B.2#2"]
    assert ways[0].points[1:3] == (("L.1", Position.NORMAL), ("L.2", Position.NORMAL))
    assert ways[2].points[1:3] == (("L.1", Position.REVERSE), ("L.2", Position.REVERSE))


@given(st.sampled_from(STOPS), st.sampled_from(list(Direction)))
def test_routes_connect_and_can_be_run_backwards(section_id: str, direction: Direction) -> None:
    for route in routes_from(LINE, section_id, direction):
        for before, after in zip(route.piece_ids, route.piece_ids[1:], strict=False):
            assert after in next_pieces(LINE, before, direction)
            assert before in next_pieces(LINE, after, direction.opposite)
        owners = [LINE.pieces[piece_id].section_id for piece_id in route.piece_ids]
        assert tuple(dict.fromkeys(owners)) == (section_id, *route.section_ids)
        back = find_route(LINE, route.to_section, section_id, direction.opposite)
        assert back is not None
        assert back.piece_ids == tuple(reversed(route.piece_ids))
        assert back.points == tuple(reversed(route.points))


def test_routes_are_found_once_for_each_line() -> None:
    once = routes_from(LINE, STOPS[0], Direction.DOWN)
    assert routes_from(LINE, STOPS[0], Direction.DOWN) is once
    other = parse_line(SAMPLE, "sample.toml")
    assert routes_from(other, STOPS[0], Direction.DOWN) == once
    assert routes_from(other, STOPS[0], Direction.DOWN) is not once
