"""`import mini-tokyo`, `import gtfs`, `export gtfs`, `duties`: what they print and write, and bad input."""

import csv
import json
import re
import shlex
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from network.files.timetable_schema import TimetableFile
from network.timetable import seconds_of

SHIPPED = Path(__file__).resolve().parents[2] / "network/timetables"
PREFIX = "JR-East.Karasuyama."


def trains(tmp_path: Path) -> str:
    """A train each way, in the form of mini-tokyo-3d."""
    rows = [
        {
            "id": f"{PREFIX}{number}.Weekday",
            "n": number,
            "d": direction,
            "tt": [{"s": f"{PREFIX}{first}", "d": leaves}, {"s": f"{PREFIX}{last}", "a": arrives}],
            beyond: ["JR-East.Tohoku.Utsunomiya"],
        }
        for number, direction, first, last, leaves, arrives, beyond in (
            ("1M", "Outbound", "Hoshakuji", "Karasuyama", "06:00", "06:40", "os"),
            ("2M", "Inbound", "Karasuyama", "Hoshakuji", "07:00", "07:40", "ds"),
        )
    ]
    path = tmp_path / "trains.json"
    path.write_text(json.dumps(rows), encoding="utf-8")
    return str(path)


def test_a_timetable_is_counted_or_made(main: Callable[..., Any], tmp_path: Path) -> None:
    counted = main("import", "mini-tokyo", trains(tmp_path), "--json").figures()
    assert (counted["trains"], counted["stations"], counted["calls"]) == (2, 2, 4)
    ended = main("import", "mini-tokyo", trains(tmp_path), "out.toml", "--line", "karasuyama", "--json")
    assert ended.code == 0, ended.err
    figures = ended.figures()
    assert (figures["trains"], figures["sets"], figures["warnings"]) == (2, 1, [])
    assert figures["stations"][0] == {
        "source": "Hoshakuji",
        "station": "HSK",
        "by": "romanised name",
        "like": [],
    }
    text = (tmp_path / "out.toml").read_text("utf-8")
    assert 'begins = "portal:HSK.MD"' in text
    assert 'trains = ["1M", "2M"]' in text
    told = main("import", "mini-tokyo", trains(tmp_path), "--line", "karasuyama")
    assert "station: Hoshakuji = HSK (romanised name)" in told.out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("out.toml",), "--line; expected the line"),
        (("--line", "nowhere"), "shipped line"),
        (("--line", "karasuyama", "--id", "a/b"), "--id is 'a/b'"),
        (("--line", "karasuyama", "--calendar", "Sunday"), "a calendar that is in it: Weekday"),
        (("--line", "karasuyama", "--name", "Taki=TAK"), "a station of the source"),
        (("--line", "karasuyama", "--add", "none.toml"), "file of additions"),
        (("--line", "karasuyama", "--turn-min", "-1"), "--turn-min"),
    ],
)
def test_bad_options_are_one_line(
    main: Callable[..., Any], tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    ended = main("import", "mini-tokyo", trains(tmp_path), *options)
    assert ended.code == 2
    assert message in ended.err
    assert ended.err.count("\n") == 1
    assert not (tmp_path / "out.toml").exists()


def test_gtfs_out_and_back(main: Callable[..., Any], tmp_path: Path) -> None:
    ended = main("export", "gtfs", "karasuyama_weekday", "day.zip", "--json")
    assert ended.code == 0, ended.err
    assert (ended.figures()["trips.txt"], ended.figures()["stop_times.txt"]) == (28, 219)
    back = main("import", "gtfs", "day.zip", "back.toml", "--line", "karasuyama", "--json")
    assert back.code == 0, back.err
    assert back.figures()["sets"] == 4
    assert (tmp_path / "back.toml").read_text("utf-8") == (SHIPPED / "karasuyama_weekday.toml").read_text(
        "utf-8"
    )
    other = main("import", "gtfs", "day.zip", "other.toml", "--line", "karasuyama", "--service", "DAY")
    assert other.code == 0, other.err
    assert "station: Hoshakuji = HSK (id)" in other.out
    wrong = main("import", "gtfs", "day.zip", "--line", "busy_line")
    assert wrong.code == 2
    assert "read as any other feed: it was written of karasuyama, not busy_line" in wrong.err


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--weekdays", "0000000"),
        ("--centre", "95,0"),
        ("--from", "20260230"),
        ("--to", "20200101"),
        ("--agency-url", "operator"),
        ("--timezone", "JST; DROP"),
    ],
)
def test_bad_facts_of_a_feed(main: Callable[..., Any], tmp_path: Path, option: str, value: str) -> None:
    ended = main("export", "gtfs", "karasuyama_weekday", "day.zip", option, value)
    assert ended.code == 2
    assert option in ended.err
    assert list(tmp_path.iterdir()) == []


def test_duties_as_table_and_files(main: Callable[..., Any], tmp_path: Path) -> None:
    ended = main("duties", "karasuyama_weekday", "--out", "out", "--json")
    assert ended.code == 0, ended.err
    figures = ended.figures()
    assert [duty["stock_id"] for duty in figures["sets"]] == ["V1", "V2", "V3", "V4"]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "duties.csv",
        "duties.png",
        "duties.svg",
    ]
    with (tmp_path / "out/duties.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(duty["trains"]) for duty in figures["sets"]) == 28
    told = main("duties", "karasuyama_weekday").out
    assert "E346M (empty) - Hoshakuji (beyond)" in told
    assert "10.0 min" in told


def test_duties_of_a_directory_that_is_no_run_are_bad_input(main: Callable[..., Any], tmp_path: Path) -> None:
    assert main("duties", str(tmp_path)).code == 2


def departing(tmp_path: Path) -> str:
    """A train of which Ogane, 12.6 km on, has a departure alone, 900 s after the one before."""
    calls = [("Hoshakuji", {"d": "06:00"}), ("Ogane", {"d": "06:15"}), ("Karasuyama", {"a": "06:40"})]
    row = {"id": f"{PREFIX}1M.Weekday", "n": "1M", "d": "Outbound", "os": ["JR-East.Tohoku.Utsunomiya"]}
    row |= {"tt": [{"s": PREFIX + name, **times} for name, times in calls]}
    path = tmp_path / "departing.json"
    path.write_text(json.dumps([row]), encoding="utf-8")
    return str(path)


def test_no_arrival_is_computed_before_the_train_that_is_named_can_be_there(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    source = departing(tmp_path)
    slow = (SHIPPED.parents[1] / "vehicle/trains/br642.toml").read_text("utf-8")
    slow = re.sub(r"(?m)^speed_max_kmh = .*$", "speed_max_kmh = 52.0", slow)
    (tmp_path / "slow.toml").write_text(slow, encoding="utf-8")
    texts: list[str] = []
    for name, options in (("any.toml", ()), ("one.toml", ("--train", "slow.toml"))):
        ended = main("import", "mini-tokyo", source, name, "--line", "karasuyama", *options)
        assert ended.code == 0, ended.err
        texts.append((tmp_path / name).read_text("utf-8"))
    assert 'arrival = "06:14:40", departure = "06:15", inferred' in texts[0]
    assert 'arrival = "06:14:40"' not in texts[1]
    assert "not before the least running time of br642 allows" in texts[1]


@pytest.mark.parametrize(("up_leaves", "said"), [("06:02", "0 out of"), ("06:20", "arranged: not, as")])
def test_departures_alone_are_arranged_where_a_train_is_named(
    main: Callable[..., Any], tmp_path: Path, up_leaves: str, said: str
) -> None:
    """An up train that needs the track from Ogane for some 14 minutes, until the down train has to leave there."""
    rows = json.loads(Path(departing(tmp_path)).read_text("utf-8"))
    rows.append({"id": f"{PREFIX}2M.Weekday", "n": "2M", "d": "Inbound"})
    rows[-1]["tt"] = [
        {"s": PREFIX + name, key: at}
        for name, key, at in [
            ("Karasuyama", "d", up_leaves),
            ("Ogane", "d", "06:38"),
            ("Hoshakuji", "a", "06:56"),
        ]
    ]
    (tmp_path / "both.json").write_text(json.dumps(rows), encoding="utf-8")
    asked = ("import", "mini-tokyo", "both.json", "--line", "karasuyama")
    assert "arranged" not in main(*asked).out
    ended = main(*asked, "out.toml", "--train", "br642")
    assert ended.code == 0, ended.err
    assert said in ended.out
    made = TimetableFile.model_validate(tomllib.loads((tmp_path / "out.toml").read_text("utf-8")))
    down, up = (
        [seconds_of("", "", text, None) for text in (c.arrival, c.departure) if text]
        for t in made.trains
        for c in t.calls[1:2]
    )
    assert (down[-1] > up[0]) == ("not" not in said)
    for follow in re.findall(r"moves a printed time by (\d+) s: branchline (.*)", ended.out):
        *command, limit_s = shlex.split(follow[1])
        assert (command[-1], limit_s) == ("--limit", follow[0])
        assert main(*command, limit_s).code == 0
        assert main(*command, str(int(limit_s) - 1)).code == 1
    assert ("branchline arrange" in ended.out) == ("not" in said)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ("--line", "karasuyama", "--train", "nothing"),
            "vehicle/trains: name is 'nothing'; expected one of",
        ),
        (("--train", "br642"), "--train is 'br642'; expected --line with it"),
    ],
)
def test_a_train_that_there_is_not_or_without_a_line_is_refused(
    main: Callable[..., Any], tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    ended = main("import", "mini-tokyo", departing(tmp_path), *options)
    assert ended.code == 2
    assert message in ended.err


def test_a_place_that_is_too_full_is_no_warning_of_a_plan_that_gives_it_room(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    """Two sets at Naka's two tracks from the morning, and a train that runs through; one set is brought there later."""
    (tmp_path / "ura.csv").write_text("name,km,tracks,kind\nUra,0,2,\nNaka,6,2,\nSaki,12,2,\n", "utf-8")
    assert main("new", "line", "ura.csv", "ura.toml").code == 0
    rows: list[dict[str, Any]] = []
    for number, way, calls in (
        ("1", "Outbound", [("Ura", "d", "05:30"), ("Naka", "d", "05:38"), ("Saki", "a", "05:46")]),
        ("5", "Outbound", [("Naka", "d", "08:00"), ("Saki", "a", "08:08")]),
        ("6", "Inbound", [("Naka", "d", "08:30"), ("Ura", "a", "08:38")]),
    ):
        times = [{"s": f"U.U.{name}", key: at} for name, key, at in calls]
        rows.append({"id": f"U.{number}.Weekday", "n": number, "d": way, "tt": times})
    (tmp_path / "ura.json").write_text(json.dumps(rows), encoding="utf-8")
    asked = ("import", "mini-tokyo", "ura.json", "--line", "ura.toml")
    assert "warning: Naka has no free track for 1 at 05:37" in main(*asked).out
    ended = main(*asked, "--train", "br642")
    assert ("arranged: printed" in ended.out, "warning" in ended.out) == (True, False), ended
