"""The busy line: what is committed is what its generator writes, and its timetable is one that can run."""

from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from documents.busy_line import DWELL_S, INTERVAL_S, LINE_ID, STATIONS, STEP_S, TURN_BACK_S, files
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Direction, SectionKind
from network.timetable import AtPortal, BecomesTrain, Timetable, load_timetable
from scenario.scenario import load_scenario
from study.feasibility.check import feasibility
from sumo_cfg.build import net_digest, shipped_net
from sumo_cfg.writer import write_plain
from tests.plain import run_on_plain

LINE = load_line(shipped_line(LINE_ID))
TIMETABLE = load_timetable(shipped_timetable(LINE_ID), LINE)


@pytest.mark.parametrize("path", files(), ids=lambda path: "/".join(path.parts[-3:]))
def test_the_committed_file_is_what_the_generator_writes(path: Path) -> None:
    assert path.read_text("utf-8") == files()[path]


def test_the_committed_net_is_this_lines() -> None:
    assert net_digest(shipped_net(LINE_ID)) == write_plain(LINE).digest


def test_six_stations_of_two_tracks_over_33_km() -> None:
    stations = list(LINE.stations.values())
    assert [station.id for station in stations] == [name for name, _ in STATIONS]
    assert all(len(station.tracks) == 2 for station in stations)
    assert stations[-1].position_m - stations[0].position_m == pytest.approx(33_000.0)
    assert [b.position_m - a.position_m for a, b in pairwise(stations)] == [pytest.approx(6_600.0)] * 5
    assert sum(s.kind is SectionKind.BETWEEN for s in LINE.sections.values()) == 5


@pytest.mark.parametrize("direction", list(Direction))
def test_48_trains_each_way_every_15_minutes(direction: Direction) -> None:
    trains = [train for train in TIMETABLE.trains.values() if train.direction is direction]
    leaving_s = [train.calls[0].last_s for train in trains]
    assert len(trains) == 48
    assert {b - a for a, b in pairwise(leaving_s)} == {INTERVAL_S} == {900}
    assert leaving_s[-1] - leaving_s[0] < 12 * 3600
    for train in trains:
        assert {b.last_s - a.last_s for a, b in pairwise(train.calls[:-1])} == {STEP_S}
        assert {call.last_s - call.first_s for call in train.calls[1:-1]} == {DWELL_S}


def test_every_meet_is_at_a_station_and_every_station_sees_some() -> None:
    found = feasibility(load_scenario(LINE_ID).setup)
    assert found.findings == ()
    places = Counter(meet.station for meet in found.meets)
    # At each of the four stations inside, each of 47 intervals shared by both directions has its meet.
    assert set(places) == {name for name, _ in STATIONS[1:-1]}
    assert min(places.values()) >= 45


def test_a_set_turns_back_on_the_track_where_it_stands_and_no_two_stand_on_one() -> None:
    standing: dict[tuple[str, str | None], list[tuple[int, int]]] = {}
    for train in TIMETABLE.trains.values():
        if isinstance(train.ends, BecomesTrain):
            last, after = train.calls[-1], TIMETABLE.trains[train.ends.number]
            first = after.calls[0]
            assert (last.station_id, last.track) == (first.station_id, first.track)
            assert first.last_s - last.first_s == TURN_BACK_S
            standing.setdefault((last.station_id, last.track), []).append((last.first_s, first.last_s))
    assert len(standing) == 4
    for times in standing.values():
        assert all(leaves_s < comes_s for (_, leaves_s), (comes_s, _) in pairwise(sorted(times)))


def test_it_all_says_that_it_is_assumed() -> None:
    assert any("made up" in text for text in LINE.assumed)
    assert any("all times" in text for text in TIMETABLE.head.assumed)
    assert TIMETABLE.head.sources == []


def _first_two_trains_of_each_set() -> Timetable:
    """The morning: each set comes in, turns back once and goes to the depot."""
    trains, diagrams = {}, []
    for diagram in TIMETABLE.diagrams:
        first, second = (TIMETABLE.trains[number] for number in diagram.train_numbers[:2])
        last = second.calls[-1]
        calls = (*second.calls[:-1], replace(last, departure_s=last.first_s + DWELL_S))
        depot = AtPortal(f"{last.station_id}.P")
        trains |= {first.number: first, second.number: replace(second, calls=calls, ends=depot)}
        diagrams.append(replace(diagram, train_numbers=(first.number, second.number)))
    return replace(TIMETABLE, trains=trains, diagrams=tuple(diagrams))


@pytest.mark.nightly
def test_a_morning_of_it_runs_to_plan() -> None:
    scenario = load_scenario(LINE_ID)
    setup = replace(scenario.setup, timetable=_first_two_trains_of_each_set())
    run = run_on_plain(replace(scenario, setup=setup))
    assert run.broken == ()
    assert run.summary["invariants_broken"] == run.summary["collisions"] == 0
    assert run.summary["trains_arrived"] == 14
    # Passing costs no time: a train that waited for the other's section would be late by its release.
    assert run.summary["late_s_max"] < DWELL_S
