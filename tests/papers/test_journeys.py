"""Whole journeys: what is shared, what it saves, and a bound that says how much more could be."""

from dataclasses import replace
from pathlib import Path

import pytest

from onboard.driving.planner.wish import Style
from papers import journeys
from papers.journeys import (
    JourneyCase,
    figures_of,
    line_cases,
    missed_by_s,
    row_of,
    solved_case,
    styled_j,
    track_cases,
    write_seconds,
)
from papers.reference_data import BESIDE
from scenario.scenario import load_scenario
from vehicle.optimum import least_time
from vehicle.optimum.journey import JourneyStop, TimeWindow
from vehicle.optimum.least import least_time_bound_s

HOPS = 3


@pytest.fixture(scope="module")
def cases() -> list[JourneyCase]:
    """The first train down the line, over its first hops."""
    hops, stops = journeys.planned_hops, journeys.published_stops
    with pytest.MonkeyPatch.context() as short:
        short.setattr(
            journeys,
            "planned_hops",
            lambda setup: [h for h in hops(setup) if h.mission.number == "321M"][:HOPS],
        )
        short.setattr(journeys, "published_stops", lambda *of: stops(*of)[: HOPS + 1])
        return list(line_cases(load_scenario("karasuyama_weekday").setup, quick=True))


@pytest.fixture(scope="module")
def whole() -> list[JourneyCase]:
    """All of its journey."""
    return list(line_cases(load_scenario("karasuyama_weekday").setup, quick=True))


@pytest.mark.nightly
def test_a_whole_train_of_the_line_is_within_one_percent_of_the_bound(whole: list[JourneyCase]) -> None:
    assert all(row_of(case).passed for case in whole)


def test_a_train_of_the_line_is_within_one_percent_of_the_bound(cases: list[JourneyCase]) -> None:
    assert [case.name for case in cases] == [
        "321M, windows free",
        "321M, as published",
        "321M, published to the minute",
    ]
    assert all(row_of(case).passed for case in cases)


@pytest.mark.nightly
def test_each_window_costs_energy_and_never_saves_any(whole: list[JourneyCase]) -> None:
    free, published, minute = (case.energies for case in whole)
    assert free is not None and published is not None and minute is not None
    assert free.optimal.energy_j < minute.optimal.energy_j < published.optimal.energy_j
    assert free.saving_percent > 0.1
    assert published.saving_percent == pytest.approx(0.0, abs=1e-6)


def test_a_journey_that_misses_a_window_or_is_not_shared_at_all_does_not_pass(
    cases: list[JourneyCase],
) -> None:
    free = cases[0]
    assert free.energies is not None
    assert missed_by_s(free.stops, free.energies.optimal) <= 1e-6
    early = JourneyStop(free.stops[-1].name, TimeWindow(latest_s=free.stops[-1].arrival.latest_s - 5.0))
    assert not row_of(replace(free, stops=(*free.stops[:-1], early))).passed
    unshared = replace(free, energies=replace(free.energies, optimal=free.energies.standard))
    assert not row_of(unshared).passed
    loose = replace(free, energies=replace(free.energies, bound_j=0.97 * free.energies.bound_j))
    assert not row_of(loose).passed


def test_windows_that_cannot_be_kept_are_told_with_stop_and_seconds(cases: list[JourneyCase]) -> None:
    free = cases[0]
    least_s = sum(hop.least_s for hop in free.hops) + sum(stop.dwell_min_s for stop in free.stops[1:-1])
    start_s = free.stops[0].departure.earliest_s
    short = JourneyStop(free.stops[-1].name, TimeWindow(latest_s=start_s + least_s - 7.0))
    row = row_of(solved_case("short", free.hops, (*free.stops[:-1], short)))
    assert not row.passed
    assert row.ours == f"not possible: arrival at {free.stops[-1].name} 7.0 s after its latest time, at best"


def test_figures_tell_every_hop_and_the_styles_in_order(cases: list[JourneyCase], tmp_path: Path) -> None:
    free = cases[0]
    assert free.energies is not None
    names = [figure.name for figure in figures_of(free)]
    assert names[2:] == [f"{free.name}: {hop.name}" for hop in free.hops]
    energies = [
        styled_j(free, free.energies.optimal, style) for style in (Style.OPTIMAL, Style.COAST, Style.HOLD)
    ]
    assert energies == sorted(energies)
    assert [path.name for path in write_seconds(cases, tmp_path)] == ["journeys.svg", "journeys.png"]
    assert write_seconds(cases[1:2], tmp_path) == ()


def test_no_run_is_faster_than_the_bound_of_the_least_time(cases: list[JourneyCase]) -> None:
    for hop in cases[0].hops:
        fastest_s = float(least_time(hop.course).time_s[-1])
        assert 0.98 * fastest_s < least_time_bound_s(hop.course) <= fastest_s


@pytest.mark.skipif(not (BESIDE / "ttobench").is_dir(), reason="tracks of TTOBench are not shipped")
def test_a_track_with_several_stops() -> None:
    cases = track_cases(BESIDE / "ttobench")
    for _ in range(3):
        case = next(cases)
        assert case.name.startswith("CH_Stadelhofen_Altstetten")
        assert row_of(case).passed
        assert case.energies is not None
        assert case.energies.saving_percent > 3.0
