"""What the report says before its modules have drawn it, and where they never do."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

OFF, LOADING, UNDRAWN = "which is switched off here", "Loading", "could not be drawn"
START = "start(document, {"
MODULE = '<script type="module">'
LATER_MS = 60_000


def told(page: Page) -> list[str]:
    """Which of the three a reader sees."""
    text = page.locator("body").inner_text()
    return [said for said in (OFF, LOADING, UNDRAWN) if said in text]


def changed(report: Path, tmp_path: Path, old: str, new: str) -> str:
    """The address of the report with a change."""
    text = report.read_text("utf-8")
    assert text.count(old) == 1
    path = tmp_path / "report.html"
    path.write_text(text.replace(old, new), "utf-8")
    return path.as_uri()


def test_while_it_loads_nothing_is_said_to_have_failed(
    browser: Browser, weekday_report: Path, tmp_path: Path
) -> None:
    """Modules that have begun and take a minute; then they draw, and nothing of it stays."""
    waits = "await new Promise((go) => { globalThis.goOn = go; });\n"
    page = browser.new_page()
    page.clock.install()
    page.goto(changed(weekday_report, tmp_path, START, waits + START))
    page.wait_for_function("globalThis.goOn !== undefined")
    page.clock.run_for(LATER_MS)
    assert told(page) == [LOADING]
    page.evaluate("goOn()")
    page.wait_for_function("globalThis.branchline !== undefined")
    assert told(page) == []
    page.close()


@pytest.mark.parametrize(
    ("old", "new", "after_ms"),
    [
        (START, "throw new Error('broken'); " + START, 0),
        ('"branchline/app.js";', '"branchline/nowhere.js";', 0),
        (MODULE, '<script type="of another time">', LATER_MS),
    ],
    ids=["fails", "module missing", "never begins"],
)
def test_what_fails_or_never_begins_is_said(
    browser: Browser, weekday_report: Path, tmp_path: Path, old: str, new: str, after_ms: int
) -> None:
    page = browser.new_page()
    page.clock.install()
    page.goto(changed(weekday_report, tmp_path, old, new), wait_until="load")
    page.clock.run_for(after_ms)
    page.wait_for_selector("#undrawn", state="visible")
    assert told(page) == [UNDRAWN]
    assert page.get_by_text("Trains arrived").is_visible()
    page.close()


def test_switched_off_is_said_only_where_it_is(browser: Browser, weekday_report: Path) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(weekday_report.as_uri())
    assert told(page) == [OFF]
    context.close()
