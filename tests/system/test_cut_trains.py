"""Trains ended early or left out by order, in runs of the busy line: the set goes on from where it stands, all that does
not come is told and late as stated, and the day is the same on both links.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

from onboard.notes import EndedEarly, OrderDenied
from scenario.scenario import load_scenario
from study.measures.day_figures import day_figures
from study.runner.outcome import unfinished
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute
from tests.system.test_order_of_trains import TRAINS
from wayside.said import GoesOnAs, TrainCut

pytestmark = pytest.mark.system

# A's set is to come back as B.
DAY: Final = """
[[trains]]
number = "A"
direction = "down"
begins = "stabled"
ends = "becomes:B"
calls = [
  { station = "ASA", track = "1", departure = "10:00" },
  { station = "IZU", track = "1", arrival = "10:06", departure = "10:07" },
  { station = "USU", track = "1", arrival = "10:13" },
]
[[trains]]
number = "B"
direction = "up"
begins = "from:A"
ends = "becomes:C"
calls = [
  { station = "USU", track = "1", departure = "10:22" },
  { station = "IZU", track = "2", arrival = "10:28", departure = "10:29" },
  { station = "ASA", track = "1", arrival = "10:35" },
]
[[trains]]
number = "C"
direction = "down"
begins = "from:B"
ends = "stabled"
calls = [
  { station = "ASA", track = "1", departure = "10:50" },
  { station = "IZU", track = "1", arrival = "10:56" },
]
[[diagrams]]
stock = "SA"
trains = ["A", "B", "C"]
"""
SILENT: Final = """
[[fault]]
kind = "cut"
target = "SA <-> block-manager"
start = "10:06:10"
duration_s = 960.0
"""
CUTS: Final = 'turn_back_at = ["IZU"]\n'


def day(
    folder: Path, keys: str, faults: str, link: PartyLink = PartyLink.SIMULATED, times: str = DAY
) -> FinishedRun:
    (folder / "meet.toml").write_text(TRAINS + times, encoding="utf-8")
    file = folder / "day.toml"
    head = 'extends = "busy_line"\nid = "day"\nname = "A short turn"\ntimetable = "meet.toml"\n'
    gains = "cancelled_min = 3.0\ncut_gain_min = 1.0\n"
    file.write_text(
        f"{head}[limits]\nstall_limit_s = 3600.0\n[dispatch]\ncertificate = true\n{gains}{keys}{faults}",
        encoding="utf-8",
    )
    return execute(load_scenario(str(file)), link, carrier=CarrierKind.PLAIN)


def called(run: FinishedRun, number: str) -> list[str]:
    return [s.station_id for s in run.result.stops if s.number == number and not s.cancelled]


def test_a_late_train_ends_at_the_loop_and_its_set_comes_back_from_there(tmp_path: Path) -> None:
    done = day(tmp_path, CUTS, SILENT)

        [
            e.event
            for e in done.result.journal.entries
            if isinstance(e.event, TrainCut | GoesOnAs | EndedEarly | OrderDenied)
        ]
    )

        print(s)


    assert unfinished(done.result) == ()
