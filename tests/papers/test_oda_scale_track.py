"""`branchline reproduce oda-scale-track`: figures of Oda 2019, section 3.3.4, and what the camera is worth."""

from dataclasses import replace

import numpy as np
import pytest

from network.model import Direction
from onboard.localisation.vision import ImageWindow, SightTable
from papers import oda_scale_track
from papers.oda_scale_track import ScaleTrackStop, TrackTest, reproduce, run_stops
from papers.reproduction import Options
from simulation.sensors.camera import PAPER_CAMERA, PAPER_SIGN, PAPER_TABLE_M, Renderer
from simulation.sensors.sighting_model import record_table
from vehicle.train_file import load_train, shipped_train


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(PAPER_CAMERA, 5)


@pytest.fixture(scope="module")
def table(renderer: Renderer) -> SightTable:
    return record_table(renderer, PAPER_SIGN, PAPER_TABLE_M, 5, window=ImageWindow(640, 480, 1280, 960))


@pytest.mark.nightly
def test_it_passes_on_its_short_slice() -> None:
    result = reproduce(Options(seed=5, quick=True))
    assert [row.case for row in result.rows if not row.passed] == []
    assert result.remarks[-1].startswith("Quick")
    assert all(parameter.origin for parameter in result.parameters)


def test_the_papers_figures_of_three_stops_by_hand() -> None:
    """Squares of 0.08, 0.04 and 0.04 add up to 0.0096; three times the root of half of that."""
    stops = tuple(ScaleTrackStop(Direction.DOWN, error_m, 0.0, 1, 0, 0) for error_m in (-0.12, 0.0, 0.0))
    assert [row.ours for row in oda_scale_track._rows(stops, "")] == ["2 of 3", -0.04, 0.2078, 0.12]


def test_ten_stops_as_the_paper_ran_them(renderer: Renderer, table: SightTable) -> None:
    stops = run_stops(renderer, table, 6, 10)
    errors = np.array([stop.error_m for stop in stops])
    assert np.all(np.abs(errors) <= 0.1)
    assert 3.0 * errors.std(ddof=1) <= 0.033
    assert {stop.direction for stop in stops} == {Direction.DOWN, Direction.UP}
    assert all(stop.out_of_bounds == 0 and stop.sightings > 0 for stop in stops)


def test_the_camera_makes_good_what_the_tag_left_open(renderer: Renderer, table: SightTable) -> None:
    """A place known to 0.5 m at the start (and no better by odometer) ends within the paper's 0.033 m."""
    stops = run_stops(renderer, table, 6, 12, replace(TrackTest(), tag_accuracy_m=0.5))
    assert max(abs(stop.error_m) for stop in stops) <= 0.033
    assert all(stop.out_of_bounds == 0 for stop in stops)


def test_without_a_sign_in_sight_the_odometer_alone_decides(table: SightTable) -> None:
    blind = Renderer(replace(PAPER_CAMERA, noise_grey=120.0), 5)  # nothing to be made out
    stops = run_stops(blind, table, 6, 12, replace(TrackTest(), tag_accuracy_m=0.5))
    assert all(stop.sightings == 0 for stop in stops)
    assert max(abs(stop.error_m) for stop in stops) > 0.1
    assert all(stop.out_of_bounds == 0 for stop in stops)


def test_same_seed_same_stops(renderer: Renderer, table: SightTable) -> None:
    assert run_stops(renderer, table, 8, 2) == run_stops(renderer, table, 8, 4)[:2]
    assert run_stops(renderer, table, 9, 2) != run_stops(renderer, table, 8, 2)


def test_the_car_is_the_papers() -> None:
    row = load_train(shipped_train("oda_scale_car")).row[0]
    assert row["length_m"] == pytest.approx(1.244)  # 3.3.2
    assert row["mass_empty_kg"] == pytest.approx(83.0)
    assert row["wheel_diameter_m"] == pytest.approx(0.102)
    assert row["speed_max_mps"] == pytest.approx(11.0 / 3.6)
