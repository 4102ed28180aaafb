"""What can happen to an on-board unit on a small line: for the state diagrams, and for tests that look at every state.

The real `step` of duty and authority, between two stations A and B with open line O and one set of points X between
them, out and back. The train moves as its command lets it; telegrams answer what is open, well or ill; tags, timers and
people come when they can. Numbers and times are outside the states, so a state here is one of the unit as it runs.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

from network.model import Position, SectionKind, TagPurpose
from onboard.authority.records import (
    Ask,
    Confirmed,
    Contested,
    Granted,
    PeerRestarted,
    PointsDenied,
    Proof,
    Queried,
    Refused,
    SignedOff,
    SignedOn,
)
from onboard.authority.records import Event as AuthorityEvent
from onboard.duty.machine import step
from onboard.duty.plan import Leg, Plan, PointsNeeded, Span, Stop, Tag
from onboard.duty.records import (
    ABLE,
    ASK,
    LEAVE,
    RELEASE,
    AtMark,
    Begin,
    ChangeEnds,
    DutyState,
    EndOfHeld,
    Event,
    Found,
    Heard,
    How,
    Leave,
    Looked,
    NotAtMark,
    OffTheLine,
    Order,
    Phase,
    Place,
    PointsSeen,
    PointsWrong,
    PositionLost,
    SetBack,
    Started,
    Stopped,
    SwitchedOn,
    TagPassed,
    TagReached,
    TimerDue,
)
from onboard.duty.shown import command_of
from onboard.duty.turn import Action, DutyParameters
from onboard.duty.unable import TooSteep

X: Final = PointsNeeded("PX", Position.NORMAL, "X", "terminal")
_KINDS: Final = {
    "A": SectionKind.TRACK,
    "O": SectionKind.BETWEEN,
    "X": SectionKind.POINTS,
    "B": SectionKind.TRACK,
}
_TIMES: Final = DutyParameters(dwell_min_s=20.0, request_lead_s=45.0, emergency_release_s=30.0)
_NOW_S, _DEPARTURE_S = 0.0, 1000.0
_PLACES_A_SPAN: Final = (
    3  # between joints, perhaps beyond the next, surely beyond it with the rear still behind
)


def _plan(number: str, section_ids: tuple[str, ...], tags: tuple[Tag, ...]) -> Plan:
    spans = tuple(Span(s, _KINDS[s], (X,) if s == "X" else (), s, 0.0) for s in section_ids)
    first, last = section_ids[0], section_ids[-1]
    stops = (Stop(first, True, 0, 0, None, _DEPARTURE_S), Stop(last, True, 3, 3, None, None))
    leg = Leg(f"{first}>{last}", first, section_ids[1:])
    return Plan(number, number, spans, (leg,), stops, tags, last, 0.0, enters=False)


PLANS: Final = (
    _plan("out", ("A", "O", "X", "B"), (Tag(1, TagPurpose.APPROACH, 2), Tag(2, TagPurpose.ARRIVAL, 4, 3))),
    _plan("back", ("B", "X", "O", "A"), (Tag(3, TagPurpose.DEPARTED, 3), Tag(4, TagPurpose.ARRIVAL, 4, 3))),
)
_TAGS: Final = ({3: 0, 9: 1}, {6: 0, 9: 1})  # by plan: where a tag lies, and its index
END: Final = 9
TOO_STEEP: Final = TooSteep("B", "O", 0.0, 40.0, 1.0, 2.0, 0.0, 0.5)


class Run(NamedTuple):
    """A unit and its train: on which plan, how far in thirds of a span, and how."""

    state: DutyState = DutyState()
    plan: int = 0
    spot: int = 0
    moves: bool = False
    known: bool = True
    emergency: bool = False
    read: int = -1  # the last tag
    unable: bool = False  # to reach the next stop, where it stands at one
    untold: bool = False  # found by what does not tell tracks apart

    @property
    def place(self) -> Place:
        """What `onboard.motion` would make of it."""
        if not self.known:
            return Place(stands=not self.moves, emergency=self.emergency)
        span, part = divmod(self.spot, _PLACES_A_SPAN)
        here = span + (part == 2)
        perhaps = span + 1 + (part > 0)
        return Place(
            known=True,
            stands=not self.moves,
            emergency=self.emergency,
            here=here,
            sure=here + 1,
            perhaps=perhaps,
            clear=span,
            clear_at_mark=span,
            reach=perhaps,
            near={0: 0, END: 1}.get(self.spot, -1),
            passed=int(self.spot == END and not self.moves),
            unable=TOO_STEEP if self.unable and self.spot == 0 and not self.moves else None,
            untold=self.untold,
        )

    @property
    def under(self) -> tuple[str, ...]:
        """Sections that the train stands in."""
        span, part = divmod(self.spot, _PLACES_A_SPAN)
        return tuple(s.section_id for s in PLANS[self.plan].spans[span : span + 1 + (part > 0)])


class Step(NamedTuple):
    """One thing that can happen, and what comes of it."""

    event: Event
    run: Run
    actions: tuple[Action, ...]


def steps(run: Run) -> Iterator[Step]:
    """All that can happen next."""
    for event, after in (*_people(run), *_movement(run), *_time(run), *_telegrams(run)):
        yield taken(event, after)


def taken(event: Event, run: Run) -> Step:
    """The real machine takes the event where the train then is."""
    state, actions = step(PLANS[run.plan], _TIMES, run.state, event, run.place, _NOW_S)
    lost = Order.LOSE in actions
    emergency = (run.emergency or lost or Order.STOP in actions) and Order.RELEASE not in actions
    return Step(event, run._replace(state=state, emergency=emergency, known=run.known and not lost), actions)


def event_name(event: Event) -> str:
    """An event by its type: a telegram by what it means, a timer by its name."""
    match event:
        case Heard(heard):
            return type(heard).__name__
        case TimerDue(timer):
            return f"TimerDue {timer.name}"
        case _:
            return type(event).__name__


def phase_name(run: Run) -> str:
    """The phase of its duty."""
    return run.state.phase.value


def may_go_on(run: Run) -> bool:
    """Whether the next joint is free: by the stop limit, or without a position by the crew's eye."""
    plan, state = PLANS[run.plan], run.state
    if run.spot == END:
        return False
    joint = run.spot // _PLACES_A_SPAN + 1
    if run.spot % _PLACES_A_SPAN == 2:
        return True
    if run.known and state.phase is not Phase.ON_SIGHT:
        return state.limit.joint > joint
    span = plan.spans[joint]
    return not span.points or all(needed in state.authority.proven for needed in span.points)


def may_start(run: Run) -> bool:
    """Whether the train drives: to the next joint, up to its mark, or to a tag before either."""
    drives = command_of(PLANS[run.plan], run.state).drive and not run.emergency
    short_of_mark = run.spot == END and run.state.phase is Phase.RUNNING
    return drives and (may_go_on(run) or short_of_mark or _TAGS[run.plan].get(run.spot, -1) > run.read)


_Happening = tuple[Event, Run]


def _people(run: Run) -> Iterator[_Happening]:
    phase = run.state.phase
    if phase in (Phase.OFF, Phase.GONE):
        yield Begin(PLANS[0], signs_on=True), Run(run.state)
    if phase is Phase.LEAVING:
        yield OffTheLine(), run
    if phase is Phase.OFF:
        for spot, stands_at in ((0, 0), (3, None)):
            yield SwitchedOn(PLANS[0], stands_at), Run(run.state, 0, spot, known=False, emergency=True)
    if phase is Phase.FINISHED:
        yield ChangeEnds(), run
        yield Leave(), run
        other = 1 - run.plan
        if run.spot == END and set(run.state.authority.held) == set(run.under):
            yield Begin(PLANS[other], signs_on=False), run._replace(plan=other, spot=0, moves=False, read=-1)
    if phase is Phase.STANDING or (phase is Phase.RUNNING and not run.moves):
        yield SetBack(60.0), run
    if command_of(PLANS[run.plan], run.state).confirm:
        yield (AtMark(run.state.at) if run.spot == END else NotAtMark()), run
    if phase is Phase.ON_SIGHT and not run.moves:
        if not run.known and PLANS[run.plan].spans[run.spot // _PLACES_A_SPAN + (run.spot < END)].points:
            yield PointsSeen(X), run
            yield PointsWrong(X), run
        if not run.known and run.spot == END and run.state.stands_at != 1:
            yield AtMark(1), run
        if not run.known and not run.state.authority.holds(PLANS[run.plan].spans[-1].section_id):
            yield EndOfHeld(run.spot // _PLACES_A_SPAN), run


def _movement(run: Run) -> Iterator[_Happening]:
    on_line = run.state.phase not in (Phase.OFF, Phase.LEAVING, Phase.GONE)
    tag = _TAGS[run.plan].get(run.spot, -1)
    if not run.moves and may_start(run):
        yield Started(), run._replace(moves=True)
    if run.moves:
        if run.known and tag > run.read:
            pass  # a tag that is expected is read, or missed and the position lost
        else:
            bounds_may_pass = run.spot % _PLACES_A_SPAN == 0 and run.spot != END
            if may_go_on(run) or bounds_may_pass:
                yield Looked(), run._replace(spot=run.spot + 1)
            if not may_go_on(run):
                how = How.AT if run.spot == END else How.SHORT
                yield Stopped(how, 0.0), run._replace(moves=False)
        yield Stopped(How.SHORT, -1.0), run._replace(moves=False, emergency=True)
    if run.moves and tag > run.read:
        yield TagPassed(tag, not run.known), run._replace(known=True, read=tag, untold=False)
        if run.known:
            yield TagReached(tag), run
    if on_line and not run.known:
        yield Found(), run._replace(known=True, untold=True)
    if run.known and run.spot == 0 and run.state.phase is Phase.STANDING:
        yield Looked(), run._replace(unable=not run.unable)  # motors fail, or are there again
    if run.known and on_line:
        yield PositionLost(), run._replace(known=False, emergency=True)


def _time(run: Run) -> Iterator[_Happening]:
    state = run.state
    waits = state.phase is Phase.STANDING or (state.phase is Phase.ON_SIGHT and state.stands_at is not None)
    if (waits or state.phase is Phase.RUNNING) and not state.may_ask:
        yield TimerDue(ASK), run
    if waits and not state.may_leave:
        yield TimerDue(LEAVE), run
    if not state.released and not run.moves:
        yield TimerDue(RELEASE), run
    if state.unable is not None:
        yield TimerDue(ABLE), run
    yield from ((TimerDue(request.timer), run) for request in state.authority.requests)
    yield from ((TimerDue(command.timer), run) for command in state.authority.commands)


def _telegrams(run: Run) -> Iterator[_Happening]:
    if run.state.phase not in (Phase.OFF, Phase.GONE):
        for event in (*_answers(run), *_of_points(run), Queried(), PeerRestarted()):
            yield Heard(event), run
        if run.state.authority.on_line:
            yield Heard(Contested(run.state.authority.held[:1])), run


def _answers(run: Run) -> Iterator[AuthorityEvent]:
    state = run.state.authority
    ahead = tuple(s.section_id for s in PLANS[run.plan].spans if s.section_id not in run.under)
    for request in state.requests:
        if request.ask is not Ask.REPORT:
            yield Refused(request.ask, request.subject, "held", lost_sight=False, answers=True)
            yield Refused(request.ask, request.subject, "stale token", lost_sight=True, answers=True)
        match request.ask:
            case Ask.SIGN_ON if request.section_ids is None:
                yield SignedOn(run.under, _with_points(run.under), answers=True, newer=True)
                whole = (*run.under, *ahead[max(0, run.spot // _PLACES_A_SPAN) :])
                yield SignedOn(whole, _with_points(whole), answers=True, newer=True)
            case Ask.SIGN_ON:
                yield SignedOn(request.section_ids or (), (), answers=True, newer=True)
            case Ask.SIGN_OFF:
                yield SignedOff(answers=True)
            case Ask.ROUTE:
                section_ids = request.section_ids or ()
                yield Granted(request.subject, section_ids, ("X",), answers=True, fresh=True, newer=True)
                yield Granted(request.subject, section_ids, ("X",), answers=True, fresh=True, newer=False)
            case Ask.REPORT:
                yield Confirmed(state.held, answers=True, newer=False)
                yield Confirmed(state.held, answers=True, newer=True)
                yield Confirmed((*state.held, "elsewhere"), answers=True, newer=True)
                yield Confirmed(state.held, answers=True, newer=False, contested=state.held[:1])
                yield Confirmed(state.held[1:], answers=True, newer=False)


def _with_points(section_ids: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(section_id for section_id in section_ids if section_id == "X")


def _of_points(run: Run) -> Iterator[AuthorityEvent]:
    state = run.state.authority
    if state.commands or state.unsaid or state.proven:
        yield Proof("PX", "terminal", "normal", mine=True)
        yield Proof("PX", "terminal", None, mine=True)
    if state.commands:
        yield PointsDenied("PX", "terminal", "not detected", mine=True)


_GOOD: Final = (
    "SignedOn",
    "Granted",
    "Proof",
    "Confirmed",
    "TagPassed",
    "TimerDue ask",
    "TimerDue leave",
    "Started",
    "Looked",
    "Stopped",
    "Begin",
    "Leave",
    "SignedOff",
    "OffTheLine",
)


def course() -> tuple[Run, ...]:
    """A course on which all goes well: out, back, and off the line."""
    run = Run()
    runs = [run]
    while run.state.phase is not Phase.GONE:
        possible = [s for s in steps(run) if s.run not in runs and _is_good(s.event)]
        run = min(possible, key=lambda s: _GOOD.index(event_name(s.event))).run
        runs.append(run)
    return tuple(runs)


def first() -> tuple[Run, ...]:
    """Where to look first: that course, and a unit switched on at each place of the way."""
    lost = [
        Run(plan=plan, spot=spot, known=False, emergency=True) for plan in (0, 1) for spot in range(END + 1)
    ]
    return (*course(), *(taken(SwitchedOn(PLANS[run.plan], None), run).run for run in lost))


def _is_good(event: Event) -> bool:
    lost = isinstance(event, Heard) and isinstance(event.event, Proof) and event.event.position is None
    return event_name(event) in _GOOD and not lost


def following(run: Run) -> Iterator[tuple[str, Run]]:
    """What `documents.explored` asks for: events by name and what they lead to."""
    for step_ in steps(run):
        yield event_name(step_.event), step_.run
