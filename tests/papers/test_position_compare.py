"""One run with every sensor set: what the line has for them, what fails, and what is judged."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from papers import position_sets
from papers.position_compare import (
    FAR_M,
    Measures,
    acting_row,
    draw_comparison,
    far_from_a_fix,
    held_row,
    measures_of,
    numbers,
    reproduce,
    row_of,
    write_table,
)
from papers.position_run import PositionResult
from papers.position_sets import (
    MOVED_M,
    SETS,
    TROUBLES,
    SensorSetRun,
    moments_of,
    on_the_track,
    path_of_run,
    setup_of,
    troubles_concerning,
)
from papers.reproduction import Options
from simulation.faults.fault import InForce
from simulation.faults.table import FAULTS
from simulation.settings import PositionSensor
from simulation.world.records import TRACE
from study.report.style import write_figure

HOLDS = Measures("a", "nothing fails", True, 1.0, 2.0, 3.0, 4.0, 5.0, 0.1, 0.0, 0, -0.5, True)


def run_of(errors_m: list[float], halves_m: list[float], at_m: list[float] | None = None) -> SensorSetRun:
    trace = np.zeros(len(errors_m), TRACE)
    trace["estimate_error_m"] = errors_m
    trace["bound_ahead_m"] = trace["bound_behind_m"] = halves_m
    trace["position_m"] = np.arange(len(errors_m)) * 20.0 if at_m is None else at_m
    trace["speed_mps"] = 20.0
    return SensorSetRun(
        SETS[0],
        (),
        PositionResult(trace, trace["speed_mps"] >= 0.0, out_m=-0.5, steps=10, known_steps=9, arrived=True),
    )


def test_a_set_is_there_for_every_sensor_with_a_reader() -> None:
    assert SETS[0].carries == (PositionSensor.TAGS,)
    assert SETS[-1].name == "all"
    assert set(SETS[-1].carries) == {word for carried in SETS for word in carried.carries}


def test_every_trouble_is_a_fault_or_lies_on_the_track() -> None:
    assert all(not trouble.kind or trouble.kind in FAULTS for trouble in TROUBLES)
    for trouble in TROUBLES:
        assert len(moments_of(trouble, "V1", 0, InForce())) == (2 if trouble.kind else 0)
    everything = troubles_concerning(SETS[-1])
    assert {trouble.concerns for trouble in everything} == {None, *SETS[-1].carries}
    assert not any(trouble.held for trouble in troubles_concerning(SETS[-1], held=False))


def test_what_was_moved_is_moved_on_the_line_alone() -> None:
    setup = setup_of(SETS[-1], seed=1)
    path, line = path_of_run(setup), setup.line
    so = on_the_track(line, path, troubles_concerning(SETS[-1]))
    moved = [(line.tags[key], tag) for key, tag in so.tags.items() if tag != line.tags[key]]
    assert moved
    for before, after in moved:
        apart_m = path.to_path_m(after.piece_id, after.position_m) - path.to_path_m(
            before.piece_id, before.position_m
        )
        assert apart_m == pytest.approx(MOVED_M)
    assert set(so.markers) < set(line.markers)
    assert sum(beacon != line.beacons[key] for key, beacon in so.beacons.items()) == 1
    assert on_the_track(line, path, ()) is line


def test_the_measures_of_a_run() -> None:
    found = measures_of(run_of([0.0, 3.0, -4.0, 0.0], [5.0, 5.0, 3.0, 5.0]))
    assert found.sigma_m == pytest.approx(2.5)
    assert found.error_most_m == 4.0
    assert found.outside_s == 1
    assert found.half_median_m == 5.0
    assert found.unknown_share == pytest.approx(0.1)


def test_a_run_without_a_position_has_no_bounds_that_hold() -> None:
    ran = run_of([0.0, 1.0], [2.0, 2.0])
    ran.result.known_steps, ran.result.out_m = 0, -np.inf
    assert not row_of(measures_of(ran)).passed


def test_the_way_without_a_fix_is_what_wheels_alone_ran() -> None:
    halves = [1.0 + 0.4 * number for number in range(51)]  # as wheels leave it over a kilometre
    assert far_from_a_fix(run_of([0.0] * 51, halves)) == pytest.approx(1.0 - FAR_M / 1000.0, abs=0.03)
    halves[30:] = [1.0 + 0.4 * number for number in range(21)]
    assert far_from_a_fix(run_of([0.0] * 51, halves)) == pytest.approx(0.08, abs=0.03)


def test_a_broken_bound_fails_inside_the_model_and_is_told_beyond_it() -> None:
    assert row_of(HOLDS).passed
    broken = replace(HOLDS, nearest_to_outside_m=0.01)
    unsaid = replace(HOLDS, nearest_to_outside_m=np.nan)
    assert held_row([HOLDS]).passed
    assert not any(held_row([HOLDS, each]).passed or row_of(each).passed for each in (broken, unsaid))
    assert row_of(replace(broken, inside_the_model=False)).passed
    assert "beyond the model" in row_of(replace(broken, inside_the_model=False)).case


def test_a_fault_that_changes_nothing_is_found_out() -> None:
    plain = run_of([0.0, 1.0], [2.0, 2.0])
    idle = replace(plain, troubles=(TROUBLES[0],))
    acting = replace(run_of([0.0, 1.5], [2.0, 2.0]), troubles=(TROUBLES[1],))
    assert acting_row([plain, acting]).passed
    assert not acting_row([plain, idle, acting]).passed
    assert TROUBLES[0].name in str(acting_row([plain, idle]).ours)


def test_table_and_plot_are_written(tmp_path: Path) -> None:
    plain = run_of([0.0, 1.0, 0.5], [2.0, 2.0, 3.0])
    troubled = replace(plain, troubles=troubles_concerning(SETS[0]))
    with write_table([measures_of(plain), measures_of(troubled)], tmp_path).open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["case"] for row in rows] == ["nothing fails", "all of these in turn"]
    assert float(rows[0]["error_most_m"]) == 1.0
    files = write_figure("compared", lambda: draw_comparison([plain, troubled]), tmp_path)
    assert all(file.stat().st_size > 1000 for file in files)
    assert list(numbers().values()) == list(range(1, len(numbers()) + 1))


def test_it_goes_by_the_defaults() -> None:
    assert position_sets.GNSS.receiver.protection_m == 20.0


@pytest.mark.nightly
def test_all_sets_and_faults() -> None:
    result = reproduce(Options())
    assert [row.case for row in result.rows if not row.passed] == []
