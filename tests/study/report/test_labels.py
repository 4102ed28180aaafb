"""Labels of the report's figures do not collide, on a quiet line and with 96 trains: by matplotlib's own extents."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Direction
from study.measures.summary import summarise
from study.report import graph, labels, style
from study.report.charts import draw_delays, draw_energy, draw_stop_errors
from study.report.curve import draw_run_curve, mark_stations
from study.report.data import ReportedRun
from study.report.graph import draw_train_graph, station_label
from study.report.labels import Box, dense
from study.report.occupancy import draw_occupancy
from study.report.style import drawing
from tests.nightly import others_nightly

DAYS = (("karasuyama", "karasuyama_weekday"), ("busy_line", "busy_line"), ("rtri_test_line", "rtri_crossing"))


def one_each_way(run: ReportedRun) -> list[tuple[str, str]]:
    """(unit, train) of the longest course down, and up."""
    ways = ([key for key in run.courses if run.directions[key[1]] is way] for way in Direction)
    return [max(own, key=lambda key: len(run.courses[key])) for own in ways if own]


def figures(run: ReportedRun) -> dict[str, Figure]:
    drawn = {
        "graph": draw_train_graph(run)[0],
        "occupancy": draw_occupancy(run),
        "energy": draw_energy(run),
        "errors": draw_stop_errors(run, summarise(run.tables, run.timetable)),
        "delays": draw_delays(run),
        **{f"curve of {train}": draw_run_curve(run, unit, train) for unit, train in one_each_way(run)},
    }
    return {name: figure for name, figure in drawn.items() if figure is not None}


def outline(text: Text) -> Box:
    """A text as it lies on the screen: matplotlib's extent of it when level, turned about its anchor."""
    angle = text.get_rotation()
    text.set_rotation(0.0)
    level = text.get_window_extent()
    text.set_rotation(angle)
    anchor = text.get_transform().transform(text.get_unitless_position())
    middle = np.array([(level.x0 + level.x1) / 2, (level.y0 + level.y1) / 2]) - anchor
    turn = np.radians(angle)
    x, y = anchor + np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ middle
    return Box(float(x), float(y), level.width / 2 - 0.5, level.height / 2 - 0.5, float(turn))


def anchored(text: Text) -> bool:
    """Whether a turned text turns about its anchor; one that stands upright on an axis lies in its own extent."""
    return text.get_rotation() % 90.0 != 0.0


def seen(figure: Figure) -> list[tuple[str, Box]]:
    """Every text that can be read, with where it lies; those of ticks outside their axis are never drawn."""
    figure.draw_without_rendering()
    hidden: set[int] = set()
    for axes in figure.axes:
        for axis, ends in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            low, high = min(ends), max(ends)
            for tick in axis.get_major_ticks():
                if not low - 1e-9 <= tick.get_loc() <= high + 1e-9:
                    hidden |= {id(tick.label1), id(tick.label2)}
    found: list[tuple[str, Box]] = []
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if not text.get_visible() or not text.get_text().strip() or id(text) in hidden:
            continue
        extent = text.get_window_extent()
        if extent.width <= 0.0:
            continue
        x, y = (extent.x0 + extent.x1) / 2, (extent.y0 + extent.y1) / 2
        box = Box(x, y, extent.width / 2 - 0.5, extent.height / 2 - 0.5, 0.0)
        found.append((text.get_text(), outline(text) if anchored(text) else box))
    return found


def collisions(figure: Figure) -> list[tuple[str, str]]:
    return [(a, b) for (a, here), (b, there) in combinations(seen(figure), 2) if here.overlaps(there)]


def numbers_of(axes: Axes, run: ReportedRun) -> list[Text]:
    return [text for text in axes.texts if text.get_text() in run.timetable.trains]


def numbers_on_lines(figure: Figure, run: ReportedRun) -> list[str]:
    """Numbers of trains that lie on a plan or a run, of whichever train."""
    figure.draw_without_rendering()
    found: list[str] = []
    for axes in figure.axes:
        lines = [np.asarray(line.get_xydata()) for line in axes.lines if len(line.get_xydata()) > 2]
        cloud = np.concatenate([dense(axes.transData.transform(line)) for line in lines])
        found += [text.get_text() for text in numbers_of(axes, run) if outline(text).covers(cloud)]
    return found


@pytest.mark.parametrize("day", others_nightly(DAYS, DAYS[2:]), ids=lambda day: day[1])
def test_no_label_lies_on_another(make_day: Callable[[str, str], ReportedRun], day: tuple[str, str]) -> None:
    run = make_day(*day)
    with drawing():
        for name, figure in figures(run).items():
            assert collisions(figure) == [], name


@pytest.mark.parametrize("day", others_nightly(DAYS[:2], DAYS[:1]), ids=lambda day: day[1])
def test_every_train_has_its_number_beside_its_line(
    make_day: Callable[[str, str], ReportedRun], day: tuple[str, str]
) -> None:
    run = make_day(*day)
    with drawing():
        figure, _ = draw_train_graph(run)
        written = {text.get_text() for axes in figure.axes for text in numbers_of(axes, run)}
        assert written == set(run.timetable.trains)
        assert numbers_on_lines(figure, run) == []


@pytest.mark.parametrize("rule", others_nightly(["overlaps", "covers"], ["overlaps"]))
def test_a_graph_whose_numbers_are_put_anywhere_is_found_out(
    make_day: Callable[[str, str], ReportedRun], monkeypatch: pytest.MonkeyPatch, rule: str
) -> None:
    """Without one of the two rules of `place_numbers`, on a graph too small for its trains, the check above fails."""
    run = make_day("busy_line", "busy_line")
    monkeypatch.setattr(graph, "_PANEL_IN", 1.2)
    nothing = {"overlaps": lambda *_: False, "covers": lambda *_: 0}[rule]
    with monkeypatch.context() as careless, drawing():
        careless.setattr(labels.Box, rule, nothing)
        figure, _ = draw_train_graph(run)
    with drawing():
        bad = collisions(figure) if rule == "overlaps" else numbers_on_lines(figure, run)
    assert bad


boxes = st.builds(
    Box, st.floats(-50, 50), st.floats(-50, 50), st.floats(1, 30), st.floats(1, 30), st.floats(-np.pi, np.pi)
)


@given(a=boxes, b=boxes)
def test_boxes_that_share_a_point_overlap(a: Box, b: Box) -> None:
    grid = np.linspace(-1.0, 1.0, 41)
    along = np.array([np.cos(a.angle), np.sin(a.angle)])
    up = np.array([-along[1], along[0]])
    inside = np.array([a.x, a.y]) + np.array(
        [along * a.half_width * s + up * a.half_height * t for s in grid for t in grid]
    )
    if b.covers(inside):
        assert a.overlaps(b)
    assert a.overlaps(b) == b.overlaps(a)


def test_boxes_apart_do_not_overlap() -> None:
    turned = Box(0.0, 0.0, 10.0, 1.0, np.pi / 4)
    assert not turned.overlaps(Box(6.0, -6.0, 3.0, 3.0, 0.0))  # its level extent would
    assert turned.overlaps(Box(6.0, 6.0, 3.0, 3.0, 0.0))
    assert turned.covers(np.array([[5.0, 5.0], [5.0, -5.0]])) == 1


def test_a_name_in_one_script_stands_once() -> None:
    station = load_line(shipped_line("karasuyama")).stations["OGN"]
    assert station_label(replace(station, name=station.name_ja)) == station.name_ja
    assert station_label(station).startswith(station.name)


@pytest.mark.parametrize(("apart_m", "turned"), [(300.0, False), (1300.0, True), (5000.0, False)])
def test_names_of_stations_of_a_run_curve_stand_beside_each_other(apart_m: float, turned: bool) -> None:
    names = (
        "Kiryu",
        "Shimo-Shinden",
        "Aioi",
        "Undo-Koen",
        "Omama",
        "L'Abbaye Haute-Côte",
        "O no Kuchi",
        "Mato",
    )
    places = [(name, "下新田" * (1 + at % 2), apart_m * at) for at, name in enumerate(names)]
    stations = [SimpleNamespace(name=name, name_ja=ja, position_m=at_m) for name, ja, at_m in places]
    with style.drawing():
        figure = Figure(figsize=(style.WIDTH_IN, 5.6), layout="constrained")
        axes = figure.subplots(1, 1)
        axes.set_xlim(*((40_000.0, -100.0) if turned else (-100.0, 40_000.0)))
        mark_stations(cast(ReportedRun, SimpleNamespace(stations=stations)), (axes,), -100.0, 40_000.0)
        figure.draw_without_rendering()
        boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == len(names)
    assert all(a.x1 <= b.x0 or b.x1 <= a.x0 for a, b in combinations(boxes, 2))
    assert style.spread([0.0, 0.0, 0.0], [1.0, 3.0]) == pytest.approx(
        [-5 / 3, -2 / 3, 7 / 3]
    )  # 0 in the mean
