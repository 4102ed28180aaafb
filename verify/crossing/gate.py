"""The device of a level crossing, its lamps and barriers, and the judge of the road, as one party: the real step of the
device, which sees at once what its equipment shows.

What the judge keeps says what a train on the road would meet, apart from what device and unit know. Three things are
known of times: a proof heard in a closure is no older than that closure; persons free a road after a memory was lost
only while no train comes; and a proof of before has run out when the device proves closed anew.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from enum import Enum, IntEnum
from typing import Final, NamedTuple

from msgspec.structs import replace

from radio.envelope import DropReason
from radio.messages import CrossingOver, CrossingRequest, Restarted
from verify.crossing.explored_crossing import (
    BEFORE,
    CURRENT,
    NOW_S,
    OUT_S,
    RUNS_S,
    UNIT,
    CrossingTrouble,
    ExploredCrossing,
    since_s,
)
from verify.crossing.rider import Told
from verify.on_air import InAir, opened
from wayside.actions import Action, Drive, Send
from wayside.crossing_said import CloseCrossing, CrossingDetected, OpenCrossing
from wayside.level_crossing import (
    WHOEVER,
    Approach,
    ClosureAsked,
    CrossingDevice,
    CrossingEvent,
    CrossingLeft,
    CrossingMemory,
    CrossingState,
    CrossingTimeDue,
    start,
    step,
)


class ArmsAt(Enum):
    """Where barriers are; where there are none, whether lamps are to shine."""

    UP = "up"
    BETWEEN = "between"
    DOWN = "down"


class GateFault(Enum):
    """What of lamps and barriers fails."""

    NONE = "none"
    STUCK = "barriers do not move"
    DEAD = "lamps do not shine"
    UNDETECTED = "contacts show nothing"


class Shut(IntEnum):
    """Whether the road is closed, and for the least time when a train that may come onto it does."""

    NOT = 0
    YOUNG = 1
    OLD = 2


class RoadRule(IntEnum):
    """What must never be."""

    NONE = 0
    OPEN = 1
    TOO_SOON = 2
    OPENS = 3


BROKEN: Final = {
    RoadRule.OPEN: "a train comes onto a road that is not closed",
    RoadRule.TOO_SOON: "a train comes onto a road that has not been closed for its least time",
    RoadRule.OPENS: "the road opens under a train, or before one that has its proof",
}


class RoadJudge(NamedTuple):
    """`later`: this closure began after the unit's proof; `excused`: the road ceased to be closed while a train went by
    a proof from before, or could stop no more: nobody can help that in time.
    """

    shut: Shut = Shut.NOT
    later: bool = False
    excused: bool = False
    broken: RoadRule = RoadRule.NONE


class GateState(NamedTuple):
    """`heard`: boot of the unit as last heard; `closes`: what lamps and barriers are commanded."""

    power: bool
    epoch: int
    heard: int
    device: CrossingDevice
    closes: bool = False
    arms: ArmsAt = ArmsAt.UP
    fault: GateFault = GateFault.NONE
    lost: bool = False  # without power, and its memory gone
    judge: RoadJudge = RoadJudge()


class GateStep(NamedTuple):
    """What comes of a step. `ceases`, `opens`: the road is closed no more, is commanded open; `alone`: only while no
    train comes; `unproven`: only while it has no proof, nor is one on its way.
    """

    name: str
    state: GateState
    sends: tuple[InAir, ...] = ()
    ceases: bool = False
    opens: bool = False
    trouble: CrossingTrouble = CrossingTrouble.NONE
    alone: bool = False
    unproven: bool = False


class Rider(NamedTuple):
    """What the judge sees of the train. `guarded`: on the road by a proof, or with one; `proven`: with one that holds;
    `committed`: it can stop no more; `comes`: it is on the road, or near, or its unit says over and over that it does;
    `believes`: it has a proof, or one is on its way.
    """

    guarded: bool
    proven: bool
    committed: bool
    comes: bool
    believes: bool


class GateModel:
    """Steps of the device and what belongs to it."""

    def __init__(self, explored: ExploredCrossing) -> None:
        self._explored: Final = explored

    def start(self) -> GateState:
        """Open, and nobody announced."""
        device = start(self._explored.config, CrossingMemory())
        return self._shown("", GateState(True, 1, 0, device)).state

    def hear(self, state: GateState, telegram: InAir) -> GateStep:
        """A telegram comes in; one for an earlier boot is answered with that."""
        if not state.power:
            return GateStep("hears", state)
        heard = opened(UNIT, telegram, state.epoch, state.heard)
        if heard is DropReason.EARLIER_BOOT:
            return GateStep("hears", state, (InAir(state.epoch, state.heard, 0, Restarted()),))
        if isinstance(heard, DropReason):
            return GateStep("hears", state)
        state = state._replace(heard=heard.epoch)
        match heard.message:
            case CrossingRequest() as request:
                return self._took("hears", state, ClosureAsked(UNIT, heard.correlation, request))
            case CrossingOver() as over:
                return self._took("hears", state, CrossingLeft(UNIT, heard.correlation, over))
            case _:
                return GateStep("hears", state)

    def events(self, state: GateState) -> tuple[GateStep, ...]:
        """All that can happen besides telegrams."""
        found = [*self._times(state), *self._equipment(state), *self._power(state)]
        if state.judge.shut is Shut.YOUNG:
            old = state.judge._replace(shut=Shut.OLD)
            found.append(GateStep("has been closed for its least time", state._replace(judge=old)))
        return tuple(s for s in found if s.state != state or s.sends)

    def _times(self, state: GateState) -> Iterator[GateStep]:
        device = state.device
        if not state.power:
            return
        waiting = {u: a for u, a in device.approaches.items() if a.starts_s > NOW_S}
        if waiting and device.state is CrossingState.OPEN:
            due = {u: replace(a, starts_s=NOW_S) for u, a in device.approaches.items()}
            yield self._timed("its time to warn comes", state, replace(device, approaches=due))
        if device.lit_s == NOW_S:
            yield self._timed("has warned for its time", state, replace(device, lit_s=OUT_S))
        if device.believed_s == RUNS_S:
            timed = self._timed("is believed no longer", state, replace(device, believed_s=NOW_S))
            yield timed._replace(unproven=True)
        if device.deadline_s == RUNS_S:
            yield self._timed("is not closed in time", state, replace(device, deadline_s=NOW_S))
        if WHOEVER in device.approaches:
            timed = self._timed("is freed by persons", state, replace(device, frees_s=NOW_S))
            yield timed._replace(alone=True)

    def _timed(self, name: str, state: GateState, device: CrossingDevice) -> GateStep:
        return self._took(name, state._replace(device=device), CrossingTimeDue())

    def _equipment(self, state: GateState) -> Iterator[GateStep]:
        if state.arms is ArmsAt.BETWEEN and state.fault is not GateFault.STUCK:
            arms = ArmsAt.DOWN if state.closes else ArmsAt.UP
            yield self._shown(f"barriers come {arms.value}", state._replace(arms=arms))
        if state.fault is GateFault.NONE:
            for fault in GateFault:
                if fault is not GateFault.NONE and (self._explored.barriers or fault is not GateFault.STUCK):
                    failed = self._shown(fault.value, state._replace(fault=fault))
                    yield failed._replace(trouble=CrossingTrouble.EQUIPMENT)
        else:
            mended = state._replace(fault=GateFault.NONE)
            yield self._shown("it is mended", self._driven(mended, mended.closes))

    def _power(self, state: GateState) -> Iterator[GateStep]:
        if state.power:
            off = self._driven(state._replace(power=False, heard=0, lost=False), True)
            for lost, trouble in ((False, CrossingTrouble.POWER), (True, CrossingTrouble.STORE)):
                name = "loses its power and what it had stored" if lost else "loses its power"
                device = start(self._explored.config, CrossingMemory() if lost else off.device.memory)
                yield GateStep(name, off._replace(device=device, lost=lost), trouble=trouble)
            return
        device = start(self._explored.config, state.device.memory, lost=state.lost)
        back = state._replace(power=True, epoch=state.epoch + 1, device=device, lost=False)
        yield self._shown("has power again", back)

    # the device, and what it drives -----------------------------------------------------------------------------

    def _took(self, name: str, state: GateState, event: CrossingEvent) -> GateStep:
        device, actions = step(state.device, event, NOW_S)
        return self._done(name, state._replace(device=_settled(device)), actions)

    def _done(self, name: str, state: GateState, actions: tuple[Action, ...]) -> GateStep:
        sends = tuple(
            InAir(state.epoch, state.heard, a.correlation, a.message) for a in actions if isinstance(a, Send)
        )
        done = GateStep(name, state, sends)
        for action in actions:
            if isinstance(action, Drive) and isinstance(action.output, OpenCrossing | CloseCrossing):
                closes = isinstance(action.output, CloseCrossing)
                driven = self._shown(name, self._driven(done.state, closes))
                opens = done.opens or driven.opens or (not closes and done.state.closes)
                more = (*done.sends, *driven.sends)
                done = driven._replace(sends=more, opens=opens, ceases=done.ceases or driven.ceases)
        return done

    def _driven(self, state: GateState, closes: bool) -> GateState:
        """Lamps at once; barriers leave the other end, unless they stick, and come to theirs in their time."""
        ends = ArmsAt.DOWN if closes else ArmsAt.UP
        arms = state.arms
        if not self._explored.barriers:
            arms = ends
        elif arms is not ends and state.fault is not GateFault.STUCK:
            arms = ArmsAt.BETWEEN
        return state._replace(closes=closes, arms=arms)

    def _shown(self, name: str, state: GateState) -> GateStep:
        """The judge sees the road, and the device what its contacts show."""
        lit = state.closes and state.fault is not GateFault.DEAD
        closed = state.arms is ArmsAt.DOWN if self._explored.barriers else lit
        judge, ceases = state.judge, not closed and state.judge.shut is not Shut.NOT
        if closed and judge.shut is Shut.NOT:
            judge = judge._replace(shut=Shut.YOUNG, later=True)
        if ceases:
            judge = judge._replace(shut=Shut.NOT)
        state = state._replace(judge=judge)
        if not state.power:
            return GateStep(name, state, ceases=ceases)
        shows = state.fault is not GateFault.UNDETECTED
        down, up = state.arms is ArmsAt.DOWN, state.arms is ArmsAt.UP
        detected = CrossingDetected(lit and shows, down and shows, up and shows)
        if detected == state.device.detected and name:
            return GateStep(name, state, ceases=ceases)
        took = self._took(name, state, detected)
        return took._replace(ceases=took.ceases or ceases)

    # the judge --------------------------------------------------------------------------------------------------

    def told(self, state: GateState, told: Told) -> GateState:
        """What a train's step means for the road."""
        judge = state.judge
        match told:
            case Told.ENTERS:
                if not judge.excused and judge.shut is not Shut.OLD:
                    rule = RoadRule.OPEN if judge.shut is Shut.NOT else RoadRule.TOO_SOON
                    judge = judge._replace(broken=rule)
                judge = judge._replace(excused=False)
            case Told.CREEPS:
                judge = judge._replace(excused=False)
            case Told.PROVEN_NOW:
                judge = judge._replace(later=False)
            case Told.PROVEN_BEFORE:
                judge = judge._replace(later=True, excused=True)
            case Told.AGAIN | Told.DROPPED:
                judge = judge._replace(excused=False)
            case Told.OLD_ENOUGH if not judge.later and judge.shut is Shut.YOUNG:
                judge = judge._replace(shut=Shut.OLD)
            case _:
                pass
        return state._replace(judge=judge)

    def judged(self, state: GateState, rider: Rider, *, ceases: bool, opens: bool) -> GateState:
        """What a step of the road means for the train."""
        judge = state.judge
        if ceases and (rider.proven or rider.committed):
            judge = judge._replace(excused=True)
        if opens and rider.guarded:
            judge = judge._replace(broken=RoadRule.OPENS)
        return state._replace(judge=judge)

    def anew(self, state: GateState) -> GateState:
        """The unit has announced itself anew: what the device has is of before."""
        approaches = {u: _of_before(a) for u, a in state.device.approaches.items()}
        return state._replace(device=replace(state.device, approaches=approaches))


def _of_before(approach: Approach) -> Approach:
    return replace(approach, correlation=BEFORE) if approach.correlation == CURRENT else approach


def _settled(device: CrossingDevice) -> CrossingDevice:
    """Times as they are told apart."""
    is_open = device.state is CrossingState.OPEN
    approaches = {
        u: replace(a, starts_s=_ahead(a.starts_s) if is_open else min(_ahead(a.starts_s), NOW_S))
        for u, a in device.approaches.items()
    }
    deadline_s = device.deadline_s
    return replace(
        device,
        approaches=approaches,
        lit_s=since_s(device.lit_s),
        deadline_s=deadline_s if deadline_s is None or math.isinf(deadline_s) else RUNS_S,
        believed_s=_ahead(device.believed_s),
    )


def _ahead(time_s: float) -> float:
    return time_s if math.isinf(time_s) else RUNS_S if time_s > NOW_S else NOW_S
