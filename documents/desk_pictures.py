"""Draws every page of the desk, in both languages and at both sizes: `python -m documents.desk_pictures FOLDER`.

They are for whoever changes the pages: look at them. The repository has `desk.png` of them, for docs/desk.md.
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from shutil import copyfile, which
from typing import Final

from console.aside import ServedDesk, served
from console.protocol import Fail, SayToSeat
from scenario.scenario import load_scenario

IMAGE: Final = Path(__file__).resolve().parents[1] / "docs" / "images" / "desk.png"
SHIPPED: Final = "dispatcher_en_1280.png"
SEATS: Final = ("instructor", "dispatcher", "staff", "driver")
SIZES: Final = ((1280, 800), (1920, 1080))
AT_S: Final = 7 * 3600 + 8 * 60.0
FLAGS: Final = ("--headless", "--no-sandbox", "--disable-gpu")


def draw(folder: Path) -> list[Path]:
    """All pages of the Karasuyama weekday at 7:08, and the choice of seats; their files."""
    library = import_module("playwright.sync_api")
    folder.mkdir(parents=True, exist_ok=True)
    browser_file = which("chromium") or which("chromium-browser")
    drawn: list[Path] = []
    with served(load_scenario("karasuyama_weekday")) as desk, library.sync_playwright() as play:
        _with_a_fault(desk)
        browser = play.chromium.launch(executable_path=browser_file, args=list(FLAGS))
        for width, height in SIZES:
            for language in ("en", "ja"):
                for seat in ("", *SEATS):
                    page = browser.new_page(viewport={"width": width, "height": height})
                    unit = "&unit=V2" if seat == "driver" else ""
                    page.goto(f"{desk.page}?lang={language}{unit}" + (f"&seat={seat}" if seat else ""))
                    page.wait_for_selector("#clock" if seat else ".seats a")
                    page.wait_for_timeout(300)
                    drawn.append(folder / f"{seat or 'choice'}_{language}_{width}.png")
                    page.screenshot(path=drawn[-1])
                    page.close()
        browser.close()
    return drawn


def _with_a_fault(desk: ServedDesk) -> None:
    """Run to where a fault is in force and a message has been said."""
    desk.run_to(AT_S)
    desk.ask(Fail(fault={"kind": "power_off", "target": "OGN-E"}))
    desk.ask(SayToSeat(text="OGN-E"))
    desk.run_to(AT_S + 5.0)


if __name__ == "__main__":
    pictures = draw(Path(sys.argv[1]))
    copyfile(next(picture for picture in pictures if picture.name == SHIPPED), IMAGE)
