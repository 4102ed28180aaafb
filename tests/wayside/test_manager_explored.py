"""What always holds of the block manager, whatever units and persons say: breadth first on a line of three sections.

P is a portal, C open line, S a track of a station; two units, two persons. The steps are the manager's own; a state is
told from another by all that decides what follows, which of tokens and times is nothing but whose is the newest.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

import pytest

from radio.messages import (
    AnyMessage,
    Claim,
    ClaimQuery,
    Contested,
    HoldingReport,
    RouteGranted,
    RouteRequest,
    SignOff,
    SignOn,
    SignOnAccepted,
)
from tests.nightly import others_nightly
from verify.breadth import Explored, explore
from wayside import acts, block_manager, reentry
from wayside.actions import Action, Send
from wayside.block_manager import AskUnits, Event, Heard, step
from wayside.config import ManagerConfig, RouteEntry, SectionEntry
from wayside.leaving import may_have_crossed
from wayside.reentry import in_station
from wayside.register import Register, UnitStanding, start
from wayside.said import (
    AcceptPicture,
    BarUnit,
    BoundaryPassed,
    ConfirmHolding,
    ConfirmOutside,
    EnterSection,
    TakeBack,
    UnbarUnit,
)

UNITS, PERSONS = ("u1", "u2"), ("Sato", "Mori")
CONFIG: Final = ManagerConfig(
    "line",
    "block-manager",
    UNITS,
    (SectionEntry("P", portal=True), SectionEntry("C", open_line=True), SectionEntry("S")),
    (RouteEntry("in", "P", ("C", "S")), RouteEntry("out", "S", ("C", "P"))),
)
CLAIMS: Final[tuple[tuple[str, ...], ...]] = ((), ("P",), ("S",), ("C", "S"))
FEW, STATES_MAX = 250, 1500  # that are looked at in every run, and in `make nightly`


@dataclass(frozen=True)
class Seen:
    """A register, told from others by its key."""

    register: Register = field(compare=False)
    key: object = None

    @staticmethod
    def of(register: Register) -> Seen:
        units = tuple(
            (
                unit.standing,
                unit.claim,
                bool(unit.by),
                unit.claim_needed,
                unit.silent,
                unit.taken_back,
                unit.token == register.token_max,
            )
            for unit in map(register.unit, UNITS)
        )
        words = register.reentry
        said = (
            tuple(sorted((s, tuple(sorted(by.items(), key=repr))) for s, by in words.entries.items())),
            words.complete,
            tuple(sorted(words.left_by.items())),
            words.stage,
            words.accepted_by != "",
            tuple(words.heard_s),
        )
        doubted = tuple((u, min(times, acts.ASKED_IN_VAIN)) for u, times in sorted(register.doubted.items()))
        held = tuple(sorted(register.holders.items()))
        key = (
            held,
            units,
            said,
            doubted,
            register.unswept,
            frozenset(register.left_through),
            register.ledger,
            register.restoring,
            register.bars,
        )
        return Seen(register, key)


@dataclass(frozen=True)
class Step:
    """One thing that can happen, and what comes of it."""

    before: Register
    event: Event
    after: Register
    actions: tuple[Action, ...]

    @property
    def sends(self) -> list[Send]:
        return [action for action in self.actions if isinstance(action, Send)]


def steps(register: Register, persons: tuple[str, ...] = PERSONS) -> Iterator[Step]:
    """All that can happen next."""
    now_s = max(60.0, register.ask_at_s)
    for event in (*_telegrams(register), *_inputs(register, persons), AskUnits()):
        after, actions = step(register, event, now_s)
        yield Step(register, event, after, actions)


def _telegrams(register: Register) -> Iterator[Event]:
    for unit_id in UNITS:
        unit, held = register.unit(unit_id), register.held_by(unit_id)
        messages: list[AnyMessage] = [Claim(claim, unit.token) for claim in CLAIMS]
        messages += [
            Claim(None, 0),
            SignOn(unit_id, None),
            SignOn(unit_id, ("P",)),
            SignOff(unit_id, unit.token),
        ]
        messages += [RouteRequest(unit_id, route.route_id, route.section_ids) for route in CONFIG.routes]
        messages += [HoldingReport(held[-1:], unit.token, held[:-1]), HoldingReport(held[:1], unit.token)]
        messages.append(HoldingReport(held, unit.token, ("P", "C", "S")))
        yield from (Heard(unit_id, 1, True, 0, message) for message in messages)
        yield Heard(unit_id, 1, False, 0, Claim((), unit.token))
        yield Heard(unit_id, 2, True, 0, Claim((), 0))
    yield BoundaryPassed("P")


def _inputs(register: Register, persons: tuple[str, ...]) -> Iterator[Event]:
    for person in persons:
        for unit_id in UNITS:
            yield ConfirmOutside(unit_id, person, "P")
            yield ConfirmHolding(unit_id, ("S",), person)
            yield ConfirmHolding(unit_id, ("C",), person)
            yield TakeBack(unit_id, person)
            yield BarUnit(unit_id, person)
            yield UnbarUnit(unit_id, person)
        if register.restoring:
            yield EnterSection("S", "u1", person)
            yield AcceptPicture(person)


# what must hold -------------------------------------------------------------------------------------------------


def _agreed_with_another(step_: Step, unit_id: str) -> bool:
    """Whether the event is a person's word of the unit that another person has said before."""
    match step_.event:
        case ConfirmOutside(about, person) | ConfirmHolding(about, _, person) if about == unit_id:
            said = step_.event.section_ids if isinstance(step_.event, ConfirmHolding) else ()
            words = reentry.words_for(step_.before, unit_id)
            return any(who != acts.person_key(person) and word == set(said) for who, word in words.items())
    return False


def check_freed(step_: Step) -> None:
    """By its holder's own report, its train having left by its own word or the boundary's, or by two persons who put it
    in a station or out of a portal.
    """
    for section_id, holder in step_.before.holders.items():
        now = step_.after.holders.get(section_id)
        if now == holder:
            continue
        assert now is None, "from one unit straight to another"
        match step_.event:
            case Heard(unit_id, message=HoldingReport()):
                assert unit_id == holder
            case Heard(unit_id, epoch=epoch, fresh=True, message=Claim(())):
                unit = step_.before.unit(holder)
                assert (unit_id, epoch, unit.standing) == (holder, unit.epoch, UnitStanding.LEAVING)
            case BoundaryPassed(portal):
                assert section_id == portal or step_.before.unit(holder).standing is UnitStanding.LEAVING
            case BarUnit() if step_.before.restoring:
                pass  # nothing was given yet, and it is on the ledger
            case Heard(unit_id, fresh=True, message=Claim(None) | SignOn(section_ids=None)):
                unit = step_.before.unit(holder)
                assert (unit_id, unit.standing) == (holder, UnitStanding.DISPUTED)
                assert step_.before.restoring
                assert holder in step_.after.ledger
            case ConfirmHolding(section_ids=section_ids):
                assert in_station(step_.after, section_ids)
                assert _agreed_with_another(step_, holder)
            case _:
                assert _agreed_with_another(step_, holder)


def check_granted(step_: Step) -> None:
    """Only while every unit is known and none is disputed; what must be swept, on sight."""
    for send in step_.sends:
        if isinstance(send.message, RouteGranted):
            assert step_.before.defined
            assert all(
                step_.before.unit(u).standing not in (UnitStanding.UNKNOWN, UnitStanding.DISPUTED)
                for u in UNITS
            )
        if isinstance(send.message, RouteGranted | SignOnAccepted):
            of_it = set(send.message.section_ids) & step_.after.unswept
            assert set(send.message.on_sight) == of_it


def check_contradicted(step_: Step) -> None:
    """A fresh claim of what another holds: its sender is disputed, and the other is told at once."""
    barred = step_.before.bars.barred
    match step_.event:
        case Heard(unit_id, fresh=True, message=Claim(section_ids)) if unit_id not in barred:
            if may_have_crossed(step_.before, step_.event):
                return  # asked again
        case _:
            return
    for section_id in section_ids or ():
        holder = step_.before.holders.get(section_id, unit_id)
        if holder == unit_id or not _weighed(step_, unit_id, section_ids or ()):
            continue
        assert step_.after.unit(unit_id).standing is UnitStanding.DISPUTED
        assert section_id in step_.after.contested(holder)
        told = [
            s.message.section_ids
            for s in step_.sends
            if s.destination == holder and isinstance(s.message, Contested)
        ]
        assert told or holder in barred or section_id in step_.before.contested(holder)


def _weighed(step_: Step, unit_id: str, claimed: tuple[str, ...]) -> bool:
    """Not the wish of a unit never on the line to enter a portal."""
    stranger = step_.before.restoring and unit_id not in step_.before.ledger
    return not (stranger and set(claimed) <= step_.before.plan.portals)


def check_told_again(step_: Step) -> None:
    """While it lasts, every unit that holds what is contested is told at each ask, and who is in doubt asked."""
    if not isinstance(step_.event, AskUnits):
        return
    said = {(send.destination, type(send.message)) for send in step_.sends}
    for unit_id in UNITS:
        contested = step_.before.contested(unit_id) and unit_id not in step_.before.bars.barred
        assert bool(contested) == ((unit_id, Contested) in said)
        assert (unit_id in step_.before.units_asked()) == ((unit_id, ClaimQuery) in said)


def check_barred(step_: Step) -> None:
    """What a barred unit says changes nothing, and nothing is said to it; barring frees nothing of a running line."""
    barred = step_.before.bars.barred
    if isinstance(step_.event, Heard) and step_.event.unit_id in barred:
        assert step_.after == step_.before
    assert not {send.destination for send in step_.sends} & set(step_.after.bars.barred)
    if isinstance(step_.event, BarUnit | UnbarUnit) and not step_.before.restoring:
        assert step_.after.holders == step_.before.holders
        assert {u for u in UNITS if step_.before.contested(u)} == {
            u for u in UNITS if step_.after.contested(u)
        }


def check_swept(step_: Step) -> None:
    """Only by the report of the unit that held it, which says that it was run through on sight."""
    swept = step_.before.unswept - step_.after.unswept
    if swept:
        assert isinstance(step_.event, Heard)
        assert isinstance(step_.event.message, HoldingReport)
        assert swept <= set(step_.event.message.swept)
        assert swept <= set(step_.before.held_by(step_.event.unit_id))


def check(step_: Step) -> None:
    check_freed(step_)
    check_granted(step_)
    check_contradicted(step_)
    check_told_again(step_)
    check_swept(step_)
    check_barred(step_)


def _left(unit_id: str) -> tuple[Event, ...]:
    return tuple(ConfirmOutside(unit_id, person, "P") for person in PERSONS)


def _claims(unit_id: str, *section_ids: str) -> Event:
    return Heard(unit_id, 1, True, 0, Claim(section_ids, 0))


COURSES: Final[dict[int, tuple[tuple[Event, ...], ...]]] = {
    1: ((_claims("u2", "P"), ConfirmHolding("u1", ("C", "S"), "Sato"), *_left("u1")),),
    2: (
        (_claims("u1", "S"), _claims("u2"), AcceptPicture("Sato")),
        (_claims("u1", "P"), *_left("u2"), AcceptPicture("Sato")),
    ),
}


def first(epoch: int) -> list[Seen]:
    """Where to look first: a start, and courses on which the line is defined, with what is to be swept and without."""
    begun, _ = step(start(CONFIG, epoch, {}, None if epoch == 1 else UNITS), AskUnits(), 0.0)
    found = [Seen.of(begun)]
    for course in COURSES[epoch]:
        register = begun
        for event in course:
            register, _ = step(register, event, 60.0)
            found.append(Seen.of(register))
        assert register.defined
    return found


def explored(epoch: int, states_max: int) -> Explored[Seen]:
    return explore(
        first(epoch),
        lambda seen: ((type(s.event).__name__, Seen.of(s.after)) for s in steps(seen.register)),
        lambda seen: "restoring" if seen.register.restoring else "running",
        states_max,
    )


@pytest.mark.parametrize("states_max", others_nightly((FEW, STATES_MAX), [FEW]))
@pytest.mark.parametrize("epoch", [1, 2])
def test_whatever_units_and_persons_say_the_rules_hold(epoch: int, states_max: int) -> None:
    found = explored(epoch, states_max)
    kinds: set[str] = set()
    for seen in found.states:
        for one in steps(seen.register):
            check(one)
            kinds |= {type(send.message).__name__ for send in one.sends}
    assert kinds >= {"RouteGranted", "Contested", "HoldingConfirmed", "SignOffAccepted"}
    assert any(seen.register.unswept and seen.register.defined for seen in found.states)
    assert any(seen.register.unit(u).taken_back for seen in found.states for u in UNITS)


@pytest.mark.parametrize("states_max", others_nightly((FEW, STATES_MAX), [FEW]))
@pytest.mark.parametrize("epoch", [1, 2])
def test_one_person_alone_never_frees(epoch: int, states_max: int) -> None:
    """However their name is spelled, and whatever else happens between."""
    one_person = ("Sato", " sato ")
    found = explore(
        first(epoch),
        lambda seen: (("", Seen.of(s.after)) for s in steps(seen.register, one_person)),
        lambda _: "",
        states_max,
    )
    for seen in found.states:
        for one in steps(seen.register, one_person):
            if not isinstance(one.event, Heard | BoundaryPassed):
                assert one.before.holders.items() <= one.after.holders.items()


# each of them can fail ------------------------------------------------------------------------------------------


def _any_word(register: Register, unit_id: str) -> frozenset[str] | None:
    return reentry.entered_for(register, unit_id)


SWITCHES: Final[dict[str, tuple[object, str, object]]] = {
    "two persons": (reentry, "agreed", _any_word),
    "the other is told": (block_manager, "newly_contested", lambda *_: ()),
    "told again": (block_manager, "tell_contested", lambda _: ()),
    "a disputed unit blocks": (
        Register,
        "undefined_because_of",
        lambda self: tuple(u for u in self.plan.unit_ids if self.unit(u).standing is UnitStanding.UNKNOWN),
    ),
    "on sight only": (Register, "on_sight", lambda *_: ()),
    "in a station": (reentry, "in_station", lambda *_: True),
    "only its holder sweeps": (
        reentry,
        "swept",
        lambda register, _unit_id, swept: (
            block_manager.replace(register, unswept=register.unswept.difference(swept)),
            (),
        ),
    ),
}


@pytest.mark.parametrize("off", others_nightly(SWITCHES, list(SWITCHES)[::6]))
def test_a_rule_switched_off_is_found(off: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(*SWITCHES[off])
    found = explored(1, 600)
    with pytest.raises(AssertionError):
        for seen in found.states:
            for one in steps(seen.register):
                check(one)
