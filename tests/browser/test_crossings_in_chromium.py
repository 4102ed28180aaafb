"""Level crossings in the report: a paper of their own where the line has some, and none where it has not."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tests.browser.test_report_in_chromium import opened, picture

if TYPE_CHECKING:
    from playwright.sync_api import Browser


def test_crossings_have_a_paper_with_the_road_beside_them(browser: Browser, crossed_report: Path) -> None:
    with opened(browser, crossed_report) as page:
        picture(page, "crossings-graph")
        page.click("#tab-crossings")
        picture(page, "crossings")
        cells = page.locator("#table-crossings tbody tr").first.locator("td").all_inner_texts()
        assert cells[:3] == ["Mill lane", "4.0", "3"]
        headings = page.locator("#table-crossings th").all_inner_texts()
        assert any("waiting time of the road" in heading for heading in headings)
        page.click("#language")
        assert page.locator("#tab-crossings").inner_text() == "踏切"


def test_a_line_without_crossings_has_no_such_paper(browser: Browser, weekday_report: Path) -> None:
    with opened(browser, weekday_report) as page:
        assert page.locator("#tab-crossings").count() == 0
