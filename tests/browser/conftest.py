"""A browser and reports to open in it; both are left out, with the reason, where there is no browser."""

import os
from collections.abc import Iterator
from pathlib import Path
from shutil import which
from typing import Any

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.timetable import load_timetable
from study.report.data import ReportedRun
from study.report.report import write_report
from tests.study.conftest import make_run
from tests.study.crossed_day import with_crossing
from tests.study.report.many_trains import busy_day

BROWSER = os.environ.get("BRANCHLINE_BROWSER") or which("chromium") or which("chromium-browser")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Chromium without a screen and without a graphics card."""
    library = pytest.importorskip(
        "playwright.sync_api", reason="Playwright is not installed: make browser", exc_type=ImportError
    )
    if BROWSER is None:
        pytest.skip("no Chromium on this machine: make browser")
    with library.sync_playwright() as play:
        opened = play.chromium.launch(executable_path=BROWSER, args=list(FLAGS))
        yield opened
        opened.close()


def report_of(run: ReportedRun, folder: Path) -> Path:
    """A report as a run writes it."""
    facts = {
        "scenario": "A day",
        "seed": 1,
        "violations": [{"t_s": 40_000.0, "checker": "a rule", "text": "broke"}],
    }
    return write_report(folder, run.line, run.timetable, run.tables, facts)


@pytest.fixture(scope="session")
def weekday() -> ReportedRun:
    """27 trains of a real line."""
    line = load_line(shipped_line("karasuyama"))
    timetable = load_timetable(shipped_timetable("karasuyama_weekday"), line)
    return ReportedRun(line, timetable, make_run(line, timetable))


@pytest.fixture(scope="session")
def weekday_report(weekday: ReportedRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same as a page."""
    return report_of(weekday, tmp_path_factory.mktemp("weekday"))


@pytest.fixture(scope="session")
def crossed_report(weekday: ReportedRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same with a level crossing and its road."""
    return report_of(with_crossing(weekday, vehicles=True), tmp_path_factory.mktemp("crossed"))


@pytest.fixture(scope="session")
def busy_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """500 trains."""
    return report_of(busy_day(500), tmp_path_factory.mktemp("busy"))
