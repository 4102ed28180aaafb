"""Words at a level crossing: what persons say of trains, and contacts that were passed while it was dark."""

import math

import msgspec
import pytest

from radio.messages import CrossingProof
from tests.wayside.test_level_crossing import (
    BARRIERS,
    CLOSED,
    CLOSING,
    COMES,
    DOWN,
    GONE,
    OPEN,
    SIGNALMAN,
    TRACKMAN,
    Box,
    asks,
    closed_for,
    leaves,
)
from wayside.level_crossing import (
    FREES_S,
    VALID_S,
    CrossingEvent,
    CrossingMemory,
    CrossingState,
    CrossingTimeDue,
    start,
    wake_at_s,
)
from wayside.said import BarUnit


def test_who_is_barred_after_speaking_is_not_struck_off_before_its_proof_has_died() -> None:
    """It has spoken 4 s after the persons and is barred 50 s later, running towards the road by its last proof."""
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    box.do(TRACKMAN, 101.0)
    box.do(asks(12.0, correlation=1), 105.0)
    box.do(BarUnit("u", "Sato"), 154.0)
    assert box.do(BarUnit("u", "Mori"), 155.0) == [("u", CrossingProof(False, VALID_S), 1)]
    assert wake_at_s(box.device) == 155.0 + FREES_S
    box.do(CrossingTimeDue(), 101.0 + FREES_S)
    assert (box.state, box.device.memory.units) == (CLOSED, ("u",))
    box.do(CrossingTimeDue(), 155.0 + FREES_S)
    assert (box.state, box.device.memory.units) == (OPEN, ())


def test_who_has_said_nothing_since_is_struck_off_in_time_though_it_is_barred() -> None:
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    box.do(TRACKMAN, 101.0)
    box.do(BarUnit("u", "Sato"), 154.0)
    box.do(BarUnit("u", "Mori"), 155.0)
    assert wake_at_s(box.device) == 101.0 + FREES_S


@pytest.mark.parametrize("comes", [asks(35.0, unit="v"), COMES])
def test_one_persons_word_is_none_of_a_train_that_comes_later(comes: CrossingEvent) -> None:
    """He was right of u; with one who is wrong of the next train that does not make two."""
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    box.do(comes, 110.0)
    assert box.do(TRACKMAN, 120.0) == []
    assert (box.device.persons, box.device.frees_s) == (("trackman",), math.inf)
    assert len(box.do(SIGNALMAN, 130.0)) >= 1


def test_what_is_said_again_of_the_same_train_changes_no_word() -> None:
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    box.do(asks(12.0, correlation=1), 105.0)
    assert box.do(TRACKMAN, 110.0) == [("u", CrossingProof(False, VALID_S), 1)]


def test_what_persons_said_of_a_train_that_leaves_after_all_is_over() -> None:
    box = closed_for("u")
    box.do(SIGNALMAN, 100.0)
    box.do(TRACKMAN, 110.0)
    box.do(leaves("u"), 112.0)
    assert (box.state, wake_at_s(box.device)) == (OPEN, None)


@pytest.mark.parametrize(("contacts", "state"), [(True, CLOSING), (False, OPEN)])
def test_by_contacts_a_front_may_have_come_while_it_was_dark(contacts: bool, state: CrossingState) -> None:
    """Nobody told the device, nor of a second one behind it: no rear opens the road, and two persons do."""
    box = Box(BARRIERS)
    config = msgspec.structs.replace(BARRIERS, contacts=contacts)
    box.device = start(config, CrossingMemory(), again=True)
    box.do(DOWN)
    assert box.state is state
    for t_s in (60.0, 70.0):
        box.do(GONE, t_s)
        assert (box.state is OPEN) is not contacts
    for person in (SIGNALMAN, TRACKMAN):
        box.do(person, 100.0)
    box.do(COMES, 110.0)
    box.do(CrossingTimeDue(), 100.0 + FREES_S)
    assert box.state is not OPEN
    box.do(GONE, 200.0)
    assert (box.state, box.device.memory) == (OPEN, CrossingMemory())
    assert start(config, CrossingMemory()).state is OPEN  # its first start


def test_that_a_memory_was_lost_is_not_forgotten_with_the_next_power_cut() -> None:
    box = Box(lost=True)
    box.do(DOWN, 100.0)
    again = Box(memory=box.device.memory)
    again.do(DOWN, 110.0)
    assert again.state is not OPEN
