"""Pictures that are read by themselves: names over columns, what cannot be run, words in Japanese."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise

import pytest
from matplotlib.patches import Rectangle

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Direction, Line
from network.timetable import load_timetable
from study.measures.duties import duties_of
from study.measures.standard_times import StandardTime
from study.plot.words import plot_word
from study.report.charts import draw_delays
from study.report.data import ReportedRun
from study.report.duty_graph import draw_duties
from study.report.running_times import draw_running_times
from study.report.style import drawing


@pytest.fixture(scope="module")
def line() -> Line:
    return load_line(shipped_line("karasuyama"))


@pytest.mark.parametrize(
    ("name", "level"),
    [("A", True), ("新横浜北西口前", True), ("Shin-Yokohama-Kita Nishiguchi Ekimae Hiroba Kita", False)],
)
def test_names_over_the_columns_of_delays_stand_beside_each_other(
    name: str, level: bool, make_day: Callable[[str, str], ReportedRun]
) -> None:
    """Level where they have room, else turned; the test line has two stations."""
    day = make_day("rtri_test_line", "rtri_crossing")
    stations = {i: replace(one, name=f"{name} {i}") for i, one in day.line.stations.items()}
    few = ReportedRun(replace(day.line, stations=stations), day.timetable, day.tables)
    with drawing():
        figure = draw_delays(few)
        assert figure is not None
        figure.draw_without_rendering()
        for axes in (one for one in figure.axes if one.axison):
            labels = [label for label in axes.get_xticklabels() if label.get_text()]
            boxes = [label.get_window_extent() for label in labels]
            assert level == all(label.get_rotation() == 0.0 for label in labels)
            assert not level or all(a.x1 < b.x0 for a, b in pairwise(boxes))


def test_a_leg_that_cannot_be_run_says_so(line: Line) -> None:
    legs = [
        StandardTime("ev_e301", Direction.DOWN, one, other, 4000.0, time_s, None, None, None)
        for one, other, time_s in (("HSK", "SHN", 300.0), ("SHN", "NIT", math.inf))
    ]
    with drawing():
        figure = draw_running_times(line, legs, ())
        assert figure is not None
        figure.draw_without_rendering()
        texts = [text.get_text() for text in figure.axes[0].texts]
        assert texts == ["300", "cannot be run"]
        assert all(
            math.isfinite(bar.get_bbox().height)
            for bar in figure.axes[0].patches
            if isinstance(bar, Rectangle)
        )


def test_a_single_leg_has_the_key_of_what_passing_trains_need(line: Line) -> None:
    leg = StandardTime("ev_e301", Direction.DOWN, "HSK", "SHN", 4000.0, 300.0, 290.0, 290.0, 280.0)
    with drawing():
        figure = draw_running_times(line, [leg], ())
        assert figure is not None
        assert "needed, passing both" in figure.axes[0].get_legend_handles_labels()[1]


def test_the_key_of_duties_is_in_japanese(line: Line) -> None:
    duties = duties_of(line, load_timetable(shipped_timetable("karasuyama_weekday"), line))
    with drawing():
        figure = draw_duties(line, duties, partial(plot_word, language="ja"))
        assert figure is not None
        words = [
            figure.axes[0].get_title(),
            *(label.get_text() for label in figure.axes[0].get_yticklabels()),
        ]
    assert not [text for text in words if "train" in text or " h" in text or "Duties" in text]
