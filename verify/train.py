"""One unit and its train, as a party of the exploration: the real steps of duty and letters, the train in thirds of
sections, the unit's power and its crew.

Two states are one where only words for people differ (why something was refused) or numbers that nothing reads any more
(of requests that are closed, of sections that are not held); `tests/verify/test_composition.py` shows of the first
states found that both kinds take the same way.
"""

from __future__ import annotations

from enum import Enum
from typing import Final, NamedTuple

from msgspec.structs import replace

from onboard.authority.letters import NO_NUMBERS, LetterNumbers, Letters
from onboard.authority.records import (
    Authority,
    Commit,
    Ordered,
    Renew,
    RequestKind,
    SendClaim,
    SendCommand,
    SendRefusal,
    SendRequest,
    SetTimer,
    StopTimer,
    Take,
    Timer,
)
from onboard.duty import records
from onboard.duty.duty_step import Action
from onboard.duty.machine import step
from onboard.plan import DutyPlan
from radio.envelope import DropReason, Received
from radio.messages import PointsCommand
from verify.explored_line import END, TERMINALS, ExploredLine, mask_of, plans_of
from verify.on_air import InAir, opened
from verify.thirds import PLACES_A_SPAN, place_in_joints
from wayside.config import MANAGER_ID

PEERS: Final = (MANAGER_ID, *TERMINALS)
REFUSED: Final = "refused"
# where the front reads a tag: whole in the second span, and at the mark
TAGS_AT: Final = (PLACES_A_SPAN, END)

# Commands of the same points are numbered 1 and 2 in turn: no more than two of them are ever told apart.
OTHER_COMMAND: Final = (1, 2, 1)


class TrainPlace(Enum):
    """Where the world has a train."""

    OUTSIDE = "outside"
    WAITING = "waits before the portal"
    ON_LINE = "on the line"
    GONE = "gone"


class TrainState(NamedTuple):
    """A unit and its train. `heard`: boots of the manager and the terminals as it last heard them; `spot`: how far on
    its plan, in thirds of a span; `keys`: points that its crew has locked on the spot.
    """

    place: TrainPlace = TrainPlace.OUTSIDE
    power: bool = True
    epoch: int = 1
    heard: tuple[int, ...] = (0,) * len(PEERS)
    duty: records.DutyState = records.DutyState()
    numbers: LetterNumbers = NO_NUMBERS
    timers: frozenset[Timer] = frozenset()
    plan: int = 0
    spot: int = 0
    moves: bool = False
    known: bool = True
    emergency: bool = False
    tags_read: int = 0  # of its plan, in order
    may_enter: bool = False
    may_leave: bool = False
    keys: frozenset[int] = frozenset()


class TrainStep(NamedTuple):
    """What comes of a step: telegrams by peer."""

    state: TrainState
    sends: tuple[tuple[int, InAir], ...] = ()


class ExploredTrain:
    """Steps of one unit and its train."""

    def __init__(self, line: ExploredLine, unit_id: str) -> None:
        self.unit_id: Final = unit_id
        self.plans: Final = plans_of(line, unit_id)
        self._parameters: Final = line.parameters

    def plan(self, state: TrainState) -> DutyPlan:
        """The plan that the train is on."""
        return self.plans[state.plan]

    def hear(self, state: TrainState, peer: int, telegram: InAir) -> TrainStep:
        """A telegram comes in; nothing happens where the unit has no power."""
        if not state.power:
            return TrainStep(state)
        heard = opened(PEERS[peer], telegram, state.epoch, state.heard[peer])
        if isinstance(heard, DropReason):
            letters = Letters(self.unit_id, MANAGER_ID, state.numbers)
            event = letters.read_dropped(heard, PEERS[peer])
            return TrainStep(state) if event is None else self.take(state, records.TelegramHeard(event))
        boots = (*state.heard[:peer], heard.epoch, *state.heard[peer + 1 :])
        return self.take(state._replace(heard=boots), heard)

    def take(self, state: TrainState, what: records.Event | Received) -> TrainStep:
        """The real machine takes an event or a telegram where the train then is, and what it says is done."""
        letters = Letters(self.unit_id, MANAGER_ID, state.numbers)
        event = what
        if isinstance(what, Received):
            read = letters.read(what)
            if read is None:
                return TrainStep(state)
            event = read if isinstance(read, Ordered) else records.TelegramHeard(read)
        assert not isinstance(event, Received)
        if isinstance(event, records.SwitchedOn):
            event = replace(event, epoch=state.epoch)
        plan = event.plan if isinstance(event, records.Begin | records.SwitchedOn) else self.plan(state)
        duty, actions = step(plan, self._parameters, state.duty, event, self.place(state), 0.0)
        return self._done(state._replace(duty=duty), letters, actions)

    def _done(self, state: TrainState, letters: Letters, actions: tuple[Action, ...]) -> TrainStep:
        timers, sends = set(state.timers), list[tuple[int, InAir]]()
        given = {points: known.correlation for points, known in state.numbers.commanded}
        for action in actions:
            match action:
                case SendRequest() | SendClaim() | SendRefusal() | SendCommand():
                    letter = letters.write(action)
                    peer = PEERS.index(letter.destination)
                    message = letter.message
                    number = (
                        given[message.points_id] if isinstance(message, PointsCommand) else letter.correlation
                    )
                    sends.append((peer, InAir(state.epoch, state.heard[peer], number, letter.message)))
                case Commit(needed):
                    letters.keep(action)
                    given[needed.points_id] = OTHER_COMMAND[given.get(needed.points_id, 0)]
                case Renew() | Take():
                    letters.keep(action)
                case SetTimer(timer) | records.SetTimerAt(timer):
                    timers.add(timer)
                case StopTimer(timer):
                    timers.discard(timer)
                case records.DrivingOrder.RELEASE:
                    state = state._replace(emergency=False)
                case records.DrivingOrder.STOP:
                    state = state._replace(emergency=True)
                case records.DrivingOrder.LOSE:
                    state = state._replace(emergency=True, known=False)
                case records.EntryAllowed():
                    state = state._replace(may_enter=True)
                case records.LeftLine():
                    state = state._replace(may_leave=True)
                case _:
                    pass
        commanded = tuple((p, known._replace(correlation=given[p])) for p, known in letters.numbers.commanded)
        numbers = letters.numbers._replace(commanded=commanded)
        state = state._replace(timers=frozenset(timers), numbers=numbers)
        return TrainStep(self.told_apart(state), tuple(sends))

    def told_apart(self, state: TrainState) -> TrainState:
        """The state without what nothing reads any more."""
        authority = state.duty.authority
        plain = replace(
            authority,
            requests=tuple(replace(r, refusal=REFUSED if r.refusal else "") for r in authority.requests),
            commands=tuple(replace(c, refusal=REFUSED if c.refusal else "") for c in authority.commands),
            mismatch=REFUSED if authority.mismatch else "",
        )
        return state._replace(
            duty=replace(state.duty, authority=plain), numbers=_in_use(plain, state.numbers)
        )

    def place(self, state: TrainState) -> records.PlaceInJoints:
        """What `onboard.motion` would make of where the train is."""
        return place_in_joints(
            state.spot, END, known=state.known, moves=state.moves, emergency=state.emergency
        )

    def meets_tag(self, state: TrainState) -> bool:
        """Whether the front is at the next tag, which it has not read."""
        ahead = TAGS_AT[-len(self.plan(state).tags) :][state.tags_read :]
        return state.spot in ahead[:1]

    def occupied(self, state: TrainState) -> int:
        """Sections that the train truly stands in, as bits."""
        if state.place is not TrainPlace.ON_LINE:
            return 0
        span, part = divmod(state.spot, PLACES_A_SPAN)
        return mask_of(tuple(s.section_id for s in self.plan(state).spans[span : span + 1 + (part == 2)]))

    def seen_or_shown(self, state: TrainState) -> int:
        """What it occupies, as bits, with what its unit shows that it holds, and so may run into."""
        shown = state.duty.authority.held if self.speaks(state) else ()
        return self.occupied(state) | mask_of(shown)

    def speaks(self, state: TrainState) -> bool:
        """Whether the unit has power and knows what it holds, so that nobody needs to speak for it."""
        authority = state.duty.authority
        request = authority.open(RequestKind.SIGN_ON)
        return state.power and not authority.unsure and not (request and request.section_ids is None)


def _in_use(authority: Authority, numbers: LetterNumbers) -> LetterNumbers:
    open_kinds = {request.ask for request in authority.requests}
    return numbers._replace(
        open=tuple(item for item in numbers.open if item[0] in open_kinds),
        tokens=tuple(item for item in numbers.tokens if item[0] in authority.held),
        macs=tuple(item for item in numbers.macs if item[0][0] in authority.held),
    )
