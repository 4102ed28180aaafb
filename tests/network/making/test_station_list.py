"""Station lists as people write them, and each way in which one can be wrong."""

from pathlib import Path

import pytest

from network.errors import InputError
from network.making.station_list import read_station_list


def csv_list(folder: Path, text: str) -> Path:
    path = folder / "list.csv"
    path.write_text(text, "utf-8")
    return path


def test_a_csv_and_a_toml_say_the_same(tmp_path: Path) -> None:
    toml = tmp_path / "list.toml"
    toml.write_text(
        '[[stations]]\nname = "Asa"\nkm = 0\ntracks = 2\nend = "portal"\n'
        '[[stations]]\nname = "Kawa"\nname_ja = "川"\nkm = 4.5\nside = "left"\ntracks = 3\n',
        "utf-8",
    )
    same = csv_list(tmp_path, "name,name_ja,km,tracks,side,end\nAsa,,0,2,,portal\n\nKawa,川,4.5,3,left,\n")
    assert read_station_list(same).stations == read_station_list(toml).stations


def test_what_is_left_out_is_filled_in(tmp_path: Path) -> None:
    path = csv_list(tmp_path, "name,tracks\n木更津,2\nGion,1\nYokota,2\nKazusa-Kameyama,1\n")
    first, halt, loop, last = read_station_list(path).stations
    assert (first.id, first.name, first.name_ja, first.km) == ("S01", "木更津", "木更津", None)
    assert (halt.id, halt.is_halt, halt.points_low, halt.points_high) == ("GIO", True, False, False)
    assert (loop.id, loop.is_halt, loop.points_low, loop.points_high) == ("YKT", False, True, True)
    assert loop.offsets_m == (-4.0, 4.0)
    assert (last.id, last.is_halt, last.portal) == ("KKM", False, False)
    # tracks of an end come together only where the line goes on
    assert (first.points_low, first.points_high) == (False, True)


def test_ids_are_each_their_own(tmp_path: Path) -> None:
    names = ["Mori", "Morii", "More", "Mure", "Mari", "M", "森", "Morio"]
    path = csv_list(tmp_path, "name,km\n" + "".join(f"{name},{i}\n" for i, name in enumerate(names)))
    ids = [station.id for station in read_station_list(path).stations]
    assert len(set(ids)) == len(names)


def test_the_first_track_lies_where_it_is_said(tmp_path: Path) -> None:
    path = csv_list(
        tmp_path,
        "name,km,tracks,side,spacing_m,offset_m,normal\n"
        "A,0,1,,,,\nB,3,2,left,5,0,\nC,6,3,,4,,2\nD,9,2,right,,0,\nE,12,1,,,,\n",
    )
    _, left, middle, right, _ = read_station_list(path).stations
    assert dict(zip(left.tracks, left.offsets_m, strict=True)) == {"1": 0.0, "2": -5.0}
    assert dict(zip(middle.tracks, middle.offsets_m, strict=True)) == {"1": -4.0, "2": 0.0, "3": 4.0}
    assert dict(zip(right.tracks, right.offsets_m, strict=True)) == {"1": 0.0, "2": 8.0}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"stations"),
        ("name\nA\n", "stations"),
        ("name,tracks,trakcs\nA,1,1\nB,1,1\n", r"line 1 is 'trakcs'; expected columns"),
        ("name,name\nA,A\nB,B\n", "each column once"),
        ("name,km\nA,0,9\nB,1\n", "line 2 is 3; expected 2 cells"),
        ("name,km,tracks\nA,0,2\nB\nC,5,2\n", "line 3 is 1; expected 3 cells"),
        ("", r": stations; expected at least 2 entries, not 0"),
        ("name,km\n", r": stations; expected at least 2 entries, not 0"),
        ("name,km\nA,0\n", r": stations; expected at least 2 entries, not 1"),
        ("name;km\nA;0\nB;1\n", r"line 1 is 'name;km'; expected commas between columns"),
        ("name\tkm\nA\t0\nB\t1\n", r"line 1 is .*; expected commas between columns"),
        ("name,km,kind\nA,0,\nB,1,signal\nC,2,\n", "expected 'station', 'halt' or 'signal station'"),
        ('name,km\n"A,0\n', "valid CSV"),
        ("name,km\nA,zero\nB,1\n", r"stations\[0\].km is 'zero'; expected a number"),
        ("name,km\nA,nan\nB,1\n", r"stations\[0\].km"),
        ("name,km\nA,0\nB,20000\n", r"stations\[1\].km"),
        ("name,km,tracks\nA,0,0\nB,1,1\n", r"stations\[0\].tracks"),
        ("name,km,tracks\nA,0,1.5\nB,1,1\n", r"stations\[0\].tracks"),
        ("name,km,tracks\nA,0,7\nB,1,1\n", r"stations\[0\].tracks"),
        ("name,km\nA,1\nB,1\n", r"stations\[1\].km is 1.0; expected more than 1, where A is"),
        (
            "name,km\nA,0\nA,1\n",
            r"stations\[1\].name is 'A'; expected a name of its own; .* a line has no branches",
        ),
        (
            "name,km\nA,0\nB,5\nC,9\nD,7\n",
            r"more than 9, where C is: .*; a line has no branches: one is a line of its",
        ),
        ("km\n0\n1\n", r"stations\[0\].name; expected a name"),
        ("name,km,id\nA,0,X\nB,1,X\n", r"stations\[1\].id is 'X'; expected an id of its own"),
        ("name,km,id\nA,0,a b\nB,1,X\n", r"stations\[0\].id"),
        ("name,km,kind\nA,0,halt\nB,1,\n", r"stations\[0\].kind is 'halt'; expected station"),
        ("name,km,kind\nA,0,\nB,1,yard\nC,2,\n", r"stations\[1\].kind is 'yard'"),
        ("name,km,kind,tracks\nA,0,,1\nB,1,halt,2\nC,2,,1\n", r"stations\[1\].tracks is 2; expected 1"),
        ("name,km,end\nA,0,\nB,1,portal\nC,2,\n", r"stations\[1\].end is 'portal'; expected nothing"),
        ("name,km,tracks,normal\nA,0,2,3\nB,1,1,\n", r"stations\[0\].normal is '3'; expected one of 1, 2"),
        (
            "name,km,tracks,points\nA,0,2,low\nB,1,1,\n",
            r"stations\[0\].points is 'low'; expected no points at the low",
        ),
        ("name,km,points\nA,0,\nB,1,both\nC,2,\n", r"stations\[1\].points is 'both'; expected nothing"),
        ("name,km,tracks,track_names\nA,0,2,1\nB,1,1,\n", r"track_names is '1'; expected 2 names"),
        ("name,km,tracks,track_names\nA,0,2,1 W\nB,1,1,\n", r"track_names is 'W'"),
        ("name,km,tracks,track_names\nA,0,2,1 1\nB,1,1,\n", "each track's name once"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_station_list(csv_list(tmp_path, text))
