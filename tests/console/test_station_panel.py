"""The panel that knows nothing of the program but its protocol, at a desk that is served."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from console.protocol import VERSION
from scenario.scenario import Scenario

PANEL = Path(__file__).parents[1] / "examples" / "panel" / "station_panel.py"


def test_it_holds_a_train_and_records_what_it_hears(two_trains: Scenario, tmp_path: Path) -> None:
    pytest.importorskip("uvicorn", reason="the extra [console] is not installed")
    from console.aside import served

    said = [
        f"VERSION = {VERSION}\n" in PANEL.read_text("utf-8"),
        len(PANEL.read_text("utf-8").splitlines()) < 100,
    ]
    assert said == [True, True]
    with served(two_trains) as desk:
        record = tmp_path / "panel.jsonl"
        answers = [
            subprocess.run(
                [sys.executable, str(PANEL), desk.socket, "A", "--hold", unit, "60", "--record", str(record)],
                capture_output=True,
                text=True,
                check=True,
            ).stdout
            for unit in ("K1", "K9")
        ]
    assert answers[0] == "held\n"
    assert answers[1].startswith("refused: ") and "K9" in answers[1]
    heard = [json.loads(line)["say"] for line in record.read_text("utf-8").splitlines()]
    assert heard.count("welcome") == 2 and heard.count("answer") == 2


def test_its_board_has_the_next_departures_with_how_late_they_are() -> None:
    scope: dict[str, object] = {"__name__": "panel"}
    exec(compile(PANEL.read_text("utf-8"), str(PANEL), "exec"), scope)
    welcome = {
        "stations": [{"id": "A", "at_m": 0.0}, {"id": "B", "at_m": 900.0}],
        "plan": [
            {"train": "T1", "times_s": [36_000.0, 36_090.0], "at_m": [0.0, 900.0]},
            {"train": "T2", "times_s": [37_000.0, 37_090.0], "at_m": [900.0, 0.0]},
            {"train": "T3", "times_s": [38_000.0, 38_090.0], "at_m": [0.0, 900.0]},
        ],
    }
    state = {
        "time_s": 36_100.0,
        "trains": [{"train": "T1", "late_s": 130.0}, {"train": "T2", "late_s": 30.0}],
    }
    board = scope["board"]
    assert callable(board)
    assert [row.rstrip() for row in board(welcome, state, "A")] == [
        "10:00 T1     2 min late",
        "10:18 T2",
        "10:33 T3",
    ]
