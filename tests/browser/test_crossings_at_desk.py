"""Level crossings at the desk in Chromium: one is broken by a click, guarded from another seat, seen from each as far
as it is known there, and what was done replays. Then axe, and nothing cut off or overlapping, on a line with eighteen.
"""

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from documents.desk_pictures import CROSSED
from scenario.scenario import load_scenario
from study.drilling.drill import find_drill, run_drill
from study.runner.run import PartyLink
from tests.browser.seated import SIZE, Seated, cut_off, overlapping, serious, served, served_desk
from tests.nightly import others_nightly

SEATS = ("instructor", "dispatcher", "staff", "driver&unit=V2")
CROSSED_S = 7 * 3600 + 11 * 60 + 20.0  # a train is before its second crossing


def at_crossing(seat: Seated) -> str | None:
    """The state that a seat's schematic shows of the crossing."""
    state: str | None = seat.page.locator("g.crossing").get_attribute("data-state")
    return state


def test_a_crossing_is_broken_by_a_click_and_guarded_and_it_replays(
    browser: Any,  # noqa: ANN401
    tmp_path: Path,
) -> None:
    with served(load_scenario(find_drill("rtri/100_crossing"))) as address:
        instructor = Seated(browser, address, "instructor", "en")
        dispatcher = Seated(browser, address, "dispatcher", "ja")
        staff = Seated(browser, address, "staff", "en")
        driver = Seated(browser, address, "driver&unit=K1", "ja")
        seats = (instructor, dispatcher, staff, driver)
        instructor.run_to("09:58:00")
        for seat, state in ((instructor, "open"), (dispatcher, "no word"), (staff, "no word")):
            seat.shows("#clock", "09:58:00")
            assert at_crossing(seat) == state
        instructor.page.get_by_role("button", name="level crossing C1").click()
        instructor.page.select_option("#fault-kind", "barriers_stuck")
        instructor.page.get_by_role("button", name="Begin the fault").click()
        instructor.shows(".answer", "done")
        staff.page.select_option("#act-kind", "guard_road")
        staff.page.get_by_role("button", name="level crossing C1").press("Enter")
        assert staff.page.locator("#act-target").input_value() == "C1"
        staff.act("guard_road")
        staff.shows(".answer", "done")
        instructor.run_to("10:01:00")
        for seat in seats[:3]:
            seat.shows("#clock", "10:01:00")
            assert at_crossing(seat) == "not proven"
        instructor.shows(".roads", "not proven (not detected in time)")
        dispatcher.shows(".roads", "監視員あり")
        dispatcher.shows(".roads", "T1")
        driver.shows("#cab-waits", "踏切C1の遮断証明")
        driver.shows("#cab-crossing", "C1")
        instructor.page.fill("#to-time", "27:00:00")
        instructor.page.get_by_role("button", name="run to").click()
        instructor.shows("#running", "all trains have finished")
        driver.shows(".log", "踏切 C1 の徐行通過を許可（監視員が道路を停止）")
        digest = instructor.page.locator("main").get_attribute("data-digest")
        with instructor.page.expect_download() as saved:
            instructor.page.get_by_role("button", name="save as a drill").click()
        file = tmp_path / "saved.toml"
        saved.value.save_as(file)
        assert [seat.said for seat in seats] == [[], [], [], []]
    assert run_drill(str(file), PartyLink.SIMULATED).run.result.digest == digest


@pytest.fixture(scope="module")
def eighteen() -> Iterator[str]:
    with served_desk(load_scenario(str(CROSSED))) as desk:
        desk.run_to(CROSSED_S)
        yield desk.page


@pytest.mark.parametrize(
    ("seat", "language"),
    others_nightly(product(SEATS, ("en", "ja")), [(SEATS[0], "en"), (SEATS[-1], "ja")], columns=True),
)
def test_a_line_with_many_crossings_is_read_by_everybody(
    browser: Any,  # noqa: ANN401
    eighteen: str,
    seat: str,
    language: str,
) -> None:
    context = browser.new_context(viewport=SIZE, bypass_csp=True)
    page = context.new_page()
    page.goto(f"{eighteen}?lang={language}&seat={seat}")
    page.wait_for_selector("g.crossing")
    names = page.locator("g.crossing").evaluate_all(
        "(all) => all.map((one) => one.getAttribute('aria-label'))"
    )
    drawn = page.locator("g.crossing").evaluate_all(
        "(all) => all.map((one) => one.querySelector('.sign').getBoundingClientRect())"
        ".map((box) => [box.left, box.top, box.right, box.bottom])"
    )
    body = page.evaluate("() => [document.body.scrollWidth, document.body.scrollHeight]")
    found = (overlapping(page), cut_off(page), serious(page))
    context.close()
    assert found == ([], [], [])
    assert body == [SIZE["width"], SIZE["height"]]
    assert len(names) == (11 if seat.startswith("driver") else 18) and all("X" in name for name in names)
    assert [
        (names[i], names[j])
        for i, a in enumerate(drawn)
        for j, b in enumerate(drawn[:i])
        if min(a[2], b[2]) - max(a[0], b[0]) > 1 and min(a[3], b[3]) - max(a[1], b[1]) > 1
    ] == []
