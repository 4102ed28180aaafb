"""What a file says of its trains, in each generation of the format, and what becomes of it as a published timetable."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.oudia.cells import (
    CallHandling,
    OudiaCell,
    cell,
    cell_text,
    operating_day,
    operation,
    operation_text,
    seconds,
    time_text,
)
from exchange.oudia.nodes import parse_oudia, read_oudia
from exchange.oudia.published import published_of
from exchange.oudia.route import OudiaRoute, route_of, summary_of
from exchange.published import PublishedTrain
from network.errors import InputError
from network.timetable import CallKind

FOLDER = Path(__file__).resolve().parents[3] / "../shared/data/timetables/oudia"
needs_shared = pytest.mark.skipif(
    not FOLDER.exists(), reason="the timetable data is not beside this checkout"
)

STATION = """Eki.
Ekimei={name}
Ekijikokukeisiki=Jikokukeisiki_Hatsu
Ekikibo=Ekikibo_Ippan
DownMain=0
UpMain=1
EkiTrack2Cont.
EkiTrack2.
TrackName=1番線
TrackRyakusyou=1
.
EkiTrack2.
TrackName=2番線
TrackRyakusyou=2
.
EkiTrack2.
TrackName=待避線
TrackRyakusyou=3
.
.
OuterTerminal.
OuterTerminalEkimei=車庫
.
.
"""
TRAIN = "Ressya.\nHoukou={way}\nSyubetsu={kind}\nRessyabangou={number}\n{rest}\n.\n"


def train(rest: str, way: str = "Kudari", number: str = "1M", kind: int = 0) -> str:
    return TRAIN.format(way=way, kind=kind, number=number, rest=rest)


def route(*trains: str, kind: str = "OuDiaSecond.1.10", dias: tuple[str, ...] = ("平日",)) -> OudiaRoute:
    down = "".join(one for one in trains if "Houkou=Kudari" in one)
    up = "".join(one for one in trains if "Houkou=Kudari" not in one)
    text = f"FileType={kind}\nRosen.\nRosenmei=試験線\n"
    text += "".join(STATION.format(name=name) for name in "ABCD")
    text += "".join(f"Ressyasyubetsu.\nSyubetsumei={name}\n.\n" for name in ("普通", "回送", "急行"))
    text += "".join(f"Dia.\nDiaName={name}\nKudari.\n{down}.\nNobori.\n{up}.\n.\n" for name in dias)
    text += "EnableOperation=2\n.\nDispProp.\n.\n"
    return route_of(parse_oudia(b"\xef\xbb\xbf" + text.encode(), "day.oud2"), "day.oud2")


def published(*trains: str, kind: str = "OuDiaSecond.1.10") -> tuple[PublishedTrain, ...]:
    read = route(*trains, kind=kind)
    return published_of(read, read.dias[0]).trains


def hm(text: str) -> int:
    return int(text[:-2]) * 3600 + int(text[-2:]) * 60


@pytest.mark.parametrize(
    ("text", "time_s"),
    [
        ("", None),
        ("459", hm("459")),
        ("45930", hm("459") + 30),
        ("000", 0),
        ("1315", hm("1315")),
        (" 542", hm("542")),
        ("13:15", hm("1315")),
        ("131545", hm("1315") + 45),
    ],
)
def test_times_as_they_are_written(text: str, time_s: int | None) -> None:
    assert seconds(text) == time_s


@pytest.mark.parametrize("text", ["2400", "1260", "12", "1", "-100", "x", "1234567", "10:0"])
def test_what_is_no_time_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"^|\w"):
        seconds(text)


@pytest.mark.parametrize(
    ("text", "of"),
    [
        ("", OudiaCell(CallHandling.NONE)),
        ("1;012/013$2", OudiaCell(CallHandling.STOP, hm("012"), hm("013"), 2)),
        ("2$0", OudiaCell(CallHandling.PASS, None, None, 0)),
        ("1;033/$3", OudiaCell(CallHandling.STOP, hm("033"), None, 3)),
        ("1;035", OudiaCell(CallHandling.STOP, None, hm("035"))),
        ("1;/035", OudiaCell(CallHandling.STOP, None, hm("035"))),
        ("2", OudiaCell(CallHandling.PASS)),
        ("1", OudiaCell(CallHandling.STOP)),
        ("3", OudiaCell(CallHandling.OTHER_WAY)),
    ],
)
def test_a_train_at_a_station(text: str, of: OudiaCell) -> None:
    assert cell(text) == of


@pytest.mark.parametrize("text", ["5;100", "1;100/200/300", "1;99", "a", "1;2530", "1;100$x"])
def test_what_is_no_train_at_a_station_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"^|\w"):
        cell(text)


times = st.none() | st.integers(0, 86_399)


@given(st.sampled_from([CallHandling.STOP, CallHandling.PASS]), times, times, st.none() | st.integers(0, 9))
def test_a_train_at_a_station_is_written_and_read_the_same(
    how: CallHandling, arrival_s: int | None, departure_s: int | None, track: int | None
) -> None:
    of = OudiaCell(how, arrival_s, departure_s, track)
    assert cell(cell_text(of)) == of


@given(st.integers(0, 6), st.lists(st.text("0123;VA", max_size=4), max_size=5))
def test_operations_are_written_and_read_the_same(kind: int, parts: list[str]) -> None:
    of = operation(operation_text(kind, *parts))
    assert of.kind == kind
    assert [of.part(i) for i in range(5)] == [*parts, *[""] * (5 - len(parts))]


def test_operations_as_files_have_them() -> None:
    assert operation("4/1$1000/1012$K7/11A;12B").parts == ("1", "1000", "1012", "K7", "11A;12B")
    assert operation("5/1000$A").parts == ("1000", "A")
    assert operation("3/2359$/1;2").parts == ("2359", "", "1;2")


@given(st.integers(3 * 3600, 27 * 3600 - 1), st.lists(st.integers(0, 12 * 3600 - 1), max_size=6))
def test_times_without_a_day_are_of_the_operating_day(first_s: int, steps: list[int]) -> None:
    times_s = [first_s]
    for step_s in steps:
        times_s.append(times_s[-1] + step_s)
    assert list(operating_day([time_s % 86_400 for time_s in times_s])) == times_s


@given(st.integers(0, 86_399))
def test_a_time_is_read_as_it_is_written(time_s: int) -> None:
    assert seconds(time_text(time_s)) == time_s
    assert time_text(time_s + 86_400) == time_text(time_s)


def test_trains_run_along_and_against_the_list() -> None:
    down, up = published(
        train("EkiJikoku=1;500,1;510/511,2,1;530/"),
        train("EkiJikoku=,1;600,1;610/", way="Nobori", number="2M"),
    )
    assert [(call.station_id, call.kind) for call in down.calls] == [
        ("0", CallKind.STOP),
        ("1", CallKind.STOP),
        ("2", CallKind.PASS),
        ("3", CallKind.STOP),
    ]
    assert (down.direction, up.direction) == ("down", "up")
    assert [call.station_id for call in up.calls] == ["2", "1"]
    assert [(call.arrival_s, call.departure_s) for call in down.calls][1:3] == [
        (hm("510"), hm("511")),
        (None, None),
    ]


def test_a_train_before_three_belongs_to_the_day_before() -> None:
    one, two, three = published(
        train("EkiJikoku=1;2350,1;010/011,1;030/"),
        train("EkiJikoku=1;010,1;030/", number="3M"),
        train("EkiJikoku=1;300,1;310/", number="5M"),
    )
    assert [call.departure_s or call.arrival_s for call in one.calls] == [hm("2350"), hm("2411"), hm("2430")]
    assert one.calls[1].arrival_s == hm("2410")
    assert two.calls[0].departure_s == hm("2410")
    assert three.calls[0].departure_s == hm("300")


def test_a_passing_with_two_times_is_a_stop_without_passengers() -> None:
    (one,) = published(train("EkiJikoku=1;500,2;510/513,2;520/520,1;530/"))
    assert [call.kind for call in one.calls[1:3]] == [CallKind.OPERATIONAL, CallKind.PASS]
    assert (one.calls[2].arrival_s, one.calls[2].departure_s) == (None, hm("520"))


def test_a_track_is_named_where_it_is_not_the_main_one() -> None:
    down, up = published(
        train("EkiJikoku=1;500$0,1;510/511$2,1;530/$1"),
        train("EkiJikoku=1;600$1,1;610/611$0,1;630/$9", way="Nobori", number="2M"),
    )
    assert [call.track for call in down.calls] == [None, "待避線", "2番線"]
    assert [call.track for call in up.calls] == [None, "1番線", "[9]"]  # there is none: who reads it says so


def test_tracks_of_older_files_stand_in_a_value_of_their_own() -> None:
    (one,) = published(
        train("EkiJikoku=1;500,1;510/511,1;530/\nRessyaTrack=0,3;2/515$x,2"), kind="OuDiaSecond.1.04"
    )
    assert [call.track for call in one.calls] == [None, "待避線", "2番線"]


def test_sets_go_on_as_the_next_train_from_the_same_track() -> None:
    up = "EkiJikoku=,,1;{},1;{}/\nOperation2B=5/$\nOperation3A={}"
    trains = (
        train("EkiJikoku=1;500$0,1;530/$1\nOperation0B=3/450$/11\nOperation1A=5/$0"),
        train("EkiJikoku=1;500$0,1;520/$0\nOperation0B=3/450$/12\nOperation1A=5/$0", number="3M"),
        train(up.format("519$0", "550", "3/600$"), way="Nobori", number="8M"),  # gone before 3M comes
        train(up.format("525$0", "600", "3/610$"), way="Nobori", number="2M"),
        train(up.format("540$1", "610", "4/0$611/615$"), way="Nobori", number="4M"),
    )
    found = {one.number: one for one in published(*trains)}
    assert {number: one.becomes for number, one in found.items()} == {
        "1M": ("4M",),
        "3M": ("2M",),
        "2M": (),
        "4M": (),
        "8M": (),
    }
    assert found["4M"].goes_to == "車庫"
    assert not any(one.comes_from for one in found.values())


def test_a_link_between_trains_without_numbers_of_their_own_is_left_and_said() -> None:
    read = route(
        train("EkiJikoku=1;500$0,1;530/$1\nOperation0B=3/450$/11\nOperation1A=5/$0"),
        train("EkiJikoku=,,1;540$1,1;610/\nOperation2B=5/$\nOperation3A=3/620$", way="Nobori"),
    )
    found = published_of(read, read.dias[0])
    assert [one.becomes for one in found.trains] == [(), ()]
    assert found.left == ("1 links between trains that have no number of their own",)


def test_a_set_from_beyond_arrives_when_its_operation_says() -> None:
    (one,) = published(train("EkiJikoku=1;500$0,1;530/$0\nOperation0B=4/0$440/458$/11\nOperation1A=3/540$"))
    assert one.comes_from == "車庫"
    assert (one.calls[0].arrival_s, one.calls[0].departure_s) == (hm("458"), hm("500"))
    (old,) = published(
        train("EkiJikoku=1;500$0,1;530/$0\nOperation0B=4/0$440/458$11"), kind="OuDiaSecond.1.07"
    )
    assert old.calls[0].arrival_s == hm("458")


def test_numbers_of_sets_in_older_files_stand_elsewhere() -> None:
    read = route(
        train("EkiJikoku=1;500$0,1;530/$0\nOperation0B=3/450$V7"),
        train("EkiJikoku=1;600$0,1;630/$0\nOperation0B=5/$0/V8", number="3M"),
        kind="OuDiaSecond.1.08",
    )
    one, other = (found.before for found in read.dias[0].trains)
    assert one is not None
    assert other is not None
    assert (one.part(2), other.part(1)) == ("V7", "V8")


def test_trains_that_carry_nobody_are_known_by_their_kind() -> None:
    found = published(train("EkiJikoku=1;500,1;530/"), train("EkiJikoku=1;600,1;630/", number="回3", kind=1))
    assert [one.revenue for one in found] == [True, False]


def test_what_does_not_run_is_left_and_said() -> None:
    read = route(
        train("EkiJikoku=1;500,1;530/\nCanceled=1"),
        train("EkiJikoku=", number="3M"),
        train("EkiJikoku=1;700,1;730/\nBikou=臨時", number="5M"),
        "Ressya.\n.\n",
        kind="OuDiaSecond.1.15",
    )
    found = published_of(read, read.dias[0])
    assert [one.number for one in found.trains] == ["5M"]
    assert found.left == (
        "trains that are cancelled (運休): 1",
        "trains that are at no station: 1",
    )
    assert summary_of(read.dias[0])["trains"] == 3


@pytest.mark.parametrize(
    ("rest", "message"),
    [
        (
            "EkiJikoku=1;500,1;2530/",
            "train 1M (line 112), B is '1;2530/'; expected how;arrival/departure$track",
        ),
        ("EkiJikoku=1;500,,,,1;530/", "5 in EkiJikoku'; expected at most 4 stations"),
        ("EkiJikoku=1;500,1;530/\nOperation0B=x/1", "Operation0B is 'x/1'; expected a kind of operation"),
    ],
)
def test_a_value_that_is_none_is_refused_with_its_train(rest: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        route(train(rest))
    assert message in str(error.value)


def test_of_several_dias_one_has_to_be_named() -> None:
    read = route(train("EkiJikoku=1;500,1;530/"), dias=("平日", "休日"))
    assert read.dia("休日").name == "休日"
    for wrong in (None, "土曜"):
        with pytest.raises(InputError, match=r"expected one of its names \(--dia\): '平日', '休日'"):
            read.dia(wrong)


@needs_shared
@pytest.mark.parametrize(
    ("name", "stations", "trains", "down", "up"),
    [("obama.oud", 29, 81, 40, 41), ("utsube.oud", 10, 150, 75, 75)],
)
def test_counts_of_the_real_files(name: str, stations: int, trains: int, down: int, up: int) -> None:
    """29 stations and 81 trains, and 150 trains: what is known of these files."""
    read = route_of(read_oudia(FOLDER / name), name)
    assert len(read.stations) == stations
    figures = summary_of(read.dia(None))
    assert (figures["trains"], figures["down"], figures["up"]) == (trains, down, up)
    assert len(published_of(read, read.dia(None)).trains) == trains


@needs_shared
def test_a_train_of_a_real_file() -> None:
    """First down train of the Obama line, as its lines have it: Obama 5:42 to Tsuruga 6:41."""
    read = route_of(read_oudia(FOLDER / "obama.oud"), "obama.oud")
    first = published_of(read, read.dia(None)).trains[0]
    names = [read.stations[int(call.station_id)].name for call in first.calls]
    assert (first.number, names[0], names[-1], len(names)) == ("921M", "小浜", "敦賀", 15)
    assert (first.calls[0].departure_s, first.calls[-1].arrival_s) == (hm("542"), hm("641"))
