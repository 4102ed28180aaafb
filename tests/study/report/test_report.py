"""The report: one file that opens offline, shows every train and station, and has room for small and empty runs."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib as mpl
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from network.model import Direction
from study.measures.summary import summarise
from study.record.energy import PARTS
from study.record.figure import schema_of
from study.record.parts import Fact
from study.record.tables import ROWS, RunTables, make_table
from study.report.charts import CallLateness, draw_delays
from study.report.curve import draw_run_curve
from study.report.data import ReportedRun, section_name, sections_in_order
from study.report.facts import headline, parts_fact
from study.report.graph import draw_train_graph
from study.report.hop import DrivenHopShown
from study.report.occupancy import draw_occupancy
from study.report.papers import CHANGES_SHOWN, EVENTS_SHOWN_MAX, REFUSED_AGAIN_S, _changes, _events
from study.report.report import BYTES_AIMED, write_report
from study.report.style import BAND_S_MAX, clock, drawing, spread, svg_of, time_bands, time_grid
from study.wording.phrase import Phrase
from tests.study.crossed_day import with_crossing
from tests.study.report.page import Page, payload_of, table_in, with_table

FACTS: dict[str, Any] = {
    "scenario": "plain-weekday",
    "day": "weekday",
    "seed": 7,
    "digest": "0a1b2c3d",
    "parties": ["block-manager", "OGN-W"],
}


@pytest.fixture(scope="module")
def page(weekday: ReportedRun, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = write_report(
        tmp_path_factory.mktemp("run"), weekday.line, weekday.timetable, weekday.tables, FACTS
    )
    assert path.name == "report.html"
    assert path.stat().st_size <= BYTES_AIMED
    assert [p.name for p in path.parent.iterdir()] == ["report.html"]
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def parsed(page: str) -> Page:
    parser = Page()
    parser.feed(page)
    return parser


def test_page_is_self_contained(page: str, parsed: Page) -> None:
    assert not parsed.open
    assert not re.search(r"https?:", page)
    assert "@import" not in page
    assert not re.search(r"<(link|img|iframe|object|embed|base)\b", page)
    assert not re.search(r"<script[^>]*\bsrc", page)
    assert not re.search(r"\bfetch\(|XMLHttpRequest|WebSocket|sendBeacon|EventSource", page)
    assert set(parsed.fetched) | set(parsed.references) <= {f"#{name}" for name in parsed.ids}
    assert len(parsed.ids) == len(set(parsed.ids))


def test_page_names_every_train_and_station(page: str, weekday: ReportedRun) -> None:
    payload = payload_of(page)
    assert {train["number"] for train in payload["trains"]} == set(weekday.timetable.trains)
    names = {(s["id"], s["name"], s["ja"]) for s in payload["line"]["stations"]}
    assert names == {(s.id, s.name, s.name_ja) for s in weekday.line.stations.values()}
    text = page[page.index("<body>") : page.index("<main")]
    assert weekday.line.name in text
    assert weekday.line.name_ja in text
    assert not re.search(r"\b(NaN|nan|inf|None|undefined)\b", text)


def test_without_javascript_the_page_says_so_and_has_its_figures(page: str) -> None:
    (said,) = re.findall(r"<noscript>(.*?)</noscript>", page, re.DOTALL)
    assert "drawn by JavaScript, which is switched off" in said
    assert page.count("switched off") == 1
    at = [page.index(text) for text in ("drawn by JavaScript", "<dt>Trains arrived</dt>", 'id="papers"')]
    assert at == sorted(at)


def test_every_word_of_the_payload_is_in_both_languages(page: str) -> None:
    payload = payload_of(page)
    for table in [*payload["tables"], *payload["columns"].values()]:
        assert len(table["title"]) == 2 and all(table["title"])
        for column in table["columns"]:
            assert len(column["heading"]) == 2 and all(column["heading"]), column["label"]
            assert column["kind"] != "word" or set(column.get("values", ())) <= set(payload["words"])


def test_headline_gives_the_run_and_its_figures(page: str, weekday: ReportedRun) -> None:
    revenue = sum(train.revenue for train in weekday.timetable.trains.values())
    assert f"{revenue} of {revenue} planned" in page
    assert "plain-weekday" in page
    assert "0a1b2c3d" in page
    assert "<dt>Seed</dt><dd>7</dd>" in page
    assert "<dt>Invariants broken</dt><dd>none</dd>" in page
    assert 'class="broken"' not in page


def test_events_are_all_there_by_time(page: str, weekday: ReportedRun) -> None:
    told = table_in(payload_of(page), "events")
    assert len(told["t_s"]) == len(weekday.tables.events)
    assert told["t_s"] == sorted(told["t_s"])
    assert any("<speed>" in english for english, _ in told["text"])
    assert "<speed>" not in page


def test_of_very_many_events_those_of_lesser_kinds_are_left_out_and_counted() -> None:
    count = EVENTS_SHOWN_MAX + 7
    kinds = ["fault" if i % 1000 == 999 else "refusal" for i in range(count)]
    events = make_table(
        "events",
        {
            "t_s": [float(i) for i in range(count)],
            "source": ["K1"] * count,
            "kind": kinds,
            "text": [f"{kind} {i}" for i, kind in enumerate(kinds)],
            "text_ja": [""] * count,
        },
    )
    shown = _events(events)
    assert len(shown.columns[0].values) == EVENTS_SHOWN_MAX
    assert [en for en, _ in shown.columns[2].values].count("fault") == kinds.count("fault")
    assert shown.notes == (Phrase("and 7 more in events.parquet", "ほか 7 件は events.parquet にある"),)


def test_who_asks_again_and_again_is_one_line_with_a_count() -> None:
    """Two that are refused in turn, one of them once more much later; what is no refusal is told each time."""
    told = [
        (0.0, "manager", "refusal", "refused: K1", "K1を拒否"),
        (0.2, "K1", "refusal", "route refused", ""),
        (5.5, "manager", "refusal", "refused: K1", "K1を拒否"),
        (6.0, "manager", "refusal", "refused: K2", "K2を拒否"),
        (11.0, "manager", "refusal", "refused: K1", "K1を拒否"),
        (12.0, "K1", "intervention", "service brake", ""),
        (13.0, "K1", "intervention", "service brake", ""),
        (11.5 + REFUSED_AGAIN_S, "manager", "refusal", "refused: K1", "K1を拒否"),
    ]
    columns = zip(schema_of(ROWS["events"]), map(list, zip(*told, strict=True)), strict=True)
    shown = _events(make_table("events", dict(columns)))
    assert list(zip(shown.columns[0].values, shown.columns[3].values, strict=True)) == [
        (0.0, ["refused: K1 (× 3)", "K1を拒否（3 回）"]),
        (0.2, ["route refused", "route refused"]),
        (6.0, ["refused: K2", "K2を拒否"]),
        (12.0, ["service brake", "service brake"]),
        (13.0, ["service brake", "service brake"]),
        (11.5 + REFUSED_AGAIN_S, ["refused: K1", "K1を拒否"]),
    ]


def test_single_figures_are_those_that_their_words_say() -> None:
    assert CallLateness(5.0, 12.0).worse_s == CallLateness(12.0, None).worse_s == 12.0
    hop: Any = SimpleNamespace(running_kwh=1.234, run_s=90.0, distance_m=1000.0)
    assert DrivenHopShown("321M", hop, pl.DataFrame()).text == "321M: 1.23 kWh, 90 s"
    parts = {name.removesuffix("_kwh"): 0.0 for name in PARTS} | {"resistance": 5.0}
    went = parts_fact({"energy": {"parts": parts, "all": {"auxiliary": 7.0}}})
    assert re.findall(r"\d\.\d", went.value.en) == ["7.0", "5.0"]  # auxiliaries first


def test_stops_off_their_marks_stand_out(weekday: ReportedRun) -> None:
    def told(error_m: float) -> Fact:
        near = pl.when(pl.col("stop_error_m").is_not_null()).then(pl.lit(0.1)).otherwise(None)
        stops = weekday.tables.stops.with_columns(near.alias("stop_error_m"))
        first = stops["stop_error_m"].is_not_null().arg_max()
        errors = stops["stop_error_m"].to_list()
        errors[first or 0] = error_m
        tables = replace(weekday.tables, stops=stops.with_columns(pl.Series("stop_error_m", errors)))
        run = ReportedRun(weekday.line, weekday.timetable, tables)
        return next(f for f in headline(run, summarise(tables, run.timetable)) if f.name.en == "Stops")

    fine, off = told(0.2), told(-8.9)
    assert not fine.bad and "off" not in fine.value.en
    assert off.bad and "; 1 more than 0.35 m off, the worst " in off.value.en
    assert "0.35 m 超 1 回" in off.value.ja


def test_sections_have_the_names_of_their_stations(weekday: ReportedRun) -> None:
    found = {section_name(weekday, section_id): section_id for section_id in weekday.line.sections}
    assert len(found) == len(weekday.line.sections)
    assert not set(" ".join(found).replace("–", " ").split()) & set(weekday.line.stations)
    assert {"Ogane 1", "Ogane W"} & set(found)
    assert section_name(weekday, "P7") == "P7"
    assert section_name(weekday, found["Ogane 1"], japanese=True) == "大金 1"


def test_broken_invariants_are_red(tmp_path: Path, make_day: Callable[[str, str], ReportedRun]) -> None:
    day = make_day("rtri_test_line", "rtri_test_line")
    violations = [
        {"t_s": 36_061.0, "checker": "one-train-a-section", "text": "K1 and K2 in 6"},
        "said in words",
    ]
    facts = {**FACTS, "violations": violations, "broken_expectations": ["late_s_max below 5"]}
    text = write_report(tmp_path, day.line, day.timetable, day.tables, facts).read_text(encoding="utf-8")
    assert '<dt>Invariants broken</dt><dd class="bad">2</dd>' in text
    assert "<li>10:01:01 one-train-a-section: K1 and K2 in 6</li>" in text
    assert "<li>said in words</li>" in text
    assert ">Expected: late_s_max below 5<" in text


@pytest.mark.parametrize(("missing", "mark"), [([], ""), (["the run was cut short"], ' class="bad"')])
def test_why_the_run_ended_is_red_where_something_was_missing(
    tmp_path: Path, make_day: Callable[[str, str], ReportedRun], missing: list[str], mark: str
) -> None:
    day = make_day("rtri_test_line", "rtri_test_line")
    facts = {**FACTS, "ended_because": "the time limit of the run", "unfinished": missing}
    text = write_report(tmp_path, day.line, day.timetable, day.tables, facts).read_text(encoding="utf-8")
    assert f"<dt>Ended because</dt><dd{mark}>the time limit of the run</dd>" in text


def test_a_run_in_which_nothing_happened_is_reported(tmp_path: Path, weekday: ReportedRun) -> None:
    tables = RunTables(**{name: make_table(name) for name in ROWS})
    text = write_report(tmp_path, weekday.line, weekday.timetable, tables, {}).read_text(encoding="utf-8")
    assert '<dd class="bad">0 of 27 planned</dd>' in text
    assert "none measured" in text
    payload = payload_of(text)
    assert payload["courses"] == []
    assert all(train["unit"] for train in payload["trains"])
    assert not re.search(r"\bnan\b", text[: text.index("importmap")].lower())


def test_same_run_gives_the_same_page(tmp_path: Path, make_day: Callable[[str, str], ReportedRun]) -> None:
    day = make_day("rtri_test_line", "rtri_test_line")
    given = day.line, day.timetable, day.tables, FACTS
    first, second = (write_report(tmp_path / name, *given).read_bytes() for name in "ab")
    assert first == second


def test_settings_are_left_alone(tmp_path: Path, make_day: Callable[[str, str], ReportedRun]) -> None:
    day = make_day("rtri_test_line", "rtri_test_line")
    with mpl.rc_context({"font.size": 31.0, "axes.grid": True}):
        before = dict(mpl.rcParams)
        write_report(tmp_path, day.line, day.timetable, day.tables, FACTS)
        assert dict(mpl.rcParams) == before


def test_train_graph_draws_the_run_where_it_was(weekday: ReportedRun) -> None:
    with drawing():
        figure, tips = draw_train_graph(weekday)
        svg = svg_of(figure, "g", tips)
    lines = {line.get_gid(): line for axes in figure.axes for line in axes.lines if line.get_gid()}
    assert set(lines) == set(tips)
    gid = next(gid for gid, tip in tips.items() if tip.startswith("321M"))
    course = weekday.tables.trajectory.filter(pl.col("train") == "321M")
    assert lines[gid].get_xydata().tolist() == course.select("t_s", "kilometrage_m").to_numpy().tolist()
    assert "<title>321M, unit " in svg
    for axes in figure.axes:
        low, high = axes.get_ylim()
        assert low > high  # DOWN runs downwards
        from_s, to_s = axes.get_xlim()
        assert to_s - from_s <= BAND_S_MAX


def test_run_curve_shows_kmh_and_runs_to_the_right(weekday: ReportedRun) -> None:
    some = list(weekday.courses)[:6]
    assert {weekday.directions[train] for _, train in some} == set(Direction)
    for unit, train in some:
        with drawing():
            figure = draw_run_curve(weekday, unit, train)
        left_m, right_m = figure.axes[0].get_xlim()
        assert (right_m - left_m) * weekday.directions[train] > 0
        speed = next(line for line in figure.axes[0].lines if line.get_label() == "speed")
        top_kmh = weekday.tables.trajectory.filter(pl.col("train") == train)["speed_mps"].max() * 3.6
        assert max(speed.get_ydata()) == pytest.approx(top_kmh)


def test_a_run_curve_marks_level_crossings_and_how_long_they_had_warned(weekday: ReportedRun) -> None:
    """At its kilometrage, with the 30 s before this train; another train has a mark and no time."""
    run = with_crossing(weekday)
    at_m = {}
    for train in ("321M", "325M"):
        unit = next(unit for unit, number in run.courses if number == train)
        rows = run.tables.warnings.with_columns(unit=pl.lit(unit))
        with drawing():
            figure = draw_run_curve(with_table(run, warnings=rows), unit, train)
        speed = figure.axes[0]
        at_m[train] = [float(line.get_xdata()[0]) for line in speed.lines if line.get_marker() == "x"]
        assert ("30 s" in {text.get_text() for text in speed.texts}) is (train == "321M")
    assert at_m["321M"][-1] == at_m["325M"][-1] == 5000.0


def test_occupancy_bars_are_the_blocks(make_day: Callable[[str, str], ReportedRun]) -> None:
    day = make_day("rtri_test_line", "rtri_test_line")
    blocks = make_table(
        "blocks",
        {
            "section": ["6", "7"], "unit": ["K1", "K1"], "train": ["T1", "T1"], "token": [1, 2],
            "granted_s": [36_010.0, 36_020.0], "released_s": [36_050.0, None],
            "entered_s": [36_020.0, None], "cleared_s": [36_040.0, None],
        },
    )  # fmt: skip
    run = with_table(day, blocks=blocks)
    rows = [section.id for section in sections_in_order(run)]
    with drawing():
        bars = [
            (rows[round(bar.get_y() + bar.get_height() / 2)], bar.get_x(), bar.get_x() + bar.get_width())
            for bar in draw_occupancy(run).axes[0].patches
        ]
    # A section that was never released is held to the end of the run.
    end_s = run.window_s[1]
    assert bars == [("6", 36_010.0, 36_050.0), ("7", 36_020.0, end_s), ("6", 36_020.0, 36_040.0)]


def test_delays_are_arrivals_and_departures(make_day: Callable[[str, str], ReportedRun]) -> None:
    day = make_day("rtri_test_line", "rtri_test_line")
    stops = day.tables.stops.with_columns(
        late_departure_s=pl.when(pl.col("station") == "A").then(7.4),
        late_arrival_s=pl.when(pl.col("station") == "B").then(-12.0),
    )
    with drawing():
        figure = draw_delays(with_table(day, stops=stops))
    assert figure is not None
    assert [text.get_text() for text in figure.axes[0].texts] == ["/+7", "−12/"]


def test_a_planned_call_to_which_nobody_came_is_no_blank(make_day: Callable[[str, str], ReportedRun]) -> None:
    """A train that never came is not shown as one that does not call there."""
    day = make_day("rtri_test_line", "rtri_test_line")
    run = with_table(day, stops=day.tables.stops[:1])
    with drawing():
        shown, too_early = draw_delays(run), draw_delays(run, 0.0)
    assert shown is not None and too_early is not None
    texts = [[text.get_text() for text in figure.axes[0].texts] for figure in (shown, too_early)]
    assert [len(cells) for cells in texts] == [2, 1]  # the second run was too short for it
    assert texts[0][1] == "–/"


def cells(figure: Figure) -> list[int]:
    """Every figure in seconds in the table of delays."""
    texts = [text.get_text().replace("−", "-") for axes in figure.axes for text in axes.texts]
    return [int(part) for text in texts for part in text.split("/") if part]


@given(late=st.lists(st.tuples(st.integers(-90, 500), st.integers(-90, 500)), min_size=9, max_size=9))
def test_worst_and_earliest_are_found_in_the_table_of_delays(
    make_day: Callable[[str, str], ReportedRun], late: list[tuple[int, int]]
) -> None:
    """Arrivals and departures drawn at random: the headline's figures are the extremes of what the table shows."""
    day = make_day("rtri_test_line", "rtri_crossing")
    known = day.tables.stops
    drawn = late[: len(known)]
    stops = known.with_columns(
        late_arrival_s=pl.when(pl.col("late_arrival_s").is_not_null()).then(
            pl.Series([float(a) for a, _ in drawn])
        ),
        late_departure_s=pl.when(pl.col("late_departure_s").is_not_null()).then(
            pl.Series([float(d) for _, d in drawn])
        ),
    )
    run = with_table(day, stops=stops)
    with drawing():
        figure = draw_delays(run)
    assert figure is not None
    shown, summary = cells(figure), summarise(run.tables, day.timetable)
    assert summary["late_s_max"] == max(0, *shown)
    assert -summary["early_departure_s_max"] in (0.0, *shown)


def test_the_worst_lateness_is_a_departure_and_stands_in_the_table(
    tmp_path: Path, weekday: ReportedRun
) -> None:
    """A train that came to Ogane on time and left 77 s late."""
    here = (pl.col("train") == "321M") & (pl.col("station") == "OGN")
    calm = weekday.tables.stops.with_columns(late_arrival_s=pl.lit(0.0), late_departure_s=pl.lit(0.0))
    stops = calm.with_columns(late_departure_s=pl.when(here).then(77.0).otherwise(pl.col("late_departure_s")))
    tables = with_table(weekday, stops=stops).tables
    page = write_report(tmp_path, weekday.line, weekday.timetable, tables, {}).read_text(encoding="utf-8")
    assert "<dt>Worst lateness</dt><dd>77 s, departure of 321M at Ogane</dd>" in page
    assert "<dt>最大遅延</dt><dd>77 秒（321M 大金 発）</dd>" in page


def test_no_train_arrived_is_said_so(tmp_path: Path, weekday: ReportedRun) -> None:
    """Every train left its first station a second late, and none came anywhere."""
    gone = {name: pl.lit(None, dtype=pl.Float64) for name in ("arrival_s", "late_arrival_s", "stop_error_m")}
    stops = weekday.tables.stops.with_columns(late_departure_s=pl.lit(1.0), **gone)
    tables = with_table(weekday, stops=stops).tables
    assert summarise(tables, weekday.timetable)["late_s_max"] is None
    page = write_report(tmp_path, weekday.line, weekday.timetable, tables, {}).read_text(encoding="utf-8")
    assert '<dt>Worst lateness</dt><dd class="bad">no train arrived</dd>' in page
    one_more = pl.when(pl.col("train") == "321M").then(pl.col("planned_arrival_s"))
    some = with_table(weekday, stops=stops.with_columns(arrival_s=one_more)).tables
    page = write_report(tmp_path, weekday.line, weekday.timetable, some, {}).read_text(encoding="utf-8")
    assert "; 26 trains did not arrive</dd>" in page


def test_trains_that_did_not_arrive_are_told_once_and_apart_from_rules(
    tmp_path: Path, weekday: ReportedRun
) -> None:
    facts = {**FACTS, "invariants_broken": 5, "violations": [], "broken": ["5 trains did not arrive: 1, 2"]}
    tables = weekday.tables
    page = write_report(tmp_path, weekday.line, weekday.timetable, tables, facts).read_text(encoding="utf-8")
    assert "5, 5 of them that a train has not arrived" in page
    assert page.count("5 trains did not arrive") == 1
    assert "Expected: 5 trains" not in page


def test_the_report_says_what_takes_regenerated_energy(page: str) -> None:
    taken = table_in(payload_of(page), "energy_taken")
    assert taken["taken_by"] == [["the train's own battery", "自車の蓄電池"]]
    assert "kWh net at the battery" in page
    assert "+40 s (+25 %)" in page


def test_clock_goes_on_after_midnight() -> None:
    assert clock(5 * 3600 + 37 * 60) == "05:37"
    assert clock(24 * 3600 + 10 * 60) == "24:10"
    assert clock(36_061, seconds=True) == "10:01:01"


def test_grid_of_a_day_is_ten_minutes_and_of_a_minute_seconds() -> None:
    assert time_grid(19 * 3600).fine_s == 600
    assert time_grid(60).fine_s == 1


@given(from_s=st.floats(0, 90_000), span_s=st.floats(1, 100_000))
def test_panels_cover_the_run_without_gaps(from_s: float, span_s: float) -> None:
    bands, grid = time_bands(from_s, from_s + span_s)
    assert bands[0].from_s <= from_s
    assert bands[-1].to_s >= from_s + span_s
    assert all(a.to_s == b.from_s for a, b in pairwise(bands))
    assert all(0 < band.to_s - band.from_s <= BAND_S_MAX for band in bands)
    assert all(math.fmod(band.from_s, grid.middle_s) == 0 for band in bands)


@given(st.lists(st.floats(0, 100), min_size=1, max_size=6).map(sorted))
def test_labels_keep_their_order_and_come_apart(positions: list[float]) -> None:
    placed = spread(positions, 2.0)
    assert len(placed) == len(positions)
    assert all(high - low > 1.0 for low, high in pairwise(placed))
    if all(high - low >= 2.0 for low, high in pairwise(positions)):
        assert placed == positions


def test_a_what_if_lists_what_it_changed_and_a_plain_run_nothing() -> None:
    changes = [
        {"file": "hills.toml", "key": "points.P1.throw_time_s", "old": 6.0, "new": 12.0},
        {"file": "hills.toml", "key": "tags.7", "old": {"id": 7}, "new": None},
    ]
    (table,) = _changes(changes)
    assert list(zip(*(column.values for column in table.columns), strict=True)) == [
        ("hills.toml", "points.P1.throw_time_s", "6.0", "12.0"),
        ("hills.toml", "tags.7", '{"id": 7}', "–"),
    ]
    (many,) = _changes(changes * CHANGES_SHOWN)
    assert len(many.columns[0].values) == CHANGES_SHOWN
    assert many.notes[0].en == f"and {CHANGES_SHOWN} more in summary.json"
    assert _changes([]) == ()
