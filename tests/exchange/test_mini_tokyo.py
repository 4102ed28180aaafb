"""From the files of mini-tokyo-3d to a published timetable, of any railway that they have."""

import json
from collections.abc import Mapping
from pathlib import Path

import pytest

from exchange.additions import read_additions, shipped_additions
from exchange.import_timetable import ImportOrder, import_timetable, write_timetable
from exchange.mini_tokyo import SOURCE as CREDIT
from exchange.mini_tokyo import read_mini_tokyo
from exchange.new_line import NewLineOptions, make_line
from exchange.published import PublishedTimetable
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from scenario.scenario import load_scenario
from study.feasibility.check import feasibility
from study.measures.standard_times import least_by_leg
from vehicle.train_file import load_train, train_named

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "../shared/data/timetables/mini_tokyo_3d"
SHIPPED = ROOT / "network/timetables"
needs_shared = pytest.mark.skipif(
    not FOLDER.exists(), reason="the timetable data is not beside this checkout"
)

CALENDARS = [("Weekday", "karasuyama_weekday"), ("SaturdayHoliday", "karasuyama_holiday")]
PREFIX = "JR-East.Karasuyama."


def row(number: str = "1M", changes: Mapping[str, object] | None = None) -> dict[str, object]:
    data: dict[str, object] = {
        "id": f"{PREFIX}{number}.Weekday",
        "n": number,
        "r": "JR-East.Karasuyama",
        "d": "Outbound",
        "os": [f"{PREFIX}Hoshakuji"],
        "ds": [f"{PREFIX}Karasuyama"],
        "tt": [{"s": f"{PREFIX}Hoshakuji", "d": "06:00"}, {"s": f"{PREFIX}Karasuyama", "a": "06:40"}],
    }
    return data | dict(changes or {})


def read(tmp_path: Path, *rows: dict[str, object], railway: str = "") -> PublishedTimetable:
    path = tmp_path / "source.json"
    path.write_text(json.dumps(rows), encoding="utf-8")
    return read_mini_tokyo(path, "Weekday", railway=railway)


@needs_shared
@pytest.mark.parametrize(("calendar", "name"), CALENDARS)
@pytest.mark.parametrize("stations", [None, FOLDER / "stations.json"])
def test_shipped_file_is_what_the_importer_writes(
    tmp_path: Path, calendar: str, name: str, stations: Path | None
) -> None:
    line = load_line(shipped_line("karasuyama"))
    published = read_mini_tokyo(FOLDER / "jreast-karasuyama.json", calendar, stations)
    order = ImportOrder(name, CREDIT, additions=read_additions(shipped_additions("karasuyama"), line))
    imported = import_timetable(published, line, order)
    out_file = tmp_path / f"{name}.toml"
    write_timetable(imported, out_file)
    assert out_file.read_text(encoding="utf-8") == (SHIPPED / f"{name}.toml").read_text(encoding="utf-8")
    assert list(tmp_path.iterdir()) == [out_file]
    assert imported.warnings == ()


@needs_shared
@pytest.mark.parametrize(
    ("file", "trains", "stations", "first", "last", "name"),
    [
        ("jreast-karasuyama", 27, 8, "宝積寺", "烏山", "Karasuyama Line, weekdays"),
        ("jreast-kururi", 40, 14, "木更津", "上総亀山", "Kururi Line, weekdays"),
        ("isumi-isumi", 29, 14, "大原", "上総中野", "Isumi Line, weekdays"),
        ("hitachinaka-minato", 68, 11, "勝田", "阿字ヶ浦", "Minato Line, weekdays"),
    ],
)
def test_published_weekdays(file: str, trains: int, stations: int, first: str, last: str, name: str) -> None:
    published = read_mini_tokyo(FOLDER / f"{file}.json", "Weekday", FOLDER / "stations.json")
    assert len(published.trains) == trains
    assert len(published.stations) == stations
    assert (published.stations[0].name_ja, published.stations[-1].name_ja) == (first, last)
    assert published.name == name
    order = {station.key: i for i, station in enumerate(published.stations)}
    for train in published.trains:
        places = [order[call.station_id] for call in train.calls]
        assert places == sorted(places, reverse=train.direction == "up")


@needs_shared
def test_what_lies_beyond_the_junction_is_known() -> None:
    published = read_mini_tokyo(FOLDER / "jreast-karasuyama.json", "Weekday")
    away = {train.number for train in published.trains if train.comes_from}
    assert len(away) == 11
    assert {train.comes_from for train in published.trains} == {"", "JR-East.Utsunomiya.Utsunomiya"}
    assert sum(bool(train.goes_to) for train in published.trains) == 10


def test_names_are_made_from_ids(tmp_path: Path) -> None:
    calls = [{"s": "X.Y.KazusaKameyama", "d": "06:00"}, {"s": "X.Y.Kururi", "a": "06:20"}]
    published = read(tmp_path, row("1M", {"r": "X.Y", "tt": calls}))
    assert [station.name for station in published.stations] == ["Kazusa-Kameyama", "Kururi"]


def test_links_name_trains_of_the_day(tmp_path: Path) -> None:
    other = "JR-East.Utsunomiya.9M.Weekday"
    published = read(
        tmp_path,
        row("1M", {"nt": [f"{PREFIX}2M.Weekday"], "pt": [other]}),
        row("2M", {"d": "Inbound", "pt": [f"{PREFIX}1M.Weekday", f"{PREFIX}7M.Weekday"], "nt": [other]}),
    )
    first, second = published.trains
    assert (first.becomes, first.follows, first.comes_from) == (("2M",), (), other)
    assert (second.becomes, second.follows, second.goes_to) == ((), ("1M",), other)


def test_a_train_of_another_railway_is_beyond(tmp_path: Path) -> None:
    away = ["JR-East.Utsunomiya.Utsunomiya"]
    published = read(tmp_path, row("1M", {"os": away}), row("3M"), row("5M", {"ds": away}))
    assert [(bool(t.comes_from), bool(t.goes_to)) for t in published.trains] == [
        (True, False),
        (False, False),
        (False, True),
    ]


def test_times_after_midnight_belong_to_the_day_before(tmp_path: Path) -> None:
    late = [{"s": f"{PREFIX}A", "d": "00:05"}, {"s": f"{PREFIX}B", "a": "00:30"}]
    over = [
        {"s": f"{PREFIX}A", "d": "23:50"},
        {"s": f"{PREFIX}B", "a": "23:59", "d": "00:01"},
        {"s": f"{PREFIX}C", "a": "03:10"},
    ]
    published = read(tmp_path, row("1M", {"tt": late}), row("3M", {"tt": over}))
    assert published.trains[0].calls[0].departure_s == 86_400 + 300
    assert published.trains[1].calls[1].departure_s == 86_400 + 60
    assert published.trains[1].calls[2].arrival_s == 86_400 + 3 * 3600 + 600


def test_a_number_twice_and_a_loop_are_told(tmp_path: Path) -> None:
    loop = [{"s": f"{PREFIX}{name}", "d": f"06:0{i}"} for i, name in enumerate("ABCA")]
    published = read(
        tmp_path,
        row("1M"),
        row("1M", {"id": f"{PREFIX}1M.2.Weekday"}),
        row("9M", {"tt": loop}),
    )
    assert [train.number for train in published.trains] == ["1M", "1M-2"]
    assert published.left == ("trains that come twice to one station: 9M",)


def test_one_railway_of_several_is_asked_for(tmp_path: Path) -> None:
    other = row("7D", {"r": "JR-East.Nikko", "id": "JR-East.Nikko.7D.Weekday"})
    with pytest.raises(InputError, match=r"expected one railway, one of JR-East.Karasuyama, JR-East.Nikko"):
        read(tmp_path, row(), other)
    got = read(tmp_path, row(), other, railway="JR-East.Nikko")
    assert [train.number for train in got.trains] == ["7D"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"d": "Round"}, r"\[0\].d is 'Round'; expected one of Outbound, Inbound"),
        ({"tt": [{"s": f"{PREFIX}Hoshakuji", "d": "06:00"}]}, "2 to 500 calls"),
        ({"tt": [{"s": f"{PREFIX}Taki", "d": "6:00"}, {"s": "X.Y"}]}, "'6:00'; expected a time HH:MM"),
        ({"tt": [{"s": f"{PREFIX}Taki"}, {"s": "X.Y"}]}, "an arrival or a departure"),
        (
            {"tt": [{"s": "A", "d": "06:00"}, {"s": "B", "a": "05:59"}]},
            r"tt\[1\].a is '05:59'; expected a time not before 06:00",
        ),
        ({"tt": 5}, "tt"),
        ({"n": " "}, r"\[0\].n is ' '; expected a train number"),
        ({"id": f"{PREFIX}1M.Sunday"}, "'Weekday'; expected a calendar that is in it: Sunday"),
    ],
)
def test_faulty_rows_are_named(tmp_path: Path, changes: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, row("1M", changes))


def test_two_trains_with_one_id_and_no_train(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\[1\].id is .*expected an id of its own"):
        read(tmp_path, row(), row())
    with pytest.raises(InputError, match="a calendar that is in it"):
        read(tmp_path)


def test_a_file_of_oudia_is_told_as_one_whatever_its_encoding(tmp_path: Path) -> None:
    path = tmp_path / "obama.oud"
    path.write_bytes("FileType=OuDia.1.02\r\nRosen.\r\nRosenmei=小浜線\r\n".encode("cp932"))
    with pytest.raises(InputError, match=r"this is one of OuDia, for branchline import oudia") as told:
        read_mini_tokyo(path, "Weekday")
    assert "iconv" not in str(told.value)


@pytest.mark.parametrize("text", ["{}", '\ufeff {"trains": [{"id": "1"}]}'])
def test_an_object_of_another_form_is_told_what_the_file_should_be(tmp_path: Path, text: str) -> None:
    path = tmp_path / "other.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(
        InputError, match=r"a JSON array of trains, each with id, n, d and tt; this is one JSON"
    ):
        read_mini_tokyo(path, "Weekday")


MINATO = """name,name_ja,km,tracks,kind
Katsuta,勝田,0.0,1,station
Kokimae,工機前,0.6,1,halt
Kaneage,金上,1.8,2,station
Nakane,中根,4.8,1,halt
Takadano-tekkyo,高田の鉄橋,7.1,1,halt
Nakaminato,那珂湊,8.2,3,station
Tonoyama,殿山,9.6,1,halt
Hiraiso,平磯,10.8,1,halt
Minohamagakuen,美乃浜学園,12.4,1,halt
Isozaki,磯崎,13.3,1,halt
Ajigaura,阿字ヶ浦,14.3,2,station
"""


@needs_shared
@pytest.mark.parametrize("train", [None, "br642"])
def test_a_day_of_departures_on_a_line_from_a_list_can_be_run(tmp_path: Path, train: str | None) -> None:
    """The Minato weekday, of which the source gives arrivals at the ends and Nakaminato alone."""
    listed, line_file, day = (
        tmp_path / name for name in ("minato.csv", "minato.toml", "minato_weekday.toml")
    )
    listed.write_text(MINATO, encoding="utf-8")
    line = make_line(listed, "minato", NewLineOptions()).line
    line_file.write_text(make_line(listed, "minato", NewLineOptions()).text, encoding="utf-8")
    least = None if train is None else least_by_leg(line, load_train(train_named(train)))
    published = read_mini_tokyo(FOLDER / "hitachinaka-minato.json", "Weekday", FOLDER / "stations.json")
    imported = import_timetable(published, line, ImportOrder("minato_weekday", CREDIT, least=least))
    write_timetable(imported, day)
    calls = {call.station_id: call for call in imported.timetable.trains["102"].calls}
    assert calls["MNH"].arrival_s == 5 * 3600 + 40  # 20 s before 05:01
    scenario = tmp_path / "day.toml"
    scenario.write_text(
        'id = "day"\nname = "Day"\nline = "minato.toml"\ntimetable = "minato_weekday.toml"\n'
        '[trains]\ndefault = "br642"\n',
        encoding="utf-8",
    )
    found = feasibility(load_scenario(str(scenario)).setup)
    assert len(imported.timetable.trains) == 68
    assert found.impossible == ()
    short = [text for text in imported.remarks if text.startswith("times too short")]
    assert any("from Isozaki to Minohamagakuen 60 s are left" in text for text in short)


def test_all_halts_where_trains_turn_are_named_at_once(tmp_path: Path) -> None:
    turning = [f"{PREFIX}{name}" for name in ("Konoyama", "Taki")]
    rows = [
        row(
            number,
            {"tt": [{"s": f"{PREFIX}Hoshakuji", "d": "06:00"}, {"s": name, "a": "06:40"}], "ds": [name]},
        )
        for number, name in zip(("1M", "3M"), turning, strict=True)
    ]
    line = load_line(shipped_line("karasuyama"))
    with pytest.raises(InputError, match=r"Konoyama, Taki.*kind = station"):
        import_timetable(read(tmp_path, *rows), line, ImportOrder("day", CREDIT))
