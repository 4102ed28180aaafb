"""Draws every page of the desk, in both languages and at both sizes: `python -m documents.desk_pictures FOLDER`.

They are for whoever changes the pages: look at them. The repository has `desk.png` of them, for docs/desk.md.
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from shutil import copyfile, which
from typing import Any, Final

from console.aside import ServedDesk, served
from console.protocol import DoAct, Fail, SayToSeat
from scenario.scenario import load_scenario

DOCS: Final = Path(__file__).resolve().parents[1] / "docs"
IMAGE: Final = DOCS / "images" / "desk.png"
CROSSED: Final = DOCS / "studies" / "level_crossings" / "by_tags.toml"  # the same line with level crossings
SHIPPED: Final = "dispatcher_en_1280.png"
SEATS: Final = ("instructor", "dispatcher", "staff", "driver")
SIZES: Final = ((1280, 800), (1920, 1080))
AT_S: Final = 7 * 3600 + 8 * 60.0
CROSSED_S: Final = AT_S + 200.0  # a train comes to crossings
FLAGS: Final = ("--headless", "--no-sandbox", "--disable-gpu")


def draw(folder: Path) -> list[Path]:
    """All pages of the Karasuyama weekday at 7:08, the choice of seats, and pages with level crossings; their files."""
    library = import_module("playwright.sync_api")
    folder.mkdir(parents=True, exist_ok=True)
    browser_file = which("chromium") or which("chromium-browser")
    drawn: list[Path] = []
    with library.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=browser_file, args=list(FLAGS))
        with served(load_scenario("karasuyama_weekday")) as desk:
            _with_a_fault(desk)
            drawn += _pages(browser, desk, ("", *SEATS), folder, "")
        with served(load_scenario(str(CROSSED))) as desk:
            _with_crossings_broken(desk)
            drawn += _pages(browser, desk, SEATS, folder, "_crossings")
        browser.close()
    return drawn


def _pages(browser: Any, desk: ServedDesk, seats: tuple[str, ...], folder: Path, what: str) -> list[Path]:  # noqa: ANN401
    """These seats' pages in both languages and at both sizes."""
    drawn: list[Path] = []
    for width, height in SIZES:
        for language in ("en", "ja"):
            for seat in seats:
                page = browser.new_page(viewport={"width": width, "height": height})
                unit = "&unit=V2" if seat == "driver" else ""
                page.goto(f"{desk.page}?lang={language}{unit}" + (f"&seat={seat}" if seat else ""))
                page.wait_for_selector("#clock" if seat else ".seats a")
                page.wait_for_timeout(300)
                drawn.append(folder / f"{seat or 'choice'}{what}_{language}_{width}.png")
                page.screenshot(path=drawn[-1])
                page.close()
    return drawn


def _with_a_fault(desk: ServedDesk) -> None:
    """Run to where a fault is in force and a message has been said."""
    desk.run_to(AT_S)
    desk.ask(Fail(fault={"kind": "power_off", "target": "OGN-E"}))
    desk.ask(SayToSeat(text="OGN-E"))
    desk.run_to(AT_S + 5.0)


def _with_crossings_broken(desk: ServedDesk) -> None:
    """Run to where one crossing has no power, another is guarded since its barriers are stuck, and trains come."""
    desk.run_to(AT_S)
    desk.ask(Fail(fault={"kind": "power_off", "target": "X07"}))
    desk.ask(Fail(fault={"kind": "barriers_stuck", "target": "X09"}))
    desk.ask(DoAct(act={"kind": "guard_road", "target": "X09", "person": "staff"}))
    desk.run_to(CROSSED_S)


if __name__ == "__main__":
    pictures = draw(Path(sys.argv[1]))
    copyfile(next(picture for picture in pictures if picture.name == SHIPPED), IMAGE)
