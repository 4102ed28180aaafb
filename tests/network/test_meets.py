"""Meets in words; where they are found is tested with the timetables."""

from __future__ import annotations

from pathlib import Path

import pytest

from network.files.line_file import load_line
from network.files.patch import load_patched_line
from network.files.shipped import shipped_line, shipped_timetable
from network.meets import Meet, meet_text, planned_meets, unresolvable_meets
from network.model import Line
from network.timetable import load_timetable

LINE = load_line(Path(__file__).with_name("sample_line.toml"))
WITHOUT_LOOP = load_patched_line(shipped_line("karasuyama"), {"remove_tracks": ["OGN.2"]}, "what_if.toml")
TIME_S = 10 * 3600 + 5 * 60 + 59.9  # 10:05 until the next minute begins


@pytest.mark.parametrize(
    ("low", "high", "position_m", "text"),
    [
        ("H", "B", 2900.0, "between Halt and Bessho at 10:05: the line is single there, and the nearest "
         "station with two tracks is Bessho"),
        ("H", "H", 1500.0, "at Halt at 10:05: a halt has no second track, and the nearest other station "
         "with two tracks is Aoki"),
        ("A", "A", 260.0, "at Aoki at 10:05: both need the same track, and the nearest other station with two "
         "tracks is Bessho"),
        (None, "A", 10.0, "beyond Aoki at 10:05: the line is single there, and the nearest station with two "
         "tracks is Aoki"),
    ],
)  # fmt: skip
def test_why_two_trains_cannot_pass(low: str | None, high: str, position_m: float, text: str) -> None:
    meet = Meet("D", "U", TIME_S, position_m, low, high, None)
    assert meet_text(meet, LINE) == f"D and U would meet {text}"


def test_trains_that_pass() -> None:
    meet = Meet("D", "U", TIME_S, 260.0, "A", "A", "A")
    assert meet_text(meet, LINE) == "D and U pass each other at Aoki at 10:05"


@pytest.fixture(params=["karasuyama_weekday", "karasuyama_holiday"])
def day(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_without_the_loop_every_meet_at_ogane_is_impossible(day: str) -> None:
    """The timetable has ten meets, all at Ogane, where one track is left."""
    path = shipped_timetable(day)
    line: Line = load_line(shipped_line("karasuyama"))
    wanted = planned_meets(line, load_timetable(path, line))
    found = unresolvable_meets(WITHOUT_LOOP, load_timetable(path, WITHOUT_LOOP))
    assert len(found) == 10
    pairs = [(meet.down_train, meet.up_train, meet.time_s) for meet in found]
    assert pairs == [(meet.down_train, meet.up_train, meet.time_s) for meet in wanted]
    assert meet_text(found[0], WITHOUT_LOOP) == (
        "321M and 322M would meet at Ogane at 05:57: it has one track, and no other station has two tracks"
    )
