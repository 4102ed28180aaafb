"""An on-board unit as a party of a run: its event-driven part in a process of its own, if you like.

The compiled tick stays with the body that it drives; what passes between the two is what passes through the unit's one
door: where the train is and what happened, and what the unit wants of its driving part.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import msgspec

from host.parties import Parties
from host.party import Advance, Codec, PartySpec, Role
from host.speech import Speech
from host.store import PartyStore, raise_epoch
from network.errors import InputError
from onboard.duty.records import DrivingCommand, DutyState, Told
from onboard.duty_parameters import DutyParameters
from onboard.notes import Note
from onboard.plan import DutyPlan
from onboard.unit import OnboardUnit, Report, Telegram, UnitAnswer
from radio.envelope import AGE_MAX_S, Endpoint
from radio.keys import KeyRing
from radio.messages import Claim


class UnitConfig(msgspec.Struct, frozen=True, tag="unit"):
    """What a unit must know before it is switched on; its line data come with the train number."""

    line_id: str
    device_id: str
    manager_id: str
    parameters: DutyParameters
    telegram_age_max_s: float = AGE_MAX_S


class UnitSaid(msgspec.Struct, frozen=True):
    """What a unit says besides telegrams."""

    command: DrivingCommand
    told: tuple[Told, ...]
    notes: tuple[Note, ...]


CODEC: Final = Codec(Report, UnitSaid)
_CONFIG: Final = msgspec.json.Decoder(UnitConfig)


def unit_of(config: UnitConfig, endpoint: Endpoint, *, perhaps_on_line: bool | None = None) -> OnboardUnit:
    """A unit that has just been switched on; `perhaps_on_line` as in `onboard.unit`."""
    return OnboardUnit(
        config.device_id, config.manager_id, config.parameters, endpoint, perhaps_on_line=perhaps_on_line
    )


def unit_specs(units: Iterable[tuple[UnitConfig, KeyRing]]) -> tuple[PartySpec, ...]:
    """What is needed to start units as parties."""
    return tuple(
        PartySpec(config.line_id, config.device_id, Role.UNIT, msgspec.json.encode(config), keys)
        for config, keys in units
    )


class _UnitMemory(msgspec.Struct, frozen=True, array_like=True):
    """What a unit keeps: whether it is, or may be, on the line."""

    on_line: bool = False


def _was_on_line(kept: bytes | None) -> bool:
    """What a unit kept; one that never ran was not on the line, one that lost it may have been."""
    if not kept:
        return kept is None
    try:
        return msgspec.msgpack.decode(kept, type=_UnitMemory).on_line
    except msgspec.MsgspecError:
        return True


class HostedUnit:
    """A unit and its durable state. Making it is a boot: the epoch is raised and saved first.

    That it is on the line is saved before anything leaves it that follows from that; that it is not, when it is.
    """

    def __init__(self, config: UnitConfig, keys: KeyRing, store: PartyStore) -> None:
        self._store: Final = store
        self._durable = raise_epoch(store)
        self._kept = _was_on_line(self._durable.spare)
        self._manager_id: Final = config.manager_id
        self._speech: Final = Speech(keys, self._durable.epoch, config.telegram_age_max_s)
        self._unit: Final = unit_of(config, self._speech, perhaps_on_line=self._kept)

    @property
    def epoch(self) -> int:
        """Number of this boot."""
        return self._durable.epoch

    @property
    def state(self) -> DutyState:
        """Where the unit is in its duty."""
        return self._unit.state

    @property
    def plan(self) -> DutyPlan:
        """The plan that its duty is on."""
        return self._unit.plan

    def advance(self, now_s: float, telegrams: Sequence[bytes], report: Report) -> UnitAnswer:
        """Act at `now_s` on what happened, telegrams and timers."""
        before, self._speech.claims_besides = self._speech.claims_besides, report.claims_besides
        answer = self._unit.advance(now_s, telegrams, report)
        if not set(report.claims_besides) <= set(before):
            answer = msgspec.structs.replace(answer, telegrams=(*answer.telegrams, *self._unasked(now_s)))
        on_line = self.state.authority.perhaps_on_line
        if on_line is not self._kept:
            self._kept = on_line
            spare = msgspec.msgpack.encode(_UnitMemory(on_line))
            self._durable = msgspec.structs.replace(self._durable, spare=spare)
            self._store.save(self._durable)
        return answer

    def _unasked(self, now_s: float) -> tuple[Telegram, ...]:
        """The claim with which false ones begin; none of a unit that does not know what it holds."""
        authority = self.state.authority
        if authority.perhaps_on_line and not authority.held:
            return ()
        data = self._speech.seal(self._manager_id, Claim(authority.held, 0), now_s)
        return (Telegram(self._manager_id, data),)


class UnitParty:
    """`host.party.Party` over a `HostedUnit`."""

    def __init__(self, spec: PartySpec, store: PartyStore, file: str) -> None:
        try:
            config = _CONFIG.decode(spec.config)
        except msgspec.MsgspecError as error:
            raise InputError(file, "", None, f"the configuration of an on-board unit ({error})") from None
        if (config.line_id, config.device_id) != (spec.line_id, spec.party_id):
            given = f"unit {spec.party_id} of line {spec.line_id}"
            expected = f"unit {config.device_id} of line {config.line_id}, as it was configured"
            raise InputError(file, "device", given, expected)
        self._unit: Final = HostedUnit(config, spec.keys, store)

    @property
    def epoch(self) -> int:
        """Number of this boot."""
        return self._unit.epoch

    @property
    def on_duty(self) -> tuple[DutyPlan, DutyState]:
        """The plan that its duty is on, and where it is in it."""
        return self._unit.plan, self._unit.state

    def advance(self, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Act at `now_s` on what happened, telegrams and timers."""
        answer = self._unit.advance(now_s, telegrams, CODEC.decode_told(told))
        said = CODEC.encode(UnitSaid(answer.command, answer.told, answer.notes))
        sent = tuple((telegram.destination, telegram.data) for telegram in answer.telegrams)
        return Advance(sent, said, answer.wake_at_s)


class PartyUnits:
    """The door to the units among `parties`: their records instead of bytes. See `host.units.Units`."""

    def __init__(self, parties: Parties) -> None:
        self._parties = parties

    def advance(self, unit_id: str, now_s: float, telegrams: Sequence[bytes], report: Report) -> UnitAnswer:
        """Let a unit act at `now_s`. PartyError if it is down."""
        done = self._parties.advance(unit_id, now_s, telegrams, CODEC.encode(report))
        said = CODEC.decode_said(done.said)
        sent = tuple(Telegram(destination, data) for destination, data in done.telegrams)
        return UnitAnswer(sent, said.command, said.told, said.notes, done.wake_at_s)

    def kill(self, unit_id: str) -> None:
        """Power cut."""
        self._parties.kill(unit_id)

    def restart(self, unit_id: str) -> None:
        """Power back: a new boot. NotCommissioned if its durable state is lost."""
        self._parties.restart(unit_id)

    def lose(self, unit_id: str) -> None:
        """Its durable state is gone."""
        self._parties.lose(unit_id)

    def commission(self, unit_id: str, number: int) -> None:
        """People put it into service again."""
        self._parties.commission(unit_id, number, b"")
