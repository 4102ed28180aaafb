"""Sets are given to trains: links of the source, first in first out, portals, and what a night leaves where."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from exchange.planned import TrainOnLine, Workings
from exchange.portals import portal_of
from exchange.workings import TURN_MIN_S, SetRules, begins_s, ends_s, workings_of
from network.clock import clock
from network.errors import InputError
from network.files.line_file import load_line
from network.files.timetable_schema import CallTable, DiagramTable, HeadTable, TimetableFile, TrainTable
from network.model import Direction, Line
from network.timetable import AtPortal, Call, load_timetable, timetable_of

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = load_line(ROOT / "tests/network/sample_line.toml")
KARASUYAMA = load_line(ROOT / "network/lines/karasuyama.toml")
BUSY = load_line(ROOT / "network/lines/busy_line.toml")


def train(
    number: str, first: str, last: str, leaves_s: int, arrives_s: int, line: Line = SAMPLE, **more: object
) -> TrainOnLine:
    down = line.stations[last].position_m > line.stations[first].position_m
    calls = (Call(first, None, None, leaves_s), Call(last, None, arrives_s, None))
    return TrainOnLine(number, Direction.DOWN if down else Direction.UP, calls, **more)  # type: ignore[arg-type]


def minutes(number: str, first: str, last: str, leaves: int, arrives: int, **more: object) -> TrainOnLine:
    return train(number, first, last, 6 * 3600 + leaves * 60, 6 * 3600 + arrives * 60, **more)  # type: ignore[arg-type]


def timetable_file(line: Line, trains: Sequence[TrainOnLine], workings: Workings) -> TimetableFile:
    """The file that these workings mean, through the checks that every timetable file passes."""
    tables = [
        TrainTable(
            number=t.number,
            direction="down" if t.direction is Direction.DOWN else "up",
            calls=[
                CallTable(
                    station=call.station_id,
                    track=workings.tracks.get((t.number, i), call.track),
                    arrival=None if call.arrival_s is None else clock(call.arrival_s),
                    departure=None if call.departure_s is None else clock(call.departure_s),
                )
                for i, call in enumerate(t.calls)
            ],
            begins=workings.begins[t.number],
            ends=workings.ends[t.number],
        )
        for t in trains
    ]
    diagrams = [DiagramTable(stock=w.stock_id, trains=list(w.numbers)) for w in workings.diagrams]
    return TimetableFile(
        timetable=HeadTable(id="made", line=line.id, dwell_min_s=0), trains=tables, diagrams=diagrams
    )


@st.composite
def days(draw: st.DrawFn, line: Line, stations: tuple[str, ...], *, beyond: bool) -> list[TrainOnLine]:
    """A day of trains between any two of the stations, some from or to other lines, on whole minutes."""
    trains: list[TrainOnLine] = []
    for number in range(draw(st.integers(1, 14))):
        first, last = draw(st.permutations(stations))[:2]
        leaves_s = 60 * draw(st.integers(5 * 60, 9 * 60))
        takes_s = 60 * draw(st.integers(35, 60))
        come, go = (draw(st.booleans()) and beyond for _ in range(2))
        trains.append(
            train(
                f"{number}M", first, last, leaves_s, leaves_s + takes_s, line, from_beyond=come, to_beyond=go
            )
        )
    return trains


LINES = [(SAMPLE, ("A", "B")), (KARASUYAMA, ("HSK", "OGN", "KRS")), (BUSY, ("ASA", "USU", "KAS"))]


@pytest.mark.parametrize(("line", "stations"), LINES)
@given(data=st.data())
def test_every_train_has_one_set_that_is_there_in_time(
    line: Line, stations: tuple[str, ...], data: st.DataObject
) -> None:
    trains = data.draw(days(line, stations, beyond=True))
    workings = workings_of(trains, line)
    ran = [number for working in workings.diagrams for number in working.numbers]
    assert sorted(ran) == sorted(t.number for t in trains)
    # the checks of a timetable file: continuous in place, time and track, portals that have a way
    timetable_of(timetable_file(line, trains, workings), "made", line)
    by_number = {t.number: t for t in trains}
    for working in workings.diagrams:
        for before, after in pairwise(by_number[number] for number in working.numbers):
            outside = workings.ends[before.number].startswith("portal:")
            assert begins_s(after) - ends_s(before) >= (1800 if outside else TURN_MIN_S)


@pytest.mark.parametrize(("line", "stations"), LINES)
@given(data=st.data())
def test_the_set_that_stood_longest_leaves_first(
    line: Line, stations: tuple[str, ...], data: st.DataObject
) -> None:
    trains = data.draw(days(line, stations, beyond=True))
    workings = workings_of(trains, line)
    by_number = {t.number: t for t in trains}
    turns: dict[str, list[tuple[int, int]]] = {}
    for after, begin in workings.begins.items():
        if begin.startswith("from:"):
            before = by_number[begin.removeprefix("from:")]
            station = before.calls[-1].station_id
            turns.setdefault(station, []).append((ends_s(before), begins_s(by_number[after])))
    for ours in turns.values():
        ours.sort()
        assert [leaves for _, leaves in ours] == sorted(leaves for _, leaves in ours)


@given(data=st.data())
def test_no_fewer_sets_can_run_a_day_without_portals(data: st.DataObject) -> None:
    # Karasuyama and Ogane have no portal behind them: a matching of ends to beginnings is all that there is.
    trains = data.draw(days(KARASUYAMA, ("OGN", "KRS"), beyond=False))
    workings = workings_of(trains, KARASUYAMA)
    fits = np.array(
        [
            [
                before.calls[-1].station_id == after.calls[0].station_id
                and begins_s(after) - ends_s(before) >= TURN_MIN_S
                for after in trains
            ]
            for before in trains
        ]
    )
    matched = int((maximum_bipartite_matching(csr_array(fits)) >= 0).sum())
    assert len(workings.diagrams) == len(trains) - matched


@given(data=st.data())
def test_no_fewer_sets_can_come_and_go_by_a_portal(data: st.DataObject) -> None:
    # All come from and go to the other line, so sets link at the portal alone.
    trains: list[TrainOnLine] = []
    for i in range(data.draw(st.integers(1, 10))):
        out_s = 60 * data.draw(st.integers(300, 700))
        more = {"line": KARASUYAMA, "to_beyond": True, "follows": (f"{i}D",)}
        trains.append(train(f"{i}D", "HSK", "KRS", out_s, out_s + 2400, KARASUYAMA, from_beyond=True))
        trains.append(train(f"{i}U", "KRS", "HSK", out_s + 3000, out_s + 5400, **more))  # type: ignore[arg-type]
    workings = workings_of(trains, KARASUYAMA)
    down, up = trains[::2], trains[1::2]
    fits = np.array([[begins_s(d) - ends_s(u) >= 1800 for d in down] for u in up])
    matched = int((maximum_bipartite_matching(csr_array(fits)) >= 0).sum())
    assert len(workings.diagrams) == len(down) - matched


@pytest.mark.parametrize("day", ["weekday", "holiday"])
def test_the_shipped_days_come_out(day: str) -> None:
    timetable = load_timetable(ROOT / f"network/timetables/karasuyama_{day}.toml", KARASUYAMA)
    trains = [
        TrainOnLine(
            t.number,
            t.direction,
            t.calls,
            t.revenue,
            from_beyond=isinstance(t.begins, AtPortal),
            to_beyond=isinstance(t.ends, AtPortal),
        )
        for t in timetable.trains.values()
    ]
    got = workings_of(trains, KARASUYAMA, SetRules(stock=("V1", "V2", "V3", "V4")))
    assert {w.stock_id: w.numbers for w in got.diagrams} == {
        d.stock_id: d.train_numbers for d in timetable.diagrams
    }
    assert got.warnings == ()
    # the published trains alone leave two sets at Karasuyama, which has one track
    alone = workings_of([t for t in trains if t.revenue], KARASUYAMA)
    assert any("2 sets stand at Karasuyama after the last train (345M, 347M)" in w for w in alone.warnings)


def test_links_of_the_source_come_before_first_in_first_out() -> None:
    trains = [
        minutes("1", "A", "B", 0, 10),
        minutes("3", "A", "B", 20, 30),
        minutes("2", "B", "A", 40, 50),
        minutes("4", "B", "A", 60, 70, follows=("1",)),
    ]
    got = workings_of(trains, SAMPLE)
    assert (got.ends["1"], got.ends["3"]) == ("becomes:4", "becomes:2")
    assert any("1 links between trains are the source's" in text for text in got.assumed)


@pytest.mark.parametrize(
    ("link", "why"),
    [
        ({"follows": ("9",)}, "9 is no train of this day"),
        ({"follows": ("2",)}, "one ends at A, the other begins at B"),
        ({"follows": ("5",)}, "4 begins before 5 has ended"),
        ({"follows": ("1", "3")}, "4 begins otherwise"),
    ],
)
def test_a_link_that_cannot_be_is_named(link: dict[str, tuple[str, ...]], why: str) -> None:
    trains = [
        minutes("1", "A", "B", 0, 10),
        minutes("3", "A", "B", 20, 30),
        minutes("2", "B", "A", 40, 50),
        minutes("4", "B", "A", 60, 70, **link),
        minutes("5", "A", "B", 80, 90),
    ]
    assert any(why in text for text in workings_of(trains, SAMPLE).warnings)


def test_sets_do_not_turn_faster_than_stated() -> None:
    trains = [minutes("1", "A", "B", 0, 10), minutes("2", "B", "A", 13, 20)]
    assert workings_of(trains, SAMPLE, SetRules(turn_min_s=180)).begins["2"] == "from:1"
    late = workings_of(trains, SAMPLE, SetRules(turn_min_s=181))
    assert (late.ends["1"], late.begins["2"]) == ("stabled", "stabled")


def test_at_a_station_with_a_portal_sets_come_from_beyond() -> None:
    trains = [minutes("1", "A", "B", 0, 10), minutes("2", "B", "A", 40, 50)]
    got = workings_of(trains, SAMPLE)
    assert got.begins == {"1": "portal:P", "2": "from:1"}
    assert got.ends == {"1": "becomes:2", "2": "portal:P"}


def test_a_set_that_finds_no_room_goes_beyond_the_portal_and_comes_back() -> None:
    trains = [minutes(str(i), "B", "A", i, i + 10) for i in range(3)]
    trains += [minutes(f"{i}D", "A", "B", 60 + i, 80 + i) for i in range(3)]
    got = workings_of(trains, SAMPLE)
    # two tracks at A: for the third set to come in the second has to leave; it is back for the third departure
    assert [got.ends[str(i)] for i in range(3)] == ["becomes:0D", "portal:P", "becomes:1D"]
    assert got.begins["2D"] == "portal:P"
    assert [w.numbers for w in got.diagrams if "1" in w.numbers] == [("1", "2D")]
    assert any("3 sets stand at Bessho before the first train" in text for text in got.warnings)


def test_beyond_without_a_portal_is_said() -> None:
    trains = [minutes("2", "B", "A", 0, 10, from_beyond=True)]
    got = workings_of(trains, SAMPLE)
    assert got.begins["2"] == "stabled"
    assert any("2: beyond Bessho there is no portal" in text for text in got.warnings)


def test_the_left_of_two_portals_is_taken() -> None:
    down = portal_of(KARASUYAMA, "HSK", Direction.DOWN, entering=True)
    up = portal_of(KARASUYAMA, "HSK", Direction.UP, entering=False)
    assert down is not None
    assert up is not None
    assert (down.section_id, up.section_id) == ("HSK.MD", "HSK.MU")
    assert down.outside == up.outside == "HSK"
    assert down.only
    # a halt is reached too, and from Karasuyama the far end of the line
    assert portal_of(KARASUYAMA, "TAK", Direction.UP, entering=False) is not None
    assert portal_of(KARASUYAMA, "KRS", Direction.DOWN, entering=False) is None
    assert portal_of(KARASUYAMA, "KRS", Direction.UP, entering=True) is None


def test_two_sets_that_stand_over_have_a_track_each() -> None:
    trains = [
        train("1D", "HSK", "OGN", 21600, 23000, KARASUYAMA),
        train("3D", "HSK", "OGN", 24000, 25400, KARASUYAMA),
        train("2U", "OGN", "HSK", 26000, 27000, KARASUYAMA),
        train("4U", "OGN", "HSK", 28000, 29000, KARASUYAMA),
    ]
    got = workings_of(trains, KARASUYAMA)
    assert got.ends["1D"] == "becomes:2U"
    at = {key: got.tracks.get(key) for key in (("1D", 1), ("3D", 1), ("2U", 0), ("4U", 0))}
    # track 1 is the usual one of down trains, 2 that of up trains: what needs no name has none
    usual = {"1D": "1", "3D": "1", "2U": "2", "4U": "2"}
    real = {number: track or usual[number] for (number, _), track in at.items()}
    assert real["1D"] == real["2U"]
    assert real["3D"] == real["4U"]
    assert real["1D"] != real["3D"]


def test_a_train_on_the_way_gives_room_to_a_set_that_stands() -> None:
    over = train("1D", "HSK", "OGN", 21600, 23000, KARASUYAMA)
    through = TrainOnLine(
        "3D",
        Direction.DOWN,
        (
            Call("HSK", None, None, 24000),
            Call("OGN", None, 25400, 25460),
            Call("KRS", None, 27000, None),
        ),
    )
    back = train("2U", "OGN", "HSK", 30000, 31000, KARASUYAMA)
    got = workings_of([over, through, back], KARASUYAMA)
    tracks = {got.tracks.get(("1D", 1), "1"), got.tracks.get(("3D", 1), "1")}
    assert tracks == {"1", "2"}
    assert not [text for text in got.warnings if "free track" in text]


def test_no_free_track_is_said() -> None:
    trains = [train(f"{i}D", "HSK", "OGN", 21600 + i * 2000, 23000 + i * 2000, KARASUYAMA) for i in range(3)]
    got = workings_of(trains, KARASUYAMA)
    assert any("3 sets stand at Ogane after the last train" in text for text in got.warnings)
    assert any("Ogane has no free track for" in text for text in got.warnings)


def test_numbers_and_sets_are_checked() -> None:
    one = minutes("1", "A", "B", 0, 10)
    with pytest.raises(InputError, match="a number of its own"):
        workings_of([one, one], SAMPLE)
    with pytest.raises(InputError, match="identifiers of sets, each once"):
        workings_of([one], SAMPLE, SetRules(stock=("V1", "V1")))
    with pytest.raises(InputError, match="a day that 1 sets can run"):
        workings_of(
            [minutes("2", "B", "A", 0, 10), minutes("4", "B", "A", 20, 30)], SAMPLE, SetRules(stock=("V1",))
        )
    with pytest.raises(InputError, match="a day that 1 sets can run: none is free for 3"):
        workings_of([one, minutes("3", "A", "B", 20, 30)], SAMPLE, SetRules(stock=("V1",)))


def test_a_published_working_keeps_its_set_over_a_portal() -> None:
    trains = [
        minutes("1", "A", "B", 0, 10, working="7"),
        minutes("2", "B", "A", 20, 30, working="7", to_beyond=True),
        minutes("4", "B", "A", 5, 12, working="8", to_beyond=True),
        # first in, first out would take the set of 4, which has waited longest
        minutes("3", "A", "B", 70, 80, working="7", from_beyond=True),
        minutes("5", "A", "B", 90, 99, from_beyond=True),
    ]
    got = {w.stock_id: w.numbers for w in workings_of(trains, SAMPLE).diagrams}
    assert got == {"7": ("1", "2", "3"), "8": ("4", "5")}


def test_a_set_that_its_working_needs_is_not_taken() -> None:
    trains = [
        minutes("2", "B", "A", 0, 10, working="7", to_beyond=True),
        minutes("1", "A", "B", 60, 70, from_beyond=True),
        minutes("3", "A", "B", 80, 90, working="7", from_beyond=True),
    ]
    got = {w.stock_id: w.numbers for w in workings_of(trains, SAMPLE).diagrams}
    assert got == {"7": ("2", "3"), "V1": ("1",)}


def test_workings_that_cannot_be_are_broken_and_said() -> None:
    # the set of 1 stands at Bessho, and 3 begins at Aoki before it could be there
    trains = [minutes("1", "A", "B", 0, 10, working="7"), minutes("3", "A", "B", 12, 22, working="7")]
    got = workings_of(trains, SAMPLE)
    assert len(got.diagrams) == 2
    assert any("the source's link from 1 to 3 is left out" in text for text in got.warnings)


def test_a_set_stands_where_no_train_on_its_way_still_holds_the_track() -> None:
    """1D has left Ogane, but holds its track until it is at Karasuyama; a set from Hoshakuji takes the other one."""

    def day(first_s: int) -> list[TrainOnLine]:
        way = (
            Call("HSK", None, None, first_s),
            Call("OGN", None, first_s + 900, first_s + 960),
            Call("KRS", None, first_s + 2000, None),
        )
        return [
            TrainOnLine("1D", Direction.DOWN, way, from_beyond=True),
            train("3D", "HSK", "OGN", 36_960, 37_900, KARASUYAMA, from_beyond=True),
            train("4D", "OGN", "HSK", 40_000, 41_000, KARASUYAMA, to_beyond=True),
        ]

    usual = workings_of(day(30_000), KARASUYAMA, SetRules()).tracks
    assert ("3D", 1) not in usual
    behind = workings_of(day(36_000), KARASUYAMA, SetRules()).tracks
    assert behind["3D", 1] == "2"
