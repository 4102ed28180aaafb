"""What the journal says of a unit: which train it is, and whether its brake is an emergency's."""

from typing import Final

import pytest

from onboard import notes
from onboard.crossing_notes import CrossingAsked
from radio.noted import Noted
from scenario.scenario import load_scenario
from simulation.events import WORLD, JournalEntry, Left, PowerOff, PowerOn
from simulation.world.roster import drawn_up
from study.drilling.drill import find_drill
from study.measures.wait_view import DutyStage, StockView, subject_of

UNIT: Final = "V3"


@pytest.fixture
def view() -> StockView:
    """Of a set that comes by the portal as 323M, turns, leaves as 326M, and comes again as 331M."""
    setup = load_scenario("karasuyama_weekday").setup
    return StockView(UNIT, drawn_up(setup, setup.line)[UNIT], 20.0, setup.line, setup.lengths_m[UNIT])


def took(view: StockView, t_s: float, *events: Noted) -> None:
    for event in events:
        entry = JournalEntry(t_s, WORLD if isinstance(event, PowerOff | PowerOn | Left) else UNIT, event)
        assert subject_of(entry) == UNIT
        view.take(entry)


def test_who_has_booted_outside_comes_in_without_an_emergency(view: StockView) -> None:
    """It is braked from its boot on, where it restarts on the line alone; there its crew releases it."""
    begun = notes.MissionBegun(train="323M", direction="down")
    took(view, 0.0, PowerOff(device_id=UNIT), PowerOn(device_id=UNIT), begun)
    assert not view.emergency
    took(view, 100.0, PowerOff(device_id=UNIT), PowerOn(device_id=UNIT), begun, notes.UnitRestarted(epoch=3))
    assert view.emergency
    took(view, 200.0, notes.EmergencyReleased())
    assert not view.emergency


def test_who_resumes_runs_if_it_had_departed(view: StockView) -> None:
    resumed = notes.Resumed(next_target=1)
    took(view, 0.0, notes.MissionBegun(train="323M", direction="down"), resumed)
    assert view.doing is DutyStage.STANDING
    took(view, 100.0, notes.Departs(station="HSK"), resumed)
    assert view.doing is DutyStage.RUNNING


def test_who_restarts_waits_for_no_level_crossing_that_it_has_not_asked_since() -> None:
    view = of_drill("rtri/100_crossing", "K1")
    asked = CrossingAsked(crossing_id="C1", arrives_s=60.0)
    for entry in told(view, notes.MissionBegun(train="T1", direction="down"), asked):
        view.take(entry)
    here = (view.line.crossings["C1"].piece_id, 0.0)
    assert view.crossing_ahead(here, 2.0)[0] == "C1"
    view.take(JournalEntry(3.0, view.unit, notes.UnitRestarted(epoch=2)))
    assert view.crossing_ahead(here, 4.0)[0] == ""


def test_who_was_driven_off_the_line_by_hand_is_to_come_as_its_next_train(view: StockView) -> None:
    """The unit that is cut out says nothing of the train as which it leaves."""
    took(view, 0.0, notes.MissionBegun(train="323M", direction="down"), notes.MissionDone(train="323M"))
    assert (view.doing, view.next_duty) == (DutyStage.FINISHED, view.duties[1])
    took(view, 100.0, notes.MissionDone(train="326M"))
    assert (view.doing, view.train) == (DutyStage.SIGNING_OFF, "326M")
    assert view.next_duty is not None and view.next_duty.train.number == "331M"


def test_who_was_hauled_away_does_nothing_more_of_its_train(view: StockView) -> None:
    """Its unit has had no power since it ran in, and says nothing of it."""
    took(
        view, 0.0, notes.MissionBegun(train="323M", direction="down"), notes.SignedOn(section_ids=("HSK.P",))
    )
    took(view, 100.0, PowerOff(device_id=UNIT), Left(unit_id=UNIT))
    assert (view.doing, view.signed_on) == (DutyStage.GONE, False)
    assert view.next_duty is not None and view.next_duty.train.number == "326M"


def of_drill(name: str, unit: str) -> StockView:
    setup = load_scenario(find_drill(name)).setup
    return StockView(unit, drawn_up(setup, setup.line)[unit], 20.0, setup.line, setup.lengths_m[unit])


def told(view: StockView, *events: Noted) -> list[JournalEntry]:
    return [JournalEntry(float(k), view.unit, event) for k, event in enumerate(events)]


def test_who_goes_to_another_track_by_order_has_that_way_ahead_and_none_of_the_old_one() -> None:
    view = of_drill("rtri/90_other_track", "K2")
    begun = notes.MissionBegun(train="T3", direction="down")
    in_a = notes.WayChanged(route_id="PW>3", instead="PW>4")
    for entry in told(view, begun, in_a, notes.WayChanged(route_id="4>8", instead="4>9")):
        view.take(entry)
        assert view.duty in view.duties
    assert view.duty is not None
    ways = [route.id for route in view.duty.mission.routes]
    assert "4>9" in ways and "9>PE" in ways and "4>8" not in ways and "8>PE" not in ways


def test_who_goes_on_as_another_train_has_the_trains_between_no_more() -> None:
    view = of_drill("rtri/93_left_out", "K1")
    assert [duty.train.number for duty in view.duties] == ["T1", "T2", "T3"]
    begun = notes.MissionBegun(train="T1", direction="down")
    ended = notes.EndedEarly(train="T1", station="A", next_train="T3")
    after = view.duties_after(told(view, begun, ended))
    assert [(duty.train.number, duty.becomes) for duty in after] == [("T1", "T3"), ("T3", None)]
    assert [call.station_id for call in after[0].train.calls] == ["A"]
