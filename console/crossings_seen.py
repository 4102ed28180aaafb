"""What can be known of level crossings without seeing them, from the journal alone: by the words of their devices that
anybody has taken up, by what one unit has heard itself, and the truth as the world writes it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from msgspec.structs import replace

from console.protocol import CrossingKnown, RoadState
from network.model import CrossingClass, LevelCrossing, Line
from onboard import crossing_notes
from onboard.crossing_notes import WhyProofLost
from radio.messages import CrossingClear, CrossingOver, CrossingRequest
from radio.noted import TookEffect
from simulation.events import (
    BarrierState,
    CrossingBarriers,
    CrossingEntered,
    CrossingLamps,
    JournalEntry,
    PowerOff,
    PowerOn,
    RoadGuarded,
)
from study.wording.reasons import reason
from wayside import crossing_said
from wayside.crossing_said import WhyUnproven
from wayside.level_crossing import VALID_S

_REQUEST, _OVER = CrossingRequest.__name__, CrossingOver.__name__
_CLEAR = CrossingClear.__name__


@dataclass(slots=True)
class _Crossing:
    """`says`: as its device has it; `heard`: as that was when a telegram of it was taken up last; `by_unit`: as each
    unit has heard itself; `announced`: those whose request it has taken.
    """

    line: LevelCrossing
    says: RoadState = RoadState.OPEN
    why: str = ""
    heard: RoadState = RoadState.UNHEARD
    heard_s: float | None = None
    by_unit: dict[str, RoadState] = field(default_factory=dict[str, RoadState])
    announced: dict[str, None] = field(default_factory=dict[str, None])
    creeps: dict[str, None] = field(default_factory=dict[str, None])
    guarded: bool = False
    lit: bool = False
    barriers: BarrierState = BarrierState.RAISED

    def hear(self, state: RoadState, t_s: float) -> None:
        self.heard, self.heard_s = state, t_s

    def known(self, now_s: float) -> RoadState:
        """A word holds as long as a proof does; where units alone close it, one that it is open also while no unit is
        announced that it answers.
        """
        if self.heard_s is None:
            return RoadState.UNHEARD
        unasked = self.line.by_radio and not self.announced
        lasts = (self.heard is RoadState.OPEN and unasked) or now_s - self.heard_s <= VALID_S
        return self.heard if lasts else RoadState.UNHEARD

    @property
    def truth(self) -> RoadState:
        """Proved closed and truly so, or what else it is."""
        up, down = self.barriers is BarrierState.RAISED, self.barriers is BarrierState.LOWERED
        if self.says is RoadState.OPEN:
            return RoadState.OPEN if up else RoadState.OPENING
        has_none = self.line.kind is not CrossingClass.BARRIERS
        closed = self.lit and (down or has_none)
        return RoadState.UNPROVEN if self.says is RoadState.CLOSED and not closed else self.says

    def shown(self, state: RoadState) -> CrossingKnown:
        """With what is heard by radio of those who come."""
        return CrossingKnown(
            id=self.line.id,
            state=state,
            announced=tuple(self.announced),
            creeps=tuple(self.creeps),
            guarded=self.guarded,
            heard_s=self.heard_s,
        )


class CrossingsSeen:
    """All level crossings of a line that have a device, entry by entry of the journal."""

    def __init__(self, line: Line) -> None:
        self._all: Final = {one.id: _Crossing(one) for one in line.crossings.values() if one.has_device}

    def known(self, now_s: float) -> tuple[CrossingKnown, ...]:
        """As whoever hears what is said by radio has them."""
        return tuple(one.shown(one.known(now_s)) for one in self._all.values())

    def heard_by(self, unit: str) -> tuple[CrossingKnown, ...]:
        """As a unit has heard of them itself."""
        return tuple(
            CrossingKnown(
                id=id_,
                state=one.by_unit.get(unit, RoadState.UNHEARD),
                creeps=(unit,) if unit in one.creeps else (),
                guarded=one.guarded,
            )
            for id_, one in self._all.items()
        )

    def truth(self, blocked: Iterable[str] = ()) -> tuple[CrossingKnown, ...]:
        """As they are, with those on which a vehicle stands."""
        stands = frozenset(blocked)
        return tuple(
            replace(
                one.shown(one.truth),
                occupied=id_ in stands,
                why=one.why,
                why_ja=reason(one.why).in_("ja"),
            )
            for id_, one in self._all.items()
        )

    def see(self, entry: JournalEntry) -> None:
        """An entry was written."""
        event, t_s = entry.event, entry.t_s
        if isinstance(event, TookEffect):
            self._telegram(event, t_s)
        elif (own := self._all.get(entry.who)) is not None:
            _of_device(own, event)
        elif (about := self._all.get(str(getattr(event, "crossing_id", "")))) is not None:
            _of_world(about, event)
            _of_unit(about, entry.who, event, t_s)
        elif isinstance(event, PowerOff | PowerOn) and (own := self._all.get(event.device_id)) is not None:
            # A device without power proves nothing; one that starts is open unless it says that it closes.
            own.says = RoadState.UNPROVEN if isinstance(event, PowerOff) else RoadState.OPEN
            own.why = ""

    def _telegram(self, event: TookEffect, t_s: float) -> None:
        to, of = self._all.get(event.receiver), self._all.get(event.source)
        if to is not None and event.kind == _REQUEST:
            to.announced[event.source] = None
        elif to is not None and event.kind == _OVER:
            to.announced.pop(event.source, None)
        if of is None:
            return
        if event.kind == _CLEAR:
            of.heard_s = t_s
        else:
            of.hear(of.says, t_s)


def _of_device(own: _Crossing, event: object) -> None:
    match event:
        case crossing_said.CrossingWarns():
            own.says, own.why = RoadState.WARNING, ""
        case crossing_said.CrossingProven():
            own.says, own.why = RoadState.CLOSED, ""
        case crossing_said.CrossingUnproven(why=WhyUnproven(value=why)):
            own.says, own.why = RoadState.UNPROVEN, why
        case crossing_said.CrossingOpens():
            own.says, own.why = RoadState.OPEN, ""
            own.announced.clear()
        case _:
            pass


def _of_world(about: _Crossing, event: object) -> None:
    match event:
        case CrossingLamps(lit=lit):
            about.lit = lit
        case CrossingBarriers(state=barriers):
            about.barriers = barriers
        case RoadGuarded(there=there):
            about.guarded = there
        case CrossingEntered(unit_id=unit):
            about.creeps.pop(unit, None)
        case _:
            pass


def _of_unit(about: _Crossing, unit: str, event: object, t_s: float) -> None:
    protected = about.line.has_protection
    match event:
        case crossing_notes.CrossingAsked():
            about.by_unit[unit] = RoadState.ASKED
        case crossing_notes.CrossingHeardClosed():
            about.by_unit[unit] = RoadState.CLOSED
            about.creeps.pop(unit, None)
        case crossing_notes.CrossingHeardClear():
            about.by_unit[unit] = RoadState.CLEAR
            about.creeps.pop(unit, None)
            about.hear(RoadState.CLEAR, t_s)
        case crossing_notes.CrossingProofLost(why=why):
            silent = why is WhyProofLost.SILENCE
            about.by_unit[unit] = RoadState.UNHEARD if silent else RoadState.UNPROVEN
            if protected and not silent:
                about.hear(RoadState.UNPROVEN, t_s)
        case crossing_notes.CrossingCreep():
            about.creeps[unit] = None
        case crossing_notes.CrossingLeftBehind():
            about.by_unit.pop(unit, None)
            about.creeps.pop(unit, None)
        case _:
            pass
