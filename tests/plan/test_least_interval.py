"""Least intervals of shipped lines against the theory's own seconds, and timetables at them that run."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from branchline.best_interval import write_answer
from network.model import Direction
from network.timetable import CallKind, TimetableTrain
from plan.even_day import Repetition, timetable_of
from plan.least_interval import (
    AS_UNITS_ASK,
    SET_LATE,
    LeastWaits,
    RepeatedPaths,
    least_interval,
    pattern_of,
    recounted,
)
from plan.most_trains import most_trains
from plan.where_to_meet import halts_of, loop_choices
from scenario.part_of_day import part_of_day
from scenario.scenario import load_scenario
from simulation.setup import Setup
from study.capacity.rules import Rules
from study.feasibility.check import feasibility
from study.measures.day_figures import day_figures
from tests.nightly import others_nightly
from tests.plain import run_on_plain

WEEKDAY = "karasuyama_weekday"
WORK = 8.0


def setup_of(name: str) -> Setup:
    return load_scenario(name).setup


def test_a_set_goes_out_on_the_track_on_which_it_came_in() -> None:
    """The two trains of the day have tracks of their own at both ends, so that no set could take up the other one."""
    (path,) = pattern_of(setup_of("bad_aibling_2016"), AS_UNITS_ASK).paths
    ends = [(train.calls[0], train.calls[-1]) for train in path.trains]
    assert [(a.station_id, a.track, b.station_id, b.track) for a, b in ends] == [
        ("AIB", "2", "KOL", "1"),
        ("KOL", "1", "AIB", "2"),
        ("AIB", "2", "KOL", "1"),
    ]


@pytest.mark.parametrize("rules", [AS_UNITS_ASK, SET_LATE])
def test_hoshakuji_has_one_track_for_both_ways(rules: Rules) -> None:
    """Each train has it from when the way to it is asked for until it is free: both together are the interval."""
    setup = setup_of(WEEKDAY)
    found = least_interval(setup, rules)
    held: list[float] = []
    (legs,) = found.pattern.legs
    for into, out in ((legs[0], legs[1]), (legs[4], legs[5])):
        begin_s = next(o.begin_s for o in into.occupations if o.section_id == "HSK.1")
        assert out.start is not None
        held.append(out.start.end_s - begin_s)
    assert found.interval_s is not None
    # two differences, each up to a whole second
    assert sum(held) <= found.interval_s <= math.ceil(sum(held)) + 1
    assert found.in_tenths_s == pytest.approx(sum(held), abs=0.2)
    assert found.least_waits
    assert recounted(setup, rules, found.proof) == []
    assert [(one.from_ticks, one.to_ticks) for one in found.proof.excluded] == [(0, found.interval_s - 1)]


def test_ways_set_late_leave_more_room_and_one_proof_does_not_do_for_the_other() -> None:
    setup = setup_of("busy_line")
    asked, late = (least_interval(setup, rules) for rules in (AS_UNITS_ASK, SET_LATE))
    assert asked.interval_s is not None and late.interval_s is not None
    assert late.interval_s < asked.interval_s
    assert recounted(setup, SET_LATE, asked.proof) != []


def test_without_the_loop_one_train_is_on_the_line_at_a_time() -> None:
    """There and back, from when the portal is asked for until the way out of the line is free but for the platform."""
    found = least_interval(setup_of("karasuyama_without_loop"))
    assert found.interval_s is not None
    first, last = found.pattern.legs[0][1], found.pattern.legs[0][4]
    there_and_back_s = last.arrives_s - first.departs_s
    assert there_and_back_s < found.interval_s < there_and_back_s + 400


def test_a_timetable_at_the_least_interval_runs(tmp_path: Path) -> None:
    """Nothing is impossible in it, and less than a second a train is caught from others."""
    setup, out = setup_of(WEEKDAY), tmp_path / "least.toml"
    write_answer(out, setup, least_interval(setup), WEEKDAY)
    assert feasibility(load_scenario(str(out)).setup).good
    morning = part_of_day(load_scenario(str(out)), None, "09:00")
    ran = run_on_plain(morning)
    on_the_line = {stop.number for stop in ran.result.stops}
    assert len(on_the_line) > 8
    assert day_figures(ran.result, ran.scenario.setup).secondary_s < len(on_the_line)


def test_a_loop_where_the_longest_stretch_is_halved() -> None:
    """Between Hoshakuji and Ogane; beyond Ogane none helps."""

    def with_loops(loops: Sequence[str]) -> Setup:
        return load_scenario(WEEKDAY, tables={"patch": {"line": {"add_loops": list(loops)}}}).setup

    assert halts_of(setup_of(WEEKDAY).line) == ("SHN", "NIT", "KNY", "KBN", "TAK")
    choices = loop_choices(with_loops, ["NIT", "TAK"], 2)
    intervals = {choice.loops: choice.found.interval_s or 0 for choice in choices if choice.found is not None}
    assert choices[0].loops in (("NIT", "KBN"), ("NIT", "TAK"))
    assert abs(intervals[()] - intervals["TAK",]) <= 2
    assert 0 < intervals["NIT", "TAK"] < 0.6 * intervals[()]


def test_a_pattern_is_of_trains_from_end_to_end() -> None:
    names = [path.name for path in pattern_of(setup_of("busy_line"), AS_UNITS_ASK).paths]
    assert names == ["down", "up"]


@pytest.mark.parametrize("printed", [True, False])
def test_trains_wait_where_they_are_said_to_beyond_a_station_that_none_stops_at(printed: bool) -> None:
    """Whether a timetable has a call there (通過) or says nothing, as of signal stations (信号場)."""
    setup = setup_of("busy_line")
    trains: dict[str, TimetableTrain] = {}
    for number, train in setup.timetable.trains.items():
        calls = [call for call in train.calls if printed or call.station_id != "EDO"]
        if printed:
            at = next(i for i, call in enumerate(calls) if call.station_id == "EDO")
            calls[at] = replace(calls[at], kind=CallKind.PASS, arrival_s=None)
        trains[number] = replace(train, calls=tuple(calls))
    setup = replace(setup, timetable=replace(setup.timetable, trains=trains))
    found = least_interval(setup)
    assert found.interval_s is not None
    day = timetable_of(setup, Repetition(found.pattern, found.moves_s, found.interval_s), "none_at_edo")
    waits_s: dict[tuple[Direction, str | None], float] = {}
    for legs, moves_s in zip(found.pattern.legs, found.moves_s, strict=True):
        for leg, (into_s, out_s) in zip(legs, pairwise(moves_s), strict=False):
            assert leg.end is not None
            station_id = setup.line.sections[leg.end.section_id].station_id
            waits_s[leg.direction, station_id] = out_s - into_s
    longest_s = 0.0
    for train in day.trains.values():
        for call in train.calls:
            if call.departure_s is not None and call.arrival_s is not None:
                stands_s = call.departure_s - call.arrival_s - setup.unit.dwell_min_s
                assert stands_s == waits_s[train.direction, call.station_id]
                longest_s = max(longest_s, stands_s)
    assert longest_s > 0


PAGE = (Path(__file__).resolve().parents[2] / "docs/best.md").read_text("utf-8")
SHOWN = re.findall(
    r"^\| `(\w+)` \| (\d+) s \| ([\d.]+) s \| (\d+) s \| (\d+) s \|.*\| (\d+) \|$", PAGE, re.MULTILINE
)


@pytest.mark.parametrize(
    ("name", "asked_s", "tenths_s", "late_s", "circle_s", "circles"),
    others_nightly(SHOWN, SHOWN[:2], columns=True),
)
def test_the_page_shows_what_is_found(
    name: str, asked_s: str, tenths_s: str, late_s: str, circle_s: str, circles: str
) -> None:
    setup = setup_of(name)
    asked, late = (least_interval(setup, rules) for rules in (AS_UNITS_ASK, SET_LATE))
    assert (asked.interval_s, late.interval_s) == (int(asked_s), int(late_s))
    assert asked.in_tenths_s == float(tenths_s)
    assert asked.circle is not None
    assert asked.circle[1] + 1 == int(circle_s)
    assert sum(map(len, asked.circles())) == int(circles)
    assert recounted(setup, AS_UNITS_ASK, asked.proof) == recounted(setup, SET_LATE, late.proof) == []


def test_sets_that_go_round_begin_and_end_the_day_where_they_are(tmp_path: Path) -> None:
    """As many sets as intervals in a round; nothing is impossible in the day."""
    setup, out = setup_of("isumi_weekday"), tmp_path / "least.toml"
    found = least_interval(setup)
    write_answer(out, setup, found, "isumi_weekday")
    day = load_scenario(str(out)).setup
    (moves,), (legs,) = found.moves_s, found.pattern.legs
    round_s = moves[-1] - moves[0] + legs[-1].departs_s - legs[0].departs_s
    assert found.interval_s is not None
    assert round_s == pytest.approx(len(day.timetable.diagrams) * found.interval_s)
    assert feasibility(day).good


def test_trains_need_not_be_evenly_spaced_to_be_as_many_as_a_track_takes() -> None:
    """Hoshakuji's one track takes three of each way in two hours, whatever the order; four it does not."""
    setup = setup_of(WEEKDAY)
    (legs,) = pattern_of(setup, AS_UNITS_ASK).legs
    pairs_s = sum(
        occupation.length_s
        for leg in legs
        for occupation in leg.occupations
        if occupation.section_id == "HSK.1"
    )
    found = most_trains(setup, 7200, WORK)
    assert (found.trains, found.at_most) == (3, 3)
    assert found.section_id == "HSK.1"
    assert found.held_s == pytest.approx(pairs_s, abs=2.0)
    assert 3 * pairs_s <= 7200 < 4 * pairs_s
    assert found.waits is not None
    repeated = Repetition(found.pattern, found.waits.moves_s, 7200, 6 * 3600, 12 * 3600)
    day = timetable_of(setup, repeated, "three_in_two_hours")
    assert len(day.trains) == 3 * 2 * 3
    stock = {diagram.stock_id: setup.trains[found.pattern.paths[0].kind_of_stock] for diagram in day.diagrams}
    assert feasibility(replace(setup, timetable=day, trains=stock)).good


@pytest.mark.parametrize(
    ("impossible", "evenly", "most", "found"),
    [
        (True, False, 24, (2, 2, ())),
        (False, False, 24, (2, 3, (3,))),
        (False, True, 24, (3, 3, ())),
        (True, False, 2, (2, 3, (3,))),
    ],
)
def test_more_trains_are_excluded_only_where_that_is_proven(
    impossible: bool, evenly: bool, most: int, found: tuple[object, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of three trains each way in two hours no moves are found, be it proven or not, or they are not looked for; two
    are had, and three if every 40 minutes one is.
    """

    def waits(pattern: RepeatedPaths, _bounds: object, period: int, *_: object) -> LeastWaits:
        if pattern.trains_each_way == 3 or (period == 2400 and not evenly):
            return LeastWaits((), math.nan, proven=False, impossible=impossible, work=0.1)
        return LeastWaits(((0.0,),), 0.0, proven=True, impossible=False, work=0.1)

    monkeypatch.setattr("plan.most_trains.least_waits", waits)
    monkeypatch.setattr("plan.most_trains.TRAINS_MAX", most)
    trains = most_trains(setup_of(WEEKDAY), 7200, WORK)
    assert (trains.trains, trains.at_most, trains.undecided) == found


def test_all_shipped_lines_with_trains_each_way_are_shown() -> None:
    assert {row[0] for row in SHOWN} >= {WEEKDAY, "kururi_weekday", "isumi_weekday", "busy_line"}
