"""What can happen to an on-board unit on a small line: for the state diagrams, and for tests that look at every state.

The real `step` of duty and authority, between two stations A and B with open line O and one set of points X between
them, out and back. The train moves as its command lets it; telegrams answer what is open, well or ill; tags, timers and
people come when they can. Numbers and times are outside the states, so a state here is one of the unit as it runs.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

from msgspec.structs import replace

from network.model import Position, SectionKind, TagPurpose
from onboard.authority.records import (
    ConfirmationHeard,
    ContestHeard,
    EarlierBootCalled,
    GrantHeard,
    PeerRestarted,
    PointsDenialHeard,
    ProofHeard,
    QueryHeard,
    RefusalHeard,
    RequestKind,
    SignOffHeard,
    SignOnHeard,
)
from onboard.authority.records import Event as AuthorityEvent
from onboard.duty import records
from onboard.duty.duty_step import Action
from onboard.duty.machine import step
from onboard.duty.shown import command_of
from onboard.duty.unable import TooSteep
from onboard.duty_parameters import DutyParameters
from onboard.plan import DutyPlan, PlanLeg, PlanStop, PlanTag, PointsNeeded, Span
from verify.thirds import PLACES_A_SPAN, place_in_joints

X: Final = PointsNeeded("PX", Position.NORMAL, "X", "terminal")
_KINDS: Final = {
    "A": SectionKind.TRACK,
    "O": SectionKind.BETWEEN,
    "X": SectionKind.POINTS,
    "B": SectionKind.TRACK,
}
TIMES: Final = DutyParameters(dwell_min_s=20.0, request_lead_s=45.0, emergency_release_s=30.0)
_NOW_S, _DEPARTURE_S = 0.0, 1000.0


def _plan(number: str, section_ids: tuple[str, ...], tags: tuple[PlanTag, ...]) -> DutyPlan:
    spans = tuple(Span(s, _KINDS[s], (X,) if s == "X" else (), s, 0.0) for s in section_ids)
    first, last = section_ids[0], section_ids[-1]
    stops = (PlanStop(first, True, 0, 0, None, _DEPARTURE_S), PlanStop(last, True, 3, 3, None, None))
    leg = PlanLeg(f"{first}>{last}", first, section_ids[1:])
    return DutyPlan(number, number, spans, (leg,), stops, tags, last, 0.0, enters=False)


PLANS: Final = (
    _plan(
        "out",
        ("A", "O", "X", "B"),
        (PlanTag(1, TagPurpose.APPROACH, 2), PlanTag(2, TagPurpose.ARRIVAL, 4, 3)),
    ),
    _plan(
        "back",
        ("B", "X", "O", "A"),
        (PlanTag(3, TagPurpose.DEPARTED, 3), PlanTag(4, TagPurpose.ARRIVAL, 4, 3)),
    ),
)
_TAGS: Final = ({3: 0, 9: 1}, {6: 0, 9: 1})  # by plan: where a tag lies, and its index
END: Final = 9
TOO_STEEP: Final = TooSteep("B", "O", 0.0, 40.0, 1.0, 2.0, 0.0, 0.5)


class ExploredRun(NamedTuple):
    """A unit and its train: on which plan, how far in thirds of a span, and how."""

    state: records.DutyState = records.DutyState()
    plan: int = 0
    spot: int = 0
    moves: bool = False
    known: bool = True
    emergency: bool = False
    read: int = -1  # the last tag
    unable: bool = False  # to reach the next stop, where it stands at one
    untold: bool = False  # found by what does not tell tracks apart

    @property
    def place(self) -> records.PlaceInJoints:
        """What `onboard.motion` would make of it."""
        place = place_in_joints(self.spot, END, known=self.known, moves=self.moves, emergency=self.emergency)
        if not self.known:
            return place
        unable = TOO_STEEP if self.unable and self.spot == 0 and not self.moves else None
        return replace(place, unable=unable, untold=self.untold)

    @property
    def under(self) -> tuple[str, ...]:
        """Sections that the train stands in."""
        span, part = divmod(self.spot, PLACES_A_SPAN)
        return tuple(s.section_id for s in PLANS[self.plan].spans[span : span + 1 + (part > 0)])


class Step(NamedTuple):
    """One thing that can happen, and what comes of it."""

    event: records.Event
    run: ExploredRun
    actions: tuple[Action, ...]


def steps(run: ExploredRun) -> Iterator[Step]:
    """All that can happen next."""
    for event, after in (*_people(run), *_movement(run), *_time(run), *_telegrams(run)):
        yield event_taken(event, after)


def event_taken(event: records.Event, run: ExploredRun) -> Step:
    """The real machine takes the event where the train then is."""
    state, actions = step(PLANS[run.plan], TIMES, run.state, event, run.place, _NOW_S)
    lost = records.DrivingOrder.LOSE in actions
    emergency = (
        run.emergency or lost or records.DrivingOrder.STOP in actions
    ) and records.DrivingOrder.RELEASE not in actions
    return Step(event, run._replace(state=state, emergency=emergency, known=run.known and not lost), actions)


def event_name(event: records.Event) -> str:
    """An event by its type: a telegram by what it means, a timer by its name."""
    match event:
        case records.TelegramHeard(heard):
            return type(heard).__name__
        case records.TimerDue(timer):
            return f"TimerDue {timer.name}"
        case _:
            return type(event).__name__


def phase_name(run: ExploredRun) -> str:
    """The phase of its duty."""
    return run.state.phase.value


def may_go_on(run: ExploredRun) -> bool:
    """Whether the next joint is free: by the stop limit, or without a position by the crew's eye."""
    plan, state = PLANS[run.plan], run.state
    if run.spot == END:
        return False
    joint = run.spot // PLACES_A_SPAN + 1
    if run.spot % PLACES_A_SPAN == 2:
        return True
    if run.known and state.phase is not records.DutyPhase.ON_SIGHT:
        return state.limit.joint > joint
    span = plan.spans[joint]
    return not span.points or all(needed in state.authority.proven for needed in span.points)


def may_start(run: ExploredRun) -> bool:
    """Whether the train drives: to the next joint, up to its mark, or to a tag before either."""
    drives = command_of(PLANS[run.plan], run.state).drive and not run.emergency
    short_of_mark = run.spot == END and run.state.phase is records.DutyPhase.RUNNING
    return drives and (may_go_on(run) or short_of_mark or _TAGS[run.plan].get(run.spot, -1) > run.read)


_Happening = tuple[records.Event, ExploredRun]


def _people(run: ExploredRun) -> Iterator[_Happening]:
    phase = run.state.phase
    if phase in (records.DutyPhase.OFF, records.DutyPhase.GONE):
        yield records.Begin(PLANS[0], signs_on=True), ExploredRun(run.state)
    if phase in (records.DutyPhase.OFF, records.DutyPhase.LEAVING):
        yield records.OffTheLine(), run
    if phase is records.DutyPhase.OFF:
        for spot, stands_at in ((0, 0), (3, None)):
            yield (
                records.SwitchedOn(PLANS[0], stands_at),
                ExploredRun(run.state, 0, spot, known=False, emergency=True),
            )
    if phase is records.DutyPhase.FINISHED:
        yield records.ChangeEnds(), run
        yield records.Leave(), run
        other = 1 - run.plan
        if run.spot == END and set(run.state.authority.held) == set(run.under):
            yield (
                records.Begin(PLANS[other], signs_on=False),
                run._replace(plan=other, spot=0, moves=False, read=-1),
            )
    if phase is records.DutyPhase.STANDING or (phase is records.DutyPhase.RUNNING and not run.moves):
        yield records.SetBack(60.0), run
    if command_of(PLANS[run.plan], run.state).confirm:
        yield (records.AtMark(run.state.at) if run.spot == END else records.NotAtMark()), run
    if phase is records.DutyPhase.ON_SIGHT and not run.moves:
        if not run.known and PLANS[run.plan].spans[run.spot // PLACES_A_SPAN + (run.spot < END)].points:
            yield records.PointsSeen(X), run
            yield records.PointsWrong(X), run
        if not run.known and run.spot == END and run.state.stands_at != 1:
            yield records.AtMark(1), run
        if not run.known and not run.state.authority.holds(PLANS[run.plan].spans[-1].section_id):
            yield records.EndOfHeld(run.spot // PLACES_A_SPAN), run


def _movement(run: ExploredRun) -> Iterator[_Happening]:
    on_line = run.state.phase not in (
        records.DutyPhase.OFF,
        records.DutyPhase.LEAVING,
        records.DutyPhase.GONE,
    )
    tag = _TAGS[run.plan].get(run.spot, -1)
    if not run.moves and may_start(run):
        yield records.WheelsTurning(), run._replace(moves=True)
    if run.moves:
        if run.known and tag > run.read:
            pass  # a tag that is expected is read, or missed and the position lost
        else:
            bounds_may_pass = run.spot % PLACES_A_SPAN == 0 and run.spot != END
            if may_go_on(run) or bounds_may_pass:
                yield records.Looked(), run._replace(spot=run.spot + 1)
            if not may_go_on(run):
                how = records.MarkRelation.AT if run.spot == END else records.MarkRelation.SHORT
                yield records.Stopped(how, 0.0), run._replace(moves=False)
        yield records.Stopped(records.MarkRelation.SHORT, -1.0), run._replace(moves=False, emergency=True)
    if run.moves and tag > run.read:
        yield records.TagBelieved(tag, not run.known), run._replace(known=True, read=tag, untold=False)
        if run.known:
            yield records.TagReached(tag), run
    if on_line and not run.known:
        yield records.FoundByOtherSensor(), run._replace(known=True, untold=True)
    if run.known and run.spot == 0 and run.state.phase is records.DutyPhase.STANDING:
        yield records.Looked(), run._replace(unable=not run.unable)  # motors fail, or are there again
    if run.known and on_line:
        yield records.PositionLost(), run._replace(known=False, emergency=True)


def _time(run: ExploredRun) -> Iterator[_Happening]:
    state = run.state
    waits = state.phase is records.DutyPhase.STANDING or (
        state.phase is records.DutyPhase.ON_SIGHT and state.stands_at is not None
    )
    if (waits or state.phase is records.DutyPhase.RUNNING) and not state.may_ask:
        yield records.TimerDue(records.ASK), run
    if waits and not state.may_leave:
        yield records.TimerDue(records.LEAVE), run
    if not state.released and not run.moves:
        yield records.TimerDue(records.RELEASE), run
    if state.unable is not None:
        yield records.TimerDue(records.ABLE), run
    yield from ((records.TimerDue(request.timer), run) for request in state.authority.requests)
    yield from ((records.TimerDue(command.timer), run) for command in state.authority.commands)


def _telegrams(run: ExploredRun) -> Iterator[_Happening]:
    if run.state.phase not in (records.DutyPhase.OFF, records.DutyPhase.GONE):
        for event in (*_answers(run), *_of_points(run), QueryHeard(), EarlierBootCalled(), PeerRestarted()):
            yield records.TelegramHeard(event), run
        if run.state.authority.on_line:
            yield records.TelegramHeard(ContestHeard(run.state.authority.held[:1])), run


def _answers(run: ExploredRun) -> Iterator[AuthorityEvent]:
    state = run.state.authority
    ahead = tuple(s.section_id for s in PLANS[run.plan].spans if s.section_id not in run.under)
    for request in state.requests:
        if request.ask is not RequestKind.REPORT:
            yield RefusalHeard(request.ask, request.subject, "held", lost_sight=False, answers=True)
            yield RefusalHeard(request.ask, request.subject, "stale token", lost_sight=True, answers=True)
        match request.ask:
            case RequestKind.SIGN_ON if request.section_ids is None:
                yield SignOnHeard(run.under, _with_points(run.under), answers=True, newer=True)
                whole = (*run.under, *ahead[max(0, run.spot // PLACES_A_SPAN) :])
                yield SignOnHeard(whole, _with_points(whole), answers=True, newer=True)
            case RequestKind.SIGN_ON:
                yield SignOnHeard(request.section_ids or (), (), answers=True, newer=True)
            case RequestKind.SIGN_OFF:
                yield SignOffHeard(answers=True)
            case RequestKind.ROUTE:
                section_ids = request.section_ids or ()
                yield GrantHeard(request.subject, section_ids, ("X",), answers=True, fresh=True, newer=True)
                yield GrantHeard(request.subject, section_ids, ("X",), answers=True, fresh=True, newer=False)
            case RequestKind.REPORT:
                yield ConfirmationHeard(state.held, answers=True, newer=False)
                yield ConfirmationHeard(state.held, answers=True, newer=True)
                yield ConfirmationHeard((*state.held, "elsewhere"), answers=True, newer=True)
                yield ConfirmationHeard(state.held, answers=True, newer=False, contested=state.held[:1])
                yield ConfirmationHeard(state.held[1:], answers=True, newer=False)


def _with_points(section_ids: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(section_id for section_id in section_ids if section_id == "X")


def _of_points(run: ExploredRun) -> Iterator[AuthorityEvent]:
    state = run.state.authority
    if state.commands or state.unsaid or state.proven:
        yield ProofHeard("PX", "terminal", "normal", mine=True)
        yield ProofHeard("PX", "terminal", None, mine=True)
    if state.commands:
        yield PointsDenialHeard("PX", "terminal", "not detected", mine=True)


_GOOD: Final = (
    "SignOnHeard",
    "GrantHeard",
    "ProofHeard",
    "ConfirmationHeard",
    "TagBelieved",
    "TimerDue ask",
    "TimerDue leave",
    "WheelsTurning",
    "Looked",
    "Stopped",
    "Begin",
    "Leave",
    "SignOffHeard",
    "OffTheLine",
)


def course() -> tuple[ExploredRun, ...]:
    """A course on which all goes well: out, back, and off the line."""
    run = ExploredRun()
    runs = [run]
    while run.state.phase is not records.DutyPhase.GONE:
        possible = [s for s in steps(run) if s.run not in runs and _is_good(s.event)]
        run = min(possible, key=lambda s: _GOOD.index(event_name(s.event))).run
        runs.append(run)
    return tuple(runs)


def first() -> tuple[ExploredRun, ...]:
    """Where to look first: that course, and a unit switched on at each place of the way."""
    lost = [
        ExploredRun(plan=plan, spot=spot, known=False, emergency=True)
        for plan in (0, 1)
        for spot in range(END + 1)
    ]
    return (*course(), *(event_taken(records.SwitchedOn(PLANS[run.plan], None), run).run for run in lost))


def _is_good(event: records.Event) -> bool:
    lost = (
        isinstance(event, records.TelegramHeard)
        and isinstance(event.event, ProofHeard)
        and event.event.position is None
    )
    return event_name(event) in _GOOD and not lost


def events_from(run: ExploredRun) -> Iterator[tuple[str, ExploredRun]]:
    """What `verify.breadth` asks for: events by name and what they lead to."""
    for step_ in steps(run):
        yield event_name(step_.event), step_.run
