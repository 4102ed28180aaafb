from pathlib import Path

import pytest

from network.clock import clock, first_given
from network.errors import InputError
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Direction
from network.timetable import (
    AtPortal,
    BecomesTrain,
    Call,
    FromTrain,
    Stabled,
    load_timetable,
    parse_timetable,
    platform_of,
)
from tests.network.sample import LINE

DAY = """
[timetable]
id = "day"
name = "A day"
line = "sample"
dwell_min_s = 30

[[trains]]
number = "1"
direction = "down"
calls = [
  { station = "A", track = "1", arrival = "06:00", departure = "06:01" },
  { station = "H", departure = "06:03:30" },
  { station = "B", arrival = "06:06", track = "1" },
]
begins = "portal:P"
ends = "becomes:2"

[[trains]]
number = "2"
direction = "up"
calls = [
  { station = "B", departure = "06:10", track = "1" },
  { station = "A", arrival = "06:15", departure = "06:16" },
]
begins = "from:1"
ends = "portal:P"

[[trains]]
number = "3"
direction = "down"
revenue = false
calls = [{ station = "A", departure = "23:58" }, { station = "B", arrival = "00:02" }]
begins = "stabled"
ends = "stabled"

[[diagrams]]
stock = "V1"
trains = ["1", "2"]
[[diagrams]]
stock = "V2"
trains = ["3"]
"""


def changed(old: str, new: str) -> str:
    assert old in DAY, old
    return DAY.replace(old, new, 1)


def test_times_in_seconds() -> None:
    timetable = parse_timetable(DAY, "day.toml", LINE)
    train = timetable.trains["1"]
    assert train.calls[0] == Call("A", "1", 21_600, 21_660)
    assert train.calls[1] == Call("H", None, None, 21_810)
    assert (train.calls[1].first_s, train.calls[2].last_s) == (21_810, 21_960)
    assert (train.begins, train.ends) == (AtPortal("P"), BecomesTrain("2"))
    assert timetable.trains["2"].begins == FromTrain("1")
    assert timetable.trains["3"].ends == Stabled()
    assert not timetable.trains["3"].revenue
    assert timetable.diagrams[0].train_numbers == ("1", "2")
    assert timetable.head.dwell_min_s == 30


def test_after_midnight_times_go_on() -> None:
    train = parse_timetable(DAY, "day.toml", LINE).trains["3"]
    assert train.calls[-1].arrival_s == 86_400 + 120
    assert clock(train.calls[-1].last_s) == "24:02:00"
    written = parse_timetable(changed('"00:02"', '"24:02"'), "day.toml", LINE).trains["3"]
    assert written == train


def test_a_whole_train_after_midnight() -> None:
    text = changed('ends = "stabled"', 'ends = "becomes:4"').replace('trains = ["3"]', 'trains = ["3", "4"]')
    text += """
[[trains]]
number = "4"
direction = "up"
calls = [{ station = "B", departure = "00:10" }, { station = "A", arrival = "00:15" }]
begins = "from:3"
ends = "stabled"
"""
    text = text.replace(
        '{ station = "B", departure = "00:10"', '{ station = "B", track = "1", departure = "00:10"'
    )
    assert parse_timetable(text, "day.toml", LINE).trains["4"].calls[0].departure_s == 86_400 + 600


AGAIN = """
[[trains]]
number = "5"
direction = "down"
calls = [{ station = "A", departure = "07:00" }, { station = "B", arrival = "07:05" }]
begins = "portal:P"
ends = "stabled"
"""


def test_a_set_leaves_by_a_portal_and_comes_back() -> None:
    text = changed('["1", "2"]', '["1", "2", "5"]') + AGAIN
    assert parse_timetable(text, "f", LINE).diagrams[0].train_numbers == ("1", "2", "5")
    with pytest.raises(InputError, match="portal:<section id>, as train 2 ends"):
        parse_timetable(text.replace(AGAIN, AGAIN.replace("portal:P", "stabled")), "f", LINE)


def test_usual_track_of_a_direction() -> None:
    assert platform_of(LINE, Call("A", None, None, 0), Direction.DOWN).name == "1"
    assert platform_of(LINE, Call("A", None, None, 0), Direction.UP).name == "2"
    assert platform_of(LINE, Call("A", "1", None, 0), Direction.UP).name == "1"
    assert platform_of(LINE, Call("B", None, None, 0), Direction.UP).name == "1"
    with pytest.raises(KeyError):
        platform_of(LINE, Call("B", "2", None, 0), Direction.UP)


FAULTS = [
    (changed('line = "sample"', 'line = "x"'), "timetable.line", "x", "sample"),
    (changed('begins = "portal:P"', ""), "trains[0].begins", None, "missing"),
    (changed('station = "H"', 'station = "Z"'), "trains[0].calls[1].station", "Z", "one of A, H, B"),
    (changed('track = "1"', 'track = "9"'), "trains[0].calls[0].track", "9", "one of 1, 2"),
    (changed('"06:00"', '"6:00"'), "trains[0].calls[0].arrival", "6:00", "HH:MM"),
    (changed('"06:00"', '"06:60"'), "trains[0].calls[0].arrival", "06:60", "HH:MM"),
    (changed('"06:00"', '"30:00"'), "trains[0].calls[0].arrival", "30:00", "HH:MM"),
    (changed('"06:01"', '"05:59"'), "trains[0].calls[0].departure", "05:59", "not before 06:00:00"),
    (changed('"06:03:30"', '"06:01"'), "trains[0].calls[1].departure", "06:01:00", "after 06:01:00"),
    (changed('"06:15"', '"06:09"'), "trains[1].calls[1].arrival", "06:09", "not before 06:10:00"),
    (changed(', departure = "06:01"', ""), "trains[0].calls[0].departure", None, "a departure"),
    (changed('arrival = "06:06", ', ""), "trains[0].calls[2].arrival", None, "a time"),
    (changed('direction = "down"', 'direction = "up"'), "trains[0].calls[1].station", "H", "beyond A"),
    (changed("portal:P", "gate:P"), "trains[0].begins", "gate:P", "stabled, portal:"),
    (
        changed('"portal:P"\n\n[[trains]]\nnumber = "3"', '"x"\n\n[[trains]]\nnumber = "3"'),
        "trains[1].ends",
        "x",
        "becomes:",
    ),
    (changed("portal:P", "portal:A.1"), "trains[0].begins", "portal:A.1", "one of P"),
    (changed('ends = "stabled"', 'ends = "portal:P"'), "trains[2].ends", "portal:P", "a way from"),
    (changed('number = "2"', 'number = "1"'), "trains[1].number", "1", "of its own"),
    (changed('["3"]', '["3", "4"]'), "diagrams[1].trains[1]", "4", "one of 1, 2, 3"),
    (changed('["3"]', '["3", "1"]'), "diagrams[1].trains[1]", "1", "diagrams[0].trains[0]"),
    (changed('["1", "2"]', '["1"]'), "trains[1].number", "2", "in one of the diagrams"),
    (changed('"V2"', '"V1"'), "diagrams[1].stock", "V1", "diagrams[0]"),
    (changed('["1", "2"]', '["2", "1"]'), "trains[1].begins", "from:1", "first train of set V1"),
    (changed("becomes:2", "becomes:3"), "trains[0].ends", "becomes:3", "becomes:2"),
    (changed("from:1", "from:3"), "trains[1].begins", "from:3", "from:1"),
    (changed("from:1", "stabled"), "trains[1].begins", "stabled", "from:1, as train 1 ends"),
    (changed("becomes:2", "stabled"), "trains[1].begins", "from:1", "stabled, as train 1 ends"),
    (changed('ends = "stabled"', 'ends = "becomes:1"'), "trains[2].ends", "becomes:1", "last train"),
    (
        changed('"06:06", track = "1"', '"06:06", track = "2"'),
        "trains[1].calls[0].track",
        "1",
        "2, where train 1 stands",
    ),
    (
        changed('  { station = "B", departure = "06:10", track = "1" },\n', ""),
        "diagrams[0].trains[1]",
        "2",
        "a train from B",
    ),
    (
        changed('departure = "06:10"', 'departure = "06:05"'),
        "diagrams[0].trains[1]",
        "2",
        "begins after 06:06:00",
    ),
]


@pytest.mark.parametrize(("text", "key", "value", "expected"), FAULTS, ids=[f[3] for f in FAULTS])
def test_a_fault_names_file_key_value_and_expectation(
    text: str, key: str, value: object, expected: str
) -> None:
    with pytest.raises(InputError) as caught:
        parse_timetable(text, "day.toml", LINE)
    error = caught.value
    assert (error.file, error.key, error.value) == ("day.toml", key, value)
    assert expected in error.expected
    assert "\n" not in str(error)


def test_load_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "day.toml"
    path.write_text(DAY, encoding="utf-8")
    assert load_timetable(path, LINE) == parse_timetable(DAY, "day.toml", LINE)


def test_shipped_names(tmp_path: Path) -> None:
    assert shipped_line("rtri_test_line").name == "rtri_test_line.toml"
    assert shipped_timetable("rtri_test_line").is_file()
    own = tmp_path / "own.toml"
    own.write_text(DAY, encoding="utf-8")
    assert shipped_timetable(str(own)) == own
    with pytest.raises(
        InputError, match=r"nowhere; expected a \.toml file or a shipped line: .*rtri_test_line"
    ):
        shipped_line("nowhere")
    with pytest.raises(InputError, match="an existing file"):
        shipped_line(str(tmp_path / "none.toml"))


def test_ten_minutes_before_midnight_are_minus_ten_minutes() -> None:
    assert [clock(time_s) for time_s in (-600.0, -0.4, 0.0, 3600.0)] == [
        "-00:10:00",
        "00:00:00",
        "00:00:00",
        "01:00:00",
    ]


def test_midnight_is_a_time_that_is_given() -> None:
    assert first_given(None, 0, 30) == 0
    assert (Call("A", None, 0, 30).first_s, Call("A", None, 30, 0).last_s) == (0, 0)
