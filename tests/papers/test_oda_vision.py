"""`branchline reproduce oda-vision` on its short slice, and that its scenes can fail it."""

import colorsys
from dataclasses import fields, replace

import numpy as np
import pytest

from onboard.localisation.vision import PAPER_COLOUR, SightTable
from papers import oda_vision
from papers.reproduction import Options, Reproduction
from radio.chance import generator
from simulation.sensors.camera import (
    PAPER_CAMERA,
    PAPER_SIGN,
    PAPER_TABLE_M,
    SIGN_QUARTER,
    CameraModel,
    Renderer,
)
from simulation.sensors.camera_surroundings import Floats
from simulation.sensors.line_sightings import PLACES_M, Sightings
from simulation.sensors.sighting_model import record_table
from simulation.settings import Light
from tests.nightly import others_nightly
from tests.papers.switches import missed


@pytest.fixture(scope="module")
def result() -> Reproduction:
    return oda_vision.reproduce(Options(seed=3, quick=True))


@pytest.mark.nightly
def test_the_short_slice_passes_and_says_that_it_is_short(result: Reproduction) -> None:
    assert [row.case for row in result.rows if not row.passed] == []
    assert result.remarks[-1].startswith("Quick")
    assert next(row for row in result.rows if "without it" in row.case).ours == 0
    assert all(parameter.origin for parameter in result.parameters)


@pytest.fixture(scope="module")
def table() -> SightTable:
    """What the paper's own camera sees."""
    return record_table(Renderer(PAPER_CAMERA, 3), PAPER_SIGN, PAPER_TABLE_M, 3, window=SIGN_QUARTER)


IMAGES = 80  # for each figure, which are enough to tell ten times more or less from the paper's


def scatter_of(camera: CameraModel, table: SightTable, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Which rows of scatter such a camera fails."""
    monkeypatch.setattr(oda_vision, "PAPER_CAMERA", camera)
    monkeypatch.setattr(oda_vision, "IMAGES", IMAGES)
    renderer = Renderer(camera, 3)
    rows = [*oda_vision.table_2_rows(renderer, 3), *oda_vision.scatter_rows(renderer, table, 3)]
    return [case for case in missed(rows) if "scatter" in case]


def times(share: float) -> CameraModel:
    """The paper's camera with everything that scatters times this."""
    camera = PAPER_CAMERA
    return replace(
        camera,
        noise_grey=share * camera.noise_grey,
        vibration_rad=share * camera.vibration_rad,
        trial_rad=share * camera.trial_rad,
    )


SWITCHES = {
    "ten_times_too_clean": times(0.1),
    "ten_times_too_noisy": times(10.0),
    "stands_as_on_a_rock": replace(PAPER_CAMERA, trial_rad=0.0),
}


def test_the_scatter_is_the_papers(table: SightTable, monkeypatch: pytest.MonkeyPatch) -> None:
    assert scatter_of(PAPER_CAMERA, table, monkeypatch) == []


@pytest.mark.parametrize("name", others_nightly(SWITCHES, ["ten_times_too_clean"]))
def test_another_scatter_is_not_the_papers(
    name: str, table: SightTable, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two-sided: in the rows as the paper writes them, and in every distance through the table."""
    assert len(scatter_of(SWITCHES[name], table, monkeypatch)) == 1 + len(oda_vision.TABLE_3_MM)


def test_a_light_in_which_nothing_is_seen_is_met_by_rain_at_dusk_alone() -> None:
    nothing = Sightings(*(np.zeros(len(PLACES_M)) for _ in fields(Sightings)))
    days = [oda_vision.CameraDay("blind", light, nothing, np.full(100, 3.0), ()) for light in Light]
    assert [day.light for day, row in zip(days, oda_vision.light_rows(days), strict=True) if row.passed] == [
        Light.RAIN_AT_DUSK
    ]


def test_a_sign_that_is_not_found_in_every_trial_has_no_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the pictures at a place show it, at the paper's own row: the paper found it in all of its trials."""
    place = min(oda_vision.TABLE_2_PX)

    def rows_seen(_renderer: Renderer, distance_mm: int, _seed: int) -> Floats:
        count = oda_vision.IMAGES // (8 if distance_mm == place else 4)
        return np.resize(np.array(oda_vision.TRIALS_PX[distance_mm]), count)

    monkeypatch.setattr(oda_vision, "rows_seen", rows_seen)
    cases = missed(oda_vision.table_2_rows(Renderer(PAPER_CAMERA, 3), 3))
    assert cases == [f"table 2: dy at {place} mm, px"]


def test_what_24_trials_say_of_the_scatter() -> None:
    """From the rows that table 2 prints: its own means and (population) 3 sigma follow from them."""
    printed_px = {250: 2.0, 300: 0.6, 350: 1.5, 400: 0.6, 450: 0.0, 500: 0.0}
    for distance, trials in oda_vision.TRIALS_PX.items():
        assert np.mean(trials) == pytest.approx(oda_vision.TABLE_2_PX[distance], abs=0.051)
        assert 3.0 * np.std(trials) == pytest.approx(printed_px[distance], abs=0.06)
    low_px, high_px = oda_vision.sigma_range_px()
    assert low_px < oda_vision.pooled_sigma(oda_vision.TRIALS_PX.values()) < high_px
    assert high_px < 3.0 * low_px  # so neither ten times more nor ten times less can be within


def test_the_papers_tables() -> None:
    """Equation 2 with the paper's own 3 sigma (px) gives its table 3."""
    for distance, scatter_px in ((300, 0.6), (350, 1.5), (400, 0.6), (450, 0.0)):
        fall_px = oda_vision.TABLE_2_PX[distance - 50] - oda_vision.TABLE_2_PX[distance + 50]
        assert scatter_px * 100.0 / fall_px == pytest.approx(oda_vision.TABLE_3_MM[distance], abs=0.2)


def test_clutter_keeps_off_the_signs_hue_and_decoys_do_not() -> None:
    low, high = PAPER_COLOUR.hue_deg
    for index in range(100):
        blue, green, red = oda_vision.random_board(
            generator(index, "board"), oda_vision.OTHER_HUES_DEG, 0.1
        ).bgr
        assert not low <= 360.0 * colorsys.rgb_to_hsv(red, green, blue)[0] <= high
        blue, green, red = oda_vision.random_scene(generator(index, "scene"), 0.0, decoys=1).boards[-1].bgr
        assert low <= 360.0 * colorsys.rgb_to_hsv(red, green, blue)[0] <= high
