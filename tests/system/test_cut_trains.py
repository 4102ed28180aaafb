"""Trains ended early or left out by order, in runs of the busy line: the set goes on from where it stands, all that
does not come is told and late as stated, and the day is the same on both links.
"""

from pathlib import Path
from typing import Final

import pytest

from onboard.notes import EndedEarly
from scenario.scenario import load_scenario
from simulation.judge.checkers import Checker
from study.measures.day_figures import DayFigures, day_figures
from study.runner.outcome import unfinished
from study.runner.run import FinishedRun, PartyLink
from tests.system.test_dispatcher_orders import ordered_day
from tests.trains import day_of
from wayside.said import GoesOnAs, TrainCut

# A's set is to come back as B.
DAY: Final = day_of(
    "A down, stabled to becomes:B: ASA 1 -/10:00; IZU 1 10:06/10:07; USU 1 10:13/-",
    "B up, from:A to becomes:C: USU 1 -/10:22; IZU 2 10:28/10:29; ASA 1 10:35/-",
    "C down, from:B to stabled: ASA 1 -/10:50; IZU 1 10:56/-",
    SA="A B C",
)
SILENT: Final = """
[[fault]]
kind = "cut"
target = "SA <-> block-manager"
start = "10:06:10"
duration_s = 960.0
"""
CUTS: Final = 'turn_back_at = ["IZU"]\n'


def day(folder: Path, keys: str, faults: str, link: PartyLink = PartyLink.SIMULATED) -> FinishedRun:
    return ordered_day(folder, DAY, f"cancelled_min = 3.0\ncut_gain_min = 1.0\n{keys}{faults}", link)


def called(run: FinishedRun, number: str) -> list[str]:
    return [s.station_id for s in run.result.stops if s.number == number and not s.cancelled]


def events(run: FinishedRun, *kinds: type) -> list[object]:
    return [entry.event for entry in run.result.journal.entries if isinstance(entry.event, kinds)]


def figures(run: FinishedRun, folder: Path) -> DayFigures:
    return day_figures(run.result, load_scenario(str(folder / "day.toml")).setup)


def test_a_late_train_ends_at_the_loop_and_its_set_comes_back_from_there(tmp_path: Path) -> None:
    done = day(tmp_path, CUTS, SILENT)
    assert unfinished(done.result) == ()
    assert [called(done, number) for number in "ABC"] == [["ASA", "IZU"], ["IZU", "ASA"], ["ASA", "IZU"]]
    left_s = next(s.departure_s for s in done.result.stops if s.number == "B" and not s.cancelled)
    assert left_s is not None and 37_740.0 <= left_s < 37_745.0  # 10:29, as planned from there
    (cut,) = events(done, TrainCut)
    assert isinstance(cut, TrainCut)
    assert (cut.trains, cut.next_train) == (("A", "B"), "B")
    # As it was, 15 min late at USU and 6 min at ASA; as it is, A counts for its 15 min, B for the 3 min stated.
    assert events(done, GoesOnAs) == [GoesOnAs(unit_id="SA", train="B")]
    assert events(done, EndedEarly) == [EndedEarly(train="A", station="IZU", next_train="B")]
    found = figures(done, tmp_path)
    assert (found.missing, found.cancelled, found.shortened) == ((), (), ("A", "B"))
    assert (found.planned_arrivals, found.arrivals) == (5, 3)  # A at USU and B at IZU do not come
    assert done.summary["trains_shortened"] == 2 and done.summary["trains_cancelled"] == 0


def test_a_train_that_begins_later_by_order_is_to_arrive(tmp_path: Path) -> None:
    """Its set is told to go on as B, and is silent from then on: B never leaves, C never comes."""
    for_ever = SILENT.replace("10:06:10", "10:25:00").replace("duration_s = 960.0\n", "")
    done = day(tmp_path, CUTS, SILENT + for_ever)
    assert done.result.cut == ("A",)
    late = [v.text for v in done.result.violations if v.checker == Checker.EVERYONE_ARRIVES]
    assert late == ["B has not arrived", "C has not arrived"]
    assert unfinished(done.result)[0] == "2 trains did not arrive: B, C"


def test_nothing_is_cut_unless_the_scenario_allows_it_there(tmp_path: Path) -> None:
    done = day(tmp_path, 'turn_back_at = ["USU"]\n', SILENT)
    assert called(done, "A") == ["ASA", "IZU", "USU"]
    assert events(done, TrainCut) == []


def test_a_round_trip_is_left_out_and_counts_as_late_as_stated(tmp_path: Path) -> None:
    """A and B do not run at all; nothing in the figures is better than on a day on which they are an hour late."""
    silent = SILENT.replace("10:06:10", "09:50:00").replace("960.0", "2400.0")
    done = day(tmp_path, 'cancel_trains = ["A", "B"]\n', silent)
    assert unfinished(done.result) == ()
    assert [called(done, number) for number in "ABC"] == [["ASA"], [], ["ASA", "IZU"]]
    found = figures(done, tmp_path)
    assert found.missing == () and {*found.cancelled, *found.shortened} == {"A", "B"}
    assert found.arrivals == 1 and found.planned_arrivals == 5
    late_s = {s.number: s.stated_late_s or 0.0 for s in done.result.stops if s.cancelled}
    assert late_s["A"] >= 1800.0 and late_s["B"] == 180.0  # 10:30 at the earliest, for 10:00
    assert found.secondary_s == pytest.approx(sum(late_s.values()))
    assert found.lost_train_minutes == pytest.approx(sum(late_s.values()) / 60.0, abs=0.5)


def test_the_same_on_both_links(tmp_path: Path) -> None:
    here, apart = (
        day(tmp_path, CUTS, SILENT, link).summary["digest"] for link in (PartyLink.SIMULATED, PartyLink.ZENOH)
    )
    assert here == apart
