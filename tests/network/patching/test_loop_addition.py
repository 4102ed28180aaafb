"""A loop laid at a halt: a track for each direction, nothing else moved, tags by the rule."""

import pytest

from network.errors import InputError
from network.files.edits import PatchInFile
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.graph import find_route, routes_from
from network.model import Direction, Line, SectionKind
from network.patching.patch import KEY, load_patched_line, patched_line
from network.tag_layout import lay_tags

HALTS = ("SHN", "NIT", "KNY", "KBN", "TAK")


def line_with(*halts: str) -> Line:
    return load_patched_line(shipped_line("karasuyama"), {"add_loops": list(halts)}, "what_if.toml")


@pytest.fixture(scope="module")
def before() -> Line:
    return load_line(shipped_line("karasuyama"))


@pytest.mark.parametrize("halt", HALTS)
def test_trains_of_both_directions_have_a_track_of_their_own(before: Line, halt: str) -> None:
    line = line_with(halt)
    station = line.stations[halt]
    assert [track.section_id for track in station.tracks] == [f"{halt}.1", f"{halt}.2"]
    assert [track.directions for track in station.tracks] == [(Direction.DOWN,), (Direction.UP,)]
    assert not station.is_halt
    low, high = ("HSK.1", "OGN.1") if station.position_m < 12_600.0 else ("OGN.1", "KRS.1")
    for track in station.tracks:
        there = find_route(line, low, track.section_id, Direction.DOWN)
        on = find_route(line, track.section_id, high, Direction.DOWN)
        assert there is not None and on is not None
        pieces = dict.fromkeys((*there.piece_ids, *on.piece_ids))  # its track is in both
        length_m = sum(line.pieces[p].length_m for p in pieces)
        whole = find_route(before, low, high, Direction.DOWN)
        assert whole is not None
        assert length_m == pytest.approx(sum(before.pieces[p].length_m for p in whole.piece_ids))
    assert {route.to_section for route in routes_from(line, f"{halt}.2", Direction.UP)} == {
        track.section_id for track in line.stations["HSK" if low == "HSK.1" else "OGN"].tracks
    }


@pytest.mark.parametrize("halt", HALTS)
def test_everything_else_stays(before: Line, halt: str) -> None:
    line = line_with(halt)
    assert set(before.points) == set(line.points) - {f"{halt}.11", f"{halt}.21"}
    for name, station in before.stations.items():
        assert line.stations[name].position_m == station.position_m
        assert [t.marks_m for t in line.stations[name].tracks][:1] == [t.marks_m for t in station.tracks][:1]
    gone = {before.stations[halt].tracks[0].section_id}
    assert set(before.sections) - gone <= set(line.sections)


def test_a_section_in_blocks_shares_them_out_by_length() -> None:
    """12.3 km in four blocks; 5.526 km are left before the loop at Niita, 6.414 km behind it: two blocks each."""
    blocks = {
        "alignments.main.coverage": [{"from_km": -1.0, "to_km": 20.3}],
        "sections.HSK-OGN.virtual_blocks": 4,
    }
    words = [
        PatchInFile({"set": blocks}, "low.toml", KEY),
        PatchInFile({"add_loops": ["NIT"]}, "up.toml", KEY),
    ]
    line, _, _ = patched_line(shipped_line("karasuyama"), words)
    between = [s.id for s in line.sections.values() if s.kind is SectionKind.BETWEEN]
    assert between == ["HSK-NIT_1", "HSK-NIT_2", "NIT-OGN_1", "NIT-OGN_2", "OGN-KRS"]
    assert len(line.stations["NIT"].tracks) == 2


@pytest.mark.parametrize("halts", [("NIT",), ("SHN", "TAK"), ("NIT", "KNY")])
def test_tags_are_those_of_the_rule(halts: tuple[str, ...]) -> None:
    """The line's own tags follow it, and so do those of the new stations."""
    line = line_with(*halts)
    laid = {(t.piece_id, t.position_m, t.purpose, t.directions) for t in lay_tags(line)}
    assert {(t.piece_id, t.position_m, t.purpose, t.directions) for t in line.tags.values()} == laid


def test_the_radio_reaches_the_new_terminals() -> None:
    (alignment,) = line_with("NIT").alignments.values()
    assert any(x.from_m <= 4_266.0 and x.to_m >= 7_266.0 for x in alignment.coverage)
    (joined,) = line_with("KBN").alignments.values()  # meets that of Ogane
    assert any(x.from_m <= 11_100.0 and x.to_m >= 16_594.0 for x in joined.coverage)


@pytest.mark.parametrize(
    ("halts", "expected"),
    [
        (["OGN"], r"add_loops\[0\] is 'OGN'; expected a halt, one of SHN"),
        (["NIT", "NIT"], r"add_loops\[1\] is 'NIT'; expected a halt"),
        (["XXX"], r"a halt"),
    ],
)
def test_where_no_loop_can_be_laid(halts: list[str], expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        line_with(*halts)


def test_a_signal_station_lies_in_the_middle_between_two_neighbours() -> None:
    """Ogane lies at km 12.600, Kobana at 15.094: a signal station (信号場) at 13.847, without platforms."""
    line = line_with("OGN.KBN")
    station = line.stations["OGN.KBN"]
    assert (station.position_m, station.is_signal_station, station.is_halt) == (13_847.0, True, False)
    assert [track.directions for track in station.tracks] == [(Direction.DOWN,), (Direction.UP,)]
    assert list(line.stations).index("OGN.KBN") == list(line.stations).index("OGN") + 1
    there = find_route(line, "OGN.1", "OGN.KBN.1", Direction.DOWN)
    on = find_route(line, "OGN.KBN.1", "KRS.1", Direction.DOWN)
    assert there is not None and on is not None


def test_stations_that_are_no_neighbours_have_none_between_them() -> None:
    with pytest.raises(InputError, match=r"or A\.B, two neighbours"):
        line_with("OGN.TAK")
