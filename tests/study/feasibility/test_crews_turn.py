"""Crews' least turn: a set's next train begins no sooner, as `check` says, `arrange` plans and a run does."""

from pathlib import Path

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import parse_toml, read_text
from network.timetable import timetable_of
from onboard.notes import Arrived, MissionBegun, MissionDone
from plan.arranging.draft import printed_calls, trains_to_arrange
from plan.arranging.line_times import line_times
from scenario.scenario import Scenario, load_scenario
from study.feasibility.check import feasibility
from study.feasibility.finding import FindingKind
from tests.plain import run_on_plain
from vehicle.train_file import load_train, train_named

# T1 is to arrive at B at 10:02:00, and its set leaves as T2 at 10:05:00; the points beyond take 6 s.
PLANNED_S, THROWS_S = 180.0, 6.0
DAY = """extends = "rtri_test_line"
id = "turn"
name = "Crews turn"
timetable = "rtri_turn_back"
patch.timetable.set = { "timetable.turn_min_s" = TURN }
"""


def _day(tmp_path: Path, turn_s: float) -> Scenario:
    path = tmp_path / "turn.toml"
    path.write_text(DAY.replace("TURN", str(turn_s)), "utf-8")
    return load_scenario(str(path))


@pytest.mark.parametrize(
    ("turn_s", "short_s"), [(0.0, None), (150.0, None), (240.0, 240.0 + THROWS_S - PLANNED_S)]
)
def test_check_names_a_turn_that_is_too_short(tmp_path: Path, turn_s: float, short_s: float | None) -> None:
    found = [f for f in feasibility(_day(tmp_path, turn_s).setup).findings if f.kind is FindingKind.TURN_BACK]
    assert [f.short_s for f in found] == ([] if short_s is None else [short_s])


def test_arrange_leaves_crews_their_time() -> None:
    line = load_line(shipped_line("rtri_test_line"))
    path = shipped_timetable("rtri_turn_back")
    file = parse_toml(read_text(path), str(path), TimetableFile)
    turns_s = []
    for turn_s in (0.0, 240.0):
        head = file.timetable.model_copy(update={"turn_min_s": turn_s})
        own = file.model_copy(update={"timetable": head})
        timetable = timetable_of(own, str(path), line)
        times = line_times(line, load_train(train_named("ev_e301")), 20.0)
        trains = trains_to_arrange(line, timetable, printed_calls(own, timetable), times)
        turns_s += [train.turn_s for train in trains if train.follows is not None]
    assert turns_s[1] - turns_s[0] == 240 - 60  # instead of the minute in which a driver changes ends


def test_a_run_begins_the_next_train_no_sooner(tmp_path: Path) -> None:
    finished = run_on_plain(_day(tmp_path, 240.0))
    entries = finished.result.journal.entries
    done_s = next(e.t_s for e in entries if isinstance(e.event, MissionDone))
    begun_s = next(e.t_s for e in entries if isinstance(e.event, MissionBegun) and e.event.train == "T2")
    arrived_s = next(e.t_s for e in entries if isinstance(e.event, Arrived))
    assert begun_s - done_s == pytest.approx(240.0, abs=0.11)
    assert done_s >= arrived_s
