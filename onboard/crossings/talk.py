"""What one boot of a unit has to do with the level crossings of its path: their views, and the telegrams to and fro."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from msgspec.structs import replace

from onboard import notes
from onboard.crossings.machine import (
    CreepAllowed,
    CrossingAnswered,
    CrossingBooted,
    CrossingEvent,
    CrossingOffLine,
    CrossingOverAnswered,
    CrossingPhase,
    CrossingPlace,
    CrossingSeen,
    CrossingUnplaced,
    CrossingView,
    ends_s,
    may_pass,
    starts_too_soon,
    step,
    still_s,
    wake_s,
)
from onboard.duty.records import CrossingCommand, DutyPhase, DutyState
from radio.envelope import Received
from radio.messages import (
    CrossingClear,
    CrossingOver,
    CrossingOverHeard,
    CrossingProof,
    CrossingRequest,
    Restarted,
)

NEAR_S: Final = 15.0  # of a crossing that closes by itself: as near as one that must have been closed so long
NEVER_ASKED: Final = 0  # what this boot says to a crossing that one before may have asked

_ANNOUNCED: Final = (CrossingPhase.ASKED, CrossingPhase.PROVEN, CrossingPhase.PASSING)


class CrossingLetter(NamedTuple):
    """A telegram for a level crossing."""

    crossing_id: str
    message: CrossingRequest | CrossingOver
    correlation: int


class CrossingTalk:
    """All crossings of one unit; `forgot`: an earlier boot may have announced it anywhere."""

    def __init__(self, *, forgot: bool) -> None:
        self.letters: list[CrossingLetter] = []
        self.notes: list[notes.Note] = []
        self._forgot: Final = forgot
        self.views: dict[str, CrossingView] = {}
        self._places: Mapping[str, CrossingPlace] = {}
        self._goes_on = self._stands = False
        self.correlations: dict[str, int] = {}
        self._announced: dict[str, None] = {}  # who has heard of it, or is yet to hear that it is over
        self._live: list[str] = []  # those that matter: ahead or announced
        self._held: tuple[float, tuple[str, str]] | None = None  # what `_first_closed` has found, and when

    def resume(
        self,
        views: Mapping[str, CrossingView],
        correlations: Mapping[str, int],
        places: Sequence[CrossingPlace],
        state: DutyState,
    ) -> None:
        """Go on as it was left: by what it knew and had said, and by where it saw the crossings of its path."""
        for crossing_id, view in views.items():
            self._put(crossing_id, view)
        self.correlations |= correlations
        self._places = {place.crossing_id: _as_it_runs(place, state, math.inf) for place in places}
        self._goes_on = state.phase is DutyPhase.RUNNING

    @property
    def creeps(self) -> bool:
        """Whether the train runs on sight over a crossing that has not proved closed."""
        return any(view.creeps for view in self.views.values())

    def look(
        self, places: Sequence[CrossingPlace] | None, state: DutyState, leaves_in_s: float, now_s: float
    ) -> None:
        """See where the train is now; None: it does not know. A stop is left in `leaves_in_s` at the soonest."""
        self._held = None
        if places is None:
            self._places, self._live, self._stands = {}, list(self.views), False
            for crossing_id in self._live:
                says = self.views[crossing_id].phase is CrossingPhase.LEAVING  # that holds wherever it is
                self._take(crossing_id, CrossingSeen(None) if says else CrossingUnplaced(), now_s)
            return
        self._goes_on = state.phase is DutyPhase.RUNNING or leaves_in_s <= 0.0
        here: dict[str, CrossingPlace] = {}
        self._places, self._stands = here, False
        for place in places:
            crossing_id = place.crossing_id
            view = self.views.get(crossing_id) or CrossingView(crossing_id, forgot=self._forgot)
            if place.clear and view.phase is CrossingPhase.AHEAD and not view.forgot:
                continue  # it lies behind, and knows that
            self.views[crossing_id] = view
            here[crossing_id] = _as_it_runs(place, state, leaves_in_s)
            self._stands = self._stands or place.stands
        self._live = [*here, *(crossing_id for crossing_id in self._announced if crossing_id not in here)]
        for crossing_id in self._live:
            self._take(crossing_id, CrossingSeen(here.get(crossing_id)), now_s)

    def hear(self, heard: Received, now_s: float) -> bool:
        """Take a telegram, if it is a level crossing's; whether it was."""
        crossing_id = heard.source
        if crossing_id not in self.views:
            return False
        match heard.message:
            case CrossingProof(passable, valid_s) | CrossingClear(passable, valid_s):
                if heard.fresh and heard.correlation == self.correlations.get(crossing_id):
                    by_contacts = isinstance(heard.message, CrossingClear)
                    answered = CrossingAnswered(passable, now_s + valid_s, by_contacts)
                    self._take(crossing_id, answered, now_s)
            case CrossingOverHeard():
                if heard.correlation == self.correlations.get(crossing_id, NEVER_ASKED):
                    self._take(crossing_id, CrossingOverAnswered(), now_s)
            case Restarted():
                self._take(crossing_id, CrossingBooted(), now_s)
            case _:
                return False
        return True

    def creep(self, crossing_id: str, now_s: float, *, guarded: bool = False) -> None:
        """Its driver has leave to creep over a crossing."""
        if crossing_id in self.views:
            self._take(crossing_id, CreepAllowed(guarded=guarded), now_s)

    def off_the_line(self, now_s: float) -> None:
        """The whole train is off the line."""
        for crossing_id in list(self.views):
            self._take(crossing_id, CrossingOffLine(), now_s)

    def command(self, now_s: float) -> CrossingCommand:
        """What the driving part is to do of it, `look_s` in elapsed time."""
        look_s, unless_on = self.proof_ends(now_s)
        before, guarded = self.held_before(now_s), self.guarded(now_s)
        return CrossingCommand(before, guarded, self.kept_standing_by(now_s), self.creeps, unless_on, look_s)

    def held_before(self, now_s: float) -> str:
        """The first crossing that the front may not go onto; empty: none."""
        return self._first_closed(now_s)[0]

    def guarded(self, now_s: float) -> str:
        """The same, however far ahead it is: a unit that acts no more, as frozen, is stopped before it."""
        return self._first_closed(now_s)[1]

    def _first_closed(self, now_s: float) -> tuple[str, str]:
        if self._held is None or self._held[0] != now_s:
            views, places = self.views, self._places.items()
            near = (id_ for id_, place in places if not may_pass(views[id_], place, now_s))
            any_ = (id_ for id_, place in places if not may_pass(views[id_], place, now_s, math.inf))
            self._held = (now_s, (next(near, ""), next(any_, "")))
        return self._held[1]

    def start_held_by(self, now_s: float) -> str:
        """The crossing so near that a train that stands does not start for it, or of which its departure is to warn;
        empty: none.
        """
        if not self._stands:
            return ""
        place = self._places.get(self.held_before(now_s))
        if place is None or not place.stands:
            return ""
        near = place.fastest_s < (place.least_s or NEAR_S)
        waits = near or starts_too_soon(self.views[place.crossing_id], place, now_s)
        return place.crossing_id if waits else ""

    def kept_standing_by(self, now_s: float) -> str:
        """The crossing for which a train stands that would go on now; empty: none, or one that is proven and has but to
        be so for its least time.
        """
        place = self._places.get(self.start_held_by(now_s))
        if place is None or self.views[place.crossing_id].phase is CrossingPhase.PROVEN:
            return ""
        return place.crossing_id if self._goes_on and math.isfinite(place.arrives_s) else ""

    def proof_ends(self, now_s: float) -> tuple[float, str]:
        """When to look again, s, if the front is not surely on this crossing by then; infinite, empty: at none."""
        ends = (math.inf, "")
        for crossing_id in self._live:
            view = self.views[crossing_id]
            if view.phase is CrossingPhase.PROVEN:
                ends = min(ends, (ends_s(view, self._places.get(crossing_id), now_s), crossing_id))
        return ends

    def wake_s(self, now_s: float, unless_on: str) -> float:
        """When to look again wherever the train is then; infinite: not before something happens. `unless_on`: the
        crossing of `proof_ends`.
        """
        seen = self._places
        if not seen:
            said = (view.said_s for view in self.views.values() if view.phase is CrossingPhase.LEAVING)
            return min((max(at_s + 2.0, now_s + 0.1) for at_s in said), default=math.inf)
        views = self.views
        wakes_s = [
            still_s(views[id_]) if id_ == unless_on else wake_s(views[id_], seen.get(id_), now_s)
            for id_ in self._live
        ]
        return min(wakes_s, default=math.inf)

    def _put(self, crossing_id: str, view: CrossingView) -> None:
        self.views[crossing_id] = view
        if view.phase is CrossingPhase.AHEAD:
            self._announced.pop(crossing_id, None)
        else:
            self._announced[crossing_id] = None

    def _take(self, crossing_id: str, event: CrossingEvent, now_s: float) -> None:
        before = self.views[crossing_id]
        after, actions = step(before, event, now_s)
        if after is before and not actions:
            return
        self._held = None
        self._put(crossing_id, after)
        if after.phase in _ANNOUNCED and before.phase not in _ANNOUNCED:
            self.correlations[crossing_id] = self.correlations.get(crossing_id, NEVER_ASKED) + 1
        for action in actions:
            if isinstance(action, CrossingRequest | CrossingOver):
                correlation = self.correlations.get(crossing_id, NEVER_ASKED)
                self.letters.append(CrossingLetter(crossing_id, action, correlation))
            else:
                self.notes.append(action)


def _as_it_runs(place: CrossingPlace, state: DutyState, leaves_in_s: float) -> CrossingPlace:
    """The place with the times of a train that runs or leaves towards it; of another they are infinite."""
    held = state.limit.joint > place.span and not state.halted and state.unable is None
    comes = held and state.at >= place.stop  # greater: it was counted as arrived short of it
    if comes and state.phase is DutyPhase.RUNNING:
        return place
    if comes and state.phase is DutyPhase.STANDING:
        leaves_in_s = max(leaves_in_s, 0.0)
        return replace(place, arrives_s=place.arrives_s + leaves_in_s, proof_s=place.proof_s + leaves_in_s)
    return replace(place, arrives_s=math.inf, proof_s=math.inf)
