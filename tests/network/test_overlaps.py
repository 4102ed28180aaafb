"""What lies in the overlap of a track, and where trains need leave to come in: distances of the sample line by hand."""

import pytest

from network.errors import InputError
from network.files.line_file import parse_line
from network.graph import find_route, fouled_sections, overlaps_coming_in, overlaps_going_out
from network.model import Direction, Line, Route
from tests.network.test_graph import SAMPLE

HEAD = "max_speed_kmh = 90\n"


def _line(overlap_m: float, *more: tuple[str, str]) -> Line:
    text = SAMPLE.replace(HEAD, f"{HEAD}overlap_m = {overlap_m}\n").replace("to_km = 0.9 }", "to_km = 3.2 }")
    text = text.replace(", { from_km = 2.5, to_km = 3.2 }]", "]")
    for old, new in more:
        assert old in text, old
        text = text.replace(old, new)
    return parse_line(text, "sample.toml")


def _route(line: Line, here: str, there: str, direction: Direction) -> Route:
    route = find_route(line, here, there, direction)
    assert route is not None
    return route


def test_the_points_lie_in_it_where_they_begin_within_that_much_beyond_the_mark() -> None:
    line = _line(1.0)
    track = next(t for t in line.stations["A"].tracks if t.section_id == "A.1")
    gap_m = line.pieces["A.1"].to_m - track.marks_m[Direction.DOWN]
    assert gap_m > 1.0
    for overlap_m, overlap in ((gap_m - 0.1, ()), (gap_m + 0.1, ("A.E",))):
        assert _route(_line(overlap_m), "P", "A.1", Direction.DOWN).overlap == overlap


def test_leave_is_needed_by_those_who_foul_and_by_those_who_would_be_fouled() -> None:
    line = _line(300.0)
    down, up = _route(line, "P", "A.1", Direction.DOWN), _route(line, "B.1", "A.2", Direction.UP)
    assert (down.entry, down.overlap) == (("A.W",), ("A.E",))
    assert (up.entry, up.overlap) == (("A.E",), ("A.W",))
    assert (
        set(overlaps_coming_in(line, down))
        == set(overlaps_coming_in(line, up))
        == {"A.W overlap", "A.E overlap"}
    )
    out = _route(line, "A.1", "B.1", Direction.DOWN)
    assert out.entry == ()  # at the end of the line nothing lies beyond, and nobody comes against it
    assert overlaps_going_out(line, out) == ("A.E overlap",)


def test_a_line_that_says_nothing_has_no_overlaps() -> None:
    line = parse_line(SAMPLE, "sample.toml")
    assert fouled_sections(line) == frozenset()
    assert _route(line, "P", "A.1", Direction.DOWN).entry == ()


def test_a_track_may_be_equipped_by_itself() -> None:
    equipped = _line(300.0, ('section = "A.1",', 'overlap_down_m = 0, section = "A.1",'))
    assert _route(equipped, "P", "A.1", Direction.DOWN).overlap == ()
    assert _route(equipped, "P", "A.2", Direction.DOWN).overlap == ("A.E",)


def test_the_radio_must_reach_where_trains_wait_for_leave() -> None:
    text = SAMPLE.replace(HEAD, f"{HEAD}overlap_m = 300.0\n").replace("to_km = 0.9 }", "to_km = 0.45 }")
    with pytest.raises(InputError, match=r"radio from km 0\.42 to 0\.52, where trains wait for leave"):
        parse_line(text, "sample.toml")
