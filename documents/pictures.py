"""Draws the pictures of README.md and docs/researcher.md: `python -m documents.pictures`.

It runs a weekday and a reproduction, three minutes.

What a picture shows follows from the scenario and its seed; the bytes also from the versions of the libraries that draw
it, so `make check` does not compare them.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from shutil import copyfile
from typing import Final

from papers.reproduction import Options
from papers.specification import reproduction
from scenario.scenario import load_scenario
from study.report.data import ReportedRun as Shown
from study.report.graph import draw_train_graph
from study.report.style import drawing
from study.runner.run import PartyLink, execute

FOLDER: Final = Path(__file__).resolve().parents[1] / "docs" / "images"
DPI: Final = 110
WINDOW: Final = "stop_window.png"


def train_graph(file: Path) -> None:
    """The weekday of the Karasuyama line, planned and run."""
    scenario = load_scenario("karasuyama_weekday")
    with drawing():
        figure, _ = draw_train_graph(
            Shown(
                scenario.setup.line, scenario.setup.timetable, execute(scenario, PartyLink.SIMULATED).tables
            )
        )
        figure.savefig(file, dpi=DPI, metadata={"Software": None})


def stop_window(file: Path) -> None:
    """From where every brake of a stated range stops in the window."""
    with tempfile.TemporaryDirectory() as folder:
        reproduction("stop-window")(Options(out=folder))
        copyfile(Path(folder) / WINDOW, file)


def main() -> None:
    """Draw both."""
    train_graph(FOLDER / "train_graph.png")
    stop_window(FOLDER / WINDOW)


if __name__ == "__main__":
    main()
