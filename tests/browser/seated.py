"""A desk that is served, and a page at one of its seats in Chromium."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from importlib.resources import files
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final

import pytest

from scenario.scenario import Scenario
from study.record.read_back import RunRead

if TYPE_CHECKING:
    from console.aside import ServedDesk

WAIT_MS: Final = 500_000
SIZE: Final = {"width": 1280, "height": 800}
SERIOUS: Final = ("serious", "critical")


@contextmanager
def served_desk(what: Scenario | RunRead, beside: RunRead | None = None) -> Generator[ServedDesk]:
    """A desk, served."""
    pytest.importorskip("uvicorn", reason="the extra [console] is not installed")
    from console.aside import served as served_aside

    with served_aside(what, beside) as desk:
        yield desk


@contextmanager
def served(what: Scenario | RunRead, beside: RunRead | None = None) -> Generator[str]:
    """A desk, served: its address."""
    with served_desk(what, beside) as desk:
        yield desk.page


def serious(page: Any) -> list[tuple[str, str, list[str]]]:  # noqa: ANN401
    """What axe finds serious on a page, whose content policy must let it in; skipped where the package is missing."""
    if find_spec("axe_playwright_python") is None:
        pytest.skip("axe-playwright-python, which brings axe, is not installed: make browser")
    page.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8"))
    found = page.evaluate("() => axe.run()")
    return [
        (one["id"], one["help"], [node["html"][:150] for node in one["nodes"]][:3])
        for one in found["violations"]
        if one["impact"] in SERIOUS
    ]


def overlapping(page: Any) -> Any:  # noqa: ANN401
    """Texts of the line that lie over each other, or under what leads down from the name of a station."""
    return page.evaluate(
        """() => {
          const texts = [...document.querySelectorAll('.schematic text')]
            .map((text) => [text.textContent, text.getBoundingClientRect()]);
          const over = (a, b, wide) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > wide
            && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3;
          const leads = [...document.querySelectorAll('.schematic .lead')].map((lead) => lead.getBoundingClientRect());
          return texts.flatMap(([one, a], i) => [
            ...texts.slice(i + 1).filter(([, b]) => over(a, b, 1)).map(([other]) => `${one} | ${other}`),
            ...leads.filter((lead) => over(a, lead, -1)).map(() => `${one} | a lead`)]);
        }"""
    )


def cut_off(page: Any) -> Any:  # noqa: ANN401
    """Texts of the line, and signs of its crossings, that reach beyond its picture."""
    return page.evaluate(
        """() => [...document.querySelectorAll('.schematic text, .schematic .crossing')].filter((text) => {
          const own = text.getBoundingClientRect(), all = text.closest('svg').getBoundingClientRect();
          return own.left < all.left - 1 || own.right > all.right + 1
            || own.top < all.top - 1 || own.bottom > all.bottom + 1;
        }).map((text) => text.textContent)"""
    )


class Seated:
    """A page at a seat."""

    def __init__(self, browser: Any, address: str, seat: str, language: str) -> None:  # noqa: ANN401
        self.seat = seat
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
