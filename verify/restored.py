"""Behaviours that the machines had once, by name: restored while a line is explored, to see what they lead to."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, Final

from onboard.authority import machine as authority
from onboard.authority import sign_on
from onboard.authority.records import EarlierBootCalled, QueryHeard
from onboard.authority.tables import SignOnStanding
from onboard.duty import on_sight
from onboard.duty.duty_step import DutyStep
from radio.messages import PointsCommand, PointsProof, PointsRefusalReason, SignOff
from wayside import block_manager, leaving, point_terminal, reentry
from wayside.actions import Send, Show
from wayside.heard import Heard
from wayside.point_terminal import Commanded, Commitment, PointsState, PointsView, Terminal
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


def _counted_out_forgotten() -> tuple[Change, ...]:
    """That the boundary has counted a train out is forgotten once its unit says that it is still in the portal."""
    return ((leaving, "counted_out", _never),)


def _silent_off_the_line() -> tuple[Change, ...]:
    """A unit that has booted off the line says nothing to who speaks to an earlier boot."""
    table = dict(authority.TABLE)
    del table[SignOnStanding.OFF_LINE, EarlierBootCalled]
    return ((authority, "TABLE", MappingProxyType(table)),)


def _booted_leaver_unheard() -> tuple[Change, ...]:
    """A unit has booted since it signed off, and says that it is outside: nobody is shown that."""
    return ((leaving, "says_gone", _in_its_boot),)


def _in_its_boot(register: Register, heard: Heard[Any]) -> Step:
    unit = register.unit(heard.unit_id)
    gone = heard.epoch == unit.epoch or unit.counted_out
    return leaving.left_line(register, heard.unit_id) if gone else (register, ())


def _booted_at_its_mark_keeps_all() -> tuple[Change, ...]:
    """A unit that has booted at its mark goes on holding what lies behind, though its crew says where it is."""
    return ((on_sight, "behind_by_eye", _nothing_behind),)


def _nothing_behind(_duty: object, _stop: int) -> int:
    return 0


def _old_token_obeyed() -> tuple[Change, ...]:
    """A terminal obeys any authentic capability, whoever has commanded under a newer token since."""
    real, table = point_terminal.refusal, dict(point_terminal.TABLE)

    def forgetful(terminal: Terminal, unit_id: str, command: PointsCommand) -> PointsRefusalReason | None:
        reason = real(terminal, unit_id, command)
        return None if reason is PointsRefusalReason.OLD_TOKEN else reason

    for state in PointsState:
        table[state, Commanded] = point_terminal._command
    return (point_terminal, "refusal", forgetful), (point_terminal, "TABLE", MappingProxyType(table))


def _repeated_command_throws() -> tuple[Change, ...]:
    """A terminal throws points again for any command since it has withdrawn their proof."""
    table = dict(point_terminal.TABLE)
    table[PointsState.UNPROVEN, Commanded] = point_terminal._command
    return ((point_terminal, "TABLE", MappingProxyType(table)),)


def _proves_undetected() -> tuple[Change, ...]:
    """A terminal proves points as they are commanded, before they lie so."""

    def proof(view: PointsView, commitment: Commitment) -> Send:
        said = PointsProof(view.entry.points_id, commitment.position, True, True, commitment.token)
        return Send(commitment.unit_id, said, view.correlation)

    return (point_terminal, "_shows", _always), (point_terminal, "_proof", proof)


def _always(*_what: object) -> bool:
    return True


def _emergency_kept() -> tuple[Change, ...]:
    """An emergency brake that has stopped a train is never released."""
    return ((DutyStep, "await_release", _not_released),)


def _not_released(duty: DutyStep) -> None:
    duty.set(released=False)


def _reported(_register: Register, _message: object, held: tuple[str, ...]) -> UnitStanding:
    return UnitStanding.REPORTED if held else UnitStanding.OUTSIDE


RESTORED: Final[MappingProxyType[str, Callable[[], tuple[Change, ...]]]] = MappingProxyType(
    {
        "sign-off-frees": _sign_off_frees,
        "booted-holds-nothing": _booted_holds_nothing,
        "leaver-counts-as-on-the-line": _claims_as_on_the_line,
        "disputed-leaver-stays": _disputed_leaver_stays,
        "counted-out-forgotten": _counted_out_forgotten,
        "silent-off-the-line": _silent_off_the_line,
        "booted-leaver-unheard": _booted_leaver_unheard,
        "booted-at-its-mark-keeps-all": _booted_at_its_mark_keeps_all,
        "old-token-obeyed": _old_token_obeyed,
        "proves-undetected": _proves_undetected,
        "repeated-command-throws": _repeated_command_throws,
        "emergency-kept": _emergency_kept,
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
