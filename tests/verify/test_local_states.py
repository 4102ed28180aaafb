"""Nothing of a register is forgotten by which two states are told apart."""

import pytest
from msgspec.structs import replace

from verify import manager
from verify.explored_line import ExploredLine, manager_config
from verify.manager import ManagerModel, plain
from wayside.register import Register, RegisteredUnit

FIXED = {"plan"}
NOT_TOLD_APART = {"started_s", "ask_at_s", "now_s"}  # times
OTHER = frozenset({"another"})


def register() -> Register:
    return ManagerModel(ExploredLine()).start().kept.register


@pytest.mark.parametrize("name", sorted({*Register.__struct_fields__} - FIXED - NOT_TOLD_APART - {"reentry"}))
def test_two_registers_that_differ_in_a_field_are_two(name: str) -> None:
    before = register()
    assert manager._key(replace(before, **{name: OTHER})) != manager._key(before)


@pytest.mark.parametrize("name", sorted({*RegisteredUnit.__struct_fields__} - {"correlation", "by"}))
def test_two_units_that_differ_in_a_field_are_two(name: str) -> None:
    before = register()
    unit_id, known = next(iter(before.units.items()))
    after = before.with_unit(unit_id, replace(known, **{name: OTHER}))
    assert plain(after) != plain(before)


@pytest.mark.parametrize("name", sorted(NOT_TOLD_APART))
def test_times_make_no_other_state(name: str) -> None:
    before = register()
    assert plain(replace(before, **{name: 7.0})) == plain(before)


def test_what_is_fixed_here_is_off() -> None:
    """With dispatch or overlaps the line would need more of the register than is explored."""
    config = manager_config(ExploredLine())
    assert not config.dispatch.weighs
    assert not any(route.entry or route.overlap for route in config.routes)
    assert not register().plan.has_overlaps
