"""The map of curvature: how it is laid along a path, its file, and what is refused."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.graph import next_pieces
from network.model import Direction, Line
from network.path import Path as Way
from network.path import path_of
from network.profile import profile_of
from onboard.localisation.curvature_map import (
    CurvatureMap,
    FirstRunRecord,
    Mounting,
    design_map,
    headings_rad,
    laid_per_m,
    measured_map,
    over_bogies,
    unbent_rad,
)
from onboard.localisation.curvature_map_file import read_map, write_map
from onboard.localisation.spatial_filter import CORNER_M, SETTLES_M, delay_m, sections
from tests.network.sample import curvature_at

MOUNTING = Mounting(3.1, 13.8)
NUMBERS = np.array(sections(CORNER_M))


@pytest.fixture(scope="module")
def line() -> Line:
    return load_line(shipped_line("karasuyama"))


def way(line: Line, direction: Direction) -> Way:
    pieces = ["HSK.MD" if direction is Direction.DOWN else "KRS.1"]
    while following := next_pieces(line, pieces[-1], direction):
        pieces.append(following[0])
    return path_of(line, pieces, direction)


@pytest.mark.parametrize("direction", Direction)
def test_the_design_is_the_heading_of_the_line_either_way(line: Line, direction: Direction) -> None:
    path = way(line, direction)
    heading_rad = profile_of(line, path)["heading_rad"]
    assert headings_rad(design_map(line), path) == pytest.approx(heading_rad, abs=2e-3)
    turns = np.diff(heading_rad)
    alignment = [curvature_at(line, path, i + 0.5) for i in range(turns.size)]
    assert np.corrcoef(turns, alignment)[0, 1] > 0.95  # the rest are legs of points


def test_laid_along_a_path_a_curve_is_as_the_car_and_the_filter_have_it(line: Line) -> None:
    path = way(line, Direction.DOWN)
    laid = laid_per_m(design_map(line), path, MOUNTING, NUMBERS)
    raw = laid_per_m(design_map(line), path, MOUNTING, None)
    assert np.all(np.isnan(laid[: int(SETTLES_M)])) and np.all(np.isfinite(laid[int(SETTLES_M) + 1 :]))
    # the long curve of 430 m before Karasuyama: its entry comes late by the car's middle and the filter
    entry_m = path.to_path_m("OGN-KRS", 16_741.555 + 21.0)
    half = 0.5 / 430.0
    late_m = np.flatnonzero(laid[int(entry_m) - 40 :] > half)[0] - 40
    assert late_m == pytest.approx(3.1 + 6.9 + delay_m(), abs=2.0)
    assert np.nanmax(np.abs(raw)) > np.nanmax(np.abs(laid))


def test_what_the_map_leaves_out_is_no_number(line: Line) -> None:
    path, whole = way(line, Direction.DOWN), design_map(line)
    step = path.step_of("OGN-KRS")
    without = CurvatureMap(whole.line_id, {k: v for k, v in whole.pieces.items() if k != "OGN-KRS"})
    laid = laid_per_m(without, path, MOUNTING, NUMBERS)
    inside = slice(int(step.start_m) + 20, int(step.end_m))  # the car's middle comes later
    assert np.all(np.isnan(laid[inside])) and np.isnan(laid[int(step.end_m) + 20])
    assert np.isfinite(laid[int(step.end_m) + 100])


def test_the_mean_over_the_bogies_can_be_undone() -> None:
    at_m = np.arange(1500.0)
    track_rad = 0.2 * np.sin(at_m / 60.0) + 1e-4 * at_m
    found = unbent_rad(over_bogies(track_rad, MOUNTING), MOUNTING)
    inside = slice(100, -150)
    assert found[inside] == pytest.approx(track_rad[inside], abs=2e-4)


def test_a_first_run_without_errors_makes_the_design_again(line: Line) -> None:
    path, design = way(line, Direction.UP), design_map(line)
    front_m = np.arange(60.0, path.length_m, 1.4)
    heading_rad = np.interp(
        front_m, np.arange(int(np.ceil(path.length_m)) + 1), over_bogies(headings_rad(design, path), MOUNTING)
    )
    counted_m = 7.0 + front_m * 1.004  # worn wheels: places in between are shared out
    anchors = tuple((7.0 + at * 1.004, at) for at in (60.0, 5_000.0, path.length_m - 20.0))
    made = measured_map(FirstRunRecord(counted_m, heading_rad, anchors), path, line, MOUNTING, 0.5, "a test")
    laid, expected = (laid_per_m(of, path, MOUNTING, NUMBERS) for of in (made, design))
    known = np.isfinite(laid) & np.isfinite(expected)
    assert known.mean() > 0.98
    assert float(np.sqrt(np.mean((laid - expected)[known] ** 2))) < 1e-5
    with pytest.raises(ValueError, match="two places"):
        measured_map(FirstRunRecord(counted_m, heading_rad, anchors[:1]), path, line, MOUNTING, 0.5, "")


def test_a_file_gives_the_map_back(line: Line, tmp_path: Path) -> None:
    file = tmp_path / "map.json"
    whole = design_map(line)
    write_map(whole, file)
    again = read_map(file, line)
    assert again.line_id == "karasuyama" and again.made == "design" and again.error_m == 0.0
    assert list(again.pieces) == list(whole.pieces)
    for piece_id, piece in again.pieces.items():
        assert piece.curvature_per_m == pytest.approx(whole.pieces[piece_id].curvature_per_m, abs=1e-9)


Data = dict[str, Any]


def _at(*keys: str | int, value: object) -> Callable[[Data], object]:
    def change(data: Data) -> object:
        inside: Any = data
        for key in keys[:-1]:
            inside = inside[key]
        inside[keys[-1]] = value
        return data

    return change


def _cut(data: Data) -> object:
    del data["pieces"][0]["curvature_per_m"][-5:]
    return data


@pytest.mark.parametrize(
    ("change", "key", "expected"),
    [
        (_at("format", value="a shopping list"), "format", "branchline curvature map"),
        (_at("version", value=2), "version", "1"),
        (_at("line", value="kururi"), "line", "karasuyama"),
        (_at("error_m", value=-1.0), "error_m", "0 to"),
        (_at("pieces", value=[]), "pieces", "at least one"),
        (_at("pieces", 0, "id", value="XXX"), "pieces[0].id", "a piece of karasuyama"),
        (_at("pieces", 0, "from_m", value=1.5), "pieces[0].from_m", "as karasuyama has"),
        (_at("pieces", 1, "to_m", value=9e9), "pieces[1].to_m", "as karasuyama has"),
        (_cut, "pieces[0].curvature_per_m", "samples"),
        (_at("pieces", 0, "curvature_per_m", 3, value=None), "pieces[0].curvature_per_m[3]", "no gaps"),
        (_at("pieces", 0, "curvature_per_m", 3, value="x"), "pieces[0].curvature_per_m[3]", "no gaps"),
        (_at("pieces", 0, "curvature_per_m", 3, value=0.2), "pieces[0].curvature_per_m[3]", "at most 0.1"),
        (lambda data: data | {"pieces": data["pieces"][:1] * 2}, "pieces[1].id", "does not have yet"),
        (_at("pieces", 0, "from_m", value="low"), "pieces[0].from_m", "float"),
        (lambda data: {k: v for k, v in data.items() if k != "version"}, "", "version"),
        (lambda data: [data], "", "other data"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(
    line: Line, tmp_path: Path, change: Callable[[Data], object], key: str, expected: str
) -> None:
    file = tmp_path / "map.json"
    write_map(design_map(line), file)
    file.write_text(json.dumps(change(json.loads(file.read_text("utf-8")))), "utf-8")
    with pytest.raises(InputError) as error:
        read_map(file, line)
    assert error.value.file == str(file) and error.value.key == key
    assert expected in str(error.value) and "\n" not in str(error.value)


def test_half_a_file_is_refused(line: Line, tmp_path: Path) -> None:
    file = tmp_path / "map.json"
    write_map(design_map(line), file)
    file.write_bytes(file.read_bytes()[:5000])
    with pytest.raises(InputError, match="valid JSON"):
        read_map(file, line)
