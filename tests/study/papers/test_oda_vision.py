"""`branchline reproduce oda-vision` on its short slice, and that its scenes can fail it."""

from __future__ import annotations

import colorsys

import pytest

from onboard.localisation.vision import PAPER_COLOUR
from radio.chance import generator
from study.papers.oda_vision import (
    OTHER_HUES_DEG,
    TABLE_2_PX,
    TABLE_3_MM,
    random_board,
    random_scene,
    reproduce,
)
from study.papers.reproduction import Options, Reproduction, reproduction


@pytest.fixture(scope="module")
def result() -> Reproduction:
    return reproduce(Options(seed=3, quick=True))


def test_registered() -> None:
    assert reproduction("oda-vision") is reproduce


def test_the_short_slice_passes_and_says_that_it_is_short(result: Reproduction) -> None:
    assert [row.case for row in result.rows if not row.passed] == []
    assert result.remarks[-1].startswith("Quick")


def test_scatter_at_300_to_450_mm(result: Reproduction) -> None:
    rows = [row for row in result.rows if row.case.startswith("distance scatter")]
    assert [row.paper for row in rows] == list(TABLE_3_MM.values())
    assert all(isinstance(row.ours, float) and row.ours <= 3.1 for row in rows)


def test_no_sign_where_there_is_none(result: Reproduction) -> None:
    row = next(row for row in result.rows if "without it" in row.case)
    assert row.ours == 0


def test_every_parameter_has_an_origin(result: Reproduction) -> None:
    assert all(parameter.origin for parameter in result.parameters)


def test_the_papers_tables() -> None:
    """Equation 2 with the paper's own 3 sigma (px) gives its table 3."""
    for distance, scatter_px in ((300, 0.6), (350, 1.5), (400, 0.6), (450, 0.0)):
        fall_px = TABLE_2_PX[distance - 50] - TABLE_2_PX[distance + 50]
        assert scatter_px * 100.0 / fall_px == pytest.approx(TABLE_3_MM[distance], abs=0.2)


def test_clutter_keeps_off_the_signs_hue_and_decoys_do_not() -> None:
    low, high = PAPER_COLOUR.hue_deg
    for index in range(100):
        blue, green, red = random_board(generator(index, "board"), OTHER_HUES_DEG, 0.1).bgr
        assert not low <= 360.0 * colorsys.rgb_to_hsv(red, green, blue)[0] <= high
        blue, green, red = random_scene(generator(index, "scene"), 0.0, decoys=1).boards[-1].bgr
        assert low <= 360.0 * colorsys.rgb_to_hsv(red, green, blue)[0] <= high
