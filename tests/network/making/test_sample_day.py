"""The small day beside a new line: two sets that meet at the loop nearest the middle, or one where none is."""

from itertools import pairwise
from pathlib import Path

import pytest

from exchange.new_line import NewLineOptions, make_line
from network.errors import InputError
from network.making.sample_day import timetable_toml, write_sample
from network.model import Line
from network.timetable import Timetable, parse_timetable


def line_of(tmp_path: Path, text: str, max_speed_kmh: float = 60.0) -> Line:
    path = tmp_path / "list.csv"
    path.write_text(text, "utf-8")
    return make_line(path, "drawn", NewLineOptions(max_speed_kmh=max_speed_kmh)).line


def shared_stops(timetable: Timetable, down: str, up: str) -> list[str]:
    """Where the stops of two trains overlap in time."""
    up_calls = {call.station_id: call for call in timetable.trains[up].calls}
    return [
        call.station_id
        for call in timetable.trains[down].calls
        if max(call.first_s, up_calls[call.station_id].first_s)
        < min(call.last_s, up_calls[call.station_id].last_s)
    ]


def test_two_sets_meet_at_the_loop_nearest_the_middle(tmp_path: Path) -> None:
    line = line_of(tmp_path, "name,km,tracks\nA,0,1\nB,2,2\nC,5,1\nD,7,2\nE,12,1\n")
    timetable = parse_timetable(timetable_toml(line, "t"), "t", line)
    assert shared_stops(timetable, "1D", "4U") == shared_stops(timetable, "3D", "2U") == ["D"]
    assert [diagram.train_numbers for diagram in timetable.diagrams] == [("1D", "2U"), ("4U", "3D")]


def test_without_a_loop_one_set_goes_there_and_back(tmp_path: Path) -> None:
    line = line_of(tmp_path, "name,km,tracks\nA,0,2\nC,5,1\nE,12,2\n")
    timetable = parse_timetable(timetable_toml(line, "t"), "t", line)
    assert [diagram.train_numbers for diagram in timetable.diagrams] == [("1D", "2U")]


def test_a_way_of_a_day_and_more_is_read_as_it_was_written(tmp_path: Path) -> None:
    """360 km at 40 km/h, and a quarter more, are 11.3 h; 480 km are 15 h, and a file has hours up to 29."""
    line = line_of(tmp_path, "name,km,tracks\nA,0,2\nC,360,2\nE,720,2\nF,800,2\n", 40.0)
    down = parse_timetable(timetable_toml(line, "t"), "t", line).trains["1D"]
    for before, after in pairwise(down.calls[:3]):
        assert 11.25 * 3600 <= after.first_s - before.last_s < 11.5 * 3600
    assert down.calls[-1].first_s > 30 * 3600
    far = line_of(tmp_path, "name,km,tracks\nA,0,2\nC,360,2\nE,840,2\n", 40.0)
    with pytest.raises(InputError, match=r"trains\[0\].calls\[2\].arrival is '3"):
        write_sample(far, tmp_path / "line.toml", tmp_path / "x.toml")
    assert not (tmp_path / "x_times.toml").exists()


def test_a_way_too_long_for_its_tags_is_one_message(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="more than 99 tags around A"):
        line_of(tmp_path, "name,km,tracks\nA,0,2\nC,1500,2\n")


def test_no_leg_is_quicker_than_the_line_allows(tmp_path: Path) -> None:
    line = line_of(tmp_path, "name,km,tracks\nA,0,2\nC,5,1\nE,12,2\n")
    down = parse_timetable(timetable_toml(line, "t"), "t", line).trains["1D"]
    for before, after, km in zip(down.calls[:-1], down.calls[1:], (5.0, 7.0), strict=True):
        assert after.first_s - before.last_s > km / 60.0 * 3600.0


def test_files_that_would_overwrite_the_line_are_refused(tmp_path: Path) -> None:
    line = line_of(tmp_path, "name,km\nA,0\nE,12\n")
    for name in ("x.toml", "x_times.toml"):
        with pytest.raises(InputError, match="another name than the line file's"):
            write_sample(line, tmp_path / name, tmp_path / "x.toml")
    for path in (tmp_path / "x.txt", tmp_path / "a b.toml"):
        with pytest.raises(InputError, match=r"NAME.toml"):
            write_sample(line, tmp_path / "line.toml", path)
    with pytest.raises(InputError, match="existing folder"):
        write_sample(line, tmp_path / "line.toml", tmp_path / "no" / "x.toml")
    assert not list(tmp_path.glob("x*"))
