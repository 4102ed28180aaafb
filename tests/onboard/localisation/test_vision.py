"""The sign in an image, the table, the station database and the position fix; figures from Oda 2019, chapter 3."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction
from onboard.localisation.vision import (
    PAPER_COLOUR,
    Image,
    SightTable,
    StationSign,
    TargetSighting,
    frame_rate_error_m,
    is_plausible,
    largest_cluster,
    next_target,
    position_fix,
    search_window,
    sight,
    sign_mask,
)

CYAN = (150, 150, 20)  # BGR: hue 180 deg, saturation 87 %, value 59 %
GREY = (120, 120, 120)
AXIS = (480.0, 640.0)
SIZE = (960, 1280)
PIXELS_M = 906.67 * 0.189  # the lens of the paper times the sign's depth below it
BACK_M = 0.244


def plain(rows: int = 120, columns: int = 160, bgr: tuple[int, int, int] = GREY) -> Image:
    return np.full((rows, columns, 3), bgr, dtype=np.uint8)


def pinhole_table(distances_m: list[float] | None = None) -> SightTable:
    """The table a level pinhole would give: every figure in proportion to 1 / depth."""
    distance = np.array(distances_m or [0.2 + 0.1 * k for k in range(32)])
    offset = PIXELS_M / (distance + BACK_M)
    area = np.pi / 4.0 * (906.67 * 0.018 / (distance + BACK_M)) ** 2
    return SightTable(distance, offset, offset * 0.2 / 0.189, area)


def test_the_papers_threshold_in_opencvs_units() -> None:
    lower, upper = PAPER_COLOUR.bounds()
    assert lower.tolist() == [45, 36, 69]  # H 90 deg, S 14 %, V 27 %
    assert upper.tolist() == [112, 255, 201]  # H 224 deg, S 100 %, V 79 %


@pytest.mark.parametrize(("row", "column", "radius"), [(40, 50, 4), (70, 100, 11), (60, 80, 20)])
def test_centroid_of_a_disc(row: int, column: int, radius: int) -> None:
    image = plain()
    cv2.circle(image, (column, row), radius, CYAN, thickness=-1)
    cluster = largest_cluster(image, left_px=300, top_px=500)
    assert cluster is not None
    # a pixel's middle is half past its index
    assert cluster.row_px == pytest.approx(500 + row + 0.5, abs=0.05)
    assert cluster.column_px == pytest.approx(300 + column + 0.5, abs=0.05)
    assert cluster.area_px == pytest.approx(np.pi * radius**2, rel=0.2)


@pytest.mark.parametrize(
    "bgr",
    [
        pytest.param((20, 20, 150), id="red"),
        pytest.param((20, 150, 150), id="yellow"),
        pytest.param((120, 112, 112), id="too pale"),
        pytest.param((50, 50, 10), id="too dark"),
        pytest.param((250, 250, 40), id="too bright"),
    ],
)
def test_other_colours_are_not_the_sign(bgr: tuple[int, int, int]) -> None:
    image = plain()
    cv2.circle(image, (80, 60), 15, bgr, thickness=-1)
    assert largest_cluster(image) is None


def test_an_empty_scene_has_no_sign() -> None:
    assert largest_cluster(plain()) is None


@pytest.mark.parametrize(("side", "survives"), [(1, False), (2, False), (4, False), (5, True)])
def test_two_erosions_need_five_pixels(side: int, survives: bool) -> None:
    image = plain()
    image[50 : 50 + side, 70 : 70 + side] = CYAN
    assert (largest_cluster(image) is not None) is survives


def test_single_pixels_of_the_colour_are_noise() -> None:
    image = plain()
    image[10:110:7, 10:150:7] = CYAN
    assert not sign_mask(image).any()


def test_the_largest_of_several_is_taken() -> None:
    image = plain()
    cv2.circle(image, (30, 30), 6, CYAN, thickness=-1)
    cv2.circle(image, (120, 80), 9, CYAN, thickness=-1)
    cluster = largest_cluster(image)
    assert cluster is not None
    assert cluster.column_px == pytest.approx(120.5, abs=0.1)


def test_a_sign_cut_by_the_edge_is_not_measured() -> None:
    image = plain()
    cv2.circle(image, (2, 60), 9, CYAN, thickness=-1)
    assert largest_cluster(image) is None


@given(st.floats(min_value=0.2, max_value=3.3))
def test_the_table_is_exact_for_a_pinhole_between_its_entries(distance_m: float) -> None:
    found = pinhole_table().distance_at(PIXELS_M / (distance_m + BACK_M))
    assert found is None or found == pytest.approx(distance_m, abs=1e-9)
    assert found is not None or distance_m in (0.2, 3.3)  # rounding at the very ends


def test_outside_the_table_there_is_no_distance() -> None:
    table = pinhole_table()
    assert table.distance_at(PIXELS_M / (0.15 + BACK_M)) is None
    assert table.distance_at(PIXELS_M / (3.4 + BACK_M)) is None
    assert table.distance_at(-5.0) is None


def test_slope_is_equation_2() -> None:
    """Table 2: 100 mm take dy from 315.1 to 266.1 px around 350 mm, and 1.5 px of scatter become 3.1 mm."""
    distance = np.array([0.25, 0.30, 0.40, 0.50])
    offset = np.array([346.9, 315.1, 266.1, 230.0])
    table = SightTable(distance, offset, offset, offset)
    assert 1.5 * table.slope_m_per_px(0.35) * 1000.0 == pytest.approx(3.1, abs=0.05)


@pytest.mark.parametrize(
    ("distance", "offset"),
    [([0.5], [200.0]), ([0.5, 0.4], [200.0, 250.0]), ([0.4, 0.5], [200.0, 250.0]), ([0.4, 0.5], [2.0, -1.0])],
)
def test_a_table_that_cannot_be_inverted_is_refused(distance: list[float], offset: list[float]) -> None:
    columns = np.array(offset)
    with pytest.raises(ValueError, match=r"sight table|must fall"):
        SightTable(np.array(distance), columns, columns, columns)


def test_sighting_of_a_drawn_sign_and_the_check_of_column_and_size() -> None:
    table = pinhole_table()
    offset, column, area = table.expected_at(0.5)
    image = plain(*SIZE)
    centre = (round(AXIS[1] + column - 0.5), round(AXIS[0] + offset - 0.5))
    cv2.circle(image, centre, round((area / np.pi) ** 0.5), CYAN, thickness=-1)
    seen = sight(image, table, AXIS)
    assert seen is not None
    assert seen.distance_m == pytest.approx(0.5, abs=0.004)
    image = plain(*SIZE)
    cv2.circle(image, (centre[0] - 150, centre[1]), 10, CYAN, thickness=-1)
    assert sight(image, table, AXIS) is None
    assert sight(image, table, AXIS, plausible_only=False) is not None
    assert not is_plausible(table, offset, column, 3.0 * area, 0.5)
    assert not is_plausible(table, offset, column, area / 3.0, 0.5)


@given(
    st.floats(min_value=0.25, max_value=3.2),
    st.floats(min_value=-1.0, max_value=1.0),
    st.floats(min_value=0.0, max_value=0.3),
)
def test_the_search_window_holds_the_whole_sign(true_m: float, share: float, bound_m: float) -> None:
    table = pinhole_table()
    window = search_window(table, true_m + share * bound_m, bound_m, AXIS, SIZE)
    assert window is not None
    offset, column, area = table.expected_at(true_m)
    radius = (area / np.pi) ** 0.5
    assert window.top <= max(AXIS[0] + offset - radius, 0)
    assert window.bottom >= min(AXIS[0] + offset + radius, SIZE[0])
    assert window.left <= AXIS[1] + column - radius
    assert window.right >= min(AXIS[1] + column + radius, SIZE[1])


def test_beyond_the_table_nothing_is_searched() -> None:
    assert search_window(pinhole_table(), 5.0, 0.1, AXIS, SIZE) is None
    assert search_window(pinhole_table(), 0.0, 0.1, AXIS, SIZE) is None


def test_equation_1() -> None:
    # 40 km/h at 52 frames a second
    assert frame_rate_error_m(40.0 / 3.6, 52.0) == pytest.approx(0.2137, abs=1e-4)
    assert frame_rate_error_m(0.0, 52.0) == 0.0


SIGNS = (
    StationSign("a", "1", Direction.DOWN, 1005.0, 1000.0),
    StationSign("a", "2", Direction.UP, 985.0, 990.0),
    StationSign("b", "1", Direction.DOWN, 3005.0, 3000.0),
    StationSign("b", "2", Direction.DOWN, 3015.0, 3010.0),
)


@pytest.mark.parametrize(
    ("at_m", "direction", "expected_m"),
    [
        (0.0, Direction.DOWN, 1005.0),
        (1002.0, Direction.DOWN, 1005.0),  # past the mark, the sign still ahead
        (1006.0, Direction.DOWN, 3005.0),
        (2000.0, Direction.UP, 985.0),
        (900.0, Direction.UP, None),
        (4000.0, Direction.DOWN, None),
    ],
)
def test_next_target(at_m: float, direction: Direction, expected_m: float | None) -> None:
    found = next_target(SIGNS, at_m, direction)
    assert (None if found is None else found.position_m) == expected_m


def test_the_route_says_which_track() -> None:
    found = next_target(SIGNS, 2000.0, Direction.DOWN, [("b", "2")])
    assert found is not None
    assert found.track == "2"


@pytest.mark.parametrize("sign", SIGNS[:2])
def test_kilometrage_less_or_plus_the_distance(sign: StationSign) -> None:
    """Oda, 3.1: absolute position of the sign less the distance where kilometrage rises, plus where it falls."""
    fix = position_fix(TargetSighting(0.5, 230.0, 243.0, 400.0), sign, pinhole_table(), 1.0, 52.0)
    assert fix.kilometrage_m == pytest.approx(sign.position_m - sign.direction * 0.5)
    assert fix.bound_behind_m - fix.bound_ahead_m == pytest.approx(1.0 / 52.0)  # the estimate only runs ahead
    assert fix.accuracy_m == fix.bound_behind_m


def test_a_fix_on_a_scale_track_is_in_metres_of_the_line() -> None:
    sighting, table = TargetSighting(0.5, 230.0, 243.0, 400.0), pinhole_table()
    fix = position_fix(sighting, SIGNS[0], table, 1.0, 52.0, metres_per_metre=10.0)
    small = position_fix(sighting, SIGNS[0], table, 1.0, 52.0)
    assert fix.kilometrage_m == pytest.approx(1000.0)
    assert fix.bound_behind_m == pytest.approx(10.0 * small.bound_behind_m)
