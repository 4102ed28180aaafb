"""What a dispatcher has a train do: wait, until a time or until another has a section (交換順序), or end where it
stands and go on as a later train of its set (途中折返し, 運休).

Invariant: it only keeps a route back. Nothing is granted by it that would not be granted without; a wait ends by its
time, whoever forgets it, and all of it is forgotten with the power of the manager.
"""

from __future__ import annotations

from typing import Final

from msgspec.structs import replace

from radio.messages import RefusalReason, RouteRequest, TrainOrdered
from wayside.actions import Action, Show
from wayside.register import Against, BiddenUnit, Register
from wayside.said import EndTrain, LetGo, LetWait, Refused, TrainEndBidden, WaitBidden, WaitOver

Bid = LetWait | LetGo | EndTrain
TOLD_MAX: Final = 6  # assumed: so often a train is told to end, as the order may be lost
WAITS = True  # off: nobody is kept back by what a dispatcher says


def bid(register: Register, event: Bid, now_s: float) -> tuple[Register, tuple[Action, ...]]:
    """The register after what a dispatcher has said of a train; it counts at once, since it only keeps back."""
    why = _why_not(register, event)
    return (register, (_refused(event, why),)) if why else _taken(register, event, now_s)


def _taken(register: Register, event: Bid, now_s: float) -> tuple[Register, tuple[Action, ...]]:
    unit_id, by = event.unit_id, event.person
    match event:
        case LetGo():
            return _without(register, unit_id), (Show(WaitOver(unit_id=unit_id, by=by)),)
        case EndTrain(next_train=train):
            note = TrainEndBidden(unit_id=unit_id, train=train, by=by)
            return _with(register, unit_id, BiddenUnit(next_train=train)), (Show(note),)
        case LetWait(hold_s=hold_s, behind=behind, section_id=section_id):
            bidden = BiddenUnit(now_s + hold_s, behind, section_id)
            shown = WaitBidden(unit_id=unit_id, hold_s=hold_s, other_id=behind, section_id=section_id, by=by)
            return _with(register, unit_id, bidden), (Show(shown),)


def _why_not(register: Register, event: Bid) -> str:
    """Why that cannot be; empty: it can."""
    unit_id = event.unit_id
    if unit_id not in register.plan.unit_ids or not event.person:
        return "not on the fleet list"
    match event:
        case LetGo():
            return "" if unit_id in register.bidden else "it is not kept back"
        case EndTrain():
            stands = len(register.held_by(unit_id)) == 1
            return "" if stands else "it does not stand in one track with nothing ahead granted"
        case LetWait(behind=behind, section_id=section_id):
            return _senseless(register, unit_id, behind, section_id)


def _senseless(register: Register, unit_id: str, behind: str, section_id: str) -> str:
    """Why a wait cannot be meant so; empty: it can."""
    if bool(behind) is not bool(section_id):
        return "say both which train goes first and over which section"
    if not behind:
        return ""
    if behind == unit_id or behind not in register.plan.unit_ids:
        return "it cannot wait for that train"
    if section_id not in register.plan.order:
        return "there is no such section"
    other = register.bidden.get(behind)
    if other is not None and other.behind == unit_id:
        return "the two would wait for each other"
    return ""


def heard(
    register: Register, unit_id: str, route_id: str, now_s: float
) -> tuple[Register, Against | TrainOrdered | None]:
    """The register as a unit asks for a route: why not now, or what it is told instead; None: nothing keeps it back."""
    mine = register.bidden.get(unit_id)
    if mine is None or not WAITS:
        return register, None
    if mine.next_train:
        if mine.told >= TOLD_MAX or len(register.held_by(unit_id)) != 1:
            return _without(register, unit_id), None
        told = replace(mine, told=mine.told + 1)
        return _with(register, unit_id, told), TrainOrdered(route_id, mine.next_train)
    if now_s >= mine.until_s:
        return _without(register, unit_id), None
    return register, (RefusalReason.NOT_ITS_TURN, mine.section_id or None, mine.behind or None)


def weighed(
    register: Register, unit_id: str, message: RouteRequest, against: Against | None
) -> tuple[Register, Against | None, TrainOrdered | None]:
    """The register, why a request for what a unit does not hold yet is refused, if so, and what it is told instead: to
    end its train where another has its way, too.
    """
    mine = register.bidden.get(unit_id)
    ends = mine is not None and bool(mine.next_train)
    free = against is None or (ends and against[0] is RefusalReason.HELD)
    if not free or set(message.section_ids) <= set(register.held_by(unit_id)):
        return register, against, None
    register, instead = heard(register, unit_id, message.route_id, register.now_s)
    if isinstance(instead, TrainOrdered):
        return register, against, instead
    return register, instead or against, None


def settled(register: Register) -> tuple[Register, tuple[Action, ...]]:
    """The register without waits for a unit that has the section now, and what the journal is told."""
    over = [
        u for u, b in register.bidden.items() if b.behind and register.holders.get(b.section_id) == b.behind
    ]
    for unit_id in over:
        register = _without(register, unit_id)
    return register, tuple(Show(WaitOver(unit_id=unit_id)) for unit_id in over)


def answered(register: Register, unit_id: str) -> Register:
    """The register once a unit has said that it has ended its train, or will not."""
    mine = register.bidden.get(unit_id)
    return _without(register, unit_id) if mine is not None and mine.next_train else register


def _with(register: Register, unit_id: str, bidden: BiddenUnit) -> Register:
    return replace(register, bidden={**register.bidden, unit_id: bidden})


def _without(register: Register, unit_id: str) -> Register:
    return replace(register, bidden={u: b for u, b in register.bidden.items() if u != unit_id})


def _refused(event: Bid, why: str) -> Show:
    return Show(Refused(unit_id=event.unit_id, why=f"{event.person}: {why}"))
