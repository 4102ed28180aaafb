"""Coming onto the line and leaving it: by what is accepted and what truly stands there; and a cab without power."""

from dataclasses import replace
from heapq import heapify
from types import SimpleNamespace
from typing import Any

import pytest

from host.units import LocalUnits
from network.model import Direction
from network.timetable import AtPortal, Call, Diagram, Stabled, Timetable, TimetableTrain
from onboard.duty.records import DutyPhase, EntryAllowed, Finished, LeftLine, SwitchedOn, WheelsTurning
from simulation.agenda import Agenda, AgendaKind
from simulation.cabs import Cabs
from simulation.carriers.plain_track import PlainTrack
from simulation.duties import RETRY_STEPS, Duties, StockStage
from simulation.events import Entered, Left, PowerOff, PowerOn
from simulation.journal import Journal
from simulation.people import Pause, People
from simulation.scatter import ScatterSettings, Weather
from simulation.setup import STEP_S, STEPS_PER_S, Setup, unit_configs
from simulation.world.books import Books
from simulation.world.on_board import OnBoard
from simulation.world.roster import draw_up
from simulation.world.signs import Signs
from simulation.world.trains import Trains
from wayside.said import BoundaryPassed

ENTER_S, LEAD_S = 36_000.0, 210.0
AT_ONCE = People(times=0.0)
AT = round((ENTER_S - LEAD_S) * STEPS_PER_S)


def same_times(setup: Setup, people: People, count: int) -> Setup:
    """K1, K2 ... come in by the western portal at the same time, so that each finds the one before it there."""
    calls = (Call("A", "1", None, round(ENTER_S)), Call("B", "1", round(ENTER_S) + 120, None))
    trains = {
        number: TimetableTrain(number, Direction.DOWN, True, calls, AtPortal("PW"), Stabled())
        for number in (f"T{i}" for i in range(1, count + 1))
    }
    diagrams = tuple(Diagram(f"K{i}", (f"T{i}",)) for i in range(1, count + 1))
    timetable = Timetable(setup.timetable.head, trains, diagrams)
    kind = setup.trains["K1"]
    kinds = {diagram.stock_id: kind for diagram in diagrams}
    return Setup("two", setup.line, timetable, kinds, people=people)


class Yard:
    """Trains outside the western portal; the wayside hears them and says nothing."""

    def __init__(self, setup: Setup, people: People = AT_ONCE, count: int = 2) -> None:
        setup = same_times(setup, people, count)
        lengths_m = {p.id: round(p.length_m, 6) for p in setup.line.pieces.values()}
        self.agenda, self.journal = Agenda(), Journal()
        self.trains = Trains(setup, PlainTrack(lengths_m, STEP_S))
        self.units = LocalUnits(unit_configs(setup, b"k" * 32))
        self.on_board = OnBoard(setup, self.trains, self.units)
        self.sent: list[tuple[str, str]] = []
        self.inputs: list[Any] = []
        wayside: Any = SimpleNamespace(
            uncommissioned=set(),
            machines={},
            crossings=SimpleNamespace(on_line=(), guarded=frozenset[str]()),
            transmit=lambda _step, source, destination, _data: self.sent.append((source, destination)),
            input=lambda _step, _device, value: self.inputs.append(value),
        )
        checkers: Any = SimpleNamespace(
            entered=lambda *_: None,
            train_left=lambda *_: None,
            observe=lambda *_: None,
            reversed=lambda *_: None,
        )
        self.books = Books(self.trains)
        lengths = dict.fromkeys(self.trains.stock_ids, 40.0)
        world: Any = SimpleNamespace(
            setup=setup,
            drawn=draw_up(setup.line, setup.timetable, lengths, LEAD_S),
            journal=self.journal,
            agenda=self.agenda,
            trains=self.trains,
            wayside=wayside,
            books=self.books,
            charging=None,
            on_board=self.on_board,
            signs=Signs(self.trains, self.books.next_target),
        )
        self.cabs = Cabs(world)
        self.duties: Duties = Duties(world, self.cabs, checkers)
        self.duties.open(AT - 10)

    def stage(self, slot: int) -> StockStage:
        return self.duties._stage[slot]

    def next_duty(self) -> int:
        """Step at which the next stock takes up its duty."""
        while (item := self.agenda.pop_due(10**9)) is not None:
            if item.kind is AgendaKind.DUTY:
                return item.step
        raise AssertionError("no duty is due")

    def accept(self, slot: int, step: int) -> None:
        self.duties.unit_tells(slot, EntryAllowed("T1"), step)

    def boot(self, slot: int, off: int, on: int) -> None:
        """Its unit is off between these steps."""
        self.cabs.power_off(slot, off)
        assert self.cabs.power_on(slot, on)
        self.duties.powered_on(slot, on)

    def crews_to(self, step: int) -> None:
        """Have crews do what is due by a step; nothing else goes on."""
        due = sorted(item for item in self.agenda._heap if item.kind is AgendaKind.CREW and item.step <= step)
        self.agenda._heap = [item for item in self.agenda._heap if item not in due]
        heapify(self.agenda._heap)
        for item in due:
            pause, stock_id = item.subject.split(" ")
            self.duties.crew_due(Pause(pause), self.trains.slot_of[stock_id], item.step)


@pytest.fixture
def yard(rtri_setup: Setup) -> Yard:
    return Yard(rtri_setup)


def test_stock_outside_is_confirmed_and_comes_when_it_is_time(yard: Yard) -> None:
    assert [(entry.unit_id, entry.person) for entry in yard.inputs] == [
        ("K1", "controller"),
        ("K2", "controller"),
    ]
    assert yard.next_duty() == AT


def test_a_stock_waits_outside_until_it_is_accepted(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    assert yard.stage(0) is StockStage.WAITING
    assert yard.trains.active() == []
    assert ("K1", "block-manager") in yard.sent  # its unit signs on all the same
    yard.accept(0, AT + 5)
    assert yard.stage(0) is StockStage.ON_LINE
    assert yard.trains.active() == [0]
    assert any(isinstance(entry.event, Entered) for entry in yard.journal.entries)


@pytest.mark.parametrize(("late_s", "least", "most"), [(0.0, 1.0, 1.0), (300.0, 0.3, 0.4)])
def test_a_late_train_begins_in_the_weather_of_its_own_hour(
    yard: Yard, late_s: float, least: float, most: float
) -> None:
    """It rains from a minute after it should have come; its driver reckons with the rain (`adhesion_least`)."""
    rain = {"from": "09:57:30", "to": "24:00", "adhesion_low": 0.3, "adhesion_high": 0.4}
    scatter = ScatterSettings(weather=(Weather.model_validate(rain),))
    yard.trains.setup = replace(yard.trains.setup, scatter=scatter)
    yard.duties.take_up(0, AT)
    yard.accept(0, AT + round(late_s * STEPS_PER_S))
    assert least <= float(yard.trains.plants[0].adhesion_factor) <= most


def test_a_stock_that_is_accepted_waits_until_nothing_truly_stands_there(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    yard.accept(0, AT)
    yard.duties.take_up(1, AT)
    yard.accept(1, AT)
    assert yard.trains.active() == [0]
    assert yard.stage(1) is StockStage.WAITING
    again = AT + RETRY_STEPS
    assert again in [item.step for item in yard.agenda._heap if item.kind is AgendaKind.DUTY]
    yard.duties.take_up(1, again)
    assert yard.trains.active() == [0]
    yard.trains.remove(0)
    yard.duties.take_up(1, again + 100)
    assert yard.trains.active() == [1]


@pytest.mark.parametrize("boots", [False, True])
def test_a_unit_that_dies_before_a_portal_that_is_taken_comes_in_once_it_is_accepted_again(
    yard: Yard, boots: bool
) -> None:
    for slot in (0, 1):
        yard.duties.take_up(slot, AT)
        yard.accept(slot, AT)
    again = AT + RETRY_STEPS
    yard.cabs.power_off(1, AT + 10)
    if boots:
        yard.duties.power_on(1, AT + 20)
    yard.trains.remove(0)
    yard.duties.take_up(1, again)
    assert yard.trains.active() == []
    if not boots:
        yard.duties.power_on(1, again + 10)
    yard.accept(1, again + 20)
    assert yard.trains.active() == [1]


def test_who_has_come_in_since_does_not_look_at_its_portal_again(yard: Yard) -> None:
    for slot in (0, 1):
        yard.duties.take_up(slot, AT)
        yard.accept(slot, AT)
    yard.trains.remove(0)
    yard.accept(1, AT + 20)
    yard.duties.take_up(1, AT + RETRY_STEPS)
    assert yard.trains.active() == [1]
    assert yard.stage(1) is StockStage.ON_LINE


def test_stock_queues_before_its_portal(yard: Yard) -> None:
    """Outside, one stands behind the other: the second does not sign on before the first has entered."""
    yard.duties.take_up(0, AT)
    sent = len(yard.sent)
    yard.duties.take_up(1, AT + 1)
    assert yard.stage(1) is StockStage.OUTSIDE
    assert len(yard.sent) == sent
    yard.accept(0, AT + 2)
    yard.duties.take_up(1, AT + 3)
    assert yard.stage(1) is StockStage.WAITING


def test_who_comes_to_a_portal_later_stays_behind(rtri_setup: Setup) -> None:
    """Found by swarm 93: whoever looked first once the portal was free came in, and trains of one track were in the
    wrong order on the line.
    """
    yard = Yard(rtri_setup, count=3)
    for slot in range(3):
        yard.duties.take_up(slot, AT + slot)
    yard.accept(0, AT + 3)
    yard.duties.take_up(2, AT + 4)
    assert yard.stage(2) is StockStage.OUTSIDE
    yard.duties.take_up(1, AT + 5)
    assert yard.stage(1) is StockStage.WAITING


def test_what_a_unit_believes_opens_no_portal(yard: Yard) -> None:
    """K1's unit says that it is far away; its train stands in the portal all the same."""
    yard.duties.take_up(0, AT)
    yard.accept(0, AT)
    yard.duties.take_up(1, AT)
    yard.trains.units[0].position_m = 500.0
    yard.accept(1, AT)
    assert yard.trains.active() == [0]


def test_a_unit_that_dies_while_waiting_signs_on_again(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    yard.cabs.power_off(0, AT + 10)
    sent = len(yard.sent)
    yard.cabs.timer(0, AT + 20)
    assert len(yard.sent) == sent
    assert yard.cabs.power_on(0, AT + 30)
    assert yard.units._running["K1"].state.phase is DutyPhase.OFF  # nobody has entered its number yet
    yard.duties.powered_on(0, AT + 30)
    assert yard.units._running["K1"].state.phase is DutyPhase.SIGNING_ON
    assert len(yard.sent) > sent
    yard.accept(0, AT + 40)
    assert yard.stage(0) is StockStage.ON_LINE


def test_who_waits_at_a_portal_is_overdue_from_its_time_on(yard: Yard) -> None:
    enter_s = ENTER_S - LEAD_S
    assert yard.duties.overdue_s(enter_s + 1000.0) == 0.0  # nothing has been taken up
    yard.duties.take_up(0, AT)
    assert yard.duties.overdue_s(enter_s + 30.0) == pytest.approx(30.0)
    yard.accept(0, AT)  # its departure from the portal has no time: from when it should have been there
    assert yard.duties.overdue_s(enter_s + 40.0) == pytest.approx(40.0)


def test_an_acceptance_moves_nobody_who_is_on_the_line(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    yard.accept(0, AT)
    place_m = float(yard.trains.truths[0].position_m)
    yard.trains.truths[0].position_m = place_m + 5.0
    yard.accept(0, AT + 100)
    assert yard.trains.truths[0].position_m == place_m + 5.0


def test_who_is_told_that_the_line_is_left_is_taken_off_it(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    yard.duties.unit_tells(0, LeftLine("T1"), AT)  # not on the line: nothing to leave
    assert yard.stage(0) is StockStage.WAITING
    yard.accept(0, AT)
    yard.duties.unit_tells(0, LeftLine("T1"), AT + 100)
    assert yard.trains.active() == []
    assert yard.stage(0) is StockStage.DONE
    assert any(isinstance(entry.event, Left) for entry in yard.journal.entries)
    assert not yard.duties.all_done()  # K2 is still to come


def test_a_journey_that_ends_on_the_line_is_done(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    yard.accept(0, AT)
    yard.duties.unit_tells(0, Finished("T1"), AT + 100)
    assert yard.duties.finished(0)
    assert yard.trains.active() == [0]


# people take time ---------------------------------------------------------------------------------------------------

SLOW = People.model_validate({"sigma": 0.0} | {pause.value: 10.0 for pause in Pause})


@pytest.fixture
def slow(rtri_setup: Setup) -> Yard:
    """A yard in which everything takes people ten seconds."""
    return Yard(rtri_setup, SLOW)


@pytest.fixture
def come(slow: Yard) -> Yard:
    """The first train has come in."""
    slow.duties.take_up(0, AT)
    slow.crews_to(AT + 100)
    slow.accept(0, AT + 100)
    slow.crews_to(AT + 200)
    return slow


def test_a_crew_enters_its_number_some_time_after_it_has_come(slow: Yard) -> None:
    slow.duties.take_up(0, AT)
    assert slow.sent == []
    slow.crews_to(AT + 99)
    assert slow.sent == []
    assert slow.duties.waiting()[0].waits_for == "its crew to enter the train number"
    slow.crews_to(AT + 100)
    assert ("K1", "block-manager") in slow.sent


def test_a_train_comes_in_some_time_after_it_may_and_leaves_some_time_after_it_has_signed_off(
    slow: Yard,
) -> None:
    slow.duties.take_up(0, AT)
    slow.crews_to(AT + 100)
    slow.accept(0, AT + 105)
    slow.crews_to(AT + 204)
    assert slow.trains.active() == []
    slow.crews_to(AT + 205)
    assert slow.trains.active() == [0]
    slow.duties.unit_tells(0, LeftLine("T1"), AT + 300)
    slow.crews_to(AT + 399)
    assert slow.trains.active() == [0]
    slow.crews_to(AT + 400)
    assert slow.trains.active() == []


def test_after_a_boot_the_brake_stays_on_until_the_number_is_entered(come: Yard) -> None:
    """A unit that has just booted knows of no train: what its sensors show tells it nothing."""
    come.boot(0, AT + 300, AT + 400)
    assert come.trains.truths[0].powered == 0
    assert come.on_board.tag_read(0, 1, 0.0) == []
    assert come.units._running["K1"].state.phase is DutyPhase.OFF
    come.crews_to(AT + 499)
    assert come.units._running["K1"].state.phase is DutyPhase.OFF
    come.crews_to(AT + 500)
    assert come.trains.truths[0].powered == 1
    assert come.units._running["K1"].state.phase is not DutyPhase.OFF


def test_power_lost_again_begins_the_wait_again(slow: Yard) -> None:
    slow.duties.take_up(0, AT)
    for off, on in ((AT + 50, AT + 60), (AT + 155, AT + 158)):
        slow.boot(0, off, on)
    slow.crews_to(AT + 257)
    assert slow.sent == []
    slow.crews_to(AT + 258)
    assert slow.sent != []


def test_a_train_whose_unit_dies_before_it_has_left_does_not_leave(come: Yard) -> None:
    come.duties.unit_tells(0, LeftLine("T1"), AT + 300)
    come.boot(0, AT + 350, AT + 360)
    come.crews_to(AT + 500)
    assert come.trains.active() == [0]


def test_a_number_that_comes_up_before_the_crew_has_entered_one_is_the_one_it_enters(
    come: Yard, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A unit that booted in its terminus is not told to change ends: its crew begins with the new number."""
    come.boot(0, AT + 300, AT + 310)
    said: list[object] = []
    monkeypatch.setattr(
        come.cabs, "tell", lambda _slot, _step, happened=(), _telegrams=(): said.extend(happened)
    )
    come.duties._next["K1"] = 0  # its next train is due now
    come.duties.take_up(0, AT + 320)
    assert said == []
    come.crews_to(AT + 410)
    assert [type(happened) for happened in said] == [SwitchedOn]


# cabs ---------------------------------------------------------------------------------------------------------------


def test_a_cab_without_power_is_told_nothing(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    yard.accept(0, AT)
    yard.cabs.power_off(0, AT + 10)
    yard.cabs.power_off(0, AT + 11)  # it is off already
    written, sent = len(yard.journal.entries), len(yard.sent)
    yard.cabs.tell(0, AT + 20, (WheelsTurning(),))
    yard.cabs.set_back(0, AT + 20, 60.0)
    assert (len(yard.journal.entries), len(yard.sent)) == (written, sent)
    kinds = [type(entry.event) for entry in yard.journal.entries]
    assert kinds.count(PowerOff) == 1
    assert not yard.cabs.power_on(1, AT + 30)  # it was never off
    assert yard.cabs.power_on(0, AT + 30)
    assert [type(e.event) for e in yard.journal.entries].count(PowerOn) == 1


def test_a_timer_wakes_a_unit_at_its_step_and_never_before(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    wakes = [
        item for item in yard.agenda._heap if item.kind is AgendaKind.UNIT_TIMER and item.subject == "K1"
    ]
    (wake,) = wakes
    assert wake.step == AT + 20  # a sign-on is repeated after 2 s
    sent = len(yard.sent)
    yard.cabs.timer(0, wake.step - 1)
    assert len(yard.sent) == sent
    yard.cabs.timer(0, wake.step)
    assert len(yard.sent) == sent + 1


def test_each_that_has_not_finished_says_where_it_is_and_what_it_waits_for(yard: Yard) -> None:
    assert yard.duties.waiting() == []
    yard.duties.take_up(0, AT)
    yard.accept(0, AT)
    yard.duties.take_up(1, AT)
    yard.cabs.power_off(0, AT)
    inside, outside = yard.duties.waiting()
    assert (inside.stock_id, inside.number, inside.stands) == ("K1", "T1", True)
    assert inside.place.startswith("section PW at km ")
    assert inside.waits_for == "its unit to be switched on"
    assert (outside.stock_id, outside.place) == ("K2", "no section, outside its portal")
    assert outside.waits_for.startswith("signing on: ")


def test_what_is_seen_of_a_unit_that_is_frozen_off_or_has_a_timer(yard: Yard) -> None:
    yard.duties.take_up(0, AT)
    assert yard.cabs.answers(0) and yard.cabs.wakes(0)  # it will sign on again
    yard.cabs.freeze(0, AT, frozen=True)
    assert not yard.cabs.answers(0)
    assert yard.cabs.waits_for(0) == "its unit, which is frozen"
    yard.cabs.freeze(0, AT, frozen=False)
    assert yard.cabs.answers(0)
    yard.cabs.power_off(0, AT)
    assert not yard.cabs.answers(0) and not yard.cabs.wakes(0)


def test_a_train_without_power_is_hauled_out_of_its_portal(yard: Yard) -> None:
    """The contact counts it out; nobody else hears of it, and its unit signs nothing off."""
    yard.duties.take_up(0, AT)
    yard.accept(0, AT)
    yard.cabs.power_off(0, AT + 10)
    yard.sent.clear()
    yard.duties.haul_away(0, AT + 20)
    assert yard.trains.active() == []
    assert yard.stage(0) is StockStage.DONE
    assert yard.inputs[2:] == [BoundaryPassed("PW")]
    assert yard.sent == []
    yard.duties.haul_away(0, AT + 30)
    assert len(yard.inputs) == 3, "it is gone already"


@pytest.mark.parametrize("why", ["it has power", "it moves", "it stands beyond its portal"])
def test_nobody_hauls_a_train_away_when(yard: Yard, why: str) -> None:
    yard.duties.take_up(0, AT)
    yard.accept(0, AT)
    if why != "it has power":
        yard.cabs.power_off(0, AT + 10)
    if why == "it moves":
        yard.trains.plants[0].speed_mps = 0.1
    if why == "it stands beyond its portal":
        yard.trains.truths[0].position_m += yard.trains.kinds[0].length_m
    yard.duties.haul_away(0, AT + 20)
    assert yard.trains.active() == [0]
    assert yard.stage(0) is StockStage.ON_LINE
