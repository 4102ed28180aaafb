"""The run curve: no name of a station over another."""

from itertools import combinations
from types import SimpleNamespace
from typing import Any

import pytest
from matplotlib.figure import Figure

from study.report.curve import mark_stations
from study.report.style import WIDTH_IN, drawing, spread

LONG = (
    "Kiryu",
    "Shimo-Shinden",
    "Aioi",
    "Undo-Koen",
    "Omama",
    "Kami-Kambai",
    "L'Abbaye Haute-Côte",
    "O no Kuchi",
)


@pytest.mark.parametrize("apart_m", [300.0, 1300.0, 5000.0])
@pytest.mark.parametrize("turned", [False, True])
def test_names_of_stations_stand_beside_each_other(apart_m: float, turned: bool) -> None:
    run: Any = SimpleNamespace(
        stations=[
            SimpleNamespace(name=name, name_ja="下新田" * (1 + at % 2), position_m=apart_m * at)
            for at, name in enumerate((*LONG, "Mato"))
        ]
    )
    with drawing():
        figure = Figure(figsize=(WIDTH_IN, 5.6), layout="constrained")
        axes = figure.subplots(1, 1)
        low_m, high_m = -0.1 * apart_m, 40_000.0
        axes.set_xlim(*((high_m, low_m) if turned else (low_m, high_m)))
        mark_stations(run, (axes,), low_m, high_m)
        figure.draw_without_rendering()
        boxes = [(text.get_text(), text.get_window_extent()) for text in axes.texts]
    assert len(boxes) == 9
    for (one, a), (other, b) in combinations(boxes, 2):
        assert a.x1 <= b.x0 or b.x1 <= a.x0, (one, other)


def test_each_two_places_have_a_distance_of_their_own() -> None:
    assert spread([0.0, 1.0, 2.0], 1.0) == [0.0, 1.0, 2.0]
    placed = spread([0.0, 0.0, 0.0], [1.0, 3.0])
    assert placed == pytest.approx([-5 / 3, -2 / 3, 7 / 3])  # 0 in the mean
    assert spread([0.0, 0.0, 0.0], [1.0, 3.0], (0.0, 9.0)) == [0.0, 1.0, 4.0]
    assert spread([9.0, 9.0, 9.0], [1.0, 3.0], (0.0, 9.0)) == [5.0, 6.0, 9.0]
    assert spread([], 1.0) == []
