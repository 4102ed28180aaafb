"""The block manager as a party of the exploration: its real step, its power, and the persons who speak for units.

Times stand outside: units may be asked again at any time, and what must wait until telegrams of an earlier boot are too
old (a person's word) waits until none of them is on the air. Two states are one where only times, counts of inputs and
names shown to people differ, or where the two persons have said each what in the other the other has.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, NamedTuple, cast

import msgspec
from msgspec.structs import replace

from radio.envelope import DropReason
from radio.messages import Restarted, RouteGranted
from verify.explored_line import (
    CAPABILITY_KEYS,
    PERSONS,
    PORTAL,
    UNITS,
    ExploredLine,
    UnwishedFor,
    manager_config,
    mask_of,
    places,
    sections_of,
)
from verify.happening import Happening
from verify.on_air import InAir, opened, sealed
from wayside import acts, reentry
from wayside.barring import person_key
from wayside.block_manager import AskUnits, Event, Heard, step, wake_at_s
from wayside.register import Register, UnitStanding, start
from wayside.said import (
    AcceptPicture,
    BarUnit,
    BoundaryPassed,
    ConfirmHolding,
    ConfirmOutside,
    TakeBack,
    UnbarUnit,
)

BEFORE_S, LATE_S = 0.0, 1000.0  # which is later than whatever a rule of the manager waits for
GRANTED_IN_DOUBT: Final = "granted while the line was not defined"

ONE_BY_ONE: Final = tuple((person,) for person in PERSONS)


@dataclass(frozen=True, slots=True)
class PlainRegister:
    """A register, told from others by its key."""

    register: Register = field(compare=False)
    key: object


class ManagerState(NamedTuple):
    """`kept`: the register, or with the power off what outlives that. `heard`: boots of the units. `bad`: what must
    never happen and did in the step that led here.
    """

    power: bool
    epoch: int
    heard: tuple[int, ...]
    kept: PlainRegister
    bad: str = ""


class ManagerStep(NamedTuple):
    """What comes of a step: telegrams by unit; `granted`: the correlation of the last grant to the unit heard."""

    state: ManagerState
    sends: tuple[tuple[int, InAir], ...] = ()
    granted: int = 0


ManagerEvent = Happening[ManagerState, InAir]


def plain(register: Register) -> PlainRegister:
    """The register without times, counts and names; of a correlation only whether there is one."""
    units = {
        u: replace(known, by="x" if known.by else "", correlation=min(known.correlation, 1))
        for u, known in register.units.items()
    }
    words = replace(
        register.reentry,
        inputs={},
        heard_s=dict.fromkeys(register.reentry.heard_s, 0.0),
        defined_s=None,
        accepted_by="x" if register.reentry.accepted_by else "",
    )
    doubted = {u: min(times, acts.ASKED_IN_VAIN) for u, times in register.doubted.items()}
    register = replace(
        register, units=units, reentry=words, doubted=doubted, started_s=0.0, ask_at_s=0.0, now_s=0.0
    )
    key = _key(register)
    if words.entries or words.complete:
        others = _of_the_other(register)
        if (other := _key(others)) != key and repr(other) < repr(key):
            return PlainRegister(others, other)
    return PlainRegister(register, key)


def _of_the_other(register: Register) -> Register:
    """What the two persons have said, each by the other: who of two it is makes no difference."""
    words, of = (
        register.reentry,
        dict(zip(map(person_key, PERSONS), map(person_key, reversed(PERSONS)), strict=True)),
    )
    swapped = replace(
        words,
        entries={s: {of[p]: unit for p, unit in by.items()} for s, by in words.entries.items()},
        complete=frozenset((of[p], unit) for p, unit in words.complete),
        left_by={(of[p], unit): place for (p, unit), place in words.left_by.items()},
    )
    return replace(register, reentry=swapped)


def _key(thing: object) -> object:
    """All that is in a register besides its fixed data, so that no field of it can be forgotten."""
    match thing:
        case msgspec.Struct():
            names = (name for name in thing.__struct_fields__ if name != "plan")
            return type(thing).__name__, *(_key(getattr(thing, name)) for name in names)
        case dict():
            items = cast("dict[object, object]", thing).items()
            return tuple(sorted(((name, _key(value)) for name, value in items), key=repr))
        case frozenset():
            return tuple(sorted(cast("frozenset[object]", thing), key=repr))
        case _:
            return thing


class ManagerModel:
    """Steps of the block manager."""

    def __init__(self, line: ExploredLine) -> None:
        self._config: Final = manager_config(line)
        self._may_bar: Final = line.bars
        self._places: Final = places(line)
        self._who_errs: Final = (PERSONS,) if line.agree else ONE_BY_ONE
        self.units: Final = UNITS[: line.trains]

    def start(self) -> ManagerState:
        """A day under way: every unit is known to be off the line."""
        register = start(self._config, 1, CAPABILITY_KEYS)
        for unit_id in self.units:
            register, _ = step(register, ConfirmOutside(unit_id, PERSONS[0]), LATE_S)
        return ManagerState(True, 1, (0,) * len(self.units), plain(register))

    def hear(self, state: ManagerState, unit: int, telegram: InAir, granted: int) -> ManagerStep:
        """A telegram comes in; one for an earlier boot is answered with that. `granted`: the correlation of the last
        grant to this unit, which stands outside the state.
        """
        if not state.power:
            return ManagerStep(state)
        heard = opened(self.units[unit], telegram, state.epoch, state.heard[unit])
        if heard is DropReason.EARLIER_BOOT:
            restarted = InAir(state.epoch, state.heard[unit], 0, Restarted())
            return ManagerStep(state, ((unit, restarted),), granted)
        if isinstance(heard, DropReason):
            return ManagerStep(state, (), granted)
        boots = (*state.heard[:unit], heard.epoch, *state.heard[unit + 1 :])
        event = Heard(heard.source, heard.epoch, heard.fresh, heard.correlation, heard.message)
        register = state.kept.register
        known = register.unit(heard.source)
        if known.correlation:
            register = register.with_unit(heard.source, replace(known, correlation=granted))
        return self._took(state._replace(heard=boots, kept=PlainRegister(register, None)), event, unit)

    def grants(self, state: ManagerState) -> int:
        """Units (as bits) to whose last grant a request may still be a repetition."""
        units = state.kept.register.units
        return sum(1 << i for i, u in enumerate(self.units) if u in units and units[u].correlation)

    def boundary_passed(self, state: ManagerState) -> ManagerStep:
        """The contact at the boundary has counted a train out."""
        return self._took(state, BoundaryPassed(PORTAL)) if state.power else ManagerStep(state)

    def events(self, state: ManagerState) -> tuple[ManagerEvent, ...]:
        """All that can happen besides telegrams; what changes nothing and says nothing is left out."""
        if not state.power:
            return (ManagerEvent("power is back", self._booted(state)),)
        found = (*self._asks(state), *self._words(state), *self._bars(state), self._fails(state))
        return tuple(e for e in found if e.state != state or e.sends)

    def holders(self, state: ManagerState) -> tuple[int, ...]:
        """By unit: what it holds by the register, as bits."""
        return tuple(mask_of(state.kept.register.held_by(unit_id)) for unit_id in self.units)

    def _took(self, state: ManagerState, event: Event, unit: int = -1, now_s: float = LATE_S) -> ManagerStep:
        before = state.kept.register
        after, actions = step(before, event, now_s)
        sends = sealed(self.units, state.epoch, state.heard, actions)
        granted = any(isinstance(sent.message, RouteGranted) for _, sent in sends)
        bad = GRANTED_IN_DOUBT if granted and not before.defined else state.bad
        correlation = after.unit(self.units[unit]).correlation if unit >= 0 else 0
        return ManagerStep(state._replace(kept=plain(after), bad=bad), sends, correlation)

    def _asks(self, state: ManagerState) -> Iterator[ManagerEvent]:
        if wake_at_s(state.kept.register) is not None:
            after, sends, _ = self._took(state, AskUnits())
            yield ManagerEvent("asks the units", after, sends)

    def _words(self, state: ManagerState) -> Iterator[ManagerEvent]:
        """True words: that the picture is right, where a silent train stands, or what was said before is not so."""
        register = state.kept.register
        if register.restoring and not reentry.missing_for_acceptance(register):
            after, sends, _ = self._took(state, AcceptPicture(PERSONS[0]))
            yield ManagerEvent("a person accepts the picture", after, sends, word=True)
        lacking = reentry.missing(register).unit_ids
        for unit, unit_id in enumerate(self.units):
            corrects = self._corrects(state, unit_id)
            if corrects or unit_id in lacking:
                yield from self._words_of(state, unit, corrects=corrects)
            if register.restoring:
                yield from self._taken_back(state, unit_id)

    def _taken_back(self, state: ManagerState, unit_id: str) -> Iterator[ManagerEvent]:
        """While the line is restored, whoever has said something of a unit may take that back."""
        for person in reentry.words_for(state.kept.register, unit_id):
            after, sends, _ = self._took(state, TakeBack(unit_id, person))
            yield ManagerEvent(f"{person} takes back what was said of {unit_id}", after, sends, word=True)

    def _bars(self, state: ManagerState) -> Iterator[ManagerEvent]:
        """Two persons bar a unit that nothing is wrong with, or unbar one."""
        for unit_id in self.units if self._may_bar else ():
            barred = unit_id in state.kept.register.bars.barred
            after, sends = state, tuple[tuple[int, InAir], ...]()
            for person in PERSONS:
                word = UnbarUnit(unit_id, person) if barred else BarUnit(unit_id, person)
                after, more, _ = self._took(after, word, now_s=BEFORE_S)
                sends = (*sends, *more)
            name = f"{' and '.join(PERSONS)} {'unbar' if barred else 'bar'} {unit_id}"
            yield ManagerEvent(name, after, sends, UnwishedFor.NONE if barred else UnwishedFor.WORD)

    def errs(self, state: ManagerState) -> tuple[ManagerEvent, ...]:
        """Words of persons that are not true, or about a unit that speaks for itself."""
        if not state.power:
            return ()
        return tuple(
            told._replace(trouble=UnwishedFor.WORD)
            for unit, unit_id in enumerate(self.units)
            for told in self._words_of(
                state, unit, corrects=self._corrects(state, unit_id), by=self._who_errs
            )
            if told.state != state or told.sends
        )

    def _corrects(self, state: ManagerState, unit_id: str) -> bool:
        register = state.kept.register
        unit = register.unit(unit_id)
        doubted = unit.standing is UnitStanding.LEAVING and unit.unproven  # as the manager has shown
        said = bool(unit.by) or bool(reentry.words_for(register, unit_id))
        return (said or doubted) and not register.restoring

    def _words_of(
        self, state: ManagerState, unit: int, *, corrects: bool, by: tuple[tuple[str, ...], ...] = ONE_BY_ONE
    ) -> Iterator[ManagerEvent]:
        unit_id = self.units[unit]
        for persons in by:
            for stands in (0, *self._places):
                after, sends = state, tuple[tuple[int, InAir], ...]()
                for person in persons:
                    word = (
                        ConfirmHolding(unit_id, sections_of(stands), person)
                        if stands
                        else ConfirmOutside(unit_id, person, PORTAL)
                    )
                    after, more, _ = self._took(after, word)
                    sends = (*sends, *more)
                where = " ".join(sections_of(stands)) or "off the line"
                says = f"{' and '.join(persons)} say{'s' * (len(persons) == 1)}"
                name = f"{says} that {unit_id} is {'in ' if stands else ''}{where}"
                yield ManagerEvent(
                    name,
                    after,
                    sends,
                    about=unit,
                    stands=stands,
                    word=True,
                    corrects=corrects,
                    quiet=self._may_bar,
                )

    def _fails(self, state: ManagerState) -> ManagerEvent:
        register = state.kept.register
        memory = self._started(state.epoch, register)
        off = ManagerState(False, state.epoch, (0,) * len(self.units), plain(memory))
        return ManagerEvent("power fails", off, trouble=UnwishedFor.POWER)

    def _booted(self, state: ManagerState) -> ManagerState:
        register = self._started(state.epoch + 1, state.kept.register)
        return ManagerState(True, state.epoch + 1, state.heard, plain(register))

    def _started(self, epoch: int, register: Register) -> Register:
        return start(
            self._config, epoch, CAPABILITY_KEYS, register.ledger, register.unswept, {}, bars=register.bars
        )
