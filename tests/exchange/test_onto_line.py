"""A published day on a line: cut to it, its missing times computed, what it does not say said."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.onto_line import OntoLine, onto_line
from exchange.planned import TrainOnLine
from exchange.published import PublishedStation, PublishedTimetable, PublishedTrain
from exchange.running import CHANGE_MPS2, DWELL_S, StationRun, observed_running, plausible_s
from exchange.train_numbers import numbers_of
from network.errors import InputError
from network.files.line_file import load_line
from network.files.names import is_identifier
from network.files.shipped import shipped_line
from network.model import Direction, Line
from network.timetable import Call, CallKind

LINE = load_line(shipped_line("karasuyama"))
NAMES = ["宇都宮", "宝積寺", "下野花岡", "仁井田", "鴻野山", "大金", "小塙", "滝", "烏山"]
STATIONS = tuple(PublishedStation(name, name) for name in NAMES)
STOP, PASS, OPERATIONAL = CallKind.STOP, CallKind.PASS, CallKind.OPERATIONAL


def at(text: str) -> int | None:
    """Seconds of `10:05` or `10:05:30`; None of `-`."""
    if text == "-":
        return None
    hours, minutes, *rest = (int(part) for part in text.split(":"))
    return hours * 3600 + minutes * 60 + (rest[0] if rest else 0)


def call(name: str, times: str, kind: CallKind = STOP, track: str | None = None) -> Call:
    """A call with `arrival departure`, or a departure alone."""
    arrival, departure = times.split() if " " in times else ("-", times)
    return Call(name, track, at(arrival), at(departure), kind)


def train(number: str, *calls: Call, **more: object) -> PublishedTrain:
    return replace(PublishedTrain(number, "down", calls), **more)


def put(*trains: PublishedTrain, line: Line = LINE, **more: object) -> OntoLine:
    published = PublishedTimetable("day", STATIONS, trains, "day.oud")
    return onto_line(published, line, **more)  # type: ignore[arg-type]


def clocks(of: TrainOnLine) -> list[tuple[str, int | None, int | None]]:
    return [(one.station_id, one.arrival_s, one.departure_s) for one in of.calls]


def inferred(of: TrainOnLine) -> list[int]:
    """Indices of calls of which a time was computed."""
    return [i for i, one in enumerate(of.calls) if one.inferred]


def test_the_quickest_train_of_a_timetable_tells_how_long_a_run_takes() -> None:
    """To arrivals; where a source has none, to departures less the shortest stand."""
    there = StationRun("A", "B", True, True)
    trains = [(Call("A", None, None, 0), Call("B", None, 300 + late_s, 360)) for late_s in (20, 0)]
    assert observed_running(trains)(there) == 300
    departs = [(Call("A", None, None, 600), Call("B", None, None, 600 + 360))]
    assert observed_running(departs)(there) is None
    assert observed_running(departs, rough=True)(there) == 360 - DWELL_S


def test_a_train_is_cut_to_the_line_and_goes_beyond_it() -> None:
    onto = put(
        train("1M", call("宇都宮", "9:50"), call("宝積寺", "10:05 10:07"), call("烏山", "10:40 -")),
        train("2M", call("烏山", "11:00"), call("宝積寺", "11:33 11:35"), call("宇都宮", "11:50 -")),
        train("9M", call("宇都宮", "12:00"), call("宝積寺", "12:15 -")),
    )
    down, up = onto.trains
    assert clocks(down) == [("HSK", at("10:05"), at("10:07")), ("KRS", at("10:40"), None)]
    assert clocks(up) == [("KRS", None, at("11:00")), ("HSK", at("11:33"), at("11:35"))]
    assert (down.from_beyond, down.to_beyond, up.from_beyond, up.to_beyond) == (True, False, False, True)
    assert inferred(down) == inferred(up) == []
    assert onto.elsewhere == 1
    assert onto.assumed == ()


def test_trains_for_other_days_are_named_and_can_be_left_out() -> None:
    way = call("宝積寺", "10:07"), call("烏山", "10:40 -")
    later = call("宝積寺", "12:07"), call("烏山", "12:40 -")
    trains = (
        train("1M", *way),
        train("1M", *later, said="土曜・休日運休"),
        train("3M", *later, said="土曜・休日運休"),
    )
    remarks = put(*trains).remarks
    assert "the source says of 1M-2, 3M: 土曜・休日運休" in remarks
    assert any(
        text.startswith("a number that the source has twice") and text.endswith(": 1M-2") for text in remarks
    )
    onto = put(*trains, train("9M", call("宇都宮", "12:00"), call("宝積寺", "12:15 -")), without=("1M-2",))
    assert [one.number for one in onto.trains] == ["1M", "3M"]
    assert "left out, as asked: 1M-2" in onto.remarks
    assert onto.elsewhere == 1
    with pytest.raises(InputError, match="'4M'") as raised:
        put(*trains, without=("4M",))
    assert raised.value.key == "--without"


def test_the_direction_is_that_of_the_kilometrage() -> None:
    stations = STATIONS[::-1]
    trains = (train("1M", call("宝積寺", "10:07"), call("烏山", "10:40 -"), direction="up"),)
    onto = onto_line(PublishedTimetable("day", stations, trains, "day.oud"), LINE)
    assert onto.join.reversed_order
    assert onto.trains[0].direction is Direction.DOWN


def test_a_junction_listed_twice_is_one_call() -> None:
    stations = (
        *STATIONS[:6],
        PublishedStation("支線", "支線"),
        PublishedStation("大金2", "大金"),
        *STATIONS[6:],
    )
    calls = (
        call("宝積寺", "10:00"),
        call("大金", "10:20 -"),
        call("大金2", "10:22"),
        call("烏山", "10:40 -"),
    )
    onto = onto_line(PublishedTimetable("day", stations, (train("1M", *calls),), "day.oud"), LINE)
    assert clocks(onto.trains[0])[1] == ("OGN", at("10:20"), at("10:22"))
    assert inferred(onto.trains[0]) == []


def test_an_arrival_follows_from_the_quickest_train_on_the_leg() -> None:
    onto = put(
        train("1M", call("宝積寺", "10:00"), call("大金", "10:16"), call("烏山", "10:32 -")),
        train("3M", call("宝積寺", "12:00"), call("大金", "12:15:30 12:16"), call("烏山", "12:33 -")),
        train("5M", call("宝積寺", "14:00"), call("大金", "14:25"), call("烏山", "14:41 -")),
    )
    arrivals = [one.calls[1].arrival_s for one in onto.trains]
    assert arrivals == [at("10:15:30"), at("12:15:30"), at("14:15:30")]
    assert list(map(inferred, onto.trains)) == [[1], [], [1]]
    assert "2 of 9 calls have one that is not the source's" in onto.assumed[0]


def test_where_no_train_has_both_times_each_is_there_shortly_before_it_leaves() -> None:
    onto = put(
        train("1M", call("宝積寺", "10:00"), call("大金", "10:16"), call("烏山", "10:32")),
        train("5M", call("宝積寺", "14:00"), call("大金", "14:25"), call("烏山", "14:41")),
    )
    assert [one.calls[1].arrival_s for one in onto.trains] == [at("10:15:40"), at("14:24:40")]
    assert [clocks(one)[-1] for one in onto.trains] == [
        ("KRS", at("10:32"), None),
        ("KRS", at("14:41"), None),
    ]


def test_departures_a_minute_apart_do_not_hurry_the_trains_that_have_two() -> None:
    """From one departure in whole minutes to the next may seem a minute; it tells nothing of arrivals."""
    onto = put(
        train("1M", call("鴻野山", "10:00"), call("大金", "10:05"), call("烏山", "10:25")),
        train("3M", call("鴻野山", "12:00"), call("大金", "12:06"), call("烏山", "12:26")),
    )
    assert onto.trains[1].calls[1].arrival_s == at("12:05:40")


def test_running_times_that_are_given_count_first() -> None:
    def running(leg: StationRun) -> float | None:
        assert (leg.from_stand, leg.to_stand) == (True, True)
        return 780.4 if (leg.from_id, leg.to_id) == ("HSK", "OGN") else None

    onto = put(
        train("1M", call("宝積寺", "10:00"), call("大金", "10:16"), call("烏山", "10:32 -")), running=running
    )
    assert onto.trains[0].calls[1].arrival_s == at("10:13:01")
    assert "earlier by running times of the legs" in onto.assumed[0]


def test_an_arrival_is_never_after_the_departure() -> None:
    onto = put(
        train("1M", call("宝積寺", "10:00"), call("大金", "10:16"), call("烏山", "10:32 -")),
        running=lambda leg: 2000.0,
    )
    assert onto.trains[0].calls[1].arrival_s == at("10:16")


@pytest.mark.parametrize(
    ("least_s", "arrival"), [(700.0, "10:15:40"), (940.0, "10:15:40"), (950.2, "10:15:51"), (2000.0, "10:16")]
)
def test_a_least_running_time_takes_from_the_stand_where_there_is_no_room(
    least_s: float, arrival: str
) -> None:
    onto = put(
        train("1M", call("宝積寺", "10:00"), call("大金", "10:16"), call("烏山", "11:32 -")),
        least=lambda leg: least_s,
    )
    assert onto.trains[0].calls[1].arrival_s == at(arrival)
    short = [text for text in onto.remarks if text.startswith("times too short")]
    wanted = "times too short: from Hoshakuji to Ogane 960 s are left, where at least 2000 s are needed: 1M"
    assert short == ([wanted] if least_s > 960 else [])


def test_no_arrival_is_computed_before_the_line_lets_a_train_be_there() -> None:
    """12.6 km at 65 km/h are 698 s, and a start and a stop at 0.8 m/s2 lose 11.3 s each; a given arrival stays."""
    onto = put(
        train("1M", call("宝積寺", "10:00"), call("大金", "10:05 10:16"), call("烏山", "10:32 -")),
        train("3M", call("宝積寺", "12:00"), call("大金", "12:16"), call("烏山", "12:32 -")),
    )
    assert LINE.max_speed_mps * 3.6 == pytest.approx(65.0)
    assert onto.trains[0].calls[1].arrival_s == at("10:05")
    arrival_s = onto.trains[1].calls[1].arrival_s
    length_m = LINE.stations["OGN"].position_m - LINE.stations["HSK"].position_m
    wanted_s = length_m * 3.6 / 65.0 + 2.0 * 65.0 / 3.6 / (2.0 * 0.8)
    assert arrival_s is not None
    assert 0.0 <= arrival_s - 12 * 3600 - wanted_s < 1.0
    assert any("from Hoshakuji to Ogane 300 s are left" in text for text in onto.remarks)


@given(st.floats(1.0, 50_000.0), st.floats(5.0, 40.0), st.integers(0, 2))
def test_the_least_time_is_that_of_even_starts_and_stops(
    length_m: float, speed_mps: float, stands: int
) -> None:
    """The distance under the curve of speed over that time is the leg's."""
    time_s = plausible_s(length_m, speed_mps, stands)
    top_mps = min(speed_mps, CHANGE_MPS2 * time_s / stands) if stands else speed_mps
    changing_s = stands * top_mps / CHANGE_MPS2
    assert top_mps * (time_s - changing_s / 2.0) == pytest.approx(length_m)
    assert time_s >= length_m / speed_mps * (1.0 - 1e-12)


@given(st.lists(st.lists(st.integers(1, 12), min_size=7, max_size=7), min_size=1, max_size=6))
def test_computed_arrivals_keep_departures_the_dwell_and_the_least_running_time(
    days: list[list[int]],
) -> None:
    trains: list[PublishedTrain] = []
    for index, minutes in enumerate(days):
        times = [36_000 + index * 600 + 60 * sum(minutes[:i]) for i in range(8)]
        calls = (Call(name, None, None, t) for name, t in zip(NAMES[1:], times, strict=True))
        trains.append(train(f"{index}M", *calls))
    published = {one.number: one for one in trains}
    for one in put(*trains).trains:
        for before, here, source in zip(
            one.calls, one.calls[1:-1], published[one.number].calls[1:-1], strict=False
        ):
            assert here.departure_s == source.departure_s
            assert here.arrival_s is not None
            assert here.departure_s is not None
            length_m = LINE.stations[here.station_id].position_m - LINE.stations[before.station_id].position_m
            needed_s = plausible_s(length_m, LINE.max_speed_mps, 2)
            assert here.arrival_s <= here.departure_s
            assert here.arrival_s - before.last_s >= min(needed_s, here.departure_s - before.last_s)
            room = here.departure_s - before.last_s - needed_s >= DWELL_S
            assert not room or here.departure_s - here.arrival_s >= DWELL_S


def test_passings_without_a_time_lie_between_those_around_them() -> None:
    """Kilometrages 0, 3.691, 5.766, 8.157, 12.600: of 1000 s in proportion."""
    calls = (
        call("宝積寺", "10:00"),
        *(call(name, "-", PASS) for name in NAMES[2:5]),
        call("大金", "10:16:40 -"),
    )
    onto = put(train("1M", *calls))
    passed = [one.departure_s for one in onto.trains[0].calls[1:4]]
    wanted = [36_000 + round(1000 * km / 12.6) for km in (3.691, 5.766, 8.157)]
    assert passed == wanted
    assert inferred(onto.trains[0]) == [1, 2, 3]
    assert [one.kind for one in onto.trains[0].calls] == [STOP, PASS, PASS, PASS, STOP]


def test_passings_at_the_ends_are_left_and_said() -> None:
    onto = put(train("1M", call("宝積寺", "10:00", PASS), call("大金", "10:16"), call("烏山", "10:32 -")))
    assert [one.station_id for one in onto.trains[0].calls] == ["OGN", "KRS"]
    assert onto.trains[0].from_beyond
    assert "passing Hoshakuji as the first station on the line is left out: 1M" in onto.remarks


def test_times_in_one_minute_are_moved_and_marked() -> None:
    onto = put(train("1M", call("宝積寺", "10:00"), call("下野花岡", "10:00 10:00"), call("烏山", "10:32 -")))
    found = onto.trains[0].calls[1]
    assert found.arrival_s is not None
    assert at("10:00") < found.arrival_s <= at("10:00:59")  # type: ignore[operator]
    assert found.departure_s == found.arrival_s
    assert inferred(onto.trains[0]) == [1]


def test_a_time_that_was_computed_before_stays_marked() -> None:
    """What an export says of its times is not lost where its file is not read back whole."""
    ends = call("宝積寺", "10:00"), call("烏山", "10:40 -")
    onto = put(train("1M", ends[0], replace(call("大金", "10:20 10:21"), inferred=True), ends[1]))
    assert inferred(onto.trains[0]) == [1]
    assert "1 of 3 calls have one that is not the source's" in onto.assumed[0]


@pytest.mark.parametrize(
    ("calls", "why"),
    [
        (
            (call("宝積寺", "10:20"), call("大金", "10:10 10:11"), call("烏山", "10:40 -")),
            "does not follow 10:20:00",
        ),
        (
            (call("宝積寺", "10:00"), call("大金", "10:20 10:18"), call("烏山", "10:40 -")),
            "before it arrives",
        ),
        (
            (call("宝積寺", "10:00"), call("大金", "10:20"), call("鴻野山", "10:40 -")),
            "it turns round at Ogane",
        ),
        ((call("宝積寺", "-"), call("大金", "-"), call("烏山", "-")), "no time is given at all"),
        (
            (call("宝積寺", "-"), call("大金", "10:20"), call("烏山", "-")),
            "no time is given at HSK, where it begins",
        ),
        (
            (call("宝積寺", "10:00", PASS), call("大金", "10:20"), call("烏山", "10:40", PASS)),
            "less than two stations",
        ),
        ((call("宝積寺", "30:10"), call("烏山", "30:40 -")), "it begins at 30:10:00"),
    ],
)
def test_a_train_that_cannot_be_is_left_out_and_why_is_said(calls: tuple[Call, ...], why: str) -> None:
    good = train("3M", call("宝積寺", "12:00"), call("烏山", "12:40 -"))
    onto = put(train("1M", *calls), good)
    assert [one.number for one in onto.trains] == ["3M"]
    assert any(text.startswith("left out: 1M (") and why in text for text in onto.remarks)
    assert onto.elsewhere == 0


def test_a_day_without_any_train_on_the_line_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"day\.oud: trains is '1 trains'; expected one with two stops on karasuyama"
    ):
        put(train("9M", call("宇都宮", "12:00"), call("宝積寺", "12:15 -")))
    with pytest.raises(
        InputError, match=r"two stops on karasuyama; left out: 9M \(it turns round at Hoshakuji\)"
    ):
        put(train("9M", call("宝積寺", "12:00"), call("大金", "12:15 12:16"), call("宝積寺", "12:40 -")))


@pytest.mark.parametrize(("name", "track"), [("1", "1"), ("１番線", "1"), ("Track 2", "2"), ("3番線", None)])
def test_tracks_are_found_by_name(name: str, track: str | None) -> None:
    onto = put(
        train("1M", call("宝積寺", "10:00"), call("大金", "10:15 10:16", track=name), call("烏山", "10:32 -"))
    )
    assert onto.trains[0].calls[1].track == track
    assert any("Ogane has no '3番線'" in text for text in onto.remarks) == (track is None)


def test_the_usual_track_of_the_source_is_named_where_the_line_has_another() -> None:
    """At Ogane our down trains take track 1. A source whose down trains take 2 is not put on ours."""
    way = call("宝積寺", "10:00"), call("大金", "10:15 10:16"), call("烏山", "10:32 -")

    def track(usual: dict[str, str]) -> str | None:
        stations = tuple(replace(s, usual=usual) if s.key == "大金" else s for s in STATIONS)
        onto = onto_line(PublishedTimetable("day", stations, (train("1M", *way),), "day.oud"), LINE)
        return onto.trains[0].calls[1].track

    assert track({"down": "2番線", "up": "1番線"}) == "2"
    assert track({"down": "1番線", "up": "2番線"}) is track({"down": "9番線"}) is track({}) is None


def test_numbers_are_made_identifiers_and_links_follow() -> None:
    onto = put(
        train("回346M", call("宝積寺", "10:00"), call("烏山", "10:40 -"), becomes=("1002レ", "9999M")),
        train("1002レ", call("烏山", "11:00"), call("宝積寺", "11:40 -"), follows=("回346M",)),
        train("", call("宝積寺", "12:00"), call("烏山", "12:40 -")),
        train("7M", call("宝積寺", "14:00"), call("烏山", "14:40 -"), becomes=("8M",)),
        train("8M", call("烏山", "15:00"), call("宝積寺", "15:40 -")),
        train("8M", call("烏山", "17:00"), call("宝積寺", "17:40 -")),
    )
    assert [one.number for one in onto.trains] == ["E346M", "1002", "D001", "7M", "8M", "8M-2"]
    assert onto.trains[0].becomes == ("1002",)
    assert onto.trains[1].follows == ("E346M",)
    assert onto.trains[3].becomes == ()
    said = " ".join(onto.remarks)
    assert "numbers: 回346M is E346M, 1002レ is 1002, 8M is 8M-2" in said
    assert "trains without a number are given one: D001" in said
    assert "links to 8M, which several trains are called, are left out: 7M" in said
    assert "links to trains that are not on the line are left out: E346M" in said


@given(st.lists(st.tuples(st.text(st.sampled_from("回試レ1MD0U-. /２")), st.booleans()), max_size=12))
def test_numbers_are_identifiers_and_each_its_own(published: list[tuple[str, bool]]) -> None:
    numbers = numbers_of(published)
    assert len(set(numbers)) == len(numbers) == len(published)
    assert all(is_identifier(number) for number in numbers)


def test_opposing_trains_that_pass_a_station_at_one_time_meet_there() -> None:
    """One of the two stands there: an operating stop, which public timetables write as a passing."""
    onto = put(
        train("1D", call("宝積寺", "10:00"), call("大金", "10:15", PASS), call("烏山", "10:30 -")),
        train("2D", call("烏山", "10:00"), call("大金", "10:15", PASS), call("宝積寺", "10:30 -")),
    )
    assert [text for text in onto.remarks if "運転停車" in text] == [
        "1D and 2D meet at Ogane about 10:15, where the source has no stop for it:"
        " one of them may stand there (運転停車)"
    ]


def test_trains_that_cross_between_passings_may_hide_a_stop() -> None:
    onto = put(
        train("1D", call("宝積寺", "10:00"), call("大金", "10:14", PASS), call("烏山", "10:30 -")),
        train("2D", call("烏山", "10:00"), call("大金", "10:17 10:18"), call("宝積寺", "10:33 -")),
    )
    (said,) = [text for text in onto.remarks if "運転停車" in text]
    assert "1D and 2D meet at Ogane or Karasuyama or between them, about 10:" in said


def test_a_meet_at_a_stop_hides_nothing() -> None:
    onto = put(
        train("1D", call("宝積寺", "10:00"), call("大金", "10:14 10:20"), call("烏山", "10:35 -")),
        train("2D", call("烏山", "10:00"), call("大金", "10:16", PASS), call("宝積寺", "10:33 -")),
        train("4D", call("烏山", "10:40"), call("大金", "10:56", PASS), call("宝積寺", "11:13 -")),
    )
    assert not any("運転停車" in text for text in onto.remarks)


def test_a_stop_where_there_is_no_platform_is_not_for_passengers() -> None:
    ogane = LINE.stations["OGN"]
    bare = replace(ogane, tracks=tuple(replace(track, platform_m=None) for track in ogane.tracks))
    line = replace(LINE, stations={**LINE.stations, "OGN": bare})
    calls = (call("宝積寺", "10:00"), call("大金", "10:15 10:16"), call("烏山", "10:32 -"))
    onto = put(train("1M", *calls), train("3E", *calls, revenue=False), line=line)
    assert [one.calls[1].kind for one in onto.trains] == [OPERATIONAL, STOP]
    assert "stops at Ogane, which has no platform, are not for passengers: 1M" in onto.remarks


def test_what_the_source_lacks_and_what_it_may_only_spell_otherwise_is_said() -> None:
    stations = (*STATIONS[:7], PublishedStation("滝x", "Takii"), STATIONS[8])
    trains = (train("1M", call("宝積寺", "10:00"), call("滝x", "10:30 10:31"), call("烏山", "10:40 -")),)
    onto = onto_line(PublishedTimetable("day", stations, trains, "day.oud"), LINE)
    assert "stations of the line that the source has not: Taki; no train calls there" in onto.remarks
    assert "Takii is not joined: if it is TAK, say so by hand" in onto.remarks
    assert "calls at Takii, which is not on the line, are left out: 1M" in onto.remarks
    by_hand = onto_line(PublishedTimetable("day", stations, trains, "day.oud"), LINE, {"Takii": "TAK"})
    assert [one.station_id for one in by_hand.trains[0].calls] == ["HSK", "TAK", "KRS"]
