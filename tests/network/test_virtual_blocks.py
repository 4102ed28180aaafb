"""Virtual blocks of a line file: sections of equal length, all that lies there on them, and what is refused."""

from __future__ import annotations

import pytest

from network.errors import InputError
from network.files.line_file import parse_line
from network.files.shipped import shipped_line
from network.graph import all_routes

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
