"""Substitute working in Chromium: two hours of the Karasuyama day with the block manager dead, every word of operators,
pilots and dispatcher by a click from two seats, as the page has them; what was clicked is a drill with the same digest.
"""

import re
from pathlib import Path
from typing import Any, Final

import pytest

from network.clock import clock
from scenario.scenario import load_scenario
from study.drilling.drill import find_drill, run_drill
from study.runner.run import PartyLink
from tests.browser.seated import Seated, served_desk

BEGIN_S: Final = 6 * 3600 + 44 * 60
END_S: Final = 9 * 3600 + 20 * 60
LOOKS_EVERY_S: Final = 30
SOON_MS: Final = 15_000  # nothing is computed meanwhile that takes long
NEXT: Final = ".procedure li.next button[data-step]"
ROLES: Final = {
    "dispatcher": ("dispatcher",),
    "staff": ("operator HSK", "operator OGN", "operator KRS", "pilot HSK-OGN", "pilot OGN-KRS"),
}


class AtSeat(Seated):
    """Who follows the page: takes the roles of the seat, and does what is next."""

    def take_roles(self) -> None:
        for role in ROLES[self.seat]:
            self.page.locator(f'.roles button[data-post="{role}"]').click()
            self.shows(".answer", "done")

    def sees(self, time_s: int) -> None:
        from playwright.sync_api import expect

        expect(self.page.locator("#clock")).to_have_text(clock(time_s), timeout=SOON_MS)

    def has_next(self, step: str) -> bool:
        return self.page.locator(f'{NEXT}[data-step="{step}"]').count() > 0

    def next_step(self) -> str:
        """Do what is next, if anything is: its section and name."""
        button = self.page.locator(NEXT).first
        if not button.count():
            return ""
        step = str(button.get_attribute("data-step"))
        button.click()
        return step


@pytest.mark.nightly
def test_two_hours_of_substitute_working_from_two_seats(browser: Any, tmp_path: Path) -> None:  # noqa: ANN401
    with served_desk(load_scenario(find_drill("karasuyama/95_substitute_working"))) as desk:
        seats = [AtSeat(browser, desk.page, seat, "en") for seat in ROLES]
        desk.run_to(BEGIN_S - 60)
        for seat in seats:
            seat.take_roles()
        now_s, clicked = BEGIN_S, []
        while now_s < END_S:
            desk.run_to(now_s)
            for seat in seats:
                seat.sees(now_s)
                while step := seat.next_step():
                    clicked.append(step)
                    while seat.has_next(step):  # what was clicked is on its way to the desk
                        now_s += 1
                        desk.run_to(now_s)
                        seat.sees(now_s)
            now_s += LOOKS_EVERY_S
        # Words of all three kinds, in both sections and at Ogane itself.
        assert {"OGN-KRS order", "OGN-KRS ask", "HSK-OGN arrived", "OGN-KRS board", "HSK-OGN release"} <= {
            *clicked
        }
        desk.run_to(27 * 3600)
        seats[0].page.get_by_role("button", name="protocol").click()
        seats[0].shows("#score", "trains arrived: 27/27")
        score = seats[0].page.locator("#score").inner_text()
        assert re.search(r"steps left out, out of order or refused\s+none", score)
        assert re.search(r"rules broken\s+none", score)
        seats[0].page.get_by_role("button", name="close").click()
        digest = seats[1].page.locator("main").get_attribute("data-digest")
        with seats[1].page.expect_download() as saved:
            seats[1].page.get_by_role("button", name="save as a drill").click()
        file = tmp_path / "saved.toml"
        saved.value.save_as(file)
        assert [seat.said for seat in seats] == [[], []]
    drill = run_drill(str(file), PartyLink.SIMULATED)
    assert drill.run.result.digest == digest
    assert drill.run.result.violations == () and drill.passed


def test_a_step_left_out_and_one_too_early_are_shown_and_counted_in_japanese(browser: Any) -> None:  # noqa: ANN401
    with served_desk(load_scenario(find_drill("rtri/95_substitute_working"))) as desk:
        staff = Seated(browser, desk.page, "staff", "ja")
        staff.page.locator('.roles button[data-post="operator A"]').click()
        staff.shows(".answer", "実行済み")
        desk.run_to(10 * 3600 + 60)
        book = staff.page.locator('.book[data-block="6"]')
        book.locator("summary").click()
        book.locator('[data-step="6 clear"]').click()
        desk.run_to(10 * 3600 + 180)
        staff.shows(".log", "順序によらず実施")
        book.get_by_label("6 転てつ器の手回しと鎖錠: 省略").click()
        staff.shows(".answer", "実行済み")
        desk.run_to(10 * 3600 + 181)
        staff.shows(".log", "はできない")  # no train is in the book yet
        instructor = Seated(browser, desk.page, "instructor", "ja")  # the only one, while the run goes on
        instructor.page.get_by_role("button", name="記録と評価").click()
        instructor.shows("#score", "省略・順序違い・不能の手順")
        assert staff.said == instructor.said == []
