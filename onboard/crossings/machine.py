"""Invariant: no front goes onto a crossing that its unit asks to close, but by a proof that holds and is as old as the
least time when the front could first be there, or by leave to creep over it; and a unit gives a crossing up only with
its train standing, surely short of it or with its rear surely beyond.

A pure machine, one view for each crossing: `step(view, event, now_s) -> (view, actions)`, with `now_s` as time that has
passed. `TABLE` is where the unit stands with the crossing and the kind of event. What lies in metres and seconds of
running comes as a `CrossingPlace` from `onboard.crossings.ahead`. What a unit says to a crossing it says again: until
it is answered, just before the warning begins, so that this knows the time as it is now, when the proof is due, while
a proof must go on to hold, and now and then until it is over it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Final

import msgspec
from msgspec.structs import replace

from onboard import crossing_notes, notes
from radio.messages import CrossingOver, CrossingRequest

EARLY_S: Final = 6.0  # asked so long before its warning must begin: time for telegrams that are lost
ABOUT_S: Final = 0.5  # who looks when that time should have come finds it so little later
HELD_FROM_S: Final = 60.0  # nearer than this by its fastest run, a crossing ends the movement limit
REPEAT_S: Final = 2.0
REFRESH_S: Final = 4.0  # so often while it should have proved closed and has not
CHANGED_S: Final = 1.0  # while its warning has not begun it hears at once of a time that differs by more
LAST_LOOK_S: Final = 3.0  # before the warning, where it was asked earlier than that: its train stood
ENTERS_S: Final = 3.0  # so much later than predicted the front may come, and the proof still hold
PROOF_LATE_S: Final = 1.0  # a telegram on its way
HOLDS_YET_S: Final = 6.0  # a proof that holds no longer is asked for again: three times, if they are lost
STILL_S: Final = (
    29.5  # said at least so often: twice before persons have a crossing opened for which it is silent
)
GIVE_UP_S: Final = 30.0  # assumed: who stands so long without going on there lets the road go
KEEPS_LEAST_TIME = True  # off: a proof counts at once, however near the train is


class CrossingPhase(Enum):
    """Where the unit stands with a crossing."""

    AHEAD = "ahead"  # not announced there, or behind
    ASKED = "asked"
    PROVEN = "proven"
    PASSING = "passing"  # the front is on it, or may be
    LEAVING = "leaving"  # over it, or given up, until that is heard


class CrossingPlace(msgspec.Struct, frozen=True):
    """How the train is to a crossing on its path, by its own localisation.

    From now on, s: `arrives_s` until its front is there by the run that it means, `fastest_s` by the fastest possible,
    `proof_s` until it must know the crossing closed so that it need not brake; infinite: it does not come there yet.
    `warning_s`, `closing_s` and `least_s` are the line's: the whole warning, its part until closed, and from closed to
    the front at least. `span` and `stop`: in which span of the plan it lies, and which stop is the last before it.
    `entered`: the front may be on it, `under`: surely is, or was, `beyond`: surely has left it, `clear`: the rear too;
    who sees that looks at once. `stands`: the train does. `departs`: no contact warns of it, so it does not start
    before the crossing has proved closed, or will have in time.
    """

    crossing_id: str
    span: int
    stop: int
    warning_s: float
    closing_s: float
    least_s: float
    arrives_s: float = math.inf
    fastest_s: float = math.inf
    proof_s: float = math.inf
    entered: bool = False
    under: bool = False
    beyond: bool = False
    clear: bool = False
    stands: bool = False
    departs: bool = False

    @property
    def warns_s(self) -> float:
        """When the warning must begin, s from now; negative: it should have."""
        return min(self.arrives_s - self.warning_s, self.proof_s - self.closing_s)

    @property
    def due_s(self) -> float:
        """When the crossing is to be asked, s from now; not positive: it is time."""
        return self.warns_s - EARLY_S


class CrossingView(msgspec.Struct, frozen=True):
    """What the unit knows of one crossing.

    `said_s`: when it spoke to it last; `begins_s`: when the warning was to begin by that; `since_s`, `until_s`: since
    when it has proved closed without a break, and how long that holds; `idle_s`: since when it stands without going on
    there. `creeps`: it may creep over it unproven. `forgot`: a boot before this one may have announced it there.
    `answered`: the crossing has heard what was said last.
    """

    crossing_id: str
    phase: CrossingPhase = CrossingPhase.AHEAD
    said_s: float = -math.inf
    begins_s: float = -math.inf
    since_s: float = math.inf
    until_s: float = -math.inf
    idle_s: float = math.inf
    creeps: bool = False
    passed: bool = False
    forgot: bool = False
    answered: bool = False


@dataclass(frozen=True, slots=True)
class CrossingSeen:
    """Event: how the train is to it now; None: it is not on the path."""

    place: CrossingPlace | None


@dataclass(frozen=True, slots=True)
class CrossingUnplaced:
    """Event: the unit does not know where its train is."""


@dataclass(frozen=True, slots=True)
class CrossingAnswered:
    """Event: the crossing says whether it is closed, and until when (s) that holds; one that closes `by_contacts`,
    whether nothing is on it.
    """

    closed: bool
    until_s: float
    by_contacts: bool = False


@dataclass(frozen=True, slots=True)
class CrossingOverAnswered:
    """Event: the crossing has heard that the unit is over it, or has given it up."""


@dataclass(frozen=True, slots=True)
class CrossingBooted:
    """Event: the device has started again: nothing that was sent is known to have arrived."""


@dataclass(frozen=True, slots=True)
class CrossingOffLine:
    """Event: the whole train is off the line."""


@dataclass(frozen=True, slots=True)
class CreepAllowed:
    """Event: its driver may creep over it, on sight and whistling; `guarded`: somebody has stopped its road."""

    guarded: bool = False


CrossingEvent = (
    CrossingSeen
    | CrossingUnplaced
    | CrossingAnswered
    | CrossingOverAnswered
    | CrossingBooted
    | CrossingOffLine
    | CreepAllowed
)
CrossingAction = CrossingRequest | CrossingOver | notes.Note
CrossingStep = tuple[CrossingView, tuple[CrossingAction, ...]]


def step(view: CrossingView, event: CrossingEvent, now_s: float) -> CrossingStep:
    """The next view and what to say or note. An event that does not fit changes nothing."""
    handler = TABLE.get((view.phase, type(event)))
    return (view, ()) if handler is None else handler(view, event, now_s)


def may_pass(
    view: CrossingView, place: CrossingPlace, now_s: float, held_from_s: float = HELD_FROM_S
) -> bool:
    """Whether the front may go onto the crossing, or it is so far ahead that this does not matter yet."""
    far = view.phase is CrossingPhase.AHEAD and place.fastest_s > held_from_s
    if far or place.clear or view.phase is CrossingPhase.PASSING or view.creeps:
        return True
    old_enough = now_s + place.fastest_s >= view.since_s + place.least_s or not KEEPS_LEAST_TIME
    return view.phase is CrossingPhase.PROVEN and now_s < view.until_s and old_enough


def starts_too_soon(view: CrossingView, place: CrossingPlace, now_s: float) -> bool:
    """Whether a train that starts now, or when it is to leave, may come before a proof that its departure waits for:
    the crossing has not heard of it, or what it was asked last cannot be so in time.
    """
    if not place.departs or view.phase is CrossingPhase.PROVEN:
        return False
    proves_s = max(view.said_s, view.begins_s) + place.closing_s + PROOF_LATE_S
    needs_s = now_s + min(place.proof_s, place.arrives_s - place.least_s)
    return place.due_s <= 0.0 and not (view.answered and proves_s <= needs_s)


def wake_s(view: CrossingView, place: CrossingPlace | None, now_s: float) -> float:
    """When to look again, s; infinite: not before something happens."""
    match view.phase:
        case CrossingPhase.AHEAD:
            return now_s + (math.inf if place is None or place.clear else _asked_in_s(place))
        case CrossingPhase.PROVEN:
            waits = place is not None and not may_pass(view, place, now_s)
            return now_s + 1.0 if waits else min(_again_s(view, place, now_s), view.until_s)
        case CrossingPhase.ASKED if place is not None and not math.isfinite(place.arrives_s):
            return min(now_s + REFRESH_S, view.idle_s + GIVE_UP_S)
        case CrossingPhase.ASKED | CrossingPhase.PASSING:
            return _again_s(view, place, now_s)
        case CrossingPhase.LEAVING:
            return view.said_s + REPEAT_S


def ends_s(view: CrossingView, place: CrossingPlace | None, now_s: float) -> float:
    """When to look again unless the front is surely there by then, s: by a proof that holds until it should be, nothing
    is to be said on the road but, now and then, that the train still is. Infinite: `wake_s` counts wherever it is.
    """
    if view.phase is not CrossingPhase.PROVEN or place is None or place.under or not view.answered:
        return math.inf
    asks_s = _again_s(view, place, now_s)
    return asks_s if _holds(view, place, now_s) and may_pass(view, place, now_s) else math.inf


def still_s(view: CrossingView) -> float:
    """When it is to hear at the latest that the train still comes, s."""
    return view.said_s + STILL_S


def _holds(view: CrossingView, place: CrossingPlace, now_s: float) -> bool:
    """Whether a proof holds until the front is there, as it should come."""
    return now_s + place.arrives_s + ENTERS_S < view.until_s


def _asked_in_s(place: CrossingPlace) -> float:
    """When the crossing is to be asked, s from now; infinite: it does not come there before something happens."""
    due_s = place.due_s
    return due_s if due_s > ABOUT_S else math.inf


def _again_s(view: CrossingView, place: CrossingPlace | None, now_s: float) -> float:
    """When what was said is to be said again, s."""
    soonest_s = view.said_s + REPEAT_S
    if view.phase is CrossingPhase.PASSING or place is None:
        return still_s(view)
    if not view.answered:
        return soonest_s
    if view.phase is CrossingPhase.PROVEN:
        return max(soonest_s, view.until_s - (REPEAT_S if _holds(view, place, now_s) else HOLDS_YET_S))
    warns_s = now_s + place.warns_s
    if now_s < view.begins_s and abs(warns_s - view.begins_s) > CHANGED_S:
        return soonest_s if place.stands else now_s
    last_look_s = warns_s - LAST_LOOK_S
    if view.said_s < warns_s - EARLY_S - ABOUT_S and now_s < last_look_s:
        return last_look_s
    proves_s = warns_s + place.closing_s + PROOF_LATE_S
    return min(still_s(view), proves_s if view.said_s < proves_s else view.said_s + REFRESH_S)


def _asks(view: CrossingView, place: CrossingPlace | None, now_s: float) -> CrossingStep:
    """Say how soon the front can be there; of one that does not come there yet, later than anything counts."""
    arrives_s = 0.0 if place is None or place.entered else place.arrives_s
    proof_s = arrives_s if place is None else min(place.proof_s, arrives_s)
    request = CrossingRequest(round(arrives_s, 1), round(max(proof_s, 0.0), 1))
    if place is not None and not place.entered and view.phase is CrossingPhase.ASKED:
        view = replace(view, begins_s=now_s + place.warns_s)
    return replace(view, said_s=now_s, answered=False), (request,)


def _repeats(view: CrossingView, place: CrossingPlace | None, now_s: float) -> CrossingStep:
    return _asks(view, place, now_s) if now_s >= _again_s(view, place, now_s) else (view, ())


def _gives_up(view: CrossingView, now_s: float, *, passed: bool) -> CrossingStep:
    fresh = CrossingView(view.crossing_id, CrossingPhase.LEAVING, now_s, passed=passed)
    left = crossing_notes.CrossingLeftBehind(crossing_id=view.crossing_id, passed=passed)
    return fresh, (left, CrossingOver(passed))


def _look_ahead(view: CrossingView, event: CrossingSeen, now_s: float) -> CrossingStep:
    """Asks it to close in time; one that it may have asked before a boot it tells that it is over it, or gives up."""
    place = event.place
    if place is None:
        return view, ()
    if place.under and not place.clear:
        return _asks(replace(view, phase=CrossingPhase.PASSING, forgot=False), place, now_s)
    if view.forgot and (place.clear or (place.stands and not place.entered)):  # else it may stand on it
        return _gives_up(view, now_s, passed=place.clear)
    if place.clear or place.due_s > ABOUT_S:
        return view, ()
    asked, said = _asks(replace(view, phase=CrossingPhase.ASKED), place, now_s)
    note = crossing_notes.CrossingAsked(crossing_id=view.crossing_id, arrives_s=round(place.arrives_s, 1))
    return asked, (note, *said)


def _look_asked(view: CrossingView, event: CrossingSeen, now_s: float) -> CrossingStep:
    """Says again how soon the front can be there; gives it up off its path, or standing without going on there."""
    place = event.place
    if place is None:
        return _gives_up(view, now_s, passed=False)
    if place.clear:
        return _gives_up(view, now_s, passed=True)
    if place.under or (place.entered and view.creeps):  # standing on it nobody is safer
        return _asks(replace(view, phase=CrossingPhase.PASSING), place, now_s)
    if math.isfinite(place.arrives_s) or not place.stands or place.entered:
        view = replace(view, idle_s=math.inf)
        return _repeats(view, place, now_s) if math.isfinite(place.arrives_s) else (view, ())
    view = replace(view, idle_s=min(view.idle_s, now_s))
    return _gives_up(view, now_s, passed=False) if now_s >= view.idle_s + GIVE_UP_S else (view, ())


def _look_proven(view: CrossingView, event: CrossingSeen, now_s: float) -> CrossingStep:
    """On it by a proof that holds, it passes; a proof that nobody has said again is none."""
    place = event.place
    if place is not None and place.clear:
        return _gives_up(view, now_s, passed=True)
    if place is not None and place.entered and (place.under or may_pass(view, place, now_s)):
        return replace(view, phase=CrossingPhase.PASSING), ()
    if now_s >= view.until_s:
        lost, said = _look_asked(replace(_unproven(view), answered=False), event, now_s)
        return lost, (
            crossing_notes.CrossingProofLost(
                crossing_id=view.crossing_id, why=crossing_notes.WhyProofLost.SILENCE
            ),
            *said,
        )
    if place is None or (place.stands and not math.isfinite(place.arrives_s)):
        return _look_asked(_unproven(view), event, now_s)
    return _repeats(view, place, now_s)


def _look_passing(view: CrossingView, event: CrossingSeen, now_s: float) -> CrossingStep:
    """Keeps it closed until the safe rear has left it."""
    place = event.place
    if place is None:
        return _repeats(view, place, now_s)
    if place.clear:
        return _gives_up(view, now_s, passed=True)
    over = now_s >= view.until_s and not view.creeps  # what it came so far by
    short = place.stands or over if not place.entered else place.stands and over and not place.under
    if short:  # it has turned, comes another time, or starts anew before what may be the road
        return _look_ahead(CrossingView(view.crossing_id, forgot=True), event, now_s)
    if view.creeps and place.beyond:
        view = replace(view, creeps=False)
    return _repeats(view, place, now_s)


def _look_leaving(view: CrossingView, event: CrossingSeen, now_s: float) -> CrossingStep:
    """Says so until it is heard; announces itself anew where it comes there again."""
    place = event.place
    if place is not None and not place.clear and place.due_s <= ABOUT_S:
        return _look_ahead(CrossingView(view.crossing_id), event, now_s)
    if now_s < view.said_s + REPEAT_S:
        return view, ()
    return replace(view, said_s=now_s), (CrossingOver(view.passed),)


def _lose_place(view: CrossingView, _event: CrossingUnplaced, _now_s: float) -> CrossingStep:
    """Whether the train is still on it will be seen; until then it stays announced there."""
    return CrossingView(view.crossing_id, forgot=True), ()


def _unproven(view: CrossingView) -> CrossingView:
    return replace(view, phase=CrossingPhase.ASKED, since_s=math.inf, until_s=-math.inf)


def _proof(view: CrossingView, event: CrossingAnswered, now_s: float) -> CrossingStep:
    """Closed: proven, as long as that holds; not closed yet: it knows of the train."""
    view = replace(view, answered=True)
    if not event.closed:
        return view, ()
    proven = replace(view, phase=CrossingPhase.PROVEN, since_s=now_s, until_s=event.until_s)
    note = crossing_notes.CrossingHeardClear if event.by_contacts else crossing_notes.CrossingHeardClosed
    return replace(proven, creeps=False), (note(crossing_id=view.crossing_id),)


def _proof_again(view: CrossingView, event: CrossingAnswered, now_s: float) -> CrossingStep:
    """Still closed: it holds on; not closed any more: it is dropped at once."""
    if event.closed:
        return replace(view, until_s=event.until_s, answered=True), ()
    note = crossing_notes.CrossingProofLost(
        crossing_id=view.crossing_id, why=crossing_notes.WhyProofLost.NOT_CLOSED
    )
    return replace(_unproven(view), said_s=now_s), (note,)


def _over_heard(view: CrossingView, _event: CrossingOverAnswered, _now_s: float) -> CrossingStep:
    """The crossing does not wait for this train any more."""
    return CrossingView(view.crossing_id), ()


def _off_line(view: CrossingView, _event: CrossingOffLine, now_s: float) -> CrossingStep:
    """Nothing of the train is on it, nor comes."""
    announced = view.phase is not CrossingPhase.AHEAD or view.forgot
    return _gives_up(view, now_s, passed=True) if announced else (view, ())


def _say_again(view: CrossingView, _event: CrossingBooted, _now_s: float) -> CrossingStep:
    """What was said is due again; a proof of the boot before holds as long as it did."""
    return replace(view, said_s=-math.inf, answered=False), ()


def _creep(view: CrossingView, event: CreepAllowed, _now_s: float) -> CrossingStep:
    """May creep over it, unless a proof comes first."""
    if view.creeps:
        return view, ()
    return replace(view, creeps=True), (
        crossing_notes.CrossingCreep(crossing_id=view.crossing_id, guarded=event.guarded),
    )


_ANNOUNCED: Final = (CrossingPhase.ASKED, CrossingPhase.PROVEN, CrossingPhase.PASSING)
TABLE: Final[Mapping[tuple[CrossingPhase, type], Callable[[CrossingView, Any, float], CrossingStep]]] = (
    MappingProxyType(
        {
            (CrossingPhase.AHEAD, CrossingSeen): _look_ahead,
            (CrossingPhase.ASKED, CrossingSeen): _look_asked,
            (CrossingPhase.PROVEN, CrossingSeen): _look_proven,
            (CrossingPhase.PASSING, CrossingSeen): _look_passing,
            (CrossingPhase.LEAVING, CrossingSeen): _look_leaving,
            (CrossingPhase.ASKED, CrossingAnswered): _proof,
            (CrossingPhase.PROVEN, CrossingAnswered): _proof_again,
            (CrossingPhase.LEAVING, CrossingOverAnswered): _over_heard,
            **dict.fromkeys(((phase, CrossingBooted) for phase in _ANNOUNCED), _say_again),
            (CrossingPhase.LEAVING, CrossingBooted): _say_again,
            **dict.fromkeys(
                ((phase, CrossingOffLine) for phase in (CrossingPhase.AHEAD, *_ANNOUNCED)), _off_line
            ),
            (CrossingPhase.PASSING, CrossingUnplaced): _lose_place,
            (CrossingPhase.AHEAD, CreepAllowed): _creep,
            (CrossingPhase.ASKED, CreepAllowed): _creep,
        }
    )
)
