import random

from hypothesis import given
from hypothesis import strategies as st

from simulation.agenda import Agenda, AgendaKind, Item


def due(agenda: Agenda, step: int = 9) -> list[Item]:
    """All that is due by then, as it comes."""
    return list(iter(lambda: agenda.pop_due(step), None))


@given(st.lists(st.tuples(st.integers(0, 20), st.sampled_from(AgendaKind)), max_size=40))
def test_items_come_by_step_then_kind_then_as_they_were_put_in(items: list[tuple[int, AgendaKind]]) -> None:
    agenda = Agenda()
    for order, (step, kind) in enumerate(items):
        agenda.put(step, kind, str(order))
    out = [(item.step, item.kind, int(item.subject)) for item in due(agenda, 20)]
    assert out == sorted((step, kind, order) for order, (step, kind) in enumerate(items))


def test_nothing_comes_before_its_step() -> None:
    agenda = Agenda()
    assert agenda.next_step() is None
    agenda.put(7, AgendaKind.DUTY, "V1")
    assert agenda.pop_due(6) is None
    assert agenda.next_step() == 7
    assert [item.subject for item in due(agenda)] == ["V1"]  # late is still due


def test_all_telegrams_of_a_device_can_be_taken_at_once() -> None:
    agenda = Agenda()
    agenda.put(3, AgendaKind.TO_DEVICE, "BM", b"one")
    agenda.put(3, AgendaKind.TO_DEVICE, "A-E", b"other")
    agenda.put(3, AgendaKind.TO_UNIT, "BM", b"unit")
    agenda.put(3, AgendaKind.TO_DEVICE, "BM", b"two")
    agenda.put(4, AgendaKind.TO_DEVICE, "BM", b"later")
    assert [item.data for item in agenda.pop_all(3, AgendaKind.TO_DEVICE, "BM")] == [b"one", b"two"]
    assert agenda.pop_all(3, AgendaKind.TO_DEVICE, "BM") == []
    assert [item.data for item in due(agenda)] == [b"other", b"unit", b"later"]


def test_what_is_put_in_first_comes_before_all_of_its_kind_in_its_own_order() -> None:
    """As what a script has from the beginning does, however late it is told."""
    agenda = Agenda()
    agenda.put(3, AgendaKind.SCRIPT, "crew K1")
    agenda.put(3, AgendaKind.TO_UNIT, "K1")
    agenda.put_first(3, AgendaKind.SCRIPT, "begin 0")
    agenda.put_first(3, AgendaKind.SCRIPT, "begin 1")
    agenda.put_first(2, AgendaKind.SCRIPT, "begin 2")
    assert [item.subject for item in due(agenda, 3)] == ["begin 2", "K1", "begin 0", "begin 1", "crew K1"]


def test_what_is_due_just_then_and_what_is_withdrawn() -> None:
    agenda = Agenda()
    agenda.put(3, AgendaKind.SCRIPT, "end 1")
    agenda.put(3, AgendaKind.UNIT_TIMER, "K1")
    agenda.put(5, AgendaKind.SCRIPT, "end 2")
    assert [agenda.is_due(step, AgendaKind.SCRIPT) for step in (2, 3, 4, 5)] == [False, True, False, True]
    agenda.withdraw(AgendaKind.SCRIPT, "end 1")
    assert not agenda.is_due(3, AgendaKind.SCRIPT)
    assert [item.subject for item in due(agenda)] == ["K1", "end 2"]


def test_what_is_put_off_is_due_once_and_telegrams_still_arrive() -> None:
    agenda = Agenda()
    agenda.put(3, AgendaKind.TO_DEVICE, "C1")
    agenda.put(5, AgendaKind.TO_DEVICE, "C1")
    agenda.put(5, AgendaKind.TO_DEVICE, "C1", b"proof")
    agenda.put(5, AgendaKind.UNIT_TIMER, "C1")
    agenda.withdraw(AgendaKind.TO_DEVICE, "C1", 3)
    came = [(item.step, item.kind, item.data) for item in due(agenda)]
    to_device, timer = AgendaKind.TO_DEVICE, AgendaKind.UNIT_TIMER
    assert came == [(3, to_device, None), (5, to_device, b"proof"), (5, timer, None)]


def test_what_is_left_when_some_are_taken_out_still_comes_in_order() -> None:
    agenda, chance = Agenda(), random.Random(1)
    for step in chance.sample(range(200), 200):
        agenda.put(step, AgendaKind.TO_DEVICE, chance.choice("ab"))
    taken = agenda.pop_all(150, AgendaKind.TO_DEVICE, "a")
    left = [item.step for item in due(agenda, 200)]
    assert (left, len(taken) + len(left)) == (sorted(left), 200)
