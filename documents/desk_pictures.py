"""Draws every page of the desk, in both languages and at both sizes: `python -m documents.desk_pictures FOLDER`.

They are for whoever changes the pages: look at them. The repository has `desk.png` of them, for docs/desk.md.
"""

from __future__ import annotations

import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from shutil import copyfile, which
from threading import Event, Thread
from typing import Any, Final

from console.access import LOOPBACK, on_loopback
from console.live import LiveDesk
from console.protocol import DeskAnswer, Fail, RunTo, SayToSeat
from console.seats import Seat
from console.server import DeskServer, listening_on
from scenario.scenario import load_scenario

IMAGE: Final = Path(__file__).resolve().parents[1] / "docs" / "images" / "desk.png"
SHIPPED: Final = "dispatcher_en_1280.png"
SEATS: Final = ("instructor", "dispatcher", "staff", "driver")
SIZES: Final = ((1280, 800), (1920, 1080))
AT_S: Final = 7 * 3600 + 8 * 60.0
FLAGS: Final = ("--headless", "--no-sandbox", "--disable-gpu")


def draw(folder: Path) -> list[Path]:
    """All pages of the Karasuyama weekday at 7:08, and the choice of seats; their files."""
    from playwright.sync_api import sync_playwright

    folder.mkdir(parents=True, exist_ok=True)
    browser_file = which("chromium") or which("chromium-browser")
    drawn: list[Path] = []
    with _desk() as address, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=browser_file, args=list(FLAGS))
        for width, height in SIZES:
            for language in ("en", "ja"):
                for seat in ("", *SEATS):
                    page = browser.new_page(viewport={"width": width, "height": height})
                    unit = "&unit=V2" if seat == "driver" else ""
                    page.goto(f"{address}?lang={language}{unit}" + (f"&seat={seat}" if seat else ""))
                    page.wait_for_selector("#clock" if seat else ".seats a")
                    page.wait_for_timeout(300)
                    drawn.append(folder / f"{seat or 'choice'}_{language}_{width}.png")
                    page.screenshot(path=drawn[-1])
                    page.close()
        browser.close()
    return drawn


@contextmanager
def _desk() -> Generator[str]:
    """A desk that stands, with a fault in force and a train that is driven by hand."""
    import uvicorn

    changed = Event()
    with listening_on(LOOPBACK, 0) as bound:
        port = bound.getsockname()[1]
        server = DeskServer(on_loopback(port))

        def note() -> None:
            changed.set()
            server.changed()

        live = LiveDesk(load_scenario("karasuyama_weekday"), note)
        live.start()
        server.desk = live
        _ask(live, RunTo(time_s=AT_S))
        while live.moment.known.time_s < AT_S:
            changed.clear()
            changed.wait(60.0)
        _ask(live, Fail(fault={"kind": "power_off", "target": "OGN-E"}))
        _ask(live, SayToSeat(text="OGN-E"))
        _ask(live, RunTo(time_s=AT_S + 5.0))
        web = uvicorn.Server(uvicorn.Config(server.app, log_level="error", ws="websockets-sansio"))
        thread = Thread(target=web.run, kwargs={"sockets": [bound]})
        thread.start()
        try:
            yield f"http://{LOOPBACK}:{port}/"
        finally:
            web.should_exit = True
            thread.join()
            live.stop()


def _ask(live: LiveDesk, request: Any) -> None:  # noqa: ANN401 - any request of the protocol
    done = Event()

    def take(_: DeskAnswer) -> None:
        done.set()

    live.ask(Seat.INSTRUCTOR, request, take)
    done.wait(60.0)


if __name__ == "__main__":
    pictures = draw(Path(sys.argv[1]))
    copyfile(next(picture for picture in pictures if picture.name == SHIPPED), IMAGE)
