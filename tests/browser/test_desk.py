"""The desk in Chromium: the paper's drill "block manager loses its power", by clicks at two seats."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Any, Final

import pytest

from console.access import LOOPBACK, on_loopback
from console.live import LiveDesk
from scenario.scenario import Scenario, load_scenario
from study.drilling.drill import run_drill
from study.record.read_back import RunRead
from study.runner.run import PartyLink

pytestmark = [pytest.mark.browser, pytest.mark.system]

WAIT_MS: Final = 500_000
SIZE: Final = {"width": 1280, "height": 800}


@contextmanager
def served(what: Scenario | RunRead) -> Generator[str]:
    """A desk, served: its address."""
    uvicorn = pytest.importorskip("uvicorn", reason="the extra [console] is not installed")
    from console.server import DeskServer, listening_on

    with listening_on(LOOPBACK, 0) as bound:
        port = bound.getsockname()[1]
        server = DeskServer(on_loopback(port))
        live = LiveDesk(what, server.changed)
        live.start()
        server.desk = live
        web = uvicorn.Server(uvicorn.Config(server.app, log_level="error", ws="websockets-sansio"))
        thread = Thread(target=web.run, kwargs={"sockets": [bound]})
        thread.start()
        try:
            yield f"http://{LOOPBACK}:{port}/"
        finally:
            web.should_exit = True
            thread.join()
            live.stop()
        assert live.error is None


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A desk of the Karasuyama weekday, served."""
    with served(load_scenario("karasuyama_weekday")) as address:
        yield address


class Seated:
    """A page at a seat."""

    def __init__(self, browser: Any, address: str, seat: str, language: str) -> None:  # noqa: ANN401
        self.page = browser.new_page(viewport=SIZE)
        self.said: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.goto(f"{address}?seat={seat}&lang={language}")
        self.page.wait_for_selector("#clock")
        self.page.wait_for_selector(".section, .cab")

    def shows(self, where: str, text: str) -> None:
        from playwright.sync_api import expect

        expect(self.page.locator(where)).to_contain_text(text, timeout=WAIT_MS)

    def run_to(self, clock: str) -> None:
        self.page.fill("#to-time", clock)
        self.page.get_by_role("button", name="run to").click()
        self.shows("#clock", clock)

    def states(self) -> set[str]:
        found = self.page.locator("g.section").all()
        return {one.get_attribute("class").removeprefix("section ") for one in found}

    def act(self, kind: str) -> None:
        self.page.select_option("#act-kind", kind)
        self.page.locator("#act-form button[type=submit]").click()
        self.page.locator("#act-form [role=group] button").first.click()


def test_the_block_manager_loses_its_power_and_the_line_is_restored(
    browser: Any,  # noqa: ANN401
    address: str,
    tmp_path: Path,
) -> None:
    instructor = Seated(browser, address, "instructor", "en")
    dispatcher = Seated(browser, address, "dispatcher", "ja")
    instructor.run_to("06:44:00")
    assert dispatcher.states() == {"free", "held"}
    instructor.page.get_by_role("button", name="block-manager").click()
    instructor.page.select_option("#fault-kind", "power_off")
    instructor.page.fill("#key-duration_s", "600")
    instructor.page.get_by_role("button", name="Begin the fault").click()
    instructor.shows(".answer", "done")
    instructor.run_to("06:44:30")
    dispatcher.shows("#clock", "06:44:30")
    assert dispatcher.states() == {"undefined"}
    dispatcher.shows("#alarm", "閉そく管理装置の応答なし")
    instructor.run_to("06:56:00")
    dispatcher.shows("#clock", "06:56:00")
    dispatcher.act("accept_picture")
    dispatcher.shows(".answer", "実行済み")
    dispatcher.act("reenter_assisted")
    dispatcher.shows(".answer", "実行済み")
    instructor.run_to("07:00:00")
    dispatcher.shows("#clock", "07:00:00")
    assert "free" in dispatcher.states()
    instructor.page.fill("#to-time", "27:00:00")
    instructor.page.get_by_role("button", name="run to").click()
    instructor.shows("#running", "all trains have finished")
    digest = instructor.page.locator("main").get_attribute("data-digest")
    with instructor.page.expect_download() as saved:
        instructor.page.get_by_role("button", name="save as a drill").click()
    file = tmp_path / "saved.toml"
    saved.value.save_as(file)
    drill = run_drill(str(file), PartyLink.SIMULATED)
    assert drill.run.result.digest == digest
    assert len(drill.run.result.trains_arrived) == 27
    assert drill.passed
    assert (instructor.said, dispatcher.said) == ([], [])


def test_a_page_at_1280_by_800_needs_no_scrolling_and_cuts_no_text(
    browser: Any,  # noqa: ANN401
    address: str,
) -> None:
    for seat in ("instructor", "dispatcher", "staff"):
        for language in ("en", "ja"):
            page = Seated(browser, address, seat, language).page
            size = page.evaluate("() => [document.body.scrollWidth, document.body.scrollHeight]")
            assert size[0] <= SIZE["width"] and size[1] <= SIZE["height"], (seat, language, size)
            cut = page.evaluate(
                """() => [...document.querySelectorAll('.schematic text')].filter((text) => {
                  const own = text.getBoundingClientRect(), all = text.ownerSVGElement.getBoundingClientRect();
                  return own.left < all.left - 1 || own.right > all.right + 1
                    || own.top < all.top - 1 || own.bottom > all.bottom + 1;
                }).map((text) => text.textContent)"""
            )
            assert cut == [], (seat, language)
            page.close()
