"""A page at the desk in Chromium while its run goes on: what is pressed is done however long that takes, and what is
shown over a line that broke is said to be old until the line is there again.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import pytest

from console.protocol import SetPace
from scenario.scenario import Scenario
from tests.browser.seated import WAIT_MS, Seated, served_desk
from tests.console.conftest import two_trains  # noqa: F401

if TYPE_CHECKING:
    from console.aside import ServedDesk

PRESSED_MS: Final = 60_000  # what is not done until then was not pressed
BEFORE_S: Final = 36_000.0 - 120.0  # the first train leaves at ten
MIDDLE: Final = """() => {
  const at = document.querySelector('.trains tbody button').getBoundingClientRect();
  return [at.x + at.width / 2, at.y + at.height / 2];
}"""
DONE: Final = "() => document.querySelector('.answer').textContent === 'done'"
LATER: Final = "was => document.querySelector('#clock').textContent > was"


@pytest.fixture(scope="module")
def desk(two_trains: Scenario) -> Iterator[ServedDesk]:  # noqa: F811
    with served_desk(two_trains) as served:
        served.run_to(BEFORE_S)
        yield served


def goes_on(page: Any) -> None:  # noqa: ANN401
    """A second of the run is drawn."""
    page.wait_for_function(LATER, arg=page.locator("#clock").inner_text(), timeout=WAIT_MS)


def test_what_is_pressed_for_longer_than_a_picture_lasts_is_done(browser: Any, desk: ServedDesk) -> None:  # noqa: ANN401
    seated = Seated(browser, desk.page, "dispatcher", "en")
    page = seated.page
    desk.ask(SetPace(factor=1.0))
    goes_on(page)
    page.evaluate("() => document.querySelector('.trains tbody button').focus()")
    page.keyboard.down(" ")
    goes_on(page)
    page.keyboard.up(" ")
    page.wait_for_function(DONE, timeout=PRESSED_MS)
    seated.shows(".trains", "let go")
    x, y = page.evaluate(MIDDLE)
    page.mouse.move(x, y)
    page.mouse.down()
    goes_on(page)
    page.mouse.up()
    seated.shows(".trains tbody tr", "hold back")
    desk.ask(SetPace(factor=0.0))
    page.close()


def test_what_is_shown_without_a_line_is_old_and_the_page_says_when_it_is_back(
    browser: Any,  # noqa: ANN401
    desk: ServedDesk,
) -> None:
    page, open_lines, there = browser.new_page(), [], [True]

    def line(route: Any) -> None:  # noqa: ANN401
        if there[0]:
            route.connect_to_server()
            open_lines.append(route)
        else:
            route.close()

    page.route_web_socket("**/desk", line)
    page.goto(f"{desk.page}?seat=dispatcher&lang=en")
    page.wait_for_selector(".section")
    there[0] = False
    open_lines.pop().close()
    page.wait_for_selector("body.lost")
    assert "no line to the desk" in page.locator("#alarm").inner_text()
    there[0] = True
    page.wait_for_selector("body:not(.lost)", timeout=WAIT_MS)
    assert (page.locator("#alarm").inner_text(), page.locator("#alarm.on").count()) == ("", 0)
    page.close()
