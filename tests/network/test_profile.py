import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from network.files.line_file import parse_line
from network.model import Direction, Line
from network.path import Path, path_of
from network.profile import PROFILE, Profiles, heights_of, profile_of
from tests.network.sample import LINE, changed, curvature_at, gradient_permille_at

DOWN = [
    "P",
    "A.11.stem",
    "A.11.normal",
    "A.1",
    "A.12.normal",
    "A.12.stem",
    "A-B",
    "B.11.stem",
    "B.11.normal",
    "B.1",
]
DOWN_PATH = path_of(LINE, DOWN, Direction.DOWN)
UP_PATH = path_of(LINE, DOWN[::-1], Direction.UP)
LOOP = [name.replace("normal", "reverse").replace("A.1", "A.2", name == "A.1") for name in DOWN]
LOOP_PATH = path_of(LINE, [*LOOP[:-1], "B.2"], Direction.DOWN)


def test_shape_and_dtype() -> None:
    rows = profile_of(LINE, DOWN_PATH)
    assert rows.dtype == PROFILE
    assert rows.shape == (3201,)
    assert rows.flags.c_contiguous


def test_elevation_follows_the_gradients() -> None:
    rows = profile_of(LINE, DOWN_PATH)["elevation_m"]
    assert rows[[0, 500, 1000, 1500, 3200]] == pytest.approx([100.0, 100.0, 105.0, 110.0, 101.5])
    back = profile_of(LINE, UP_PATH)["elevation_m"]
    assert back == pytest.approx(rows[::-1])


def test_heights_of_the_pieces_are_those_of_the_path_over_them() -> None:
    rows = profile_of(LINE, DOWN_PATH)["elevation_m"]
    heights = heights_of(LINE)
    for step in DOWN_PATH.steps:
        for along_m, height_m in heights[step.piece_id]:
            assert height_m == pytest.approx(
                np.interp(step.start_m + along_m, np.arange(rows.size), rows), abs=0.02
            )
    assert len(heights["A-B"]) > 2  # its gradient changes on the way


def test_turn_of_a_curve_is_plateau_and_half_of_each_transition() -> None:
    """Clothoid: a transition of length t turns by t / (2 R), the 300 m between by 300 / R."""
    turn = profile_of(LINE, DOWN_PATH)["turn_rad"]
    assert turn[600] == 0.0
    assert turn[650] == pytest.approx(50 / (2 * 300))
    assert turn[625] == pytest.approx(25**2 / (2 * 50 * 300))
    assert turn[1000] == pytest.approx(350 / 300)
    assert turn[2299] - turn[2000] == pytest.approx(299 / 250)
    assert turn[3200] == pytest.approx(350 / 300 + 300 / 250)
    assert profile_of(LINE, UP_PATH)["turn_rad"] == pytest.approx(turn[-1] - turn[::-1])


def test_mean_curvature_under_a_train_in_the_plateau() -> None:
    turn = profile_of(LINE, DOWN_PATH)["turn_rad"]
    assert (turn[800] - turn[760]) / 40 == pytest.approx(1 / 300)


def test_limits_by_direction() -> None:
    down, up = profile_of(LINE, DOWN_PATH)["limit_mps"], profile_of(LINE, UP_PATH)["limit_mps"]
    assert down[[500, 600, 800, 1000, 1100, 2100]] == pytest.approx([25, 17.5, 17.5, 17.5, 25, 15])
    assert up[3200 - 2100] == pytest.approx(25)
    assert up[3200 - 800] == pytest.approx(17.5)


def test_limits_hold_for_every_row_they_touch() -> None:
    """2.0 to 2.3005 km: a lookup by floor, nearest or ceiling anywhere inside finds the limit."""
    limit = profile_of(LINE, DOWN_PATH)["limit_mps"]
    for path_m in (2000.0, 2000.4, 2299.7, 2300.2, 2300.5):
        for row in (math.floor(path_m), round(path_m), math.ceil(path_m)):
            assert limit[row] == pytest.approx(15)
    assert limit[1998] == limit[2303] == pytest.approx(25)


def test_diverging_limit_over_reverse_leg_and_stem() -> None:
    limit = profile_of(LINE, LOOP_PATH)["limit_mps"]
    assert limit[[100, 105, 130, 160]] == pytest.approx([10] * 4)
    assert limit[[90, 170, 350, 430]] == pytest.approx([25] * 4)
    assert limit[[360, 419]] == pytest.approx([10] * 2)
    assert limit[[3000, 3060]] == pytest.approx([10] * 2)
    assert profile_of(LINE, DOWN_PATH)["limit_mps"][100:160] == pytest.approx(25)


def test_a_length_that_is_no_whole_number_ends_at_the_end() -> None:
    line = parse_line(
        changed("to_km = 0.1\n", "to_km = 0.1004\n").replace("from_km = 0.1\n", "from_km = 0.1004\n"), "f"
    )
    path = path_of(line, ["P"], Direction.DOWN)
    rows = profile_of(line, path)
    assert rows.shape == (102,)
    assert rows["elevation_m"][-1] == pytest.approx(100.0)


def test_gradient_and_curvature_change_sign_with_direction() -> None:
    assert gradient_permille_at(LINE, DOWN_PATH, 1000.0) == 10.0
    assert gradient_permille_at(LINE, UP_PATH, 2200.0) == -10.0
    assert gradient_permille_at(LINE, DOWN_PATH, 3200.0) == -5.0
    assert curvature_at(LINE, DOWN_PATH, 800.0) == pytest.approx(1 / 300)
    assert curvature_at(LINE, DOWN_PATH, 625.0) == pytest.approx(0.5 / 300)
    assert curvature_at(LINE, UP_PATH, 3200 - 2100.0) == pytest.approx(1 / 250)
    assert curvature_at(LINE, DOWN_PATH, 100.0) == 0.0


def line_with(permilles: list[int], radius_m: float, transition_m: float) -> Line:
    """The sample with other hills and another first curve."""
    head, rest = changed(
        "= 300.0, transition_m = 50.0", f"= {radius_m}, transition_m = {transition_m}"
    ).split("gradients = [", 1)
    step_km = 3.2 / len(permilles)
    ends_km = [round(i * step_km, 4) for i in range(len(permilles))] + [3.2]
    table = ", ".join(
        f"{{ from_km = {a}, to_km = {b}, permille = {p} }}"
        for a, b, p in zip(ends_km, ends_km[1:], permilles, strict=False)
    )
    return parse_line(f"{head}gradients = [{table}]\n{rest.split(']', 1)[1]}", "f")


@given(
    st.lists(st.integers(-35, 35), min_size=1, max_size=6),
    st.sampled_from([-1.0, 1.0]),
    st.floats(100.0, 2000.0),
    st.floats(0.0, 200.0),
    st.sampled_from(list(Direction)),
)
def test_profile_properties(
    permilles: list[int], sign: float, radius_m: float, transition_m: float, direction: Direction
) -> None:
    line = line_with(permilles, sign * radius_m, transition_m)
    path: Path = path_of(line, DOWN if direction is Direction.DOWN else DOWN[::-1], direction)
    rows = profile_of(line, path)
    assert np.all(np.diff(rows["turn_rad"]) >= 0.0)
    assert rows["turn_rad"][-1] == pytest.approx((400 - transition_m) / radius_m + 300 / 250)
    assert np.all(rows["limit_mps"] > 0.0)
    assert np.all(rows["limit_mps"] <= line.max_speed_mps)
    slopes = np.diff(rows["elevation_m"]) * 1000.0
    known = {permille * direction for permille in permilles}
    assert slopes.min() >= min(known) - 1e-6
    assert slopes.max() <= max(known) + 1e-6
    for path_m in (100, 1234, 2500):
        if gradient_permille_at(line, path, path_m) == gradient_permille_at(line, path, path_m + 1):
            assert slopes[path_m] == pytest.approx(gradient_permille_at(line, path, path_m), abs=1e-6)


def test_a_profile_is_computed_once_for_a_line_and_a_path(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Path] = []

    def computed(line: Line, path: Path) -> NDArray[np.void]:
        asked.append(path)
        return profile_of(line, path)

    profiles = Profiles(computed)
    first = profiles.of_path(LINE, DOWN_PATH)
    first["limit_mps"] = 0.0  # the caller's own
    again = profiles.of_path(LINE, path_of(LINE, DOWN, Direction.DOWN))
    assert np.array_equal(again, profile_of(LINE, DOWN_PATH))
    assert asked == [DOWN_PATH]
    slower = parse_line(changed("max_speed_kmh = ", "max_speed_kmh = 1#", 1), "sample.toml")
    assert profiles.of_path(slower, DOWN_PATH)["limit_mps"].max() < again["limit_mps"].max()
    assert len(asked) == 2  # another line, the same path
    monkeypatch.setattr("network.profile.ROWS_KEPT", again.size)
    profiles.of_path(LINE, UP_PATH)
    profiles.of_path(LINE, DOWN_PATH)
    assert asked[2:] == [UP_PATH, DOWN_PATH]  # no more rows are kept than that
