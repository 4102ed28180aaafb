"""Invariant: from when a unit is told that the crossing is closed until that unit has said that it is over it, or has
given it up, the crossing is commanded closed; a proof is sent only while lamps and barriers are detected so and nothing
is on the road.

The device of a level crossing (踏切制御装置) as a pure machine: `step(device, event, now_s) -> (device, actions)`, with
`now_s` as time that has passed, not as a clock shows it. A unit says how soon its front can be there; the warning
begins so much before that as the line has it, so that it lasts as long for slow trains as for fast ones
(踏切警報時間の定時間化). It says so again and again: a proof holds for `VALID_S`, and silence takes it away, but never
opens the crossing. A unit may put its time off while the crossing is still open; once that is closing, only the
unit's word that it is over it, or has given it up, counts. Which units have announced themselves is its durable
memory: after a restart the crossing stays closed until each of them has said so. Two persons may say that no train
comes (踏切の復帰扱い): proofs are taken back, and who says nothing for `FREES_S` from then on is struck off. Controlled
by contacts it closes when a front passes the first and opens when as many rears have passed the last; with protection,
units that ask are told whether anything is known to be on it, and nothing else. With departures a train that begins
beyond the first contact is announced by its unit, and counts as if that had counted it in: its rear counts it out, or
its unit, which gives it up.
`TABLE` is the state of the crossing and the kind of event.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from enum import Enum
from types import MappingProxyType
from typing import Any, Final

import msgspec
from msgspec.structs import replace

from radio.messages import CrossingClear, CrossingOver, CrossingOverHeard, CrossingProof, CrossingRequest
from wayside import barring
from wayside.actions import Action, Drive, Send, Show
from wayside.barring import NO_BARS, Bars
from wayside.config import CrossingConfig
from wayside.crossing_said import (
    CloseCrossing,
    CrossingContact,
    CrossingDetected,
    CrossingOpens,
    CrossingProven,
    CrossingUnproven,
    CrossingWarns,
    NoTrainComes,
    NoTrainSaid,
    OpenCrossing,
    WhyUnproven,
)
from wayside.said import Barred, BarUnit, Unbarred, UnbarUnit

VALID_S: Final = 15.0  # assumed: in the second half of it a unit can ask again three times
TELEGRAM_S: Final = 1.0  # assumed: a proof under way
# Of who says nothing the last proof has died, 20 s after it was sent at the latest, and who could not stop any more
# then has come onto the road: 44 s later from 110 km/h at 0.7 m/s2.
FREES_S: Final = 65.0
PERSONS: Final = 2  # who must say the same
WHOEVER: Final = (
    ""  # had announced itself, or passed a contact, and is not known: it never says that it is over it
)
_TIME_TOLERANCE_S: Final = 1e-9


class CrossingState(Enum):
    """What the device has commanded, and knows."""

    OPEN = "open"
    CLOSING = "closing"  # commanded, not (or no longer) detected
    CLOSED = "closed"  # as detected


class CrossingMemory(msgspec.Struct, frozen=True, array_like=True):
    """Durable state: units that have announced themselves, trains that contacts have counted in and not out, barred
    units.
    """

    units: tuple[str, ...] = ()
    counted: int = 0
    bars: Bars = NO_BARS


class Approach(msgspec.Struct, frozen=True, array_like=True):
    """A unit that comes: its warning must begin then (s); one known from before a restart, or from before persons said
    that no train comes, is due at once.
    """

    starts_s: float = -math.inf
    correlation: int = 0


class CrossingDevice(msgspec.Struct, frozen=True):
    """State of the device.

    `lit_s`: since when lamps are detected; `deadline_s`: when what was commanded must be detected; `believed_s`: until
    then a unit may still go by what was proved of lamps that went out.
    `persons` have said since a train was announced or counted in last that no train comes; two of them strike off at
    `frees_s` who has said nothing since, and as many as were `doubted` of the trains that contacts have counted in.
    `listening`: units that are told whether anything is on it, and the correlation of what each asked last.
    """

    config: CrossingConfig
    memory: CrossingMemory
    state: CrossingState = CrossingState.OPEN
    approaches: Mapping[str, Approach] = msgspec.field(default_factory=dict[str, Approach])
    detected: CrossingDetected = CrossingDetected(lamps=False, lowered=False, raised=False)
    lit_s: float = math.inf
    deadline_s: float | None = None
    believed_s: float = -math.inf
    persons: tuple[str, ...] = ()
    frees_s: float = math.inf
    doubted: int = 0
    listening: Mapping[str, int] = msgspec.field(default_factory=dict[str, int])


class ClosureAsked(msgspec.Struct, frozen=True):
    """Event: a request passed the envelope's checks."""

    unit_id: str
    correlation: int
    message: CrossingRequest


class CrossingLeft(msgspec.Struct, frozen=True):
    """Event: a unit's word that it is over it, or has given it up, passed the envelope's checks."""

    unit_id: str
    correlation: int
    message: CrossingOver


class CrossingTimeDue(msgspec.Struct, frozen=True):
    """Event: look at the times at which warnings must begin, and at the limit of what was commanded."""


CrossingEvent = (
    ClosureAsked
    | CrossingLeft
    | CrossingDetected
    | CrossingContact
    | NoTrainComes
    | BarUnit
    | UnbarUnit
    | CrossingTimeDue
)
CrossingStep = tuple[CrossingDevice, tuple[Action, ...]]


def start(
    config: CrossingConfig, memory: CrossingMemory, *, lost: bool = False, again: bool = False
) -> CrossingDevice:
    """A device after a (re)start: closed, for whoever had announced itself; `lost`: nobody knows who had, and may stand
    on it unheard, so persons must say that no train comes. `again`: so they must where contacts control it, which any
    number of fronts and rears may have passed while it was dark.
    """
    if lost or (again and config.contacts):
        memory = replace(memory, units=(*memory.units, WHOEVER))
    wanted = bool(memory.units or memory.counted)
    return CrossingDevice(
        config,
        memory,
        CrossingState.CLOSING if wanted else CrossingState.OPEN,
        dict.fromkeys(memory.units, Approach()),
    )


def step(device: CrossingDevice, event: CrossingEvent, now_s: float) -> CrossingStep:
    """The next state and what to do. Never raises for what a unit sends."""
    if isinstance(event, BarUnit | UnbarUnit):
        return _bar(device, event, now_s)
    if isinstance(event, ClosureAsked | CrossingLeft) and event.unit_id in device.memory.bars.barred:
        return device, ()
    after, actions = TABLE[device.state, type(event)](device, event, now_s)
    if after.detected.is_free is not device.detected.is_free:
        actions = (*actions, *(_clear(after, unit_id) for unit_id in after.listening))
    kept = CrossingMemory(tuple(sorted(after.approaches)), after.memory.counted, after.memory.bars)
    return (after if kept == after.memory else replace(after, memory=kept)), actions


def _bar(device: CrossingDevice, event: BarUnit | UnbarUnit, now_s: float) -> CrossingStep:
    """What it says counts no more, or counts again, once a second person says the same; it has no proof, and what is
    closed for it stays closed. One that it has had since persons spoke dies before anybody is struck off.
    """
    before, bar = device.memory.bars, isinstance(event, BarUnit)
    bars = barring.bars_after_word(before, event.unit_id, event.person, bar=bar)
    device = replace(device, memory=replace(device.memory, bars=bars))
    if bars.barred == before.barred:
        return device, ()
    note = Barred if bar else Unbarred
    device, withdrawn = _doubted(device, {event.unit_id})
    if withdrawn and device.frees_s < math.inf:
        device = replace(device, frees_s=now_s + FREES_S)
    return device, (Show(note(unit_id=event.unit_id, by=event.person)), *withdrawn)


def _doubted(device: CrossingDevice, unit_ids: Collection[str]) -> tuple[CrossingDevice, tuple[Send, ...]]:
    """These count as not heard, and whoever of them has been is told that he has no proof."""
    mine = {unit_id: each for unit_id, each in device.approaches.items() if unit_id in unit_ids}
    withdrawn = tuple(
        Send(unit_id, CrossingProof(False, VALID_S), approach.correlation)
        for unit_id, approach in mine.items()
        if approach.starts_s > -math.inf
    )
    unheard = dict.fromkeys(mine, Approach())
    return replace(device, approaches={**device.approaches, **unheard}), withdrawn


def wake_at_s(device: CrossingDevice) -> float | None:
    """When the next warning must begin, or what was commanded must be detected, or who is silent is struck off."""
    times_s = [device.frees_s]
    if device.state is CrossingState.OPEN:
        times_s += [approach.starts_s for approach in device.approaches.values()]
    elif device.state is CrossingState.CLOSING and _shuts(device):
        times_s.append(_proves_from_s(device))
    elif device.deadline_s is not None:
        times_s.append(device.deadline_s)
    return min((time_s for time_s in times_s if math.isfinite(time_s)), default=None)


def _wanted(device: CrossingDevice) -> bool:
    """Whether any train is announced, or was counted in."""
    return bool(device.approaches or device.memory.counted)


def _seen(device: CrossingDevice, detected: CrossingDetected, now_s: float) -> CrossingDevice:
    """What its contacts show now."""
    begins = detected.lamps and not device.detected.lamps
    lit_s = now_s if begins else device.lit_s if detected.lamps else math.inf
    return replace(device, detected=detected, lit_s=lit_s)


def _shuts(device: CrossingDevice) -> bool:
    """Whether lamps shine, barriers are down and nothing is on the road, as detected."""
    seen = device.detected
    return seen.lamps and (seen.lowered or not device.config.barriers) and seen.is_free


def _proves_from_s(device: CrossingDevice) -> float:
    """When the warning has been given for its time until closed, and nobody goes by one before it."""
    return max(device.lit_s + device.config.closing_s, device.believed_s)


def _shows_closed(device: CrossingDevice, now_s: float) -> bool:
    """Whether they do, and the warning has been given for its time until closed: lamps may have failed meanwhile."""
    return _shuts(device) and now_s >= _proves_from_s(device) - _TIME_TOLERANCE_S


def _starts_s(config: CrossingConfig, request: CrossingRequest, now_s: float) -> float:
    """When the warning must begin: constant before the front, or earlier for one that must brake before that."""
    before_front_s = request.arrives_s - config.closing_s - config.closed_s
    before_proof_s = request.proof_s - config.closing_s - TELEGRAM_S
    return now_s + min(before_front_s, before_proof_s)


def _clear(device: CrossingDevice, unit_id: str) -> Send:
    return Send(unit_id, CrossingClear(device.detected.is_free, VALID_S), device.listening[unit_id])


def _listen(device: CrossingDevice, event: ClosureAsked) -> CrossingStep:
    """Contacts close it, whatever a unit asks; it is told, now and at each change, whether anything is on it."""
    device = replace(device, listening={**device.listening, event.unit_id: event.correlation})
    return device, (_clear(device, event.unit_id),)


def _proof(device: CrossingDevice, unit_id: str) -> Send:
    proof = CrossingProof(device.state is CrossingState.CLOSED, VALID_S)
    return Send(unit_id, proof, device.approaches[unit_id].correlation)


def _proofs(device: CrossingDevice) -> tuple[Send, ...]:
    """To everyone who has been heard since the last restart."""
    heard = (unit_id for unit_id, approach in device.approaches.items() if approach.starts_s > -math.inf)
    return tuple(_proof(device, unit_id) for unit_id in heard)


def _announced(device: CrossingDevice, event: ClosureAsked, now_s: float) -> CrossingDevice:
    approach = Approach(_starts_s(device.config, event.message, now_s), event.correlation)
    known = device.approaches.get(event.unit_id)
    device = _comes(device) if known is None else device
    device = replace(device, approaches={**device.approaches, event.unit_id: approach})
    if not device.config.departures:
        return device
    if known is None:
        return _counted(device, 1)
    heard_again = known.starts_s == -math.inf
    return replace(device, doubted=max(device.doubted - 1, 0)) if heard_again else device


def _comes(device: CrossingDevice) -> CrossingDevice:
    """A train comes: what one person alone has said before was not said of it."""
    return replace(device, persons=()) if device.frees_s == math.inf else device


def _counted(device: CrossingDevice, more: int) -> CrossingDevice:
    """So many trains more, or fewer, are between the contacts."""
    return replace(device, memory=replace(device.memory, counted=max(device.memory.counted + more, 0)))


def _close(device: CrossingDevice, unit_id: str, now_s: float) -> CrossingStep:
    closing = replace(
        device,
        state=CrossingState.CLOSING,
        deadline_s=now_s + 1.5 * device.config.closing_s + TELEGRAM_S,
    )
    return closing, (Show(CrossingWarns(unit_id=unit_id)), Drive(CloseCrossing(device.config.device_id)))


def _ask_open(device: CrossingDevice, event: ClosureAsked, now_s: float) -> CrossingStep:
    """Announced: the warning begins in its time, which the unit may still put off or bring forward."""
    if device.config.protection:
        return _listen(device, event)
    device = _announced(device, event, now_s)
    device, actions = _begin_due(device, CrossingTimeDue(), now_s)
    return device, (*actions, _proof(device, event.unit_id))


def _ask_closing(device: CrossingDevice, event: ClosureAsked, now_s: float) -> CrossingStep:
    """Announced: closed for it, too; it is told whether that is detected, and since when."""
    if device.config.protection:
        return _listen(device, event)
    device = _announced(device, event, now_s)
    return device, (_proof(device, event.unit_id),)


def _begin_due(device: CrossingDevice, _event: CrossingTimeDue, now_s: float) -> CrossingStep:
    """The warning begins for the first unit whose time has come."""
    due = [
        (approach.starts_s, unit_id)
        for unit_id, approach in device.approaches.items()
        if approach.starts_s <= now_s + _TIME_TOLERANCE_S
    ]
    return _close(device, min(due)[1], now_s) if due else (device, ())


def _leave_open(device: CrossingDevice, event: CrossingLeft, _now_s: float) -> CrossingStep:
    """Not announced any more; confirmed, as often as it is said."""
    if device.config.departures and event.unit_id in device.approaches and not event.message.passed:
        device = _counted(device, -1)  # no rear of its train does that
    left = {unit_id: each for unit_id, each in device.approaches.items() if unit_id != event.unit_id}
    listening = {unit_id: each for unit_id, each in device.listening.items() if unit_id != event.unit_id}
    return replace(device, approaches=left, listening=listening), (
        Send(event.unit_id, CrossingOverHeard(), event.correlation),
    )


def _leave_closed(device: CrossingDevice, event: CrossingLeft, now_s: float) -> CrossingStep:
    """Not announced any more; opens behind the last one. Confirmed, as often as it is said."""
    device, confirmed = _leave_open(device, event, now_s)
    device, opened = _open_if_free(device)
    return device, (*confirmed, *opened)


def _open_if_free(device: CrossingDevice, struck_off: tuple[str, ...] = ()) -> CrossingStep:
    if _wanted(device):
        return device, ()
    opened = replace(
        device,
        state=CrossingState.OPEN,
        deadline_s=None,
        persons=(),
        frees_s=math.inf,
        doubted=0,
    )
    opens = CrossingOpens(struck_off=struck_off)
    return opened, (Show(opens), Drive(OpenCrossing(device.config.device_id)))


def _hear_person_open(device: CrossingDevice, _event: NoTrainComes, _now_s: float) -> CrossingStep:
    """Nobody waits there."""
    return device, ()


def _hear_person(device: CrossingDevice, event: NoTrainComes, now_s: float) -> CrossingStep:
    """One person alone changes nothing; two take every proof back, and strike off who says nothing from then on."""
    person = barring.person_key(event.person)
    if person in device.persons:
        return device, ()
    device = replace(device, persons=(*device.persons, person))
    agreed = len(device.persons) >= PERSONS
    said = Show(NoTrainSaid(by=event.person, agreed=agreed))
    if not agreed or device.frees_s < math.inf:
        return device, (said,)
    device, withdrawn = _doubted(device, device.approaches)
    frees_s = now_s + FREES_S
    return replace(device, frees_s=frees_s, doubted=device.memory.counted), (said, *withdrawn)


def _strike_off(device: CrossingDevice, now_s: float) -> tuple[CrossingDevice, tuple[str, ...]]:
    """Who has said nothing since two persons said that no train comes, if that is long enough ago."""
    if now_s < device.frees_s - _TIME_TOLERANCE_S:
        return device, ()
    silent = tuple(sorted(u for u, approach in device.approaches.items() if approach.starts_s == -math.inf))
    heard = {unit_id: each for unit_id, each in device.approaches.items() if unit_id not in silent}
    counted = max(device.memory.counted - device.doubted, 0)
    struck_off = (*silent, *[""] * (device.memory.counted - counted))
    memory = replace(device.memory, counted=counted)
    device = replace(device, approaches=heard, memory=memory, persons=(), frees_s=math.inf, doubted=0)
    return device, struck_off


def _detect_open(device: CrossingDevice, event: CrossingDetected, now_s: float) -> CrossingStep:
    """Remembered; what is not raised, as after a power cut, is opened."""
    device = _seen(device, event, now_s)
    return device, () if event.raised else (Drive(OpenCrossing(device.config.device_id)),)


def _detect_closing(device: CrossingDevice, event: CrossingDetected, now_s: float) -> CrossingStep:
    """Closed, as detected: the proof goes to all that have announced themselves."""
    return _prove(_seen(device, event, now_s), now_s)


def _prove(device: CrossingDevice, now_s: float) -> CrossingStep:
    if not _shows_closed(device, now_s):
        commanded = device.deadline_s is not None or _shuts(device)
        return (device, ()) if commanded else _close(device, "", now_s)
    device = replace(device, state=CrossingState.CLOSED, deadline_s=None)
    return device, (Show(CrossingProven()), *_proofs(device))


def _detect_closed(device: CrossingDevice, event: CrossingDetected, now_s: float) -> CrossingStep:
    """A proof that no longer holds is withdrawn at once, unasked."""
    device = _seen(device, event, now_s)
    if _shuts(device):
        return device, ()
    device = replace(
        device,
        state=CrossingState.CLOSING,
        deadline_s=now_s + device.config.closing_s + TELEGRAM_S,
    )
    if not (device.config.barriers or device.detected.lamps):  # the road is open: its least time begins anew
        told_s = now_s + VALID_S + device.config.telegram_age_max_s
        device = replace(device, believed_s=told_s, deadline_s=told_s + TELEGRAM_S)
    seen = device.detected
    why = WhyUnproven.BUTTON if seen.button else WhyUnproven.OBSTACLE if seen.obstacle else WhyUnproven.LOST
    return device, (Show(CrossingUnproven(why=why)), *_proofs(device))


def _expire(device: CrossingDevice, _event: CrossingTimeDue, now_s: float) -> CrossingStep:
    """Not detected in time is noted, and stays commanded; who is silent since persons spoke is struck off."""
    actions: tuple[Action, ...] = ()
    if device.state is CrossingState.CLOSING and _shows_closed(device, now_s):
        device, actions = _prove(device, now_s)
    if device.deadline_s is not None and now_s >= device.deadline_s - _TIME_TOLERANCE_S:
        device = replace(device, deadline_s=math.inf)
        actions = (Show(CrossingUnproven(why=WhyUnproven.LATE)),)
    device, struck_off = _strike_off(device, now_s)
    device, opened = _open_if_free(device, struck_off)
    return device, (*actions, *opened)


def _contact_open(device: CrossingDevice, event: CrossingContact, now_s: float) -> CrossingStep:
    """A front at the first contact: closes. A rear at the last one, that nobody counted in, means nothing."""
    if not event.first:
        return _counted(device, -1), ()
    return _close(_counted(device, 1), "", now_s)


def _contact_closed(device: CrossingDevice, event: CrossingContact, _now_s: float) -> CrossingStep:
    """Another front counted in, or a rear counted out: opens behind the last one."""
    device = _counted(device, 1 if event.first else -1)
    return (_comes(device), ()) if event.first else _open_if_free(device)


TABLE: Final[Mapping[tuple[CrossingState, type], Callable[[CrossingDevice, Any, float], CrossingStep]]] = (
    MappingProxyType(
        {
            (CrossingState.OPEN, ClosureAsked): _ask_open,
            (CrossingState.OPEN, CrossingLeft): _leave_open,
            (CrossingState.OPEN, CrossingDetected): _detect_open,
            (CrossingState.OPEN, CrossingContact): _contact_open,
            (CrossingState.OPEN, NoTrainComes): _hear_person_open,
            (CrossingState.OPEN, CrossingTimeDue): _begin_due,
            (CrossingState.CLOSING, ClosureAsked): _ask_closing,
            (CrossingState.CLOSING, CrossingLeft): _leave_closed,
            (CrossingState.CLOSING, CrossingDetected): _detect_closing,
            (CrossingState.CLOSING, CrossingContact): _contact_closed,
            (CrossingState.CLOSING, NoTrainComes): _hear_person,
            (CrossingState.CLOSING, CrossingTimeDue): _expire,
            (CrossingState.CLOSED, ClosureAsked): _ask_closing,
            (CrossingState.CLOSED, CrossingLeft): _leave_closed,
            (CrossingState.CLOSED, CrossingDetected): _detect_closed,
            (CrossingState.CLOSED, CrossingContact): _contact_closed,
            (CrossingState.CLOSED, NoTrainComes): _hear_person,
            (CrossingState.CLOSED, CrossingTimeDue): _expire,
        }
    )
)
