"""Minimum running times: what physics says of them, and of the margins of a timetable with passings."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from exchange.running import StationRun
from network.model import Direction
from network.timetable import CallKind, parse_timetable
from onboard.driving_settings import Driving
from scenario.scenario import load_scenario
from simulation.settings import Load
from simulation.setup import Setup
from study.measures.running_times import planned_legs
from study.measures.standard_times import (
    least_by_leg,
    planned_runs,
    smallest_margins,
    standard_times,
    whole_line,
)
from tests.scenario.own import own_scenario
from tests.trains import timetable_of

PASSING = timetable_of(
    "passing",
    "karasuyama",
    "1D down, portal:HSK.MD to stabled: HSK -/07:00; NIT pass 07:07:20; OGN 07:15/07:16 operational;"
    " TAK 07:22/07:23; KRS 07:27/-",
    dwell_min_s=20,
    A="1D",
)


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_scenario("karasuyama_weekday").setup


@pytest.fixture(scope="module")
def passing(setup: Setup) -> Setup:
    timetable = parse_timetable(PASSING, "passing.toml", setup.line)
    return replace(setup, timetable=timetable, trains={"A": setup.trains["V1"]})


def test_every_leg_of_the_line_stands_in_both_directions(setup: Setup) -> None:
    times = standard_times(setup)
    order = [s.id for s in sorted(setup.line.stations.values(), key=lambda s: s.position_m)]
    down = [(t.from_id, t.to_id) for t in times if t.direction is Direction.DOWN]
    up = [(t.from_id, t.to_id) for t in times if t.direction is Direction.UP]
    assert down == list(pairwise(order))
    assert up == [(b, a) for a, b in reversed(down)]


def test_a_stand_costs_what_braking_to_it_costs_and_passing_is_never_slower(setup: Setup) -> None:
    """From the line's limit v on the level, stopping with deceleration b loses v / 2b against running on."""
    v_mps, b_mps2 = setup.line.max_speed_mps, setup.driving.stop_deceleration_mps2
    for leg in standard_times(setup):
        if leg.stop_pass_s is not None:
            assert leg.stop_stop_s - leg.stop_pass_s == pytest.approx(v_mps / (2.0 * b_mps2), abs=1.5), leg
        if leg.pass_pass_s is not None:
            assert leg.stop_pass_s is not None
            assert leg.pass_stop_s is not None
            assert leg.pass_pass_s <= min(leg.stop_pass_s, leg.pass_stop_s) < leg.stop_stop_s
            assert leg.pass_pass_s >= leg.distance_m / v_mps - 0.1
        rounded_s = leg.rounded_s()
        assert rounded_s is not None
        assert 0.0 <= rounded_s - leg.stop_stop_s < 5.0
        assert rounded_s % 5 == 0


def test_passing_parts_add_up_to_the_run_between_the_stops(passing: Setup) -> None:
    runs = planned_runs(passing)
    assert [(r.from_id, r.to_id, r.from_kind, r.to_kind) for r in runs] == [
        ("HSK", "NIT", CallKind.STOP, CallKind.PASS),
        ("NIT", "OGN", CallKind.PASS, CallKind.OPERATIONAL),
        ("OGN", "TAK", CallKind.OPERATIONAL, CallKind.STOP),
        ("TAK", "KRS", CallKind.STOP, CallKind.STOP),
    ]
    legs = {(t.from_id, t.to_id): t for t in standard_times(passing) if t.direction is Direction.DOWN}
    first = legs["HSK", "SHN"].stop_pass_s, legs["SHN", "NIT"].pass_pass_s
    assert None not in first
    assert runs[0].least_s == pytest.approx(sum(t for t in first if t is not None), abs=1.0)
    # Latest arrival at Ogane: planned, for nobody gets on; at Taki so that the least dwell is kept.
    assert runs[1].due_s == 7 * 3600 + 15 * 60
    assert runs[2].due_s == 7 * 3600 + 22 * 60
    margin_s = 440.0 - runs[0].least_s
    assert runs[0].margin_s == pytest.approx(margin_s)
    assert runs[0].as_dict()["margin_percent"] == round(100.0 * margin_s / runs[0].least_s, 1)
    assert runs[0].least_s + runs[1].least_s == pytest.approx(planned_legs(passing)[0].least_s, abs=0.1)
    tight = replace(runs[0], due_s=runs[0].due_s - 1.0)
    assert list(smallest_margins((runs[0], tight, runs[0])).values()) == [tight]


def test_a_train_of_another_kind_and_a_slower_line_need_more(setup: Setup) -> None:
    slow = replace(setup, driving=setup.driving.model_copy(update={"stop_deceleration_mps2": 0.3}))
    for ours, theirs in zip(standard_times(setup), standard_times(slow), strict=True):
        assert theirs.stop_stop_s > ours.stop_stop_s


def test_a_line_without_a_way_through_has_none(setup: Setup) -> None:
    stations = {k: v for k, v in setup.line.stations.items() if k in ("HSK", "SHN")}
    assert whole_line(replace(setup.line, stations=stations), Direction.DOWN) is None


def test_a_hill_too_steep_is_said_and_not_rounded(setup: Setup, tmp_path: Path) -> None:
    gradients = (
        '[patch.line.set]\n"alignments.main.gradients.13.permille" = 120.0\n'
        '"alignments.main.gradients.14.permille" = 120.0\n'
    )
    steep = own_scenario(tmp_path, gradients, "karasuyama_weekday").setup
    leg = next(t for t in standard_times(steep) if (t.from_id, t.to_id) == ("OGN", "KBN"))
    assert math.isinf(leg.stop_stop_s)
    assert (leg.rounded_s(), leg.as_dict()["stop_stop_s"]) == (None, None)


def test_least_times_by_leg_are_those_of_the_table_and_add_up() -> None:
    setup = load_scenario("karasuyama_weekday").setup
    kind = next(iter(setup.trains.values()))
    least = least_by_leg(setup.line, kind)
    table = {(t.from_id, t.to_id): t for t in standard_times(replace(setup, load=Load(), driving=Driving()))}
    for (from_id, to_id), time in table.items():
        assert least(StationRun(from_id, to_id, True, True)) == time.stop_stop_s
    over = least(StationRun("OGN", "TAK", True, True))
    first, second = table["OGN", "KBN"], table["KBN", "TAK"]
    assert over == (first.stop_pass_s or 0.0) + (second.pass_stop_s or 0.0)
    assert over is not None
    assert over < first.stop_stop_s + second.stop_stop_s
    assert least(StationRun("OGN", "KBN", True, False)) == first.stop_pass_s
