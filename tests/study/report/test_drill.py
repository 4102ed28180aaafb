"""A drill in the report: numbered marks on the graph that stay apart, rows under it, verdicts in words."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from study.record.marks import DrillShown, Mark, MarkKind, MarkPlace
from study.report.data import ReportedRun
from study.report.drill import PLACE, draw_strip, falls_in_panel, mark_graph, shortened_name
from study.report.graph import draw_train_graph
from study.report.report import write_report
from study.report.style import TimeBand, drawing, time_grid
from tests.study.report.page import payload_of, table_in

BAND = TimeBand(36_000.0, 43_200.0)
LONG = "the manager grants nothing at all to anybody while it does not know who holds what"


def marks(count: int = 4) -> tuple[Mark, ...]:
    faults = [
        Mark(MarkKind.FAULT, i, f"cut K{i} <-> *", 37_000.0 + i, 38_000.0, happened="10:33")
        for i in range(1, count + 1)
    ]
    return (
        *faults,
        Mark(MarkKind.ACT, 1, "staff: repair_points P7 normal", 37_500.0, 37_500.0),
        Mark(MarkKind.EXPECTATION, 1, "it arrives", 37_000.0, 39_000.0, 38_500.0, True, "at 10:41:40.0"),
        Mark(MarkKind.EXPECTATION, 2, LONG, 37_000.0, 40_000.0, 37_700.0, False, "happened at 10:28:20.0"),
    )


def shown_texts(figure: Figure) -> list[Text]:
    return [text for text in figure.findobj(Text) if isinstance(text, Text) and text.get_text()]


def test_numbers_of_faults_that_begin_together_do_not_cover_each_other() -> None:
    with drawing():
        figure = Figure(figsize=(13.0, 3.7))
        axes = figure.subplots()
        axes.set_xlim(BAND.from_s, BAND.to_s)
        mark_graph(axes, marks(8), BAND)
        figure.canvas.draw()
        boxes = sorted((t.get_window_extent() for t in axes.texts), key=lambda box: box.x0)
    assert [t.get_text() for t in axes.texts] == [*(f"F{i}" for i in range(1, 9)), "A1"]
    assert all(left.x1 <= right.x0 for left, right in pairwise(boxes))


def test_a_faults_place_is_drawn_with_its_time_and_told_in_the_legend(weekday: ReportedRun) -> None:
    unit, train = next(iter(weekday.courses))
    begins_s = float(weekday.courses[unit, train]["t_s"][0])
    fault, *_ = marks(1)
    there = replace(fault, from_s=begins_s, to_s=begins_s + 600.0)
    for where, sign in (
        (MarkPlace(((1000.0, 2500.0),)), "its stretch of the line"),
        (MarkPlace((), (unit,)), "the train that has it"),
    ):
        with drawing():
            figure, _ = draw_train_graph(weekday, (replace(there, where=where),))
        drawn = [artist for artist in figure.findobj() if artist.get_gid() == PLACE]
        assert drawn
        if where.stretches_m:
            box = drawn[0]
            assert isinstance(box, Rectangle)
            assert (box.get_x(), box.get_y(), box.get_width(), box.get_height()) == (
                begins_s,
                1000.0,
                600.0,
                1500.0,
            )
        texts = {text.get_text() for text in shown_texts(figure)}
        assert {"while a fault lasts (F)", sign} <= texts
    with drawing():
        figure, _ = draw_train_graph(weekday, (there,))
    assert not [artist for artist in figure.findobj() if artist.get_gid() == PLACE]


def test_each_mark_has_its_row_and_what_was_not_met_stands_out() -> None:
    with drawing():
        figure = Figure(figsize=(13.0, 1.0))
        axes = figure.subplots()
        draw_strip(axes, marks(1), BAND, time_grid(BAND.to_s - BAND.from_s))
        labels = axes.get_yticklabels()
    assert [label.get_text().split()[0] for label in labels] == ["F1", "A1", "E1", "E2"]
    assert labels[3].get_color() != labels[2].get_color()
    assert labels[3].get_text().endswith("…")
    assert {line.get_marker() for line in axes.lines} >= {"D", "o", "X"}


def test_a_mark_shows_only_where_any_of_it_falls() -> None:
    (fault, act, *_) = marks(1)
    assert falls_in_panel(fault, BAND) and falls_in_panel(act, BAND)
    later = TimeBand(BAND.to_s, BAND.to_s + 3600.0)
    assert not falls_in_panel(fault, later) and not falls_in_panel(act, later)


def test_a_text_is_cut_only_if_it_must_be() -> None:
    assert shortened_name("it arrives") == "it arrives"
    assert LONG.startswith(shortened_name(LONG)[:-1]) and len(shortened_name(LONG)) < len(LONG)


@pytest.mark.nightly
def test_the_graph_has_a_strip_in_the_panels_that_the_marks_meet(weekday: ReportedRun) -> None:
    with drawing():
        plain, _ = draw_train_graph(weekday)
        figure, _ = draw_train_graph(weekday, marks())
    assert len(figure.axes) == len(plain.axes) + 1
    assert "F1  cut K1 <-> *" in {text.get_text() for text in shown_texts(figure)}


def test_the_page_says_whether_the_drill_was_passed_and_what_was_not_met(
    weekday: ReportedRun, tmp_path: Path
) -> None:
    drill = DrillShown(False, marks(1), "Latest 90 s after plan.")
    facts = {"broken_expectations": drill.unmet()}
    page = write_report(
        tmp_path, weekday.line, weekday.timetable, weekday.tables, facts, None, drill
    ).read_text("utf-8")
    assert "NOT passed: 1 of 2 expectations not met" in page
    assert f"Expected: {LONG}: happened at 10:28:20.0" in page
    assert "cut K1 <-> *" not in page  # packed, where no text is markup
    payload = payload_of(page)
    assert [mark["label"] for mark in payload["marks"]] == ["F1", "A1", "E1", "E2"]
    items, judged = table_in(payload, "drill_items"), table_in(payload, "expectations")
    assert items["what"][0] == ["cut K1 <-> *", "cut K1 <-> *"]
    assert judged["verdict"] == [["met", "成立"], ["NOT MET", "不成立"]]
    assert [t["notes"] for t in payload["tables"] if t["id"] == "expectations"] == [
        [["Latest 90 s after plan."] * 2]
    ]
