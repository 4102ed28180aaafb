"""One train that comes to a level crossing, and its unit's part of it: the real `CrossingTalk` with the machine behind
it, the train in few places, its driver, the unit's power and position.

Places are as the unit may see them (`onboard.crossings.ahead`); what is in one place is a matter of metres. A train
that may not pass stops in `SHORT` at the latest: that it can is what braking within what is held guarantees. Beyond
that, in `BRAKING`, it can stop no more.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from enum import IntEnum
from functools import cache
from typing import Final, NamedTuple

from msgspec.structs import replace

from onboard.crossings.machine import CrossingPhase, CrossingPlace, CrossingView
from onboard.crossings.talk import CrossingTalk
from onboard.duty.records import DutyPhase, DutyState, StopLimit
from radio.envelope import DropReason
from radio.messages import AnyMessage, CrossingRequest
from verify.crossing.explored_crossing import (
    BEFORE,
    CROSSING,
    CURRENT,
    NOW_S,
    OUT_S,
    CrossingTrouble,
    ExploredCrossing,
    since_s,
)
from verify.on_air import InAir, opened

ANNOUNCED: Final = (CrossingPhase.ASKED, CrossingPhase.PROVEN, CrossingPhase.PASSING)


class TrainAt(IntEnum):
    """Where the train is. The front is truly on the road from `PERHAPS_ON` to `BEYOND`."""

    FAR = 0  # more than a minute, even at its fastest
    NEAR = 1  # its time to ask has come
    SHORT = 2  # nearer than the least time, and can still stop before the road
    BRAKING = 3  # can stop no more, or stands as near
    PERHAPS_BEFORE = 4  # its bounds reach over the road, its front does not
    PERHAPS_ON = 5
    ON = 6  # its front surely is
    BEYOND = 7  # its front surely has left it, its rear not
    PASSED = 8
    RETREATS = 9  # turned with its bounds over the road, which is behind it now
    TURNED = 10  # turned, and the road lies behind it on its path
    AWAY = 11  # turned, and the road is not on its path


ON_ROAD: Final = (TrainAt.PERHAPS_ON, TrainAt.ON, TrainAt.BEYOND)
GONE: Final = (TrainAt.PASSED, TrainAt.TURNED, TrainAt.AWAY)
_ON_IT: Final = {"arrives_s": 0.0, "fastest_s": 0.0, "proof_s": 0.0, "entered": True}
_SEEN: Final = {  # seconds are some of each place, whose comparisons are those of all of it
    TrainAt.FAR: {"arrives_s": 200.0, "fastest_s": 80.0, "proof_s": 190.0},
    TrainAt.NEAR: {"arrives_s": 40.0, "fastest_s": 32.0, "proof_s": 28.0},
    TrainAt.SHORT: {"arrives_s": 12.0, "fastest_s": 11.0, "proof_s": 0.0},
    TrainAt.BRAKING: {"arrives_s": 12.0, "fastest_s": 11.0, "proof_s": 0.0},
    TrainAt.PERHAPS_BEFORE: _ON_IT,
    TrainAt.PERHAPS_ON: _ON_IT,
    TrainAt.ON: _ON_IT | {"under": True},
    TrainAt.BEYOND: _ON_IT | {"under": True, "beyond": True},
    TrainAt.RETREATS: _ON_IT | {"under": True, "beyond": True},
    TrainAt.PASSED: _ON_IT | {"under": True, "beyond": True, "clear": True},
    TrainAt.TURNED: _ON_IT | {"under": True, "beyond": True, "clear": True},
}
_RUNS: Final = DutyState(phase=DutyPhase.RUNNING, limit=StopLimit(1, None, "end of the path"))
_WAITS: Final = DutyState(phase=DutyPhase.RUNNING, limit=StopLimit(0, "6", "not held"))
VALID_S: Final = 15.0
SAYS_AGAIN: Final = "says it again"


class RiderState(NamedTuple):
    """`comes`: its way leads on over the road; `eye`: with its position lost, its driver has leave to creep over it;
    `slow`: it has started or run on by leave, and not stopped since; `by_proof`: it came onto the road without leave;
    `booted`: an earlier boot may have announced it; `heard`: boot of the device as last heard; `correlation` of what it
    has announced last in this boot, 0: nothing yet.
    """

    at: TrainAt = TrainAt.FAR
    moves: bool = True
    comes: bool = True
    power: bool = True
    known: bool = True
    eye: bool = False
    slow: bool = False
    by_proof: bool = False
    booted: bool = False
    epoch: int = 1
    heard: int = 0
    correlation: int = 0
    view: CrossingView | None = None


class Told(IntEnum):
    """What of a train's step the judge of the road must know."""

    NOTHING = 0
    ENTERS = 1  # its front comes onto the road
    CREEPS = 2  # so, by leave
    PROVEN_NOW = 3  # hears a proof of the closure that is
    PROVEN_BEFORE = 4  # one of a closure before
    AGAIN = 5  # its proof holds on, by the closure that is
    DROPPED = 6  # it has no proof any more
    OLD_ENOUGH = 7  # its proof is as old as the least time when the front can be there


class RiderStep(NamedTuple):
    """What comes of a step. `anew`: it has announced itself anew, so that older correlations count for nothing."""

    name: str
    state: RiderState
    sends: tuple[InAir, ...] = ()
    told: Told = Told.NOTHING
    anew: bool = False
    trouble: CrossingTrouble = CrossingTrouble.NONE
    repeats: bool = False  # said again by a timer


class RiderModel:
    """Steps of one train and its unit."""

    def __init__(self, explored: ExploredCrossing) -> None:
        self._explored: Final = explored
        self.events: Final = cache(self._events)  # each step is made once
        self.hear: Final = cache(self._hear)

    def place(self, state: RiderState) -> CrossingPlace | None:
        """How the unit sees the crossing; None: it is not on its path."""
        if state.at is TrainAt.AWAY:
            return None
        x = self._explored
        place = CrossingPlace(CROSSING, 0, 0, x.closing_s + x.closed_s, x.closing_s, x.least_s)
        return replace(place, stands=not state.moves, **_SEEN[state.at])

    def talk(self, state: RiderState) -> CrossingTalk:
        """The unit's own, as it was left."""
        talk, place = CrossingTalk(forgot=state.booted), self.place(state) if state.known else None
        views: dict[str, CrossingView] = {} if state.view is None else {CROSSING: state.view}
        places = () if place is None or place.clear or state.view is None else (place,)
        talk.resume(views, {CROSSING: state.correlation} if state.correlation else {}, places, _duty(state))
        return talk

    def held(self, state: RiderState) -> bool:
        """Whether its movement limit is before the road."""
        return bool(self.talk(state).held_before(NOW_S))

    def _hear(self, state: RiderState, telegram: InAir, of_now: bool) -> RiderStep:
        """A telegram of the device comes in; `of_now`: sent in the closure of the road that is."""
        if not state.power:
            return RiderStep("hears", state)
        heard = opened(CROSSING, telegram, state.epoch, state.heard)
        if isinstance(heard, DropReason):
            return RiderStep("hears", state)
        state = state._replace(heard=heard.epoch)
        talk, before = self.talk(state), state.view
        talk.hear(heard, NOW_S)
        after = talk.views.get(CROSSING)
        step = self._left(state, talk)
        if after is None or after.phase is not CrossingPhase.PROVEN:
            return step
        if before is None or before.phase is not CrossingPhase.PROVEN:
            return step._replace(told=Told.PROVEN_NOW if of_now else Told.PROVEN_BEFORE)
        extended = getattr(telegram.message, "closed", False) and of_now and not committed(state)
        return step._replace(told=Told.AGAIN if extended else step.told)

    def _left(self, state: RiderState, talk: CrossingTalk, name: str = "hears") -> RiderStep:
        """What the unit does then: it looks, and says what it has to say."""
        place = self.place(state) if state.known else None
        places = None if not state.known else () if place is None else (place,)
        talk.look(places, _duty(state), math.inf, NOW_S)
        correlation, anew = talk.correlations.get(CROSSING, 0), False
        if correlation > CURRENT:
            correlation, anew = CURRENT, True
        sends = tuple(
            InAir(state.epoch, state.heard, CURRENT if letter.correlation else 0, _plain(letter.message))
            for letter in talk.letters
        )
        view = talk.views.get(CROSSING)
        after = state._replace(view=None if view is None else _settled(view), correlation=correlation)
        told = Told.DROPPED if not (_relies(view) or committed(after)) else Told.NOTHING
        return RiderStep(name, after, sends, told, anew)

    def _events(self, state: RiderState) -> tuple[RiderStep, ...]:
        """All that can happen besides telegrams; what changes nothing and says nothing is left out."""
        if not state.power:
            found = [*self._coasts(state)]
            if not state.moves:
                found.append(RiderStep("power is back", _booted(state)))
            return tuple(found)
        found = [*self._moves(state), *self._times(state), *self._people(state), *self._troubles(state)]
        return tuple(step for step in found if step.state != state or step.sends)

    def _seen(self, name: str, state: RiderState, was: RiderState, told: Told = Told.NOTHING) -> RiderStep:
        """The unit sees where its train is now; `was`: before, with what was said until then."""
        if not state.power:
            return RiderStep(name, state, told=told)
        step = self._left(state, self.talk(was), name)
        return step if told is Told.NOTHING else step._replace(told=told)

    def _to(self, state: RiderState, at: TrainAt, name: str, **more: object) -> RiderStep:
        told = Told.NOTHING
        after = state._replace(at=at, **more)  # type: ignore[arg-type]
        creeps = state.eye or (state.view is not None and state.view.creeps)
        if state.at in (TrainAt.SHORT, TrainAt.PERHAPS_BEFORE) and (at is TrainAt.BRAKING or not state.moves):
            after = after._replace(slow=creeps and after.moves)
        if at is TrainAt.PERHAPS_ON and state.at is TrainAt.PERHAPS_BEFORE:
            creeps = creeps or state.slow
            told = Told.CREEPS if creeps else Told.ENTERS
            after = after._replace(by_proof=not creeps)
        if at in GONE:
            after = after._replace(by_proof=False, eye=False, slow=False)
        return self._seen(name, after, state, told)

    def _moves(self, state: RiderState) -> Iterator[RiderStep]:
        at = state.at
        if at in GONE:
            if self._is_settled(state):
                yield self._to(state, TrainAt.FAR, "comes again", moves=True, comes=True)
            return
        if not state.moves:
            if self._may_start(state):
                yield self._to(state, at, "starts", moves=True)
            yield from self._turns(state)
            return
        if at is TrainAt.BRAKING:
            yield self._to(state, TrainAt.SHORT, "stops", moves=False, slow=False)
        elif at is not TrainAt.FAR:
            yield self._to(state, at, "stops", moves=False, slow=False)
        yield from self._runs(state)

    def _is_settled(self, state: RiderState) -> bool:
        """Whether it says no more than it has said: coming again takes longer than its times for that."""
        if state.view is None or not state.known:
            return True
        due = state._replace(view=replace(state.view, said_s=OUT_S))
        after = self._seen("", due, due).state.view
        return after is not None and after.phase is state.view.phase

    def _may_start(self, state: RiderState) -> bool:
        """By what its unit shows, or on sight by its driver's eye: up to the road, and onto it where it may."""
        match state.at:
            case TrainAt.NEAR:
                return state.comes
            case TrainAt.SHORT:
                return state.comes and (state.known or state.eye)
            case TrainAt.PERHAPS_BEFORE:
                return state.comes and (not self.held(state) if state.known else state.eye)
            case TrainAt.PERHAPS_ON:
                return not state.known or not self.held(state)
            case _:
                return True

    def _runs(self, state: RiderState) -> Iterator[RiderStep]:
        at, free = state.at, state.eye if not state.known else not self.held(state)
        match at:
            case TrainAt.SHORT:
                if free and state.comes:
                    yield self._to(state, TrainAt.BRAKING, "runs on")
                if state.comes and state.known:
                    limit = TrainAt.PERHAPS_BEFORE
                    yield self._to(state, limit, "stops at its limit, its bounds over the road", moves=False)
            case TrainAt.RETREATS:
                yield self._to(state, TrainAt.TURNED, "runs on")
            case _:
                yield self._to(state, TrainAt(at + 1), "runs on")
        if at is TrainAt.PERHAPS_BEFORE and state.known:
            yield self._to(state, TrainAt.SHORT, "has narrower bounds")

    def _turns(self, state: RiderState) -> Iterator[RiderStep]:
        match state.at:
            case TrainAt.NEAR | TrainAt.SHORT:
                yield self._to(state, TrainAt.AWAY, "turns back")
                yield self._to(state, TrainAt.TURNED, "turns back, with the road on its path")
            case TrainAt.PERHAPS_BEFORE:
                yield self._to(state, TrainAt.RETREATS, "turns back")
                if state.known:
                    yield self._to(state, TrainAt.SHORT, "has narrower bounds")
            case TrainAt.PERHAPS_ON:
                yield self._to(state, TrainAt.BEYOND, "turns back on the road")
            case TrainAt.BEYOND:
                yield self._to(state, TrainAt.ON, "turns back on the road")
            case _:
                pass

    def _coasts(self, state: RiderState) -> Iterator[RiderStep]:
        """Braked, with nobody who says where it stops: before the road, unless it can no more."""
        if state.moves:
            at = TrainAt.SHORT if state.at is TrainAt.BRAKING else state.at
            yield RiderStep("stops", state._replace(at=at, moves=False))
            if state.at in (TrainAt.BRAKING, TrainAt.PERHAPS_BEFORE, TrainAt.PERHAPS_ON, TrainAt.ON):
                yield self._to(state, TrainAt(state.at + 1), "runs on, braked")

    def _times(self, state: RiderState) -> Iterator[RiderStep]:
        view = state.view
        if view is None:
            return
        out: list[tuple[str, CrossingView, Told]] = []
        sees = state.known or view.phase is CrossingPhase.LEAVING
        if view.phase is not CrossingPhase.AHEAD and sees:
            out.append((SAYS_AGAIN, replace(view, said_s=OUT_S), Told.NOTHING))
        if view.until_s > NOW_S:
            out.append(("has its proof run out", replace(view, until_s=OUT_S), Told.NOTHING))
        if view.since_s == NOW_S and view.phase is CrossingPhase.PROVEN:
            out.append(("has an old proof", replace(view, since_s=OUT_S), Told.OLD_ENOUGH))
        if view.idle_s == NOW_S:
            out.append(("has stood for long", replace(view, idle_s=OUT_S), Told.NOTHING))
        for name, aged, told in out:
            timed = state._replace(view=aged)
            step = self._seen(name, timed, timed, told)
            yield step._replace(repeats=name == SAYS_AGAIN)

    def _people(self, state: RiderState) -> Iterator[RiderStep]:
        if state.moves:
            return
        before_road = state.at in (TrainAt.SHORT, TrainAt.PERHAPS_BEFORE)
        if not state.known:
            if before_road and not state.eye:
                yield RiderStep("creeps on by its driver's eye", state._replace(eye=True))
            yield self._seen("finds its position", state._replace(known=True, eye=False), state)
            return
        if self.talk(state).kept_standing_by(NOW_S):
            talk = self.talk(state)
            talk.creep(CROSSING, NOW_S)
            yield self._left(state, talk, "has leave to creep over the road")
        if state.at in (TrainAt.NEAR, TrainAt.SHORT, TrainAt.PERHAPS_BEFORE):
            name = "has no way on any more" if state.comes else "has its way on"
            turned = state._replace(comes=not state.comes)
            yield self._seen(name, turned, state)

    def _troubles(self, state: RiderState) -> Iterator[RiderStep]:
        off = state._replace(
            power=False, view=None, known=False, correlation=0, heard=0, eye=False, comes=True
        )
        yield RiderStep("power fails", off, told=Told.DROPPED, trouble=CrossingTrouble.POWER)
        if state.known and state.at not in (TrainAt.PASSED, TrainAt.AWAY, TrainAt.TURNED):
            lost = self._seen("loses its position", state._replace(known=False), state)
            yield lost._replace(trouble=CrossingTrouble.POSITION)


def _booted(state: RiderState) -> RiderState:
    """A new boot, which knows only that it may be on the line."""
    return state._replace(power=True, epoch=state.epoch + 1, booted=True)


def committed(state: RiderState) -> bool:
    """Whether it can stop no more before the road."""
    return state.moves and state.at in (TrainAt.BRAKING, TrainAt.PERHAPS_BEFORE)


def of_before(telegram: InAir) -> InAir:
    """A telegram under way when the unit has announced itself anew."""
    return telegram._replace(correlation=BEFORE) if telegram.correlation == CURRENT else telegram


def _plain(message: AnyMessage) -> AnyMessage:
    """A request with its times as far as the device compares them: it is time to warn now, or not yet."""
    if isinstance(message, CrossingRequest):
        return CrossingRequest(60.0, 60.0) if message.proof_s > 0.0 else CrossingRequest(0.0, 0.0)
    return message


def _relies(view: CrossingView | None) -> bool:
    """Whether the front may go on by what the crossing has said."""
    return view is not None and view.phase in (CrossingPhase.PROVEN, CrossingPhase.PASSING)


def _duty(state: RiderState) -> DutyState:
    return _RUNS if state.comes else _WAITS


def _settled(view: CrossingView) -> CrossingView:
    """Times as they are told apart; those of a proof are read while it is one."""
    proven = view.phase is CrossingPhase.PROVEN
    relies = _relies(view)
    return replace(
        view,
        said_s=NOW_S if view.said_s > OUT_S else OUT_S,
        answered=False,  # it may say again what it has said at any time
        begins_s=-math.inf,
        since_s=since_s(view.since_s) if proven else math.inf,
        until_s=VALID_S if relies and view.until_s > NOW_S else OUT_S,
        idle_s=since_s(view.idle_s),
    )
