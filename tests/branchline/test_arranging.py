"""`branchline arrange`: from departures alone to a day that `check` lets through."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from exchange.hidden_meets import meets_between
from network.files.line_file import load_line
from network.files.timetable_schema import CallTable, TimetableFile
from network.files.toml_input import parse_toml
from network.timetable import seconds_of, timetable_of
from plan.arranging import arrange, draft
from plan.arranging.problem import TrainToArrange

STATIONS = "name,id,km,tracks,kind\nAsa,ASA,0,2,\nKido,KID,3,2,signal station\nBato,BAT,6,2,\n"
DAY = """[timetable]
id = "day"
line = "hill"
dwell_min_s = 20

[[trains]]
number = "1"
direction = "down"
begins = "stabled"
ends = "stabled"
calls = [{ station = "ASA", departure = "10:00" }, { station = "BAT", arrival = "10:20" }]

[[trains]]
number = "2"
direction = "up"
begins = "stabled"
ends = "stabled"
calls = [{ station = "BAT", departure = "UP_LEAVES" }, { station = "ASA", arrival = "10:20", inferred = true }]

[[diagrams]]
stock = "V1"
trains = ["1"]

[[diagrams]]
stock = "V2"
trains = ["2"]
"""


@pytest.fixture
def hill(main: Callable[..., Any], tmp_path: Path) -> Callable[[str], None]:
    """A line with a signal station in its middle, and a train from either end."""

    def put(up_leaves: str) -> None:
        (tmp_path / "hill.csv").write_text(STATIONS, "utf-8")
        (tmp_path / "day.toml").write_text(DAY.replace("UP_LEAVES", up_leaves), "utf-8")
        assert main("new", "line", "hill.csv", "hill.toml").code == 0

    return put


def _calls(path: Path, number: str) -> dict[str, CallTable]:
    file = parse_toml(path.read_text("utf-8"), str(path), TimetableFile)
    return {call.station: call for train in file.trains if train.number == number for call in train.calls}


def _seconds(text: str | None) -> int:
    return seconds_of("", "", text or "", None)


def test_trains_meet_at_a_signal_station_that_nobody_prints(
    main: Callable[..., Any], hill: Callable[[str], None], tmp_path: Path
) -> None:
    hill("10:00")
    asked = ("made.toml", "--train", "br642", "--scenario", "run.toml")
    arranged = main("arrange", "hill.toml", "day.toml", *asked)
    assert arranged.code == 0, arranged
    assert "printed times moved: 0 of 3" in arranged.out
    assert "stops added: Kido" in arranged.out
    calls = {number: _calls(tmp_path / "made.toml", number)["KID"] for number in ("1", "2")}
    assert any(call.operational and call.inferred for call in calls.values())
    assert main("check", "run.toml").code == 0


def test_the_arrival_that_no_source_gives_is_a_running_time_after_the_departure(
    main: Callable[..., Any], hill: Callable[[str], None], tmp_path: Path
) -> None:
    hill("10:10")
    assert main("arrange", "hill.toml", "day.toml", "made.toml", "--train", "br642").code == 0
    up = _calls(tmp_path / "made.toml", "2")
    run_s = _seconds(up["ASA"].arrival) - _seconds(up["BAT"].departure)
    # 6 km at 85 km/h take 254 s; starting and stopping at 0.8 m/s2 and less, and the way under the limit, some more.
    assert 254 + 30 < run_s < 420


def test_what_has_to_move_further_than_it_may_is_named_and_ends_in_1(
    main: Callable[..., Any], hill: Callable[[str], None], tmp_path: Path
) -> None:
    hill("10:00")
    day = tmp_path / "day.toml"
    text = day.read_text("utf-8")
    day.write_text(text.replace('arrival = "10:20" }', 'arrival = "10:01:20" }', 1), "utf-8")
    found = main("arrange", "hill.toml", "day.toml", "--limit", "60", "--train", "br642")
    assert found.code == 1
    assert re.search(r"least that would do:\n  1 \+\d+ s at Bato \(arrival printed 10:01\)", found.out)
    furthest_s = max(int(by_s) for by_s in re.findall(r"[+-](\d+) s at", found.out))
    assert f"; this one moves none by more than {furthest_s} s\n" in found.out


@pytest.mark.parametrize(
    ("files", "said"),
    [
        (("--scenario", "run.toml"), "the timetable file that the scenario is to run"),
        (("run.toml", "--scenario", "run.toml"), "another file"),
        (("run.toml", "--scenario", "hill.toml"), "exists already"),
        (("day.toml",), "exists already"),
        (("run",), "NAME.toml"),
    ],
)
def test_what_cannot_be_written_is_said_and_nothing_is(
    main: Callable[..., Any], hill: Callable[[str], None], tmp_path: Path, files: tuple[str, ...], said: str
) -> None:
    hill("10:00")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    ended = main("arrange", "hill.toml", "day.toml", *files)
    assert (ended.code, said in ended.err) == (2, True), ended
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


CALLS_1 = '{ station = "ASA", departure = "10:00" }, { station = "BAT", arrival = "10:20" }'
OF_2 = 'calls = [{ station = "BAT", departure = "10:00" }'


@pytest.mark.parametrize(
    ("was", "becomes", "said"),
    [
        (CALLS_1, '{ station = "ASA", departure = "10:00" }', "from one station with tracks of its own"),
        (CALLS_1, CALLS_1.replace("10:20", "09:20"), "a time not before 10:00:00"),
        ('"BAT", arrival', '"XYZ", arrival', "one of ASA, KID, BAT"),
        ("dwell_min_s = 20", "dwell_min_s = -1", "0 to 3600 s"),
        (OF_2, OF_2.replace('departure = "10:00"', 'departure = "10:00", track = "9"'), "9"),
        ('begins = "stabled"', 'begins = "from:2"', "the first train of set V1"),
        ('trains = ["2"]', 'trains = ["1"]', "1"),
    ],
    ids=["one call", "backwards", "station", "dwell", "track", "circle", "twice"],
)
def test_nonsense_is_one_line(
    main: Callable[..., Any], hill: Callable[[str], None], tmp_path: Path, was: str, becomes: str, said: str
) -> None:
    hill("10:00")
    day = tmp_path / "day.toml"
    day.write_text(day.read_text("utf-8").replace(was, becomes, 1), "utf-8")
    ended = main("arrange", "hill.toml", "day.toml", "made.toml", "--scenario", "run.toml")
    assert ended.code == 2, ended
    assert said in ended.err
    assert ended.err.count("\n") == 1
    assert not (tmp_path / "made.toml").exists()


def _day_at_kido(
    main: Callable[..., Any], tmp_path: Path, trains: str, tracks: int = 2, ends: int = 2, km: int = 3
) -> Callable[..., Any]:
    """A line whose middle station has so many tracks, and a day of `trains`; the command that arranges it."""
    stations = STATIONS.replace("3,2,signal station", f"{km},{tracks},station")
    stations = stations.replace("ASA,0,2,", f"ASA,0,{ends},").replace("6,2,", f"{2 * km},{ends},")
    (tmp_path / "hill.csv").write_text(stations, "utf-8")
    assert main("new", "line", "hill.csv", "hill.toml").code == 0
    (tmp_path / "day.toml").write_text(DAY[: DAY.index("[[trains]]")] + trains, "utf-8")
    return lambda *more: main("arrange", "hill.toml", "day.toml", *more, "--train", "br642")


def _train(number: str, direction: str, *calls: str) -> str:
    rows = ", ".join(f"{{ {call} }}" for call in calls)
    return (
        f'[[trains]]\nnumber = "{number}"\ndirection = "{direction}"\nbegins = "stabled"\nends = "stabled"\n'
        f'calls = [{rows}]\n\n[[diagrams]]\nstock = "V{number}"\ntrains = ["{number}"]\n\n'
    )


OVERTAKEN = _train(
    "1",
    "down",
    'station = "ASA", departure = "10:00"',
    'station = "KID", arrival = "10:05", departure = "10:20"',
    'station = "BAT", arrival = "10:26"',
) + _train("3", "down", 'station = "ASA", departure = "10:08"', 'station = "BAT", arrival = "10:16"')


def test_a_train_is_overtaken_on_the_other_track(main: Callable[..., Any], tmp_path: Path) -> None:
    found = _day_at_kido(main, tmp_path, OVERTAKEN)("made.toml", "--scenario", "run.toml")
    assert "printed times moved: 0 of 6" in found.out
    assert {_calls(tmp_path / "made.toml", number)["KID"].track for number in ("1", "3")} != {None}
    checked = main("check", "run.toml")
    assert checked.code == 0, checked


SAME_MINUTE = [
    _train(
        number,
        "down",
        'station = "ASA", departure = "10:00"',
        'station = "KID", arrival = "10:03", departure = "10:20"',
        'station = "BAT", arrival = "10:23"',
    )
    for number in ("1", "3")
]


def test_two_of_the_same_way_stand_beside_each_other(main: Callable[..., Any], tmp_path: Path) -> None:
    """Both are printed in the same minutes, and wait at Kido: who follows needs the time of a run, not of the wait."""
    arrange_day = _day_at_kido(main, tmp_path, "".join(SAME_MINUTE))
    found = arrange_day("made.toml", "--scenario", "run.toml", "--json")
    # 3 km at 85 km/h take 127 s; starting and stopping at 0.8 m/s2 and less, and the way set, a minute or two more.
    moved_s = [move["by_s"] for move in found.figures()["moves"]]
    assert 127 + 30 < max(moved_s) < 127 + 120
    assert {_calls(tmp_path / "made.toml", number)["KID"].track for number in ("1", "3")} != {None}
    checked = main("check", "run.toml")
    assert checked.code == 0, checked


@pytest.mark.parametrize("few_first", [False, True])
def test_a_train_comes_beside_the_track_that_one_ahead_has_just_left(
    main: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, few_first: bool
) -> None:
    """The first leaves Kido at 10:10, with its track until Bato at 10:19; the other leaves Asa at 10:13."""
    trains = [
        _train(
            number,
            "down",
            f'station = "ASA", departure = "10:{at:02d}"',
            f'station = "KID", arrival = "10:{at + 9:02d}", departure = "10:{at + 10:02d}"',
            f'station = "BAT", arrival = "10:{at + 19:02d}"',
        )
        for number, at in (("1", 0), ("3", 13))
    ]
    if few_first:  # as for days of many trains; with few choices the second would leave 321 s late
        monkeypatch.setattr(arrange, "CHOICE_TRAINS_MAX", 1)
    found = _day_at_kido(main, tmp_path, "".join(trains), km=10)("made.toml", "--scenario", "run.toml")
    assert "printed times moved: 0 of 8" in found.out, found.out


def test_without_a_choice_of_tracks_the_second_waits_behind_the_first(
    main: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nowhere(_trains: Sequence[TrainToArrange], _late_s: int) -> dict[str, frozenset[str]]:
        return {}

    monkeypatch.setattr(draft, "stations_beside_another", nowhere)
    found = _day_at_kido(main, tmp_path, OVERTAKEN)()
    assert "printed times moved: 0" not in found.out


AT_KIDO = [
    _train(
        str(2 * i), "up", f'station = "KID", departure = "1{i}:00"', f'station = "ASA", arrival = "1{i}:10"'
    )
    for i in range(3)
]


def test_two_sets_stand_on_two_tracks(main: Callable[..., Any], tmp_path: Path) -> None:
    found = _day_at_kido(main, tmp_path, "".join(AT_KIDO[:2]))()
    assert found.code == 0
    assert "empty working" not in found.out


def test_a_train_has_the_time_that_it_takes_from_the_track_that_it_has(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    """Two sets begin at Bato, on two tracks, the way from one of which is slower; arrivals are computed."""
    ways = [('"BAT"', '"KID"', '"ASA"', "up"), ('"ASA"', '"KID"', '"BAT"', "down")]
    trains = [
        _train(
            f"{at}{n}",
            way,
            f'station = {first}, departure = "1{n}:00"',
            f'station = {middle}, departure = "1{n}:05"',
            f'station = {last}, arrival = "1{n}:20", inferred = true',
        )
        for at, (first, middle, last, way) in enumerate(ways)
        for n in (0, 1)
    ]
    found = _day_at_kido(main, tmp_path, "".join(trains), ends=4)("made.toml", "--scenario", "run.toml")
    assert found.code == 0, found
    checked = main("check", "run.toml")
    assert "running time" not in checked.out


def test_a_third_set_is_brought_as_an_empty_working(main: Callable[..., Any], tmp_path: Path) -> None:
    found = _day_at_kido(main, tmp_path, "".join(AT_KIDO))("made.toml", "--scenario", "run.toml")
    assert found.code == 0, found
    assert "empty working added: E1" in found.out
    empty = _calls(tmp_path / "made.toml", "E1")
    assert list(empty)[-1] == "KID"
    assert 10 * 3600 < _seconds(empty["KID"].arrival) < 12 * 3600  # a track is free from 10:00 on
    assert main("check", "run.toml").code == 0


def test_a_train_with_one_call_has_no_blocking_times(
    main: Callable[..., Any], hill: Callable[[str], None], tmp_path: Path
) -> None:
    hill("10:00")
    day = tmp_path / "day.toml"
    one = CALLS_1.split(" }, ", maxsplit=1)[0] + " }"
    day.write_text(day.read_text("utf-8").replace(CALLS_1, one, 1), "utf-8")
    scenario = (
        'id = "one"\nname = "one"\nline = "hill.toml"\ntimetable = "day.toml"\n[trains]\ndefault = "br642"\n'
    )
    (tmp_path / "one.toml").write_text(scenario, "utf-8")
    ended = main("export", "displib", "one.toml", "one.json")
    assert (ended.code, "two calls or more" in ended.err) == (2, True), ended
    assert not (tmp_path / "one.json").exists()


def test_what_is_exported_as_displib_is_counted_alike_in_text_and_json(main: Callable[..., Any]) -> None:
    asked = ("export", "displib", "karasuyama_round_trip", "day.json")
    count = main(*asked, "--json").figures()
    text = f": {count['sets']} sets, {count['operations']} operations, {count['delays']} trains that may be late\n"
    assert main(*asked).out.endswith(text)


def test_tracks_that_would_do_are_named(main: Callable[..., Any], tmp_path: Path) -> None:
    # Two sets begin at Kido and end at Asa; no station has more than one track.
    asked = _day_at_kido(main, tmp_path, "".join(AT_KIDO[:2]), tracks=1, ends=1)
    found = asked("made.toml", "--scenario", "run.toml")
    assert found.code == 1, "the search came to its end: that there is no plan is its answer"
    assert "Kido had 1 more track" in found.out
    assert "Asa had 1 more track" in found.out
    assert "no printed time would be moved, on tracks as quick as those that are there" in found.out
    assert "the line has no room for its 2 trains" in found.out
    assert asked("--json").figures()["lacking"]["by_station"] == {"ASA": 1, "KID": 1}
    assert not list(tmp_path.glob("made.toml")) + list(tmp_path.glob("run.toml"))


def test_the_halt_where_trains_could_meet_is_named(main: Callable[..., Any], tmp_path: Path) -> None:
    """Both leave at 10:00, by one track of 6 km; Kido is a halt in its middle."""
    (tmp_path / "hill.csv").write_text(STATIONS.replace("3,2,signal station", "3,1,halt"), "utf-8")
    (tmp_path / "day.toml").write_text(DAY.replace("UP_LEAVES", "10:00"), "utf-8")
    assert main("new", "line", "hill.csv", "hill.toml").code == 0
    found = main("arrange", "hill.toml", "day.toml", "--limit", "60", "--train", "br642", "--json")
    assert found.code == 1, found
    assert found.figures()["lacking"]["by_station"] == {"KID": 1}
    assert sorted(found.figures()["lacking"]["trains"]["KID"]) == ["1", "2"]


def test_the_signal_station_between_two_stations_is_named(main: Callable[..., Any], tmp_path: Path) -> None:
    """Both leave at 10:00 and pass each other by print half way, where there is nothing: a row of the list mends it."""
    listed = [row for row in STATIONS.splitlines() if "KID" not in row]
    (tmp_path / "hill.csv").write_text("\n".join(listed) + "\n", "utf-8")
    (tmp_path / "day.toml").write_text(DAY.replace("UP_LEAVES", "10:00"), "utf-8")
    assert main("new", "line", "hill.csv", "hill.toml").code == 0
    found = main("arrange", "hill.toml", "day.toml", "--limit", "60", "--train", "br642")
    assert found.code == 1, found
    assert "if there were a signal station between Asa and Bato (for 1, 2), no printed time" in found.out
    listed.insert(2, "Asa - Bato,,,2,signal station")
    (tmp_path / "hill2.csv").write_text("\n".join(listed) + "\n", "utf-8")
    assert main("new", "line", "hill2.csv", "hill2.toml", "--id", "hill").code == 0
    mended = main("arrange", "hill2.toml", "day.toml", "--limit", "60", "--train", "br642")
    assert mended.code == 0, mended


@pytest.mark.parametrize(("up_leaves", "meets"), [("10:00", [("ASA", "KID")]), ("10:03", [])])
def test_printed_minutes_that_are_coarse_show_no_meet_between_stations(
    main: Callable[..., Any], tmp_path: Path, up_leaves: str, meets: list[tuple[str, str]]
) -> None:
    """Down leaves Asa at 10:00 and is at Kido at 10:05; up is there 2 min before that, or 2 min before it is at Asa."""
    trains = _train("1", "down", 'station = "ASA", departure = "10:00"', 'station = "KID", arrival = "10:05"')
    up = f'station = "KID", departure = "{up_leaves}"'
    trains += _train("2", "up", up, 'station = "ASA", arrival = "10:08"')
    _day_at_kido(main, tmp_path, trains)
    line, path = load_line(tmp_path / "hill.toml"), tmp_path / "day.toml"
    day = timetable_of(parse_toml(path.read_text("utf-8"), str(path), TimetableFile), str(path), line)
    assert list(meets_between(day, line)) == meets


def test_trains_that_come_and_go_by_portals_stand_nowhere(main: Callable[..., Any], tmp_path: Path) -> None:
    """Three trains each way by two tracks at each end: no set stands there, neither before its train nor after it."""
    stations = STATIONS.replace("kind", "kind,end").replace("2,\n", "2,,portal\n")
    stations = stations.replace("signal station", "signal station,")
    (tmp_path / "pass.csv").write_text(stations, "utf-8")
    assert main("new", "line", "pass.csv", "pass.toml").code == 0
    ends = {"down": ("ASA", "BAT"), "up": ("BAT", "ASA")}
    day = ['[timetable]\nid = "day"\nline = "pass"\ndwell_min_s = 20\n']
    for at, (way, (first, last)) in enumerate((*ends.items(),) * 3):
        hour = 10 + at // 2
        calls = f'[{{ station = "{first}", departure = "{hour}:00" }}, {{ station = "{last}", arrival = "{hour}:20" }}]'
        day.append(
            f'[[trains]]\nnumber = "{at}"\ndirection = "{way}"\nbegins = "portal:{first}.P"\nends = "portal:{last}.P"\n'
            f'calls = {calls}\n\n[[diagrams]]\nstock = "V{at}"\ntrains = ["{at}"]\n'
        )
    (tmp_path / "day.toml").write_text("\n".join(day), "utf-8")
    found = main("arrange", "pass.toml", "day.toml", "made.toml", "--scenario", "run.toml")
    assert found.code == 0, found
    assert "printed times moved: 0 of 12" in found.out
    assert main("check", "run.toml").code == 0
