"""What the picture of occupancy shows stands in it."""

from types import SimpleNamespace
from typing import Any, cast

from study.capacity.headway import HeadwayKind
from study.capacity.line_capacity import Period, Rate
from study.report.capacity import draw_occupation
from study.report.headways import draw_matrix
from study.report.style import drawing


def rate(name: str, share: float) -> Rate:
    row = SimpleNamespace(
        part=SimpleNamespace(kind=SimpleNamespace(value="line"), name=name),
        period=Period("peak", 25_200.0, 28_800.0, peak=True),
        trains=12,
        occupied_share=share,
        limit_share=0.75,
        compressed=SimpleNamespace(section_id="OTK-KNN.E"),
    )
    return cast(Rate, row)


def test_a_panel_fuller_than_those_below_it_is_shown_whole() -> None:
    """A line of 160 % cut as a whole, of 40 % section by section: each bar and its label lie within the picture."""
    with drawing():
        figure = draw_occupation({"line": [rate("A - B", 1.6)], "sections": [rate("A", 0.4), rate("B", 0.3)]})
        assert figure is not None
        figure.canvas.draw()
        for axes in figure.axes:
            texts = [text.get_window_extent() for text in axes.texts]
            shown = axes.get_window_extent()
            assert texts and all(text.x1 < shown.x1 for text in texts)
            assert float(axes.dataLim.x1) < axes.get_xlim()[1]


def test_a_cell_is_as_dark_as_the_longest_headway_in_it() -> None:
    """Two headways of one pair, the longer first; one of another; none of the other two."""
    line: Any = SimpleNamespace(stations={"A": SimpleNamespace(name="Asa")})
    cases: Any = [
        SimpleNamespace(
            station_id="A", first=a, second=b, headway=SimpleNamespace(kind=HeadwayKind.OPEN, least_s=s)
        )
        for a, b, s in (("down", "up", 300.0), ("down", "up", 200.0), ("up", "down", 100.0))
    ]
    with drawing():
        figure = draw_matrix(line, cases)
    assert figure is not None
    shades = figure.axes[0].images[0].get_array()
    assert shades is not None and shades.tolist() == [[None, 300.0], [100.0, None]]
