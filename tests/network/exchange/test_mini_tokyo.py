"""From the public timetable to trains, turnings and diagrams."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from network.errors import InputError
from network.exchange.mini_tokyo import (
    KARASUYAMA,
    ImportedCall,
    ImportedTrain,
    assemble,
    import_timetable,
    read_trains,
    turn_round,
)

SOURCE = (
    Path(__file__).resolve().parents[3] / "../shared/data/timetables/mini_tokyo_3d/jreast-karasuyama.json"
)
SHIPPED = Path(__file__).resolve().parents[3] / "network/timetables"
needs_shared = pytest.mark.skipif(
    not SOURCE.exists(), reason="the timetable data is not beside this checkout"
)

CALENDARS = [("Weekday", "karasuyama_weekday.toml"), ("SaturdayHoliday", "karasuyama_holiday.toml")]
PREFIX = "JR-East.Karasuyama."


def row(number: str = "1M", changes: Mapping[str, object] | None = None) -> dict[str, object]:
    data: dict[str, object] = {
        "id": f"{PREFIX}{number}.Weekday",
        "n": number,
        "d": "Outbound",
        "os": [f"{PREFIX}Hoshakuji"],
        "ds": [f"{PREFIX}Karasuyama"],
        "tt": [{"s": f"{PREFIX}Hoshakuji", "d": "06:00"}, {"s": f"{PREFIX}Karasuyama", "a": "06:40"}],
    }
    return data | dict(changes or {})


def source(tmp_path: Path, *rows: dict[str, object]) -> Path:
    path = tmp_path / "source.json"
    path.write_text(json.dumps(rows), encoding="utf-8")
    return path


def train(number: str, direction: str, begins: str, ends: str, leave: str, arrive: str) -> ImportedTrain:
    low, high = ("HSK", "KRS") if direction == "down" else ("KRS", "HSK")
    calls = (ImportedCall(low, departure=leave), ImportedCall(high, arrive))
    return ImportedTrain(number, direction, calls, begins, ends)


@needs_shared
@pytest.mark.parametrize(("calendar", "shipped"), CALENDARS)
def test_shipped_file_is_what_the_importer_writes(tmp_path: Path, calendar: str, shipped: str) -> None:
    out_file = tmp_path / shipped
    import_timetable(SOURCE, out_file, calendar)
    assert out_file.read_text(encoding="utf-8") == (SHIPPED / shipped).read_text(encoding="utf-8")
    assert list(tmp_path.iterdir()) == [out_file]


@needs_shared
@pytest.mark.parametrize("calendar", [calendar for calendar, _ in CALENDARS])
def test_trains_are_those_of_the_source(calendar: str) -> None:
    trains = read_trains(SOURCE, calendar, KARASUYAMA)
    assert sum(t.revenue for t in trains) == 27
    assert [t.number for t in trains if not t.revenue] == ["E346M"]
    first = {t.number: t for t in trains}["321M"]
    assert first.calls[0] == ImportedCall("HSK", None, "05:37")
    assert first.calls[-1] == ImportedCall("KRS", "06:11", None)
    assert first.begins == "portal:HSK.MD"


@needs_shared
@pytest.mark.parametrize("calendar", [calendar for calendar, _ in CALENDARS])
def test_sets_turn_as_the_stations_allow(calendar: str) -> None:
    trains = {t.number: t for t in turn_round(read_trains(SOURCE, calendar, KARASUYAMA))}
    assert trains["322M"].begins == "stabled"
    assert trains["347M"].ends == "stabled"
    assert trains["345M"].ends == "becomes:E346M"
    for arrived, leaves in (("336M", "337M"), ("338M", "339M"), ("340M", "341M")):
        assert trains[arrived].ends == f"becomes:{leaves}"
        assert trains[leaves].begins == f"from:{arrived}"
    assert sum(t.begins == "stabled" for t in trains.values()) == 1
    assert sum(t.ends == "stabled" for t in trains.values()) == 1


@needs_shared
@pytest.mark.parametrize("calendar", [calendar for calendar, _ in CALENDARS])
def test_four_sets_run_the_day(calendar: str) -> None:
    trains = turn_round(read_trains(SOURCE, calendar, KARASUYAMA))
    diagrams = dict(assemble("source", trains, KARASUYAMA))
    assert list(diagrams) == ["V1", "V2", "V3", "V4"]
    assert sorted(n for numbers in diagrams.values() for n in numbers) == sorted(t.number for t in trains)
    # the set that stands at Karasuyama in the morning stands there in the evening: the day can be repeated
    assert (diagrams["V1"][0], diagrams["V1"][-1]) == ("322M", "347M")
    by_number = {t.number: t for t in trains}
    for numbers in diagrams.values():
        for before, after in pairwise(numbers):
            gap_s = by_number[after].begins_s() - by_number[before].ends_s()
            assert gap_s >= (1800 if by_number[before].ends.startswith("portal:") else 0)


def test_longest_standing_set_leaves_first() -> None:
    trains = turn_round(
        [
            train("1", "down", "portal:HSK.MD", "", "05:00", "05:40"),
            train("3", "down", "portal:HSK.MD", "", "06:00", "06:40"),
            train("2", "up", "", "portal:HSK.MU", "06:40", "07:20"),
            train("4", "up", "", "portal:HSK.MU", "07:40", "08:20"),
        ]
    )
    assert [t.begins for t in trains[2:]] == ["from:1", "from:3"]
    assert [t.ends for t in trains[:2]] == ["becomes:2", "becomes:4"]


def test_too_few_sets_are_named() -> None:
    trains = [
        train("1", "down", "portal:HSK.MD", "stabled", "05:00", "05:40"),
        train("3", "down", "portal:HSK.MD", "stabled", "06:00", "06:40"),
    ]
    with pytest.raises(InputError, match="a day that 1 sets can run: none is free for 3"):
        assemble("day", trains, replace(KARASUYAMA, stock=("V1",)))
    stabled = [replace(t, begins="stabled") for t in trains]
    with pytest.raises(InputError, match="a day that 1 sets can run"):
        assemble("day", stabled, replace(KARASUYAMA, stock=("V1",)))


def test_half_an_hour_outside_is_kept() -> None:
    day = [
        train("2", "up", "stabled", "portal:HSK.MU", "05:00", "05:40"),
        train("1", "down", "portal:HSK.MD", "stabled", "06:09", "06:50"),
    ]
    plan = replace(KARASUYAMA, stock=("V1",))
    with pytest.raises(InputError, match="none is free for 1"):
        assemble("day", day, plan)
    later = [day[0], train("1", "down", "portal:HSK.MD", "stabled", "06:10", "06:50")]
    assert assemble("day", later, plan) == (("V1", ("2", "1")),)


def test_a_time_after_midnight_belongs_to_the_day_before() -> None:
    assert ImportedCall("KRS", arrival="00:05").time_s() == 86_400 + 300


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"d": "Round"}, r"\[0\].d is 'Round'; expected one of Outbound, Inbound"),
        ({"tt": [{"s": f"{PREFIX}Hoshakuji", "d": "06:00"}]}, "two or more calls"),
        ({"tt": [{"s": "X.Y", "d": "06:00"}] * 2}, r"tt\[0\].s is 'X.Y'; expected a station of karasuyama"),
        ({"tt": [{"s": f"{PREFIX}Taki", "d": "6:00"}] * 2}, "'6:00'; expected a time HH:MM"),
        ({"tt": [{"s": f"{PREFIX}Taki"}] * 2}, "an arrival or a departure"),
        ({"tt": 5}, "tt"),
        ({"n": '1M"\nid = "x'}, r"\[0\].n is .*expected an identifier"),
        ({"id": f"{PREFIX}1M.Sunday"}, "'Weekday'; expected a calendar that is in it: Sunday"),
    ],
)
def test_faulty_rows_are_named(tmp_path: Path, changes: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_trains(source(tmp_path, row("1M", changes)), "Weekday", KARASUYAMA)


def test_trains_from_beyond_the_junction_use_the_portals(tmp_path: Path) -> None:
    away = ["JR-East.Utsunomiya.Utsunomiya"]
    path = source(
        tmp_path,
        row("1M", {"os": away}),
        row("3M"),
        row("5M", {"pt": ["JR-East.Utsunomiya.5M.Weekday"]}),
        row("2M", {"d": "Inbound", "ds": away}),
        row("4M", {"d": "Inbound"}),
    )
    got = {t.number: (t.begins, t.ends) for t in read_trains(path, "Weekday", KARASUYAMA)}
    assert got["1M"] == got["5M"] == ("portal:HSK.MD", "")
    assert got["2M"] == ("", "portal:HSK.MU")
    assert got["3M"] == got["4M"] == ("", "")
