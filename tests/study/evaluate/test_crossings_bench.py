"""What is measured is the line with crossings as said, and what the figures come to."""

from dataclasses import replace
from typing import Any

import pytest

from scenario.scenario import load_scenario
from simulation.carriers.road_of_run import roads_at
from study.evaluate import crossings_bench
from study.evaluate.crossings_bench import COUNT, RADIO, ROAD, VEHICLES_PER_H, WITHOUT, crossed, report


def test_the_crossings_lie_evenly_outside_points_with_radio_all_along() -> None:
    """The weekday's line: 20.4 km of track in its main direction, so a crossing a kilometre or so."""
    setup = crossed(load_scenario("karasuyama_weekday").setup, COUNT, VEHICLES_PER_H)
    line = setup.line
    assert len(line.crossings) == COUNT
    for crossing in line.crossings.values():
        piece = line.pieces[crossing.piece_id]
        assert piece.from_m < crossing.position_m - 3.0 < crossing.position_m + 3.0 < piece.to_m
        assert line.sections[piece.section_id].kind.value not in ("points", "portal")
        assert crossing.warning_s == 35.0
    places_m = sorted(crossing.position_m for crossing in line.crossings.values())
    assert places_m[-1] - places_m[0] > 15_000.0
    assert sum(road.road.per_h(8) for road in roads_at(setup)) == pytest.approx(VEHICLES_PER_H)
    assert all(len(one.coverage) == 1 for one in line.alignments.values())
    assert roads_at(replace(setup, roads={})) == ()


def of_way(cpu_s: float, carrier_s: float) -> list[dict[str, Any]]:
    counts = {"carried": 10, "telegrams": 5, "queries": 4, "digests": ["a"]}
    return [{"cpu_s": cpu_s * k, "carrier_s": carrier_s, **counts} for k in (0.5, 1.0, 9.0)]


@pytest.mark.parametrize(("cpu_s", "kept"), [(13.0, True), (13.1, False)])
def test_the_budget_is_of_the_day_without_a_road(cpu_s: float, kept: bool) -> None:
    """Medians; the road's own cost stands in its row, and counts for nothing else."""
    found = report({WITHOUT: of_way(10.0, 4.0), RADIO: of_way(cpu_s, 4.0), ROAD: of_way(99.0, 80.0)})
    assert found["budgets"][0]["kept"] is kept
    assert [row["trains_s"] for row in found["rows"]] == [6.0, cpu_s - 4.0, 19.0]
    assert found["same_digest"]


def test_every_figure_is_told_as_soon_as_it_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three rounds: the days with and without level crossings in each, the one with roads in the first."""
    ran: list[str] = []
    told: list[tuple[int, str]] = []

    def afresh(_module: str, way: str, *_words: str) -> dict[str, Any]:
        ran.append(way)
        return {
            "cpu_s": 10.0 + len(ran),
            "carrier_s": 4.0,
            "carried": 1,
            "telegrams": 7,
            "queries": 1,
            "digests": ["a"],
        }

    monkeypatch.setattr(crossings_bench, "figures_afresh", afresh)
    found = crossings_bench.bench("day", 3, lambda text: told.append((len(ran), text)))
    assert ran == [WITHOUT, RADIO, ROAD, WITHOUT, RADIO, WITHOUT, RADIO]
    assert [count for count, _ in told] == [1, 2, 3, 4, 5, 6, 7]
    assert all(
        f": {way}: {10 + k}.00 cpu s" in text
        for k, (way, (_, text)) in enumerate(zip(ran, told, strict=True), 1)
    )
    # medians of 11, 14, 16 and of 12, 15, 17
    assert [row["cpu_s"] for row in found["rows"]] == [14.0, 15.0, 13.0]
