"""GTFS feeds: one day read, what is left out said, damage named; a timetable written and read again."""

import csv
import io
import json
import shutil
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.gtfs import tables as tables_module
from exchange.gtfs.days import next_date, read_services
from exchange.gtfs.exact import read_back
from exchange.gtfs.reader import GtfsChoice, GtfsDay, read_gtfs
from exchange.gtfs.tables import Feed
from exchange.gtfs.writer import FeedFacts, degrees_of, tables_of, write_gtfs
from exchange.import_timetable import ImportOrder, import_timetable
from exchange.published import PublishedTimetable, PublishedTrain
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_names, shipped_timetable
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import parse_toml
from network.model import Direction
from network.timetable import CallKind, Timetable, timetable_of
from tests.exchange.random_timetables import timetables

ROOT = Path(__file__).resolve().parents[2]
WKD = ROOT / "../shared/data/timetables/wkd_gtfs"
needs_shared = pytest.mark.skipif(not WKD.exists(), reason="the timetable data is not beside this checkout")

LINES = {name: load_line(shipped_line(name)) for name in ("karasuyama", "busy_line")}

Table = Sequence[Sequence[str]]


# Two tracks at the first of three stations; a trip there and one back on weekdays, one at the weekend, and a bus.
FEED = {
    "agency.txt": """agency_id,agency_name,agency_url,agency_timezone
1,A,https://example.com/,Asia/Tokyo""",
    "stops.txt": """stop_id,stop_name,stop_lat,stop_lon,location_type,parent_station,platform_code
A,Aoki,36.0,140.0,1,,
A1,Aoki,36.0,140.0,0,A,1
A2,Aoki,36.0,140.0,0,A,2
B,Bessho,36.1,140.0,0,,
C,Chuo,36.2,140.0,0,,""",
    "routes.txt": """route_id,route_short_name,route_type
R,Line,2
Q,Bus,3""",
    "trips.txt": """route_id,service_id,trip_id,direction_id,block_id
R,WD,1,0,x
R,WD,2,1,x
R,WE,9,0,
Q,WD,b,0,""",
    "stop_times.txt": """trip_id,arrival_time,departure_time,stop_id,stop_sequence,pickup_type,drop_off_type
1,6:00:00,6:00:00,A1,1,,
1,6:05:00,6:06:00,B,5,,
1,6:10:00,6:10:00,C,9,,
2,23:50:00,23:50:00,C,1,,
2,23:59:00,24:01:00,B,2,1,1
2,24:10:00,24:10:00,A2,3,,
9,00:30:00,00:30:00,A1,1,,
9,00:40:00,00:40:00,C,2,,
b,07:00:00,07:00:00,A,1,,
b,07:40:00,07:40:00,C,2,,""",
    "calendar.txt": """service_id,monday,tuesday,wednesday,thursday,friday,saturday,sunday,start_date,end_date
WD,1,1,1,1,1,0,0,20260101,20261231
WE,0,0,0,0,0,1,1,20260101,20261231""",
}


def feed() -> dict[str, list[list[str]]]:
    """The rows of each table, its columns first."""
    return {name: [row.split(",") for row in text.splitlines()] for name, text in FEED.items()}


def write(path: Path, tables: Mapping[str, Table]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, rows in tables.items():
            text = io.StringIO()
            csv.writer(text).writerows(rows)
            archive.writestr(name, "\ufeff" + text.getvalue())  # many feeds begin with a mark
    return path


def read(tmp_path: Path, tables: Mapping[str, Table], **choice: object) -> GtfsDay:
    return read_gtfs(write(tmp_path / "feed.zip", tables), GtfsChoice(**choice))  # type: ignore[arg-type]


def train(day: GtfsDay, number: str) -> PublishedTrain:
    return next(train for train in day.published.trains if train.number == number)


@needs_shared
def test_wkd_feed() -> None:
    day = read_gtfs(WKD)
    assert (day.trips, day.stops, day.calls) == (206, 29, 2331)
    published = day.published
    assert len(published.trains) == 206 - 55
    assert any(text.startswith("55 trips that are not by rail") for text in published.left)
    # the feed has a trip that stands for a day at Milanowek
    assert any("over 6 h lie between two calls: 2068" in text for text in published.left)
    names = [station.name for station in published.stations]
    assert names[0] == "Warszawa Śródmieście WKD"
    assert names.index("Komorów") < names.index("Podkowa Leśna Główna") < names.index("Kazimierówka")


def test_a_weekday(tmp_path: Path) -> None:
    day = read(tmp_path, feed(), date="2026-11-20")
    assert [t.number for t in day.published.trains] == ["1", "2", "9"]
    assert [station.key for station in day.published.stations] == ["A", "B", "C"]
    assert day.published.stations[0].tracks == ("1", "2")
    first, back, late = day.published.trains
    assert [c.station_id for c in first.calls] == ["A", "B", "C"]
    assert (first.calls[0].arrival_s, first.calls[0].departure_s, first.calls[0].track) == (None, 21_600, "1")
    assert (first.calls[-1].arrival_s, first.calls[-1].departure_s) == (22_200, None)
    assert (first.direction, back.direction) == ("down", "up")
    assert (first.working, back.working) == ("x", "x")
    assert back.calls[1].kind is CallKind.OPERATIONAL
    assert back.calls[1].departure_s == 86_460
    # 20 November is a Friday: what runs at 00:30 on Saturday is the end of its day
    assert late.calls[0].departure_s == 86_400 + 1800
    assert any(
        "1 trips that are not by rail (route_type 3, route Bus): b" in text for text in day.published.left
    )


def test_a_date_takes_the_night_after_it(tmp_path: Path) -> None:
    monday = read(tmp_path, feed(), date="20261116")
    assert [t.number for t in monday.published.trains] == ["1", "2"]
    saturday = read(tmp_path, feed(), date="20261121")
    assert [t.number for t in saturday.published.trains] == ["9"]
    with pytest.raises(InputError, match="a trip by rail on that day"):
        read(tmp_path, feed(), date="20271121")


def test_exceptions_of_a_calendar(tmp_path: Path) -> None:
    tables = feed()
    tables["calendar_dates.txt"] = [
        ["service_id", "date", "exception_type"],
        *(["WD", "20261116", "2"], ["WE", "20261117", "1"]),
    ]
    assert [t.number for t in read(tmp_path, tables, date="20261116").published.trains] == ["9"]
    del tables["calendar.txt"]
    services = read_services(Feed.at_path(write(tmp_path / "dates.zip", tables)))
    assert services.running_on(20261117) == {"WE"}
    assert services.running_on(20261116) == frozenset()


def test_the_day_after() -> None:
    assert [next_date(d) for d in (20260228, 20240228, 20261231, 20260430)] == [
        20260301,
        20240229,
        20270101,
        20260501,
    ]


def test_one_service_or_a_choice(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"a service, or --date YYYY-MM-DD; there are: WD \(2 trips\), WE \(1 trips\)"
    ):
        read(tmp_path, feed())
    assert len(read(tmp_path, feed(), service="WD").published.trains) == 2
    with pytest.raises(InputError, match="--service is 'X'; expected one of WD, WE"):
        read(tmp_path, feed(), service="X")
    bus = read(tmp_path, feed(), service="WD", routes=("Bus",))
    assert [t.number for t in bus.published.trains] == ["b"]
    with pytest.raises(InputError, match="--route"):
        read(tmp_path, feed(), routes=("Tram",))


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    tables = feed()
    tables["frequencies.txt"] = [
        ["trip_id", "start_time", "end_time", "headway_secs"],
        ["1", "6:00", "7:00", "600"],
    ]
    tables["trips.txt"] += [["R", "WD", "loop", "0", ""], ["R", "WD", "short", "0", ""]]
    for i, stop in enumerate(("A1", "B", "C", "A2")):
        tables["stop_times.txt"].append(["loop", f"08:0{i}:00", f"08:0{i}:00", stop, str(i), "", ""])
    tables["stop_times.txt"].append(["short", "08:00:00", "08:00:00", "B", "0", "", ""])
    left = " ".join(read(tmp_path, tables, service="WD").published.left)
    assert "1 trips given by headway (frequencies.txt): 1" in left
    assert "1 trips that come twice to one station: loop" in left
    assert "1 trips with less than two stations: short" in left


def test_an_empty_working_and_names_in_two_writings(tmp_path: Path) -> None:
    tables = feed()
    tables["stop_times.txt"] = [
        row if row[0] != "1" else [*row[:5], "1", "1"] for row in tables["stop_times.txt"]
    ]
    tables["translations.txt"] = [
        ["table_name", "field_name", "language", "translation", "record_id", "field_value"],
        *(["stops", "stop_name", "ja", "青木", "A", ""], ["stops", "stop_name", "ja", "別所", "", "Bessho"]),
    ]
    day = read(tmp_path, tables, service="WD")
    assert not train(day, "1").revenue
    assert [s.name_ja for s in day.published.stations] == ["青木", "別所", ""]
    assert {call.kind for call in train(day, "1").calls} == {CallKind.STOP}


def damaged(table: str, row: int, column: int, text: str) -> dict[str, list[list[str]]]:
    tables = feed()
    tables[table][row][column] = text
    return tables


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (
            damaged("stop_times.txt", 2, 1, "6:5"),
            r"stop_times.txt: line 3.arrival_time is '6:5'; expected a time",
        ),
        (damaged("stop_times.txt", 2, 3, "X"), r"line 3.stop_id is 'X'; expected a stop of stops.txt"),
        (damaged("stop_times.txt", 2, 0, "7"), r"line 3.trip_id is '7'; expected a trip of trips.txt"),
        (damaged("stop_times.txt", 2, 4, "-1"), r"line 3.stop_sequence is '-1'; expected a whole number"),
        (damaged("stop_times.txt", 2, 4, "9"), "a trip whose calls have numbers of their own"),
        (
            damaged("stop_times.txt", 2, 1, "5:59:59"),
            r"arrival_time of trip 1 is '05:59:59'; expected a time not before",
        ),
        (
            damaged("stop_times.txt", 0, 0, "trip"),
            r"stop_times.txt: trip_id; expected this column; the columns are: trip,",
        ),
        (damaged("trips.txt", 1, 0, "X"), r"trips.txt: line 2.route_id is 'X'; expected one of R, Q"),
        (damaged("trips.txt", 2, 2, "1"), r"line 3.trip_id is '1'; expected an id of its own"),
        (damaged("trips.txt", 1, 3, "up"), r"direction_id is 'up'; expected 0, 1 or nothing"),
        (damaged("routes.txt", 1, 2, "rail"), r"route_type is 'rail'; expected a number"),
        (damaged("stops.txt", 2, 5, "Z"), r"stops.txt: line 3.parent_station is 'Z'; expected a stop"),
        (damaged("routes.txt", 2, 0, "R"), r"routes.txt: line 3.route_id is 'R'; expected an id of its own"),
        (damaged("calendar.txt", 2, 0, "WD"), r"calendar.txt: line 3.service_id is 'WD'; expected an id of"),
        (damaged("calendar.txt", 1, 1, "yes"), r"line 2.monday is 'yes'; expected 0 or 1"),
        (damaged("calendar.txt", 1, 8, "20260230"), r"start_date is '20260230'; expected a date YYYYMMDD"),
    ],
)
def test_damage_is_named_in_one_line(
    tmp_path: Path, tables: dict[str, list[list[str]]], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, tables, service="WD")


@pytest.mark.parametrize(
    "missing", ["stop_times.txt", "stops.txt", "trips.txt", "routes.txt", "calendar.txt"]
)
def test_a_missing_table_is_named(tmp_path: Path, missing: str) -> None:
    tables = feed()
    del tables[missing]
    with pytest.raises(InputError, match=missing):
        read(tmp_path, tables, service="WD")


def test_no_feed_at_all(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a GTFS feed: a zip archive, or a folder"):
        read_gtfs(tmp_path / "none.zip")
    (tmp_path / "text.zip").write_text("trip_id,arrival_time", encoding="utf-8")
    with pytest.raises(InputError, match="which is a zip archive"):
        read_gtfs(tmp_path / "text.zip")
    whole = write(tmp_path / "whole.zip", feed()).read_bytes()
    (tmp_path / "cut.zip").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="which is a zip archive"):
        read_gtfs(tmp_path / "cut.zip")
    write(tmp_path / "deep.zip", {f"gtfs/{name}": rows for name, rows in feed().items()})
    with pytest.raises(InputError, match=r"tables at the top of the archive, not gtfs/stop_times.txt"):
        read_gtfs(tmp_path / "deep.zip")


def test_another_encoding_is_named(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "sjis.zip", "w") as archive:
        for name, rows in feed().items():
            text = "\n".join(",".join(row) for row in rows).replace("Aoki", "青木")
            archive.writestr(name, text.encode("cp932"))
    with pytest.raises(InputError, match=r"stops.txt; expected text in UTF-8 \(after line"):
        read_gtfs(tmp_path / "sjis.zip", GtfsChoice(service="WD"))


def test_a_bomb_is_cut_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables_module, "TABLE_BYTES_MAX", 1 << 20)
    tables = feed()
    with zipfile.ZipFile(write(tmp_path / "bomb.zip", tables), "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("frequencies.txt", b"trip_id\n" + b"\n" * (4 << 20))
    with pytest.raises(InputError, match="a table of at most 1 MiB"):
        read_gtfs(tmp_path / "bomb.zip", GtfsChoice(service="WD"))


@given(data=st.data())
def test_a_damaged_byte_is_bad_input_or_another_feed(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = write(tmp_path_factory.mktemp("damaged") / "feed.zip", feed())
    whole = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(whole[: data.draw(st.integers(1, len(whole)))] if data.draw(st.booleans()) else whole)
    try:
        read_gtfs(path, GtfsChoice(service="WD"))
    except InputError as error:
        assert "\n" not in str(error)


def shipped(name: str) -> tuple[Timetable, str]:
    entry = parse_toml(shipped_timetable(name).read_text(encoding="utf-8"), name, TimetableFile)
    line = load_line(shipped_line(entry.timetable.line))
    return timetable_of(entry, name, line), entry.timetable.line


def again(
    tmp_path: Path, timetable: Timetable, line_name: str
) -> tuple[Timetable | None, PublishedTimetable, str]:
    line = load_line(shipped_line(line_name))
    path = tmp_path / f"{timetable.head.id}.zip"
    write_gtfs(path, line, timetable)
    day = read_gtfs(path)
    assert day.written is not None
    file, why = read_back(day.written, line, str(path))
    return (timetable_of(file, "again", line) if file is not None else None), day.published, why


@pytest.mark.parametrize("name", shipped_names("timetables"))
def test_a_shipped_timetable_comes_back_as_it_was(tmp_path: Path, name: str) -> None:
    timetable, line_name = shipped(name)
    back, published, why = again(tmp_path, timetable, line_name)
    assert back == timetable, why
    shutil.unpack_archive(tmp_path / f"{timetable.head.id}.zip", tmp_path / "folder")
    assert replace(published, source="") == replace(read_gtfs(tmp_path / "folder").published, source="")


def test_a_timetable_with_a_long_head_comes_back_as_it_was(tmp_path: Path) -> None:
    timetable, line_name = shipped("busy_line")
    head = timetable.head.model_copy(update={"sources": ["x" * 400] * 400})  # 160 kB in one field
    back, _, why = again(tmp_path, replace(timetable, head=head), line_name)
    assert back is not None, why
    assert back.head == head


@pytest.mark.parametrize("name", ["karasuyama_weekday", "busy_line"])
def test_without_our_columns_blocks_still_give_the_sets(tmp_path: Path, name: str) -> None:
    timetable, line_name = shipped(name)
    line = load_line(shipped_line(line_name))
    plain = {
        table: _without(rows, "branchline_")
        for table, rows in tables_of(line, timetable, FeedFacts()).items()
    }
    day = read_gtfs(write(tmp_path / "plain.zip", plain))
    assert day.written is None
    got = import_timetable(day.published, line, ImportOrder("again", "a feed")).timetable
    assert {
        n: [(c.station_id, c.departure_s or c.arrival_s) for c in t.calls] for n, t in got.trains.items()
    } == {
        n: [(c.station_id, c.departure_s or c.arrival_s) for c in t.calls]
        for n, t in timetable.trains.items()
    }
    assert sum(len(d.train_numbers) for d in got.diagrams) == len(timetable.trains)


def _without(rows: Table, prefix: str) -> list[list[str]]:
    kept = [i for i, name in enumerate(rows[0]) if not name.startswith(prefix)]
    return [[row[i] for i in kept] for row in rows]


def test_a_changed_feed_is_read_as_any_other(tmp_path: Path) -> None:
    timetable, line_name = shipped("karasuyama_weekday")
    line = load_line(shipped_line(line_name))
    tables = {
        name: [list(row) for row in rows] for name, rows in tables_of(line, timetable, FeedFacts()).items()
    }
    tables["trips.txt"] = [row for row in tables["trips.txt"] if row[2] != "344M"]
    tables["stop_times.txt"] = [row for row in tables["stop_times.txt"] if row[0] != "344M"]
    day = read_gtfs(write(tmp_path / "less.zip", tables))
    assert day.written is not None
    file, why = read_back(day.written, line, "less.zip")
    assert file is None
    assert "it was changed since it was written" in why
    assert (
        read_back(day.written, load_line(shipped_line("busy_line")), "")[1]
        == "it was written of karasuyama, not busy_line"
    )


def test_what_gtfs_asks_for_is_there(tmp_path: Path) -> None:
    """Files, fields and references of the GTFS schedule reference that are required."""
    timetable, line_name = shipped("karasuyama_weekday")
    line = load_line(shipped_line(line_name))
    path = tmp_path / "feed.zip"
    write_gtfs(path, line, timetable, FeedFacts(centre=(36.6491, 140.067)))
    with zipfile.ZipFile(path) as archive:
        tables = {
            name: list(csv.DictReader(io.StringIO(archive.read(name).decode("utf-8"))))
            for name in archive.namelist()
        }
    assert {"agency.txt", "stops.txt", "routes.txt", "trips.txt", "stop_times.txt", "calendar.txt"} <= set(
        tables
    )
    (agency,) = tables["agency.txt"]
    assert agency["agency_url"].startswith("https://")
    assert agency["agency_timezone"] == "Asia/Tokyo"
    stops = {row["stop_id"]: row for row in tables["stops.txt"]}
    assert len(stops) == len(tables["stops.txt"])
    for row in stops.values():
        assert row["parent_station"] == "" if row["location_type"] == "1" else row["parent_station"] in stops
        # the line lies between Utsunomiya and Karasuyama
        assert 36.6 < float(row["stop_lat"]) < 36.7
        assert 139.9 < float(row["stop_lon"]) < 140.2
    trips = {row["trip_id"]: row for row in tables["trips.txt"]}
    down = [number for number, train in timetable.trains.items() if train.direction is Direction.DOWN]
    assert [number for number, row in trips.items() if row["direction_id"] == "0"] == down  # as it is read
    for row in tables["stop_times.txt"]:
        assert row["trip_id"] in trips
        assert stops[row["stop_id"]]["location_type"] == "0"
        assert row["arrival_time"]
        assert row["departure_time"]
    empty = [row for row in tables["stop_times.txt"] if row["trip_id"] == "E346M"]
    assert {(row["pickup_type"], row["drop_off_type"]) for row in empty} == {("1", "1")}
    assert {row["block_id"] for row in tables["trips.txt"]} == {"V1", "V2", "V3", "V4"}
    assert json.loads(tables["feed_info.txt"][0]["branchline_timetable"])["line"] == "karasuyama"


def test_the_same_timetable_gives_the_same_bytes(tmp_path: Path) -> None:
    timetable, line_name = shipped("busy_line")
    line = load_line(shipped_line(line_name))
    for name in ("a.zip", "b.zip"):
        write_gtfs(tmp_path / name, line, timetable)
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.zip", "b.zip"]


@given(st.floats(-30_000, 30_000), st.floats(-30_000, 30_000), st.floats(-60, 60))
def test_places_on_the_earth(east_m: float, north_m: float, latitude: float) -> None:
    pyproj = pytest.importorskip("pyproj")
    plane = f"+proj=tmerc +lat_0={latitude} +lon_0=140 +k=1 +x_0=0 +y_0=0 +ellps=GRS80 +units=m"
    lon, lat = pyproj.Transformer.from_crs(plane, "EPSG:4326", always_xy=True).transform(east_m, north_m)
    got = degrees_of(east_m, north_m, (latitude, 140.0))
    assert got == pytest.approx((lat, lon), abs=1e-5)  # a metre


@pytest.mark.parametrize("name", ["karasuyama", "busy_line"])
@given(data=st.data())
def test_any_timetable_comes_back_as_it_was(
    tmp_path_factory: pytest.TempPathFactory, name: str, data: st.DataObject
) -> None:
    timetable = data.draw(timetables(LINES[name]))
    path = tmp_path_factory.mktemp("drawn") / "feed.zip"
    write_gtfs(path, LINES[name], timetable)
    day = read_gtfs(path, GtfsChoice(service="DAY"))
    assert day.written is not None
    file, why = read_back(day.written, LINES[name], "feed.zip")
    assert file is not None, why
    assert timetable_of(file, "again", LINES[name]) == timetable
