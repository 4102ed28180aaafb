"""Behaviours that the machines had once, by name: restored while a line is explored, to see what they lead to."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, Final

from onboard.authority import machine as authority
from onboard.authority import sign_on
from onboard.authority.records import QueryHeard
from onboard.authority.tables import SignOnStanding
from onboard.duty import on_sight
from radio.messages import SignOff
from wayside import block_manager, leaving, reentry
from wayside.actions import Show
from wayside.heard import Heard
from wayside.reentry import Step
from wayside.register import Register, UnitStanding

Change = tuple[object, str, Any]


def _frees_at_once(register: Register, heard: Heard[SignOff]) -> Step:
    """A sign-off that is accepted frees the portal, whether or not its unit hears that."""
    after, actions = leaving.sign_off(register, heard)
    if after.unit(heard.unit_id).standing is not UnitStanding.LEAVING:
        return after, actions
    after, shown = leaving.left_line(after, heard.unit_id)
    return after, (*(action for action in actions if not isinstance(action, Show)), *shown)


def _sign_off_frees() -> tuple[Change, ...]:
    table = dict(block_manager.TELEGRAMS)
    table[UnitStanding.REPORTED, SignOff] = _frees_at_once
    return ((block_manager, "TELEGRAMS", MappingProxyType(table)),)


def _booted_holds_nothing() -> tuple[Change, ...]:
    """A unit that has booted answers that it holds nothing, and the manager takes that for what is so."""
    table = dict(authority.TABLE)
    table[SignOnStanding.OFF_LINE, QueryHeard] = sign_on.queried
    return (
        (authority, "TABLE", MappingProxyType(table)),
        (reentry, "cannot_be_outside", _never),
    )


def _never(_register: Register, _what: object) -> bool:
    return False


def _claims_as_on_the_line() -> tuple[Change, ...]:
    """A unit that has signed off and is asked in its portal counts as one on the line, which nobody asks again."""
    return ((leaving, "claimed_standing", _reported),)


def _disputed_leaver_stays() -> tuple[Change, ...]:
    """A unit in dispute that had signed off, and has left since, goes on holding what persons have said of it."""
    return ((leaving, "has_left", _never),)


def _booted_at_its_mark_keeps_all() -> tuple[Change, ...]:
    """A unit that has booted at its mark goes on holding what lies behind, though its crew says where it is."""
    return ((on_sight, "behind_by_eye", _nothing_behind),)


def _nothing_behind(_duty: object, _stop: int) -> int:
    return 0


def _reported(_register: Register, _message: object, held: tuple[str, ...]) -> UnitStanding:
    return UnitStanding.REPORTED if held else UnitStanding.OUTSIDE


RESTORED: Final[MappingProxyType[str, Callable[[], tuple[Change, ...]]]] = MappingProxyType(
    {
        "sign-off-frees": _sign_off_frees,
        "booted-holds-nothing": _booted_holds_nothing,
        "leaver-counts-as-on-the-line": _claims_as_on_the_line,
        "disputed-leaver-stays": _disputed_leaver_stays,
        "booted-at-its-mark-keeps-all": _booted_at_its_mark_keeps_all,
    }
)


@contextmanager
def restored(*names: str) -> Generator[None]:
    """With these behaviours; KeyError for a name that is none."""
    changes = [change for name in names for change in RESTORED[name]()]
    before = [(where, what, getattr(where, what)) for where, what, _ in changes]
    try:
        for where, what, value in changes:
            setattr(where, what, value)
        yield
    finally:
        for where, what, value in before:
            setattr(where, what, value)
