"""The duty graph: every train drawn, no text over another, none cut off."""

from dataclasses import replace
from itertools import combinations

import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Line
from network.timetable import load_timetable
from study.measures.duties import SetDuty, duties_of
from study.report.duty_graph import draw_duties, duty_rows
from study.report.style import drawing

LONG = "-of-a-number-that-is-as-long-as-may-be-in-a-file"


def day(name: str, line_name: str) -> tuple[Line, tuple[SetDuty, ...]]:
    line = load_line(shipped_line(line_name))
    return line, duties_of(line, load_timetable(shipped_timetable(name), line))


def close(line: Line, duties: tuple[SetDuty, ...]) -> tuple[SetDuty, ...]:
    """The same with trains of five minutes and long numbers, so that nothing has room."""
    return tuple(
        replace(
            duty,
            trains=tuple(replace(t, ends_s=t.begins_s + 300, number=t.number + LONG) for t in duty.trains),
            gaps=tuple(replace(g, before=g.before and g.before + LONG) for g in duty.gaps),
        )
        for duty in duties
    )


def check(figure: Figure, line: Line) -> int:
    figure.draw_without_rendering()
    frame = figure.bbox
    shown = 0
    for axes in figure.axes:
        inside = axes.get_window_extent()
        texts = [(text, text.get_window_extent()) for text in axes.texts]
        shown += len(texts)
        for text, box in texts:
            assert inside.x0 - 1 <= box.x0, text.get_text()
            assert box.x1 <= inside.x1 + 1, text.get_text()
        for (one, a), (other, b) in combinations(texts, 2):
            apart = a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0
            assert apart, (one.get_text(), other.get_text())
        for label in axes.get_yticklabels():
            assert label.get_window_extent().x0 >= frame.x0
    return shown


@pytest.mark.parametrize(
    ("name", "line_name"),
    [
        ("karasuyama_weekday", "karasuyama"),
        pytest.param("busy_line", "busy_line", marks=pytest.mark.nightly),
    ],
)
@pytest.mark.parametrize("narrow", [False, True])
def test_texts_stand_apart(name: str, line_name: str, narrow: bool) -> None:
    line, duties = day(name, line_name)
    with drawing():
        figure = draw_duties(line, close(line, duties) if narrow else duties)
        assert figure is not None
        shown = check(figure, line)
    trains = sum(len(duty.trains) for duty in duties)
    assert shown > (trains // 4 if narrow else trains)


def test_a_bar_for_each_train_and_the_empty_one_white() -> None:
    line, duties = day("karasuyama_weekday", "karasuyama")
    with drawing():
        figure = draw_duties(line, duties)
    assert figure is not None
    bars = [patch for patch in figure.axes[0].patches if isinstance(patch, Rectangle)]
    assert len(bars) == 28
    assert [patch.get_facecolor() for patch in bars].count((1.0, 1.0, 1.0, 1.0)) == 1
    for label, duty in zip(figure.axes[0].get_yticklabels(), duties, strict=True):
        km = sum(train.distance_m for train in duty.trains) / 1000.0
        hours = (duty.trains[-1].ends_s - duty.trains[0].begins_s) / 3600.0
        assert f" trains, {km:.1f} km\n{hours:.1f} h" in label.get_text()
    numbers = {text.get_text() for axes in figure.axes for text in axes.texts}
    assert {train.number for duty in duties for train in duty.trains} <= numbers


def test_nothing_ran_is_no_picture() -> None:
    line = load_line(shipped_line("karasuyama"))
    timetable = load_timetable(shipped_timetable("karasuyama_weekday"), line)
    assert draw_duties(line, duties_of(line, timetable, [])) is None


def test_rows_of_the_table() -> None:
    _, duties = day("karasuyama_weekday", "karasuyama")
    rows = duty_rows(duties)
    assert len(rows) == 28
    row = next(row for row in rows if row["train"] == "E346M")
    of = ("set", "order", "revenue", "before", "before_min")
    assert [row[name] for name in of] == ["V3", 6, False, "turn", 10.0]
    assert (row["departure"], row["arrival"]) == ("22:15:00", "22:48:00")
