"""Standard paths, the day with them judged, virtual blocks, what equipment is worth: on a few trains of a real line."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from network.graph import all_routes
from network.model import Line, SectionKind
from network.timetable import Diagram
from network.virtual_blocks import with_virtual_blocks
from scenario.scenario import load_scenario
from simulation.setup import Setup
from study.capacity import equipment, more
from study.capacity.compression import compressed
from study.capacity.cut import PartKind, cut_of
from study.capacity.equipment import (
    LEVERS,
    EquipmentFigures,
    fewer_tags,
    measured_by_rules,
    with_loss,
    with_throw,
    with_wheel_error,
    worth_of,
)
from study.capacity.legs import legs_of, places_of
from study.capacity.limits import LIMITS, TrafficKind, additional_share, consumed_share
from study.capacity.line_capacity import (
    CompressionTerms,
    Period,
    Rate,
    day_of,
    fullest_part,
    peak_of,
    rates_of,
)
from study.capacity.more import more_trains
from study.capacity.occupation import OccupationCost
from study.capacity.room import PathSearch
from study.capacity.rules import MINIMAL, VIRTUAL_BLOCKS, Rules
from study.capacity.shared_stretch import StretchHeadways, mean_wait_s, traffic_at
from study.capacity.standard import standard_paths
from study.capacity.theory import occupations
from study.feasibility.check import feasibility
from study.report.capacity import FILES, write_occupation

MORNING_S = (18_000.0, 34_200.0)


@pytest.fixture(scope="module")
def weekday() -> Setup:
    return load_scenario("karasuyama_weekday").setup


@pytest.fixture(scope="module")
def morning(weekday: Setup) -> Setup:
    """The trains of the weekday that begin before half past nine, as far as their sets have run."""
    old = weekday.timetable
    diagrams = list[Diagram]()
    for diagram in old.diagrams:
        numbers = tuple(n for n in diagram.train_numbers if old.trains[n].calls[-1].first_s < MORNING_S[1])
        while numbers and old.trains[numbers[-1]].direction.name == "DOWN":
            numbers = numbers[:-1]
        if numbers:
            diagrams.append(replace(diagram, train_numbers=numbers))
    trains = {n: old.trains[n] for diagram in diagrams for n in diagram.train_numbers}
    return replace(weekday, timetable=replace(old, trains=trains, diagrams=tuple(diagrams)))


def test_a_set_there_and_back_where_one_end_has_portals(weekday: Setup) -> None:
    (path,) = standard_paths(weekday)
    there, back = path.trains
    assert path.name == "down and back"
    assert [call.station_id for call in there.calls] == [c.station_id for c in reversed(back.calls)]
    gaps = [b.first_s - a.last_s for a, b in pairwise(there.calls)]
    assert min(gaps) > 60
    dwells = {c.last_s - c.first_s for c in there.calls[1:-1]}
    assert dwells == {20}


def test_paths_each_way_where_both_ends_have_portals_and_none_without() -> None:
    assert [p.name for p in standard_paths(load_scenario("busy_line").setup)] == ["down", "up"]
    assert standard_paths(load_scenario("kururi_weekday").setup) == ()


def test_what_is_put_in_holds_when_the_day_is_judged(morning: Setup) -> None:
    until_noon = Period("morning", MORNING_S[0], 43_200.0, peak=False)
    found = more_trains(morning, until_noon, PathSearch())
    assert found.trains == 2 * len(found.paths) > 0
    assert found.dropped == ()
    assert feasibility(morning).good
    for path in found.paths:
        assert until_noon.from_s <= path.departs_s < path.arrives_s <= until_noon.to_s
    assert found.trains_in(until_noon) == found.trains


def test_what_the_judgement_names_goes_out_again(morning: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    """With nothing looked at before, trains are put in on top of each other, and few of them stay."""
    monkeypatch.setattr("study.capacity.room.OccupiedSpans.until_s", nothing)
    found = more_trains(morning, Period("morning", 25_200.0, 30_600.0, peak=False), PathSearch())
    assert found.dropped
    monkeypatch.setattr(more, "_impossible", nobody)
    blind = more_trains(morning, Period("morning", 25_200.0, 30_600.0, peak=False), PathSearch())
    assert blind.dropped == ()
    assert blind.trains > found.trains


def nothing(*_: object) -> None:
    """Nothing is in the way."""


def nobody(*_: object) -> set[str]:
    """Nobody is named."""
    return set()


# rates ----------------------------------------------------------------------------------------------------------------


def test_limits_say_the_same_either_way() -> None:
    """The leaflet gives the additional time in whole percent: 18, 43, 33, 67."""
    suburban, mixed = LIMITS[TrafficKind.SUBURBAN], LIMITS[TrafficKind.MIXED]
    shares = [suburban.peak_share, suburban.day_share, mixed.peak_share, mixed.day_share]
    assert [round(100.0 * additional_share(share)) for share in shares] == [18, 43, 33, 67]
    assert consumed_share(2160.0, 3600.0, 0.6) == pytest.approx(1.0)


def test_the_cut_changes_the_answer(morning: Setup) -> None:
    legs = legs_of(occupations(morning, MINIMAL), places_of(morning.line))
    day = day_of(legs)
    terms = CompressionTerms(dwell_min_s=morning.unit.dwell_min_s)
    rates = {
        way: rates_of(legs, cut_of(morning.line, way), (day,), terms)
        for way in ("whole", "crossing", "interval")
    }
    full = {way: fullest_part(found) for way, found in rates.items()}
    shares = [one.occupied_share for one in full.values() if one is not None]
    assert shares[0] > shares[1] > shares[2] > 0.0
    for rate in rates["crossing"]:
        assert sum(rate.compressed.costs_s().values()) == pytest.approx(rate.compressed.occupied_s, abs=1e-3)
        assert rate.trains_below_limit == brute_more(rate)
    peak = peak_of(legs, day)
    assert peak.length_s == 7200.0
    assert day.from_s <= peak.from_s < peak.to_s <= day.to_s
    both = rates_of(legs, cut_of(morning.line, "interval"), (day, peak), terms)
    # UIC 406, 2nd edition: mixed traffic, and the band of nodes
    assert {(rate.part.kind, rate.period.peak, rate.limit_share) for rate in both} == {
        (PartKind.LINE, False, 0.60),
        (PartKind.LINE, True, 0.75),
        (PartKind.NODE, False, 0.60),
        (PartKind.NODE, True, 0.80),
    }


def brute_more(rate: Rate) -> int:
    """One more at a time, until the limit is passed; or one less."""
    each_s = rate.compressed.occupied_s / rate.trains
    room_s = rate.limit_share * rate.period.length_s
    count = 0
    while (rate.trains + count + 1) * each_s <= room_s:
        count += 1
    while (rate.trains + count) * each_s > room_s:
        count -= 1
    return count


# equipment ------------------------------------------------------------------------------------------------------------


def test_throw_moves_the_meet_by_as_much(morning: Setup) -> None:
    """A meet waits for one throw: 6 s more of it are 6 s more, and every train needs its points longer."""
    base, slow = measured_by_rules(morning), measured_by_rules(with_throw(morning, 12.0))
    assert slow.meet_s - base.meet_s == pytest.approx(6.0, abs=0.15)
    assert slow.occupied_share > base.occupied_share
    assert base.block_headway_s < base.headway_s
    assert base.part == "Hoshakuji - Ogane"
    quick = occupations(morning, replace(MINIMAL, unslowed=True))
    ogane_s = max(one.length_s for one in quick if one.section_id == base.section_id == "OGN.1")
    assert base.headway_s == pytest.approx(
        ogane_s, abs=0.01
    )  # who follows its like waits for its longest block


def test_levers_change_what_they_say(morning: Setup) -> None:
    assert with_loss(morning, 0.1).air.loss_good_p == 0.1
    unit = with_wheel_error(morning, 0.005).unit
    assert (unit.wheel_error_share, unit.wheel_scale_limit) == (0.005, 0.0025)
    tags = fewer_tags(morning.line).tags
    assert 0 < len(tags) < len(morning.line.tags)
    assert {lever.cost for lever in LEVERS} >= {
        OccupationCost.RADIO,
        OccupationCost.POINTS,
        OccupationCost.LOCALISATION,
        OccupationCost.DRIVING,
    }


def test_a_tornado_has_the_widest_on_top_and_is_drawn(
    morning: Setup, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is measured stands in for theory here: the throw for the headway."""

    def made_up(setup: Setup, rules: Rules = MINIMAL) -> EquipmentFigures:
        throw_s = max(points.throw_time_s for points in setup.line.points.values())
        headway_s = 100.0 if rules.by_section else 900.0 + throw_s
        return EquipmentFigures(headway_s, "HSK-OGN", 200.0, setup.air.delay_mean_s, 0.5, "Hoshakuji - Ogane")

    monkeypatch.setattr(equipment, "measured_by_rules", made_up)
    levers = [
        lever for lever in LEVERS if lever.name in {"throw time", "radio delay", "clear section by section"}
    ]
    worth = worth_of(morning, levers)
    assert [one.name for one in worth] == ["clear section by section", "throw time", "radio delay"]
    assert [one.headway_swing_s for one in worth] == pytest.approx([806.0, 9.0, 0.0])
    legs = legs_of(occupations(morning, MINIMAL), places_of(morning.line))
    rates = rates_of(legs, cut_of(morning.line, "crossing"), (day_of(legs),))
    write_occupation(tmp_path / "out", {"crossing": rates}, worth)
    assert (tmp_path / "out/tornado.png").read_bytes()[:4] == b"\x89PNG"
    assert {path.name for path in (tmp_path / "out").iterdir()} == set(FILES)


# virtual blocks -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("blocks", [1, 2, 5])
def test_a_line_in_virtual_blocks_has_the_same_routes(weekday: Setup, blocks: int) -> None:
    cut = with_virtual_blocks(weekday.line, blocks)
    assert [r.id for r in all_routes(cut)] == [r.id for r in all_routes(weekday.line)]
    assert length_m(cut) == pytest.approx(length_m(weekday.line))
    between = [s for s in cut.sections.values() if s.kind is SectionKind.BETWEEN]
    assert len(between) == 2 * blocks
    for tag in cut.tags.values():
        piece = cut.pieces[tag.piece_id]
        assert piece.from_m <= tag.position_m <= piece.to_m
    for station in cut.stations.values():
        for track in station.tracks:
            piece = cut.pieces[track.piece_id]
            assert all(piece.from_m <= mark_m <= piece.to_m for mark_m in track.marks_m.values())


def length_m(line: Line) -> float:
    return sum(piece.length_m for piece in line.pieces.values())


def test_no_block_is_no_line(weekday: Setup) -> None:
    with pytest.raises(ValueError, match="one block"):
        with_virtual_blocks(weekday.line, 0)


def test_blocks_shorten_what_a_train_holds(morning: Setup) -> None:
    longest = []
    for blocks in (1, 4):
        line = with_virtual_blocks(morning.line, blocks)
        found = occupations(replace(morning, line=line), VIRTUAL_BLOCKS)
        longest.append(max(one.length_s for one in found if one.section_id.startswith("HSK-OGN")))
    assert longest[1] < 0.6 * longest[0]


def stretches() -> Iterator[StretchHeadways]:
    for following_s in (900.0, 300.0, 90.0):
        yield StretchHeadways((following_s, following_s), (10.0, 10.0), (900.0, 900.0))


def test_a_shared_stretch_takes_more_trains_the_closer_they_follow() -> None:
    found = list(stretches())
    assert found[0].trains_per_hour_max == pytest.approx(3600.0 / ((2 * 900.0 + 2 * 910.0) / 4))
    wait_s = mean_wait_s(found[0], 2.0, 1)
    traffic = [traffic_at(one, wait_s, 1) for one in found]
    assert traffic[0] == pytest.approx(2.0, abs=0.01)
    assert traffic == sorted(traffic)
    assert mean_wait_s(found[0], 5.0, 1) == float("inf")


def test_alone_a_train_waits_for_nobody() -> None:
    one = next(stretches())
    assert mean_wait_s(one, 0.001, 1) < 1.0


def test_a_part_in_an_empty_period_is_empty(morning: Setup) -> None:
    legs = legs_of(occupations(morning, MINIMAL), places_of(morning.line))
    late = Period("night", 80_000.0, 83_600.0, peak=False)
    (rate,) = rates_of(legs, cut_of(morning.line, "whole"), (late,))
    assert (rate.trains, rate.trains_below_limit, rate.occupied_share) == (0, 0, 0.0)
    assert compressed((), frozenset({"HSK.1"})).trains == ()
