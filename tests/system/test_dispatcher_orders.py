"""Orders of the dispatcher in runs of the busy line: the same on both links, and the day goes on from the track where a
train really came.
"""

from pathlib import Path
from typing import Final

import pytest

from onboard.notes import WayChanged
from scenario.scenario import load_scenario
from study.runner.outcome import unfinished
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute
from tests.system.test_order_of_trains import TRAINS
from tests.trains import day_of
from wayside.said import TrackChanged

# A is at IZU on the track to which B is to go and comes to stand; B turns back there.
STANDS: Final = day_of(
    "A down, stabled to stabled: IZU 1 -/10:20; USU 1 10:26/-",
    "B down, stabled to becomes:C: ASA 1 -/10:00; IZU 1 10:06/-",
    "C up, from:B to stabled: IZU 1 -/10:10; ASA 1 10:16/-",
    SA="A",
    SB="B C",
)


def ordered_day(folder: Path, trains: str, keys: str, link: PartyLink = PartyLink.SIMULATED) -> FinishedRun:
    """Those of `TRAINS` and more on the busy line, with more keys of `[dispatch]`, and what follows them."""
    (folder / "meet.toml").write_text(TRAINS + trains, encoding="utf-8")
    file = folder / "day.toml"
    head = 'extends = "busy_line"\nid = "day"\nname = "A day with orders"\ntimetable = "meet.toml"\n'
    file.write_text(
        f"{head}[limits]\nstall_limit_s = 3600.0\n[dispatch]\ncertificate = true\n{keys}", encoding="utf-8"
    )
    return execute(load_scenario(str(file)), link, carrier=CarrierKind.PLAIN)


def day(folder: Path, may: str, link: PartyLink = PartyLink.SIMULATED) -> FinishedRun:
    return ordered_day(folder, STANDS, f"may = [{may}]\n", link)


def stops(run: FinishedRun, number: str) -> list[tuple[str, str]]:
    return [(stop.station_id, stop.track) for stop in run.result.stops if stop.number == number]


def test_a_train_turns_back_on_the_track_to_which_it_was_ordered(tmp_path: Path) -> None:
    done = day(tmp_path, '"change_track"')
    assert unfinished(done.result) == ()
    assert stops(done, "B") == [("ASA", "1"), ("IZU", "2")]
    assert stops(done, "C") == [("IZU", "2"), ("ASA", "1")]
    left_s = next(s.departure_s for s in done.result.stops if s.number == "C")
    assert left_s is not None and left_s < 36_630.0  # 10:10, before A has left the planned track
    events = [entry.event for entry in done.result.journal.entries]
    assert [(e.unit_id, e.section_id) for e in events if isinstance(e, TrackChanged)] == [("SB", "IZU.2")]
    assert sum(isinstance(e, WayChanged) for e in events) == 1


def test_without_leave_to_do_so_it_waits(tmp_path: Path) -> None:
    waited = day(tmp_path, "")
    assert stops(waited, "B") == [("ASA", "1"), ("IZU", "1")]
    came_s = [s.arrival_s for s in waited.result.stops if s.number == "B"][-1]
    assert came_s is not None and came_s > 37_200.0  # 10:20, when A leaves


@pytest.mark.nightly
def test_orders_are_the_same_on_both_links(tmp_path: Path) -> None:
    here, apart = (
        day(tmp_path, '"change_track"', link).summary["digest"]
        for link in (PartyLink.SIMULATED, PartyLink.ZENOH)
    )
    assert here == apart
