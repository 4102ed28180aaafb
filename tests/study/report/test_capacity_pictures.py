"""What the picture of occupancy shows stands in it."""

from types import SimpleNamespace
from typing import cast

from study.capacity.line_capacity import Period, Rate
from study.report.capacity import draw_occupation
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
