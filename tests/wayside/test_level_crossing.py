"""The rules of a level crossing's device, state by state, and its times by hand."""

import math

import pytest

from radio.messages import (
    AnyMessage,
    CrossingClear,
    CrossingOver,
    CrossingOverHeard,
    CrossingProof,
    CrossingRequest,
)
from radio.table import rows
from wayside.actions import Drive, Send, Show
from wayside.config import CrossingConfig
from wayside.crossing_said import (
    CloseCrossing,
    CrossingContact,
    CrossingDetected,
    CrossingOpens,
    CrossingUnproven,
    NoTrainComes,
    NoTrainSaid,
    OpenCrossing,
    WhyUnproven,
)
from wayside.level_crossing import (
    FREES_S,
    TABLE,
    VALID_S,
    ClosureAsked,
    CrossingDevice,
    CrossingEvent,
    CrossingLeft,
    CrossingMemory,
    CrossingState,
    CrossingTimeDue,
    start,
    step,
    wake_at_s,
)
from wayside.said import Barred, BarUnit, Unbarred, UnbarUnit

BARRIERS = CrossingConfig("line", "C", barriers=True, closing_s=15.0, closed_s=20.0)
LAMPS = CrossingConfig("line", "C", barriers=False, closing_s=0.0, closed_s=30.0)
PROTECTED = CrossingConfig("line", "C", barriers=True, closing_s=15.0, closed_s=20.0, protection=True)
DEPARTURES = CrossingConfig("line", "C", barriers=True, closing_s=15.0, closed_s=20.0, departures=True)
UP = CrossingDetected(lamps=False, lowered=False, raised=True)
MOVING = CrossingDetected(lamps=True, lowered=False, raised=False)
DOWN = CrossingDetected(lamps=True, lowered=True, raised=False)
BLOCKED = CrossingDetected(lamps=True, lowered=True, raised=False, obstacle=True)
PRESSED = CrossingDetected(lamps=True, lowered=True, raised=False, button=True)
DARK = CrossingDetected(lamps=False, lowered=True, raised=False)
OPEN, CLOSING, CLOSED = CrossingState.OPEN, CrossingState.CLOSING, CrossingState.CLOSED
COMES, GONE = CrossingContact(first=True), CrossingContact(first=False)


def asks(arrives_s: float, proof_s: float = math.inf, unit: str = "u", correlation: int = 1) -> ClosureAsked:
    return ClosureAsked(unit, correlation, CrossingRequest(arrives_s, proof_s))


def leaves(unit: str = "u", correlation: int = 1) -> CrossingLeft:
    return CrossingLeft(unit, correlation, CrossingOver(passed=True))


class Box:
    """A device and what it did last."""

    def __init__(
        self, config: CrossingConfig = BARRIERS, memory: CrossingMemory | None = None, *, lost: bool = False
    ) -> None:
        self.device: CrossingDevice = start(config, memory or CrossingMemory(), lost=lost)
        self.drives: list[object] = []
        self.notes: list[object] = []
        self.now_s = 0.0

    def do(self, event: CrossingEvent, at_s: float | None = None) -> list[tuple[str, AnyMessage, int]]:
        self.now_s = self.now_s if at_s is None else at_s
        self.device, actions = step(self.device, event, self.now_s)
        self.drives = [action.output for action in actions if isinstance(action, Drive)]
        self.notes = [action.note for action in actions if isinstance(action, Show)]
        sends = [action for action in actions if isinstance(action, Send)]
        return [(send.destination, send.message, send.correlation) for send in sends]

    @property
    def state(self) -> CrossingState:
        return self.device.state


def closed_for(*units: str) -> Box:
    """Asked at 0 by each, closed at 15."""
    box = Box()
    box.do(UP)
    for unit in units:
        box.do(asks(35.0, unit=unit))
    box.do(MOVING)
    box.do(DOWN, 15.0)
    return box


def test_every_state_takes_every_event() -> None:
    events = (ClosureAsked, CrossingLeft, CrossingDetected, CrossingContact, NoTrainComes, CrossingTimeDue)
    assert set(TABLE) == {(state, event) for state in CrossingState for event in events}
    assert len(rows(TABLE)) == len(TABLE)


def test_the_warning_begins_so_long_before_the_front_as_the_line_has_it() -> None:
    """50 s before the front, that is 15 + 20 s before it: in 15 s."""
    box = Box()
    box.do(UP)
    assert box.do(asks(50.0), 100.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert (box.state, box.drives, wake_at_s(box.device)) == (OPEN, [], 115.0)
    box.do(CrossingTimeDue(), 114.9)
    assert box.state is OPEN
    box.do(CrossingTimeDue(), 115.0)
    assert (box.state, box.drives) == (CLOSING, [CloseCrossing("C")])


def test_it_begins_earlier_for_a_train_that_would_have_to_brake() -> None:
    """It must know in 24 s: 15 s to close and 1 s for the telegram leave 8 s."""
    box = Box()
    box.do(asks(60.0, 24.0))
    assert wake_at_s(box.device) == 8.0


@pytest.mark.parametrize(("later_s", "begins_s"), [(80.0, 45.0), (40.0, 5.0), (20.0, None)])
def test_a_unit_may_say_another_time_while_it_is_open(later_s: float, begins_s: float | None) -> None:
    box = Box()
    box.do(asks(50.0))
    box.do(asks(later_s))
    if begins_s is None:
        assert (box.state, box.drives) == (CLOSING, [CloseCrossing("C")])
    else:
        assert (box.state, wake_at_s(box.device)) == (OPEN, begins_s)


def test_a_later_time_does_not_open_it() -> None:
    box = closed_for("u")
    assert box.do(asks(600.0, correlation=2), 20.0) == [("u", CrossingProof(True, VALID_S), 2)]
    assert (box.state, box.drives) == (CLOSED, [])


def test_the_proof_is_sent_once_it_is_detected_and_taken_back_at_once() -> None:
    box = Box()
    box.do(asks(35.0))
    assert box.do(MOVING) == []
    assert box.do(DOWN, 15.0) == [("u", CrossingProof(True, VALID_S), 1)]
    assert box.do(DARK, 18.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert box.notes == [CrossingUnproven(why=WhyUnproven.LOST)]


def test_what_is_on_the_road_takes_the_proof_away_until_it_is_gone() -> None:
    """It has warned on meanwhile: the proof is there again at once."""
    box = closed_for("u")
    assert box.do(BLOCKED, 18.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert (box.state, box.drives) == (CLOSING, [])
    assert box.notes == [CrossingUnproven(why=WhyUnproven.OBSTACLE)]
    assert box.do(asks(12.0, correlation=2), 20.0) == [("u", CrossingProof(False, VALID_S), 2)]
    assert box.do(DOWN, 40.0) == [("u", CrossingProof(True, VALID_S), 2)]


def test_a_road_that_is_blocked_as_it_closes_is_not_proved_closed() -> None:
    box = Box()
    box.do(asks(35.0))
    box.do(MOVING)
    assert box.do(BLOCKED, 15.0) == []
    assert box.state is CLOSING
    assert box.do(DOWN, 19.0) == [("u", CrossingProof(True, VALID_S), 1)]


def test_lamps_that_shine_again_must_have_warned_for_their_time() -> None:
    """Lit at 20 s, with the barriers down: 15 s later it is proved closed."""
    box = closed_for("u")
    box.do(DARK, 18.0)
    assert box.do(DOWN, 20.0) == []
    assert wake_at_s(box.device) == 35.0
    box.do(CrossingTimeDue(), 34.9)
    assert box.state is CLOSING
    assert box.do(CrossingTimeDue(), 35.0) == [("u", CrossingProof(True, VALID_S), 1)]


def test_what_is_not_detected_in_time_is_noted_once_and_stays_commanded() -> None:
    """15 s and half as much, and a second."""
    box = Box()
    box.do(asks(35.0))
    assert wake_at_s(box.device) == 23.5
    box.do(CrossingTimeDue(), 23.5)
    assert (box.state, box.notes) == (CLOSING, [CrossingUnproven(why=WhyUnproven.LATE)])
    box.do(CrossingTimeDue(), 60.0)
    assert (box.notes, wake_at_s(box.device)) == ([], None)
    assert (box.do(MOVING, 61.0), box.drives, box.notes) == ([], [], [])


def test_it_opens_behind_the_last_of_several() -> None:
    box = closed_for("u", "v")
    assert box.do(leaves("u", 7), 40.0) == [("u", CrossingOverHeard(), 7)]
    assert (box.state, box.drives) == (CLOSED, [])
    box.do(leaves("v"), 50.0)
    assert (box.state, box.drives, box.notes) == (OPEN, [OpenCrossing("C")], [CrossingOpens()])
    assert box.do(leaves("v"), 52.0) == [("v", CrossingOverHeard(), 1)]
    assert box.drives == []


def test_silence_opens_nothing() -> None:
    box = closed_for("u")
    box.do(CrossingTimeDue(), 36_000.0)
    assert (box.state, box.drives) == (CLOSED, [])


def test_without_barriers_lamps_close_it() -> None:
    box = Box(LAMPS)
    box.do(asks(30.0))
    assert box.do(MOVING) == [("u", CrossingProof(True, VALID_S), 1)]


def test_after_a_restart_it_is_closed_until_each_that_had_announced_itself_says_so() -> None:
    box = closed_for("u", "v")
    again = Box(memory=box.device.memory)
    assert again.state is CLOSING
    assert again.do(UP) == []
    assert again.drives == [CloseCrossing("C")]
    again.do(MOVING)
    assert again.do(DOWN, 15.0) == []  # nobody has been heard
    again.do(leaves("u"), 16.0)
    assert again.do(asks(3.0, unit="v"), 17.0) == [("v", CrossingProof(True, VALID_S), 1)]
    assert again.state is CLOSED
    again.do(leaves("v"), 30.0)
    assert again.state is OPEN


def test_one_that_has_lost_its_memory_stays_closed_until_persons_say_that_no_train_comes() -> None:
    """Whoever it had announced may stand on it without power, and says nothing."""
    box = Box(lost=True)
    box.do(DOWN, 100.0)
    box.do(CrossingTimeDue(), 115.0)
    assert (box.state, wake_at_s(box.device)) == (CLOSED, None)
    box.do(asks(3.0, unit="v"), 300.0)
    box.do(leaves("v"), 310.0)  # another has passed
    assert box.state is CLOSED
    box.do(NoTrainComes("Abe"), 400.0)
    box.do(NoTrainComes("Ito"), 401.0)
    box.do(CrossingTimeDue(), 401.0 + FREES_S)
    assert (box.state, box.drives) == (OPEN, [OpenCrossing("C")])


def test_after_a_power_cut_without_trains_it_is_opened() -> None:
    box = Box()
    box.do(DOWN)
    assert box.drives == [OpenCrossing("C")]


def test_contacts_count_fronts_in_and_rears_out() -> None:
    box = Box()
    box.do(UP)
    box.do(GONE)  # nobody had come
    assert box.state is OPEN
    box.do(COMES)
    assert (box.state, box.drives) == (CLOSING, [CloseCrossing("C")])
    box.do(MOVING)
    box.do(DOWN, 15.0)
    box.do(COMES, 20.0)
    box.do(GONE, 30.0)
    assert (box.state, box.device.memory.counted) == (CLOSED, 1)
    box.do(GONE, 60.0)
    assert (box.state, box.drives) == (OPEN, [OpenCrossing("C")])


def test_lamps_that_went_out_and_shine_again_prove_nothing_while_the_proof_of_before_may_be_believed() -> (
    None
):
    """15 s that it holds, and 5 s that it may have been under way."""
    lamps = Box(LAMPS)
    lit = CrossingDetected(lamps=True, lowered=True, raised=False)
    lamps.do(UP, 0.0)
    lamps.do(asks(30.0), 0.0)
    lamps.do(lit, 0.1)
    assert lamps.device.state is CLOSED
    assert lamps.do(DARK, 20.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert lamps.do(lit, 21.0) == []
    assert lamps.do(asks(9.0), 39.9) == [("u", CrossingProof(False, VALID_S), 1)]
    assert wake_at_s(lamps.device) == pytest.approx(20.0 + 15.0 + 5.0)
    assert lamps.do(CrossingTimeDue(), 40.0) == [("u", CrossingProof(True, VALID_S), 1)]
    lamps.do(BLOCKED, 41.0)  # while they shine what was on it keeps no proof away afterwards
    assert lamps.do(lit, 42.0) == [("u", CrossingProof(True, VALID_S), 1)]


SIGNALMAN, TRACKMAN = NoTrainComes("Signalman"), NoTrainComes("trackman")


def test_one_person_frees_nothing_however_often_he_says_so() -> None:
    box = closed_for("u")
    assert box.do(SIGNALMAN, 100.0) == []
    assert box.notes == [NoTrainSaid(by="Signalman")]
    assert box.do(NoTrainComes("  signalman"), 120.0) == []
    assert box.notes == []
    box.do(CrossingTimeDue(), 36_000.0)
    assert (box.state, wake_at_s(box.device)) == (CLOSED, None)


def test_two_persons_free_a_road_that_is_closed_for_a_silent_unit() -> None:
    """Its proof is taken back with the second word, and 65 s later it is struck off, not before."""
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    assert box.do(TRACKMAN, 130.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert box.notes == [NoTrainSaid(by="trackman", agreed=True)]
    assert wake_at_s(box.device) == 130.0 + FREES_S == 195.0
    box.do(CrossingTimeDue(), 194.9)
    assert (box.state, box.device.memory.units) == (CLOSED, ("u",))
    box.do(CrossingTimeDue(), 195.0)
    assert (box.state, box.drives) == (OPEN, [OpenCrossing("C")])
    assert box.notes == [CrossingOpens(struck_off=("u",))]
    assert (box.device.memory.units, wake_at_s(box.device)) == ((), None)


def test_who_cannot_stop_any_more_is_on_the_road_before_it_is_freed() -> None:
    """The last proof was sent before the second word: under way for 5 s at most it holds for 12 s, and the brake takes
    110 / 3.6 / 0.7 = 43.7 s.
    """
    assert BARRIERS.telegram_age_max_s + VALID_S + 110.0 / 3.6 / 0.7 <= FREES_S


def test_a_unit_that_speaks_after_the_persons_is_not_struck_off() -> None:
    box = closed_for("u", "v")
    box.do(SIGNALMAN, 100.0)
    box.do(TRACKMAN, 101.0)
    assert box.do(asks(12.0, unit="u", correlation=1), 105.0) == [("u", CrossingProof(True, VALID_S), 1)]
    box.do(CrossingTimeDue(), 166.0)
    assert (box.state, box.device.memory.units) == (CLOSED, ("u",))
    box.do(leaves("u"), 170.0)
    assert box.state is OPEN


def test_a_unit_that_was_struck_off_and_speaks_again_is_taken_again() -> None:
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    box.do(TRACKMAN, 101.0)
    box.do(CrossingTimeDue(), 166.0)
    assert box.state is OPEN
    assert box.do(asks(35.0, correlation=1), 200.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert (box.state, box.drives) == (CLOSING, [CloseCrossing("C")])


def test_words_count_for_one_closure() -> None:
    """What one person said before it opened does not make two with what another says of the next train."""
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    box.do(leaves("u"), 110.0)
    assert box.do(SIGNALMAN, 111.0) == []  # nobody waits: nothing is remembered
    box.do(asks(35.0, unit="v"), 200.0)
    assert box.do(TRACKMAN, 201.0) == []
    assert box.device.persons == ("trackman",)
    box.do(CrossingTimeDue(), 201.0 + FREES_S)
    assert box.device.memory.units == ("v",)


def test_two_persons_free_a_road_of_trains_that_contacts_have_counted_in() -> None:
    """One turned between the contacts; the front that comes meanwhile is another's, and stays counted."""
    box = Box()
    box.do(UP)
    box.do(COMES, 0.0)
    box.do(SIGNALMAN, 300.0)
    box.do(TRACKMAN, 310.0)
    box.do(COMES, 340.0)
    box.do(CrossingTimeDue(), 375.0)
    assert (box.state, box.device.memory.counted) == (CLOSING, 1)
    box.do(GONE, 400.0)
    assert box.state is OPEN


def test_a_restart_forgets_what_persons_have_said() -> None:
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    again = Box(memory=box.device.memory)
    again.do(TRACKMAN, 10.0)
    assert again.notes == [NoTrainSaid(by="trackman")]


def test_what_a_barred_unit_says_opens_nothing_and_proves_nothing_to_it() -> None:
    """Two persons bar it: its proof is taken back. Neither its word that it is over the road counts nor what it asks,
    until two have unbarred it.
    """
    box = closed_for("u")
    assert box.do(BarUnit("u", "signalman"), 20.0) == []
    assert box.do(BarUnit("u", "trackman"), 21.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert box.notes == [Barred(unit_id="u", by="trackman")]
    assert box.do(leaves("u"), 25.0) == []
    assert box.do(asks(5.0), 26.0) == []
    assert box.state is CLOSED
    again = Box(memory=box.device.memory)
    assert again.do(leaves("u"), 5.0) == []
    box.do(UnbarUnit("u", "signalman"), 30.0)
    box.do(UnbarUnit("u", "trackman"), 31.0)
    assert box.notes == [Unbarred(unit_id="u", by="trackman")]
    box.do(leaves("u"), 35.0)
    assert box.state is OPEN


def test_a_barred_unit_that_is_gone_does_not_keep_the_road() -> None:
    box = closed_for("u")
    box.do(BarUnit("u", "signalman"), 20.0)
    box.do(BarUnit("u", "trackman"), 21.0)
    box.do(SIGNALMAN, 100.0)
    box.do(TRACKMAN, 110.0)
    box.do(asks(5.0), 111.0)
    box.do(CrossingTimeDue(), 175.0)
    assert box.state is OPEN


def test_a_button_that_is_pressed_takes_the_proof_away_until_it_is_reset() -> None:
    box = closed_for("u")
    assert box.do(PRESSED, 18.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert box.notes == [CrossingUnproven(why=WhyUnproven.BUTTON)]
    assert box.do(DOWN, 60.0) == [("u", CrossingProof(True, VALID_S), 1)]


def test_with_protection_a_unit_that_asks_closes_nothing_and_is_told_that_the_road_is_clear() -> None:
    box = Box(PROTECTED)
    box.do(UP)
    assert box.do(asks(5.0, correlation=3), 1.0) == [("u", CrossingClear(True, VALID_S), 3)]
    assert (box.state, box.drives, wake_at_s(box.device), box.device.memory.units) == (OPEN, [], None, ())


def test_with_protection_units_are_told_at_once_what_is_on_it_until_they_are_over_it() -> None:
    box = Box(PROTECTED)
    box.do(UP)
    box.do(asks(50.0, unit="u", correlation=3))
    box.do(asks(50.0, unit="v", correlation=5))
    box.do(COMES, 10.0)
    assert box.do(DOWN, 25.0) == []
    assert box.do(BLOCKED, 30.0) == [
        ("u", CrossingClear(False, VALID_S), 3),
        ("v", CrossingClear(False, VALID_S), 5),
    ]
    assert box.do(asks(5.0, unit="u", correlation=3), 31.0) == [("u", CrossingClear(False, VALID_S), 3)]
    assert box.do(leaves("u", 3), 32.0) == [("u", CrossingOverHeard(), 3)]
    assert box.do(DOWN, 40.0) == [("v", CrossingClear(True, VALID_S), 5)]
    assert (box.state, box.device.memory.counted) == (CLOSED, 1)


def test_with_protection_a_button_on_the_open_road_is_told_too() -> None:
    box = Box(PROTECTED)
    box.do(UP)
    box.do(asks(50.0))
    pressed = CrossingDetected(lamps=False, lowered=False, raised=True, button=True)
    assert box.do(pressed, 5.0) == [("u", CrossingClear(False, VALID_S), 1)]


def departing(*more: CrossingEvent) -> Box:
    """With departures: u has asked twice, and what comes then happens while it is closed."""
    box = Box(DEPARTURES)
    box.do(UP)
    box.do(asks(35.0))
    box.do(asks(35.0))
    box.do(MOVING)
    box.do(DOWN, 15.0)
    for event in more:
        box.do(event)
    return box


def test_with_departures_a_unit_has_its_proof_and_its_rear_or_its_word_counts_it_out() -> None:
    box = departing()
    assert (box.state, box.device.memory.units, box.device.memory.counted) == (CLOSED, ("u",), 1)
    assert box.do(asks(5.0), 16.0) == [("u", CrossingProof(True, VALID_S), 1)]
    assert departing(GONE, leaves()).state is OPEN
    assert departing(leaves(), GONE).state is OPEN
    assert departing(leaves()).state is CLOSED  # its rear has yet to pass the last contact
    assert departing(CrossingLeft("u", 1, CrossingOver(passed=False))).state is OPEN


@pytest.mark.parametrize("first", [True, False])
def test_with_departures_the_train_behind_keeps_it_closed(first: bool) -> None:
    """Whichever comes first, the word of the one ahead or its rear at the last contact."""
    box = departing(COMES, *((leaves(), GONE) if first else (GONE, leaves())))
    assert (box.state, box.device.memory.counted) == (CLOSED, 1)
    box.do(GONE)
    assert box.state is OPEN


def test_with_departures_one_given_up_before_it_closes_leaves_nothing_behind() -> None:
    box = Box(DEPARTURES)
    box.do(UP)
    box.do(asks(90.0))
    box.do(CrossingLeft("u", 1, CrossingOver(passed=False)), 5.0)
    box.do(COMES, 10.0)
    box.do(GONE, 60.0)
    assert (box.state, box.device.memory.counted) == (OPEN, 0)


def test_with_departures_persons_do_not_strike_off_who_has_spoken_since() -> None:
    """Of u and a train counted in, the latter alone is struck off; u's rear then opens the road."""
    box = departing(COMES, NoTrainComes("a"), NoTrainComes("b"))
    box.do(asks(5.0), 20.0)
    box.do(CrossingTimeDue(), 20.0 + FREES_S)
    assert (box.state, box.device.memory.units, box.device.memory.counted) == (CLOSED, ("u",), 1)
    box.do(GONE)
    box.do(leaves())
    assert box.state is OPEN
