"""The report in a real browser: opened from disk, moved, searched, in both languages, on wide and narrow screens.

Frames a second are reported and not asserted: how many there are depends on the machine.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import polars as pl
import pytest

from study.report.data import ReportedRun
from tests.browser.conftest import report_of
from tests.nightly import others_nightly

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Route

PICTURES = os.environ.get("BRANCHLINE_PICTURES")  # a folder for what the tests saw
SIZES = ((1280, 800), (1920, 1080), (400, 800))
LANGUAGES = ("en", "ja")
PAPERS = (
    "graph",
    "summary",
    "curve",
    "stations",
    "punctuality",
    "energy",
    "margins",
    "stopping",
    "sections",
    "trains",
    "events",
)
MOVES = """
async (lasts_ms) => {
  const { graph } = globalThis.branchline;
  const found = {};
  const measure = async (name, move) => {
    const [frames, began] = [graph.layer.frames, performance.now()];
    for (let i = 0; performance.now() - began < lasts_ms; i++) {
      move(i);
      await new Promise((done) => requestAnimationFrame(done));
    }
    found[name] = (1000 * (graph.layer.frames - frames)) / (performance.now() - began);
  };
  graph.pane.fit();
  await measure("zoom", (i) => graph.pane.zoom(i % 40 < 20 ? 0.96 : 1 / 0.96, 1));
  graph.pane.fit();
  await measure("whole day", (i) => graph.pane.zoom(i % 2 ? 1.001 : 0.999, 1));
  graph.pane.zoom(0.2, 1);
  await measure("pan", (i) => graph.pane.pan(i % 100 < 50 ? 8 : -8, 0));
  graph.pane.fit();
  return found;
}
"""
# Where the line of a train is on the screen at a share of its course.
ON_LINE = """
([number, share]) => {
  const { graph, day } = globalThis.branchline;
  const course = day.byNumber.get(number).courses[0];
  const t = course.from + share * (course.to - course.from);
  let i = 0;
  while (course.t[i + 1] < t) i += 1;
  const m = course.m[i] + ((course.m[i + 1] - course.m[i]) * (t - course.t[i])) / (course.t[i + 1] - course.t[i]);
  const [view, plot, box] = [graph.pane.view, graph.pane.plot(), graph.layer.canvas.getBoundingClientRect()];
  return [
    box.left + plot.left + ((t - view.x0) / (view.x1 - view.x0)) * plot.width,
    box.top + plot.top + ((m - view.y0) / (view.y1 - view.y0)) * plot.height,
  ];
}
"""


# Which time a place on the screen stands for.
TIME_AT = """
(x) => {
  const { pane, layer } = globalThis.branchline.graph;
  const plot = pane.plot();
  const share = (x - layer.canvas.getBoundingClientRect().left - plot.left) / plot.width;
  return pane.view.x0 + share * (pane.view.x1 - pane.view.x0);
}
"""
MARK_AT = """
() => {
  const { graph, day } = globalThis.branchline;
  const event = day.events.find((e) => e.kind === "broken invariant");
  const [view, plot, box] = [graph.pane.view, graph.pane.plot(), graph.layer.canvas.getBoundingClientRect()];
  return [
    box.left + plot.left + ((event.t - view.x0) / (view.x1 - view.x0)) * plot.width,
    box.top + plot.top + 9,
  ];
}
"""

# What is laid out then answers to clicks.
DRAWN = "() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))"


@contextmanager
def opened(
    browser: Browser, report: Path, size: tuple[int, int] = SIZES[0], *, scripts: bool = True
) -> Iterator[Page]:
    """The report, opened from disk. Anything asked of any host and any error of the page fails the test."""
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]}, locale="en-GB", java_script_enabled=scripts
    )
    page = context.new_page()
    asked: list[str] = []
    wrong: list[str] = []

    def route(found: Route) -> None:
        url = found.request.url
        if url.startswith("file:") and url.partition("#")[0] == report.as_uri():
            found.continue_()
            return
        asked.append(url)
        found.abort()

    page.route("**/*", route)
    page.on(
        "request",
        lambda request: (
            None if request.url.startswith(("file:", "data:", "blob:")) else asked.append(request.url)
        ),
    )
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    page.goto(report.as_uri())
    if scripts:
        page.wait_for_function("globalThis.branchline !== undefined")
        page.evaluate(DRAWN)
    yield page
    assert asked == []
    assert wrong == []
    context.close()


def picture(page: Page, name: str) -> None:
    """Kept where somebody wants to look."""
    if PICTURES:
        page.screenshot(path=str(Path(PICTURES) / f"{name}.png"), full_page="-graph" not in name)


@pytest.mark.parametrize(
    ("size", "language"),
    others_nightly(product(SIZES, LANGUAGES), [(SIZES[0], "en"), (SIZES[2], "ja")], columns=True),
)
def test_every_paper_opens_from_disk_in_both_languages(
    browser: Browser, weekday_report: Path, size: tuple[int, int], language: str
) -> None:
    with opened(browser, weekday_report, size) as page:
        if language == "ja":
            page.click("#language")
        assert page.evaluate("document.documentElement.lang") == language
        heading = page.locator("h1").inner_text()
        assert ("烏山線" in heading, "Karasuyama" in heading) == (language == "ja", language == "en")
        for paper in PAPERS:
            page.click(f"#tab-{paper}")
            page.wait_for_timeout(50)  # two frames: canvases are drawn when they have their size
            picture(page, f"{size[0]}-{language}-{paper}")
            place = page.locator(f"#paper-{paper}")
            assert place.is_visible()
            widest = page.evaluate("document.documentElement.scrollWidth")
            assert widest <= size[0], f"{paper} is {widest} px wide"
            drawn = page.evaluate(
                "(id) => [...document.querySelectorAll(`#paper-${id} .stage canvas`)].map((c) => [c.width, c.height])",
                paper,
            )
            assert all(width > 100 and height > 100 for width, height in drawn)


by_trains = pytest.mark.parametrize("trains", others_nightly([27, 500], [27]))


def report_with(trains: int, request: pytest.FixtureRequest) -> Path:
    """The report of a day of so many trains; with 500 it takes ten seconds to make."""
    found: Path = request.getfixturevalue("weekday_report" if trains == 27 else "busy_report")
    return found


@pytest.mark.nightly
@pytest.mark.parametrize("trains", [27, 500])
def test_frames_a_second(
    browser: Browser,
    request: pytest.FixtureRequest,
    record_property: Callable[[str, object], None],
    trains: int,
) -> None:
    report = report_with(trains, request)
    with opened(browser, report) as page:
        found = page.evaluate(MOVES, 1500 if trains == 500 else 300)
        picture(page, f"{trains}-graph")
    told = ", ".join(f"{name} {frames:.0f}" for name, frames in found.items())
    record_property(
        "figures", f"{trains} trains, {report.stat().st_size / 1e3:.0f} kB: frames a second: {told}"
    )
    assert set(found) == {"zoom", "whole day", "pan"}
    assert all(frames > 0 for frames in found.values())


@by_trains
def test_a_train_is_found_by_search_and_by_pointing(
    browser: Browser, request: pytest.FixtureRequest, trains: int
) -> None:
    with opened(browser, report_with(trains, request)) as page:
        number = page.evaluate("(n) => branchline.day.trains[n].number", trains // 2)
        page.fill("#search", number.lower())
        page.press("#search", "Enter")
        assert page.evaluate("branchline.graph.options.chosen") == number
        view = page.evaluate("branchline.graph.pane.view")
        begins, ends = page.evaluate(
            "(n) => { const c = branchline.day.byNumber.get(n).courses[0]; return [c.from, c.to]; }", number
        )
        assert view["x0"] < begins < ends < view["x1"]
        page.get_by_role("button", name="20 min").click()
        assert page.evaluate(
            "branchline.graph.pane.view.x1 - branchline.graph.pane.view.x0"
        ) == pytest.approx(1200)
        page.evaluate("(n) => branchline.graph.choose(n, true)", number)
        page.mouse.move(*page.evaluate(ON_LINE, [number, 0.43]))
        told = page.locator(".tip").inner_text()
        assert "km/h" in told or "stands" in told
        picture(page, "hover-graph")
        page.fill("#search", "no such train")
        page.press("#search", "Enter")
        assert "no train no such train" in page.locator(".answer").inner_text()


def test_pointing_names_the_train_under_the_pointer(browser: Browser, weekday_report: Path) -> None:
    with opened(browser, weekday_report) as page:
        for number in page.evaluate("branchline.day.trains.slice(3, 9).map((t) => t.number)"):
            page.evaluate("(n) => branchline.graph.choose(n, true)", number)
            page.mouse.move(*page.evaluate(ON_LINE, [number, 0.21]))
            assert page.locator(".tip strong").inner_text().startswith(f"{number} ·")
        page.mouse.move(2, 2)
        assert page.locator(".tip").is_hidden()


def test_a_mark_opens_its_text(browser: Browser, weekday_report: Path) -> None:
    with opened(browser, weekday_report) as page:
        page.mouse.click(*page.evaluate(MARK_AT))
        popup = page.locator(".popup")
        assert popup.is_visible()
        assert "11:06:40 a rule · broken invariant · broke" in popup.inner_text()


def test_keys_move_zoom_and_walk_along_a_train(browser: Browser, weekday_report: Path) -> None:
    with opened(browser, weekday_report) as page:
        page.locator("#paper-graph canvas").first.focus()
        whole = page.evaluate("branchline.graph.pane.view")
        for key in ("+", "+", "+"):
            page.keyboard.press(key)
        near = page.evaluate("branchline.graph.pane.view")
        assert near["x1"] - near["x0"] == pytest.approx((whole["x1"] - whole["x0"]) / 1.25**3)
        page.keyboard.press("ArrowRight")
        assert page.evaluate("branchline.graph.pane.view.x0") > near["x0"]
        page.keyboard.press("0")
        assert page.evaluate("branchline.graph.pane.view") == whole
        page.keyboard.press("n")
        first = page.evaluate("branchline.graph.options.chosen")
        assert first == page.evaluate("branchline.day.trains[0].number")
        for _ in range(4):
            page.keyboard.press(".")
        assert first in page.locator(".unseen[aria-live]").inner_text()
        page.keyboard.press("Enter")
        assert page.locator("#curve-train").input_value() == first


def test_dragging_moves_and_the_wheel_zooms_about_the_pointer(browser: Browser, weekday_report: Path) -> None:
    with opened(browser, weekday_report) as page:
        box = page.locator("#paper-graph canvas").first.bounding_box()
        x, y = round(box["x"] + 0.6 * box["width"]), round(box["y"] + 0.5 * box["height"])
        page.mouse.move(x, y)
        before = page.evaluate(TIME_AT, x)
        page.keyboard.down("Control")
        for _ in range(6):
            page.mouse.wheel(0, -120)
        page.keyboard.up("Control")
        page.wait_for_timeout(100)
        assert page.evaluate("branchline.graph.pane.view.x1 - branchline.graph.pane.view.x0") < 20_000
        assert page.evaluate(TIME_AT, x) == pytest.approx(before, abs=1.0)
        page.mouse.down()
        page.mouse.move(x - 100, y, steps=4)
        page.mouse.up()
        assert page.evaluate(TIME_AT, x - 100) == pytest.approx(before, abs=2.0)


def test_without_javascript_the_figures_are_there(browser: Browser, weekday_report: Path) -> None:
    with opened(browser, weekday_report, scripts=False) as page:
        assert page.get_by_text("27 of 27 planned").is_visible()
        assert page.locator("noscript p").is_visible()
    with opened(browser, weekday_report) as page:
        assert page.get_by_text("drawn by JavaScript").is_hidden()
        picture(page, "no-javascript")


def test_a_table_stands_behind_each_chart_and_sorts(browser: Browser, weekday_report: Path) -> None:
    with opened(browser, weekday_report) as page:
        for paper in PAPERS[2:]:
            page.click(f"#tab-{paper}")
            assert page.locator(f"#paper-{paper} details.table").count() >= 1, paper
        page.click("#tab-margins")
        heading = page.locator("#table-margins th", has_text="trains").get_by_role("button")
        heading.click()
        cells = page.locator("#table-margins tbody tr td:nth-child(3)")
        counts = [int(text) for text in cells.all_inner_texts()]
        assert counts == sorted(counts)
        heading.click()
        assert [int(text) for text in cells.all_inner_texts()] == sorted(counts, reverse=True)


def test_two_hours_of_the_whole_day_are_its_first_and_of_a_chosen_train_its_own(
    browser: Browser, weekday_report: Path
) -> None:
    with opened(browser, weekday_report) as page:
        view, bounds = "branchline.graph.pane.view", "branchline.graph.pane.bounds"
        page.get_by_role("button", name="2 h").click()
        assert page.evaluate(f"{view}.x0 === {bounds}.x0")
        assert page.evaluate(f"{view}.x1 - {view}.x0") == pytest.approx(7200.0)
        page.evaluate("branchline.graph.choose(branchline.day.trains[20].number, true)")
        page.get_by_role("button", name="2 h").click()
        begins, ends = page.evaluate("branchline.day.trains[20].courses.map((c) => [c.from, c.to])[0]")
        middle = page.evaluate(f"({view}.x0 + {view}.x1) / 2")
        assert begins < middle < ends


def test_the_graph_of_a_drill_opens_on_what_is_done_in_it(browser: Browser, weekday_report: Path) -> None:
    """A fault of some minutes within a day is not lost in it; one before the first train widens the bounds."""
    opening = """(marks) => import("branchline/graphpaper.js").then(({ openingOf }) => {
      const { x0, x1 } = openingOf({ ...branchline.day, marks });
      return [x0, x1];
    })"""
    with opened(browser, weekday_report) as page:
        day = page.evaluate("[branchline.graph.pane.bounds.x0, branchline.graph.pane.bounds.x1]")
        fault = {"kind": "F", "from": 36_000, "to": 36_300}
        expectation = {"kind": "E", "from": 20_000, "to": None}
        assert page.evaluate(opening, []) == day
        assert page.evaluate(opening, [expectation]) == day
        assert page.evaluate(opening, [fault, expectation]) == [34_200, 38_100]
        begins, _ = page.evaluate(opening, [{"kind": "F", "from": 10_000, "to": 10_060}])
        assert begins < 10_000


def test_blocks_of_all_trains_stay_when_one_is_chosen_and_tracks_stand_apart(
    browser: Browser, weekday_report: Path
) -> None:
    """Each train holds a section for as long as it runs; the two tracks of a station each have a row of their own."""
    held = """(() => {
      const { day, graph } = branchline;
      day.stairway = day.trains.filter((t) => t.courses.length).map((train, i) => ({
        section: day.sections[i % day.sections.length], train: train.number, part: "run", colour: "#41ab5d",
        from: train.courses[0].from, to: train.courses[0].to,
      }));
      graph.options.stairway = true;
    })()"""
    ink = """(() => {
      branchline.graph.layer.drawNow();
      const c = branchline.graph.layer.canvas;
      const { data } = c.getContext("2d").getImageData(0, 0, c.width, c.height);
      let n = 0;
      for (let i = 0; i < data.length; i += 4) if (data[i + 1] > data[i] + 8 && data[i + 1] > data[i + 2] + 8) n++;
      return n;
    })()"""
    with opened(browser, weekday_report) as page:
        assert page.evaluate(ink) < 1000
        page.evaluate(held)
        everyone = page.evaluate(ink)
        page.evaluate("branchline.graph.choose(branchline.day.trains[8].number, false)")
        assert page.evaluate(ink) > 0.7 * everyone > 1000
        rows = page.evaluate(
            """import("branchline/stairway.js").then(({ rowsOf }) => {
              const rows = rowsOf(branchline.day.sections, { y: (m) => m / 100 });
              return ["OGN.1", "OGN.2"].map((id) => rows.get(id));
            })"""
        )
        assert min(row["height"] for row in rows) >= 7
        assert abs(rows[0]["y"] - rows[1]["y"]) >= 7


def test_a_sheet_is_full_and_they_are_few(browser: Browser, weekday_report: Path, tmp_path: Path) -> None:
    """27 trains: four sheets of graph with minutes, and not one for each table."""
    with opened(browser, weekday_report) as page:
        page.pdf(path=tmp_path / "report.pdf", prefer_css_page_size=True)
    sheets = re.findall(rb"/Type\s*/Page\b", (tmp_path / "report.pdf").read_bytes())
    assert 4 < len(sheets) <= 22


def test_paper_has_the_whole_day(browser: Browser, weekday_report: Path) -> None:
    with opened(browser, weekday_report) as page:
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert page.locator(".print-only canvas").count() == 4
        page.emulate_media(media="print")
        assert page.locator(".print-only canvas").first.is_visible()
        for paper in PAPERS:
            assert page.locator(f"#paper-{paper}").is_visible(), paper
        assert page.locator(".bar").is_hidden()
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        page.emulate_media(media="screen")
        assert page.locator("#paper-energy").is_hidden()


def test_a_train_that_did_not_leave_is_not_shown_as_on_time(
    browser: Browser, weekday: ReportedRun, tmp_path: Path
) -> None:
    """321M leaves no station; all others leave them as planned, and have no figure in brackets."""
    gone = pl.when(pl.col("train") != "321M").then(pl.col("departure_s")).alias("departure_s")
    run = replace(weekday, tables=replace(weekday.tables, stops=weekday.tables.stops.with_columns(gone)))
    with opened(browser, report_of(run, tmp_path)) as page:
        page.click("#tab-stations")
        page.select_option("#timetable-station", "OGN")
        marked = page.locator("button.departure", has_text="(–)").evaluate_all(
            "(all) => all.map((one) => one.title)"
        )
    assert marked == ["321M"]
