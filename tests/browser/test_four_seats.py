"""The desk in Chromium, four browsers at four seats: the manager loses its power, as in the paper's drill, a train is
driven by hand meanwhile, and the script of all four is a drill with the same digest. Then axe on each page, where the
package that has it is.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pytest

from network.clock import clock
from scenario.scenario import load_scenario
from study.drilling.drill import run_drill
from study.record.directory import reserved
from study.record.read_back import RunRead, read_run
from study.runner.run import PartyLink, execute, fill_run
from tests.browser.seated import WAIT_MS, Seated, cut_off, overlapping, serious, served
from tests.nightly import others_nightly

SIZES: Final = ({"width": 1280, "height": 800}, {"width": 1920, "height": 1080})
EARLIER: Final = re.compile(r"09:|10:00:[0-2]")  # than half a minute past ten


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with served(load_scenario("karasuyama_weekday")) as address:
        yield address


@dataclass(frozen=True)
class WorkedDay:
    """A day of the Karasuyama line, and a minute in which a train of it stands at Ogane."""

    scenario: str
    unit: str
    begin_s: int
    trains: int


ONE_SET = WorkedDay("turn_back", "V1", 6 * 3600 + 4 * 60, 2)
WEEKDAY = WorkedDay("karasuyama_weekday", "V2", 6 * 3600 + 44 * 60, 27)


@pytest.mark.parametrize("day", others_nightly([ONE_SET, WEEKDAY], [ONE_SET]), ids=lambda day: day.scenario)
def test_four_browsers_at_four_seats_and_their_script_replays(
    browser: Any,  # noqa: ANN401
    day: WorkedDay,
    turn_back: str,
    tmp_path: Path,
) -> None:
    with served(load_scenario(turn_back if day is ONE_SET else day.scenario)) as address:
        digest = worked_from_four_seats(browser, address, day, tmp_path / "saved.toml")
    drill = run_drill(str(tmp_path / "saved.toml"), PartyLink.SIMULATED)
    assert drill.run.result.digest == digest
    assert len(drill.run.result.trains_arrived) == day.trains and drill.passed


def worked_from_four_seats(browser: Any, address: str, day: WorkedDay, file: Path) -> str | None:  # noqa: ANN401
    """What is done is saved as a drill; the run's digest."""
    instructor = Seated(browser, address, "instructor", "en")
    instructor.run_to(clock(day.begin_s))
    dispatcher = Seated(browser, address, "dispatcher", "ja")
    staff = Seated(browser, address, "staff", "en")
    driver = Seated(browser, address, f"driver&unit={day.unit}", "en")
    seats = (instructor, dispatcher, staff, driver)
    instructor.page.select_option("#tell-seat", "driver")
    instructor.page.fill("#tell-text", "drive by hand from Ogane")
    instructor.page.click("#tell-form button")
    driver.shows("#messages", "drive by hand from Ogane")
    assert staff.page.locator("#messages p").count() == 0
    driver.page.locator("h1").first.click()
    driver.page.keyboard.press("ArrowUp")
    driver.shows(".answer", "done")
    driver.page.keyboard.press("ArrowUp")
    instructor.page.get_by_role("button", name="one step").click()
    driver.shows("#cab-drives", "by hand")
    instructor.page.get_by_role("button", name="block-manager").click()
    instructor.page.select_option("#fault-kind", "power_off")
    instructor.page.fill("#key-duration_s", "600")
    instructor.page.get_by_role("button", name="Begin the fault").click()
    instructor.shows(".answer", "done")
    instructor.run_to(clock(day.begin_s + 30))
    for seat in (dispatcher, staff):
        seat.shows("#clock", clock(day.begin_s + 30))
        assert seat.states() == {"undefined"}
    dispatcher.act("let_go")  # wrong: nobody is kept back, and nobody hears it
    instructor.run_to(clock(day.begin_s + 720))
    dispatcher.shows("#clock", clock(day.begin_s + 720))
    dispatcher.act("accept_picture")
    dispatcher.shows(".answer", "実行済み")
    dispatcher.act("reenter_assisted")
    dispatcher.shows(".answer", "実行済み")
    driver.page.keyboard.press("a")
    driver.shows(".answer", "done")
    instructor.run_to(clock(day.begin_s + 960))
    driver.shows("#cab-drives", "by ATO")
    staff.page.get_by_role("button", name="protocol").click()
    staff.shows(".answer", "the run's end")  # it tells what has failed
    instructor.page.get_by_role("button", name="protocol").click()
    instructor.shows("#score", "power_off block-manager")
    instructor.page.get_by_role("button", name="close").click()
    instructor.page.fill("#to-time", "27:00:00")
    instructor.page.get_by_role("button", name="run to").click()
    instructor.shows("#running", "all trains have finished")
    digest: str | None = instructor.page.locator("main").get_attribute("data-digest")
    with instructor.page.expect_download() as saved:
        instructor.page.get_by_role("button", name="save as a drill").click()
    saved.value.save_as(file)
    assert [seat.said for seat in seats] == [[], [], [], []]
    return digest


def test_a_wrong_entry_is_refused_in_a_sentence_that_a_dispatcher_reads(
    browser: Any,  # noqa: ANN401
    tmp_path: Path,
) -> None:
    with served(load_scenario("rtri_test_line")) as address:
        instructor = Seated(browser, address, "instructor", "en")
        dispatcher = Seated(browser, address, "dispatcher", "ja")
        dispatcher.act("let_go")
        dispatcher.shows(".answer", "実行済み")
        instructor.page.get_by_role("button", name="one step").click()
        dispatcher.shows("#alarm", "抑止されていない")


@pytest.mark.parametrize("language", others_nightly(["en", "ja"], ["ja"]))
@pytest.mark.parametrize(
    "seat",
    others_nightly(
        ["instructor", "dispatcher", "staff", "driver&unit=V2", ""], ["instructor", "driver&unit=V2"]
    ),
)
def test_axe_finds_nothing_serious(
    browser: Any,  # noqa: ANN401
    address: str,
    seat: str,
    language: str,
) -> None:
    context = browser.new_context(viewport=SIZES[0], bypass_csp=True)
    page = context.new_page()
    page.goto(f"{address}?lang={language}" + (f"&seat={seat}" if seat else ""))
    page.wait_for_selector("#clock" if seat else ".seats a")
    bad = serious(page)
    context.close()
    assert bad == []


@pytest.mark.parametrize("size", others_nightly(SIZES, SIZES[:1]), ids=["1280", "1920"])
@pytest.mark.parametrize("language", others_nightly(["en", "ja"], ["ja"]))
@pytest.mark.parametrize("seat", ["instructor", "dispatcher", "staff", "driver&unit=V2"])
def test_a_page_needs_no_scrolling_and_no_text_of_the_line_is_cut_or_overlaps(
    browser: Any,  # noqa: ANN401
    address: str,
    seat: str,
    language: str,
    size: Any,  # noqa: ANN401
) -> None:
    page = browser.new_page(viewport=size)
    page.goto(f"{address}?lang={language}&seat={seat}")
    page.wait_for_selector("#clock")
    page.wait_for_selector("#deeds", state="attached")
    body = page.evaluate("() => [document.body.scrollWidth, document.body.scrollHeight]")
    assert body[0] <= size["width"] and body[1] <= size["height"]
    assert (overlapping(page), cut_off(page)) == ([], [])
    page.close()


def finished(out: Path, name: str = "rtri_test_line") -> RunRead:
    with reserved(out) as place:
        fill_run(execute(load_scenario(name), PartyLink.SIMULATED, journal=place.journal), place)
    return read_run(out)


def test_two_runs_side_by_side_go_to_the_same_time(browser: Any, tmp_path: Path) -> None:  # noqa: ANN401
    from playwright.sync_api import expect

    late = tmp_path / "late.toml"
    late.write_text(
        'extends = "rtri_test_line"\nid = "late"\nname = "late"\n'
        '[[fault]]\nkind = "power_off"\ntarget = "K1"\nstart = "10:00:40"\nduration_s = 120.0\n',
        "utf-8",
    )
    runs = finished(tmp_path / "one"), finished(tmp_path / "other", str(late))
    with served(*runs) as address:
        page = browser.new_page(viewport=SIZES[0])
        page.goto(f"{address}beside.html?lang=en")
        frames = [page.frame_locator(f"iframe[name={name}]") for name in ("desk", "beside")]
        for frame in frames:
            frame.locator("#slider").wait_for()
        frames[0].locator("#slider").evaluate(
            "(one) => { one.value = 36030; one.dispatchEvent(new Event('change')); }"
        )
        for frame in frames:
            expect(frame.locator("#clock")).to_have_text("10:00:30", timeout=WAIT_MS)
        frames[1].get_by_role("button", name="one step").click()
        frames[1].get_by_role("button", name="next event").click()
        expect(frames[1].locator("#clock")).not_to_have_text("10:00:30", timeout=WAIT_MS)
        then = frames[1].locator("#clock").inner_text()
        expect(frames[0].locator("#clock")).to_have_text(then, timeout=WAIT_MS)
        page.screenshot(path=tmp_path / "beside.png")
        page.close()


def test_a_run_is_looked_at_again_with_a_slider(browser: Any, tmp_path: Path) -> None:  # noqa: ANN401
    from playwright.sync_api import expect

    with served(finished(tmp_path / "run")) as address:
        page = Seated(browser, address, "instructor", "en")
        page.page.locator("#slider").evaluate(
            "(one) => { one.value = 36030; one.dispatchEvent(new Event('change')); }"
        )
        page.shows("#clock", "10:00:30")
        page.shows(".trains", "T1")
        Seated(browser, address, "dispatcher", "ja").shows(".trains", "A駅")  # where it was last, by its name
        page.page.get_by_role("button", name="event before").click()
        page.shows(".answer", "done")
        expect(page.page.locator("#clock")).to_contain_text(EARLIER, timeout=WAIT_MS)
        assert page.said == []


def test_all_of_an_act_is_read_back(browser: Any, address: str) -> None:  # noqa: ANN401
    """For how long a train is held too, and behind which other."""
    seat = Seated(browser, address, "dispatcher", "en")
    seat.page.select_option("#act-kind", "hold_train")
    seat.page.select_option("#act-target", "V2")
    seat.page.fill("#act-hold_s", "420")
    seat.page.select_option("#act-behind", "V3")
    seat.page.locator("#act-form button[type=submit]").click()
    said = seat.page.locator("#act-form [role=group]").inner_text()
    assert "hold train V2 hold 420 s V3" in said
    seat.page.close()
