"""Virtual blocks of a line file: sections of equal length, all that lies there on them, and what is refused."""

from dataclasses import replace

import pytest

from network.errors import InputError
from network.files.line_file import load_line, parse_line
from network.files.shipped import shipped_line
from network.graph import all_routes
from network.model import Beacon, Direction, MarkerGroup
from network.virtual_blocks import BEYOND_M, with_virtual_blocks

TEXT = shipped_line("rtri_test_line").read_text("utf-8")
SECTION = 'id = "6"\n'


def test_a_section_is_cut_into_equal_blocks_and_routes_lead_over_them() -> None:
    whole, cut = (
        parse_line(TEXT, "whole"),
        parse_line(TEXT.replace(SECTION, SECTION + "virtual_blocks = 3\n"), "cut"),
    )
    low_m, high_m = whole.pieces["6"].from_m, whole.pieces["6"].to_m
    third_m = (high_m - low_m) / 3.0
    ends_m = [cut.pieces[f"6_{i}"].to_m for i in (1, 2, 3)]
    assert ends_m == pytest.approx([low_m + third_m, low_m + 2 * third_m, high_m])
    routes = {route.id: route.section_ids for route in all_routes(cut)}
    assert routes["3>8"] == ("5", "6_1", "6_2", "6_3", "7", "8")
    assert {tag_id for tag_id, tag in whole.tags.items() if tag.piece_id == "6"} == {
        tag_id for tag_id, tag in cut.tags.items() if tag.piece_id.startswith("6_")
    }


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (TEXT.replace('id = "3"\n', 'id = "3"\nvirtual_blocks = 2\n'), "between stations"),
        (
            shipped_line("karasuyama")
            .read_text("utf-8")
            .replace('id = "HSK-OGN"\n', 'id = "HSK-OGN"\nvirtual_blocks = 5\n'),
            "radio from end to end",
        ),
        (TEXT.replace(SECTION, SECTION + "virtual_blocks = 0\n"), "1"),
    ],
    ids=["track", "no radio", "none"],
)
def test_blocks_that_cannot_be_are_refused(text: str, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        parse_line(text, "line.toml")


@pytest.mark.parametrize(
    ("line_id", "blocks", "block_id", "ends_m"),
    [
        # 13/20 of the way from km 0.1 to 12.4 is 8.095, in the 65 m of platform from 8.1245 and 60 m beside it, where
        # the lower end is nearer; 4/5 of the way back from 8.654 to 0.201 is 5.2728, nearer to 5.2685 and 60 m.
        ("karasuyama", 20, "HSK-OGN_13", 8064.5),
        ("isumi", 5, "OHR-KNY_3", 5328.5),
    ],
)
def test_a_border_in_a_platform_lies_beside_it_at_the_nearer_end(
    line_id: str, blocks: int, block_id: str, ends_m: float
) -> None:
    cut = with_virtual_blocks(load_line(shipped_line(line_id)), blocks)
    assert cut.pieces[block_id].to_m == pytest.approx(ends_m)


def test_a_border_beside_a_platform_lies_in_no_other() -> None:
    """One of km 7.96 to 8.025 too: 60 m before that of km 8.1245 is in it, so that the border goes behind both."""
    line = load_line(shipped_line("karasuyama"))
    halt = next(
        s for s in line.stations.values() if s.tracks[0].platform_m == pytest.approx((8124.5, 8189.5))
    )
    for first in (True, False):
        own = replace(
            halt, id="own", tracks=tuple(replace(t, platform_m=(7960.0, 8025.0)) for t in halt.tracks)
        )
        stations = {"own": own} | line.stations if first else line.stations | {"own": own}
        cut = with_virtual_blocks(replace(line, stations=stations), 20)
        ends_m = [piece.to_m for piece in cut.pieces.values() if piece.id.startswith("HSK-OGN_")]
        assert not any(7900.0 < end_m < 8249.5 for end_m in ends_m)
        assert any(end_m == pytest.approx(8249.5) for end_m in ends_m)


def test_all_that_lies_on_a_section_lies_on_its_blocks() -> None:
    """A platform lies in one block, with 60 m to spare; every tag, beacon and marker in the block that it is in."""
    line = load_line(shipped_line("karasuyama"))
    along = [(at_m, "HSK-OGN") for at_m in range(150, 12400, 500)]
    both = (Direction.DOWN, Direction.UP)
    line = replace(
        line,
        beacons={i: Beacon(i, piece_id, at_m, both) for i, (at_m, piece_id) in enumerate(along)},
        markers={i: MarkerGroup(i, 1, piece_id, at_m, both) for i, (at_m, piece_id) in enumerate(along)},
    )
    cut = with_virtual_blocks(line, 20)
    for before, after in ((line.tags, cut.tags), (line.beacons, cut.beacons), (line.markers, cut.markers)):
        assert list(before) == list(after)
        for one in after.values():
            assert cut.pieces[one.piece_id].from_m <= one.position_m <= cut.pieces[one.piece_id].to_m
    for station in cut.stations.values():
        for track in station.tracks:
            piece = cut.pieces[track.piece_id]
            assert piece.section_id == track.section_id
            if station.is_halt and track.platform_m is not None:
                assert piece.from_m <= track.platform_m[0] - BEYOND_M
                assert track.platform_m[1] + BEYOND_M <= piece.to_m
