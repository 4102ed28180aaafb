"""Stations that trains reach from inside a line are a branch; those beyond its ends are not."""

from exchange.branches import branches
from exchange.published import PublishedStation, PublishedTimetable, PublishedTrain
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.making.station_list import ONE_WAY
from network.timetable import Call

LINE = load_line(shipped_line("karasuyama"))
IDS = {"H": "HSK", "O": "OGN", "K": "KRS"}
NAMES = {"X": "Kitsuregawa", "Y": "Sakura", "U": "Utsunomiya"}


def _branches(*ways: str) -> list[str]:
    stations = tuple(PublishedStation(key, NAMES.get(key, key)) for key in "UHOXYK")
    trains = tuple(
        PublishedTrain(
            str(number), "down", tuple(Call(key, None, None, 60 * at) for at, key in enumerate(way))
        )
        for number, way in enumerate(ways)
    )
    return list(branches(PublishedTimetable("day", stations, trains, "day.oud"), LINE, IDS))


def test_trains_to_and_from_a_branch_are_told_with_where_they_leave_the_line() -> None:
    (text,) = _branches("HOK", "HOXY", "YXOH", "XO")
    assert text.startswith("Ogane: a branch leaves the line there, to ")
    assert "Kitsuregawa, Sakura (3 trains)" in text or "Sakura, Kitsuregawa (3 trains)" in text
    assert "begin and end at Ogane" in text
    assert text.endswith(ONE_WAY)


def test_beyond_an_end_of_the_line_is_no_branch_nor_is_a_train_from_elsewhere() -> None:
    assert _branches("UHOK", "KOHU", "XY") == []


def test_what_lies_between_two_stations_of_the_line_is_no_branch() -> None:
    assert _branches("HXOK") == []
