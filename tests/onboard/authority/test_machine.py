"""The authority machine as a whole: what no table names, radio and timers, and what always holds."""

from typing import Final, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from onboard.authority.machine import TABLE, step
from onboard.authority.records import (
    Action,
    AskRoute,
    Authority,
    BeginOnLine,
    CheckedByCrew,
    Cleared,
    ConfirmationHeard,
    ContestHeard,
    EarlierBootCalled,
    EndOnLine,
    Event,
    FoundAt,
    GiveBack,
    GrantHeard,
    OpenCommand,
    OpenRequest,
    PeerRestarted,
    PointsDenialHeard,
    ProofHeard,
    QueryHeard,
    RefusalHeard,
    RepeatDue,
    RequestKind,
    SendClaim,
    SendCommand,
    SendRequest,
    SetTimer,
    SignOffHeard,
    SignOnHeard,
    StopTimer,
    TakenOff,
    Throw,
    Timer,
    TurnedBack,
    Withdrawn,
)
from onboard.authority.tables import REPEAT_S, SignOnStanding, standing
from tests.onboard.duty.stage import P5, P7, SECTIONS

OFF: Final = Authority()
ON_LINE: Final = Authority(held=("3",), on_line=True)
SIGNING_ON: Final = Authority(
    held=("3",), requests=(OpenRequest(RequestKind.SIGN_ON, section_ids=("3",), sent=True),)
)
SIGNING_OFF: Final = replace(ON_LINE, requests=(OpenRequest(RequestKind.SIGN_OFF, sent=True),))
LEAVING: Final = Authority(held=("3",), leaving=True)
OPEN: Final = Authority(
    held=("3", *SECTIONS),
    commandable=("5", "7"),
    on_line=True,
    requests=(
        OpenRequest(RequestKind.ROUTE, "8>PE", ("10",), sent=True),
        OpenRequest(RequestKind.REPORT, sent=True),
    ),
    commands=(OpenCommand(P5, sent=True), OpenCommand(P7, sent=True)),
)
STANDINGS: Final = {
    SignOnStanding.OFF_LINE: OFF,
    SignOnStanding.SIGNING_ON: SIGNING_ON,
    SignOnStanding.ON_LINE: OPEN,
    SignOnStanding.SIGNING_OFF: SIGNING_OFF,
    SignOnStanding.LEAVING: LEAVING,
}
EXAMPLES: Final[dict[type[Event], Event]] = {
    BeginOnLine: BeginOnLine(("3",)),
    FoundAt: FoundAt(("5",)),
    EndOnLine: EndOnLine(),
    TakenOff: TakenOff(),
    AskRoute: AskRoute("3>8", SECTIONS),
    Throw: Throw((P5,)),
    CheckedByCrew: CheckedByCrew(P5),
    Withdrawn: Withdrawn(("5",)),
    Cleared: Cleared(("3",)),
    GiveBack: GiveBack(("7", "8")),
    TurnedBack: TurnedBack(),
    RepeatDue: RepeatDue(None),
    SignOnHeard: SignOnHeard(("3",), (), answers=True, newer=True),
    RefusalHeard: RefusalHeard(RequestKind.ROUTE, "8>PE", "held", lost_sight=True, answers=True),
    SignOffHeard: SignOffHeard(answers=True),
    GrantHeard: GrantHeard("8>PE", ("10",), ("10",), answers=True, fresh=True, newer=True),
    ConfirmationHeard: ConfirmationHeard(("3",), answers=True, newer=True),
    ContestHeard: ContestHeard(("6",)),
    QueryHeard: QueryHeard(),
    EarlierBootCalled: EarlierBootCalled(),
    ProofHeard: ProofHeard("P5", "A-E", "normal", mine=True),
    PointsDenialHeard: PointsDenialHeard("P5", "A-E", "old token", mine=True),
    PeerRestarted: PeerRestarted(),
}
REFUSED: Final = [(at, kind) for at in SignOnStanding for kind in get_args(Event) if (at, kind) not in TABLE]


def test_the_examples_are_what_they_say() -> None:
    assert set(EXAMPLES) == set(get_args(Event))
    assert all(standing(state) is at for at, state in STANDINGS.items())


@pytest.mark.parametrize(("at", "kind"), REFUSED, ids=[f"{at.value}-{kind.__name__}" for at, kind in REFUSED])
def test_what_no_table_names_is_refused(at: SignOnStanding, kind: type[Event]) -> None:
    state = STANDINGS[at]
    assert step(state, EXAMPLES[kind], covered=True) == (state, ())


@pytest.mark.parametrize(("at", "kind"), REFUSED, ids=[f"{at.value}-{kind.__name__}" for at, kind in REFUSED])
def test_a_refused_event_sends_only_what_was_due(at: SignOnStanding, kind: type[Event]) -> None:
    state = STANDINGS[at]
    due, _ = step(state, RepeatDue(None), covered=False)
    after, actions = step(due, EXAMPLES[kind], covered=True)
    assert after == state
    assert actions == step(due, QueryHeard(), covered=True)[1][-len(actions) :] if actions else due == state


# time and radio -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("timer", "sent"),
    [
        (Timer("route"), SendRequest(replace(OPEN.requests[0], sent=False))),
        (Timer("points", "P5"), SendCommand(P5)),
        (Timer("points", "P7"), SendCommand(P7)),
        (Timer("report"), SendRequest(OpenRequest(RequestKind.REPORT, section_ids=OPEN.held))),
    ],
)
def test_what_a_timer_belongs_to_is_repeated_and_nothing_else(timer: Timer, sent: Action) -> None:
    after, actions = step(OPEN, RepeatDue(timer), covered=True)
    assert after == OPEN
    assert actions[:2] == (sent, SetTimer(timer, REPEAT_S))
    assert all(not isinstance(action, SendRequest | SendCommand) for action in actions[2:])


@pytest.mark.parametrize("timer", [Timer("sign on"), Timer("points", "P9"), Timer("ask")])
def test_a_timer_of_nothing_open_repeats_nothing(timer: Timer) -> None:
    assert step(OPEN, RepeatDue(timer), covered=True) == (OPEN, ())


def timers_of(state: Authority) -> set[Timer]:
    """Of what is open and sent."""
    return {one.timer for one in (*state.requests, *state.commands) if one.sent}


def timers_after(running: set[Timer], actions: tuple[Action, ...]) -> set[Timer]:
    for action in actions:
        if isinstance(action, SetTimer):
            running = running | {action.timer}
        if isinstance(action, StopTimer):
            running = running - {action.timer}
    return running


@pytest.mark.parametrize("state", [SIGNING_ON, OPEN, SIGNING_OFF])
def test_a_restarted_peer_gets_all_that_is_open_again_at_once(state: Authority) -> None:
    after, actions = step(state, PeerRestarted(), covered=True)
    assert after == state
    sent = [action for action in actions if isinstance(action, SendRequest | SendCommand)]
    assert len(sent) == len(state.requests) + len(state.commands)


@pytest.mark.parametrize("state", [SIGNING_ON, OPEN, SIGNING_OFF])
def test_out_of_reach_no_timer_runs_and_what_is_open_goes_out_where_the_radio_begins(
    state: Authority,
) -> None:
    timers = (*(r.timer for r in state.requests), *(c.timer for c in state.commands))
    away, stopped = step(state, RepeatDue(None), covered=False)
    assert stopped == tuple(StopTimer(timer) for timer in timers)
    assert away.waits_for_radio
    assert step(away, RepeatDue(None), covered=False) == (away, ())
    back, actions = step(away, RepeatDue(None), covered=True)
    assert back == state
    assert {action.timer for action in actions if isinstance(action, SetTimer)} == set(timers)


@pytest.mark.parametrize("state", STANDINGS.values(), ids=[at.value for at in STANDINGS])
@pytest.mark.parametrize("kind", sorted(EXAMPLES, key=lambda kind: kind.__name__))
def test_nothing_is_sent_where_the_radio_does_not_reach(state: Authority, kind: type[Event]) -> None:
    """But the answer to a query: whoever hears one is reached."""
    _, actions = step(state, EXAMPLES[kind], covered=False)
    assert not [action for action in actions if isinstance(action, SendRequest | SendCommand)]
    assert not timers_after(set(), actions)
    assert kind in (QueryHeard, EarlierBootCalled) or not [
        action for action in actions if isinstance(action, SendClaim)
    ]


def test_sign_off_goes_first_and_the_report_last() -> None:
    """Who asks for a route and drops sections says the request first: the report has the newest word."""
    _, actions = step(OPEN, PeerRestarted(), covered=True)
    sent = [
        a.request.ask if isinstance(a, SendRequest) else a.needed
        for a in actions
        if isinstance(a, SendRequest | SendCommand)
    ]
    assert sent == [RequestKind.ROUTE, P5, P7, RequestKind.REPORT]


# what always holds ----------------------------------------------------------------------------------------------

sections = st.lists(st.sampled_from(("3", *SECTIONS, "10")), max_size=6, unique=True).map(tuple)
points_ = st.sampled_from((P5, P7))
yes = st.booleans()
EVENTS: Final = st.one_of(
    st.builds(BeginOnLine, st.none() | sections, yes),
    st.builds(AskRoute, st.just("3>8"), st.just(SECTIONS)),
    st.builds(Throw, st.lists(points_, max_size=2).map(tuple)),
    st.builds(Withdrawn, sections),
    st.builds(Cleared, sections),
    st.builds(GiveBack, sections),
    st.builds(RepeatDue, st.sampled_from((None, *(r.timer for r in OPEN.requests), Timer("points", "P5")))),
    st.builds(SignOnHeard, sections, sections, yes, yes, sections),
    st.builds(
        RefusalHeard, st.sampled_from(RequestKind), st.just("3>8"), st.sampled_from(("a", "b")), yes, yes
    ),
    st.builds(SignOffHeard, yes),
    st.builds(GrantHeard, st.just("3>8"), st.just(SECTIONS), sections, yes, yes, yes, sections),
    st.builds(ConfirmationHeard, sections, yes, yes, st.just(()) | sections),
    st.builds(ContestHeard, sections),
    st.builds(
        ProofHeard,
        st.sampled_from(("P5", "P7")),
        st.sampled_from(("A-E", "B-W")),
        st.sampled_from((None, "normal", "reverse")),
        yes,
    ),
    st.builds(PointsDenialHeard, st.just("P5"), st.just("A-E"), st.sampled_from(("a", "b")), yes, yes),
    st.sampled_from((EndOnLine(), TurnedBack(), QueryHeard(), EarlierBootCalled(), PeerRestarted())),
)
SEEN: Final = st.builds(CheckedByCrew, points_)


Course = list[tuple[Event, bool]]
courses = st.lists(st.tuples(EVENTS, st.booleans()), max_size=30)
courses_with_crew = st.lists(st.tuples(EVENTS | SEEN, st.booleans()), max_size=30)
begun = st.sampled_from(tuple(STANDINGS.values()))


def after_all(
    state: Authority, course: Course
) -> list[tuple[Authority, Event, Authority, tuple[Action, ...]]]:
    """All steps of a course: before, event, after, actions."""
    steps = []
    for event, covered in course:
        after, actions = step(state, event, covered=covered)
        steps.append((state, event, after, actions))
        state = after
    return steps


def check_held_only_by_the_managers_word(state: Authority, course: Course) -> None:
    for before, event, after, _ in after_all(state, course):
        gained = set(after.held) - set(before.held)
        match event:
            case GrantHeard(answers=True, fresh=True, newer=True) | SignOnHeard(answers=True):
                assert gained <= set(event.section_ids)
            case BeginOnLine(enters=False):  # where it stands, as its crew can see
                assert gained <= set(event.section_ids or ())
            case _:
                assert not gained


@given(begun, courses_with_crew)
def test_nothing_is_held_but_by_the_managers_word_or_where_it_stands(
    state: Authority, course: Course
) -> None:
    check_held_only_by_the_managers_word(state, course)


def test_a_unit_that_obeys_any_grant_breaks_that(monkeypatch: pytest.MonkeyPatch) -> None:
    def obeys(state: Authority, event: GrantHeard) -> tuple[Authority, tuple[Action, ...]]:
        return replace(state, held=(*state.held, *event.section_ids)), ()

    late = GrantHeard("3>8", SECTIONS, (), answers=True, fresh=True, newer=False)
    check_held_only_by_the_managers_word(ON_LINE, [(late, True)])
    monkeypatch.setattr(
        "onboard.authority.machine.TABLE", {**TABLE, (SignOnStanding.ON_LINE, GrantHeard): obeys}
    )
    with pytest.raises(AssertionError):
        check_held_only_by_the_managers_word(ON_LINE, [(late, True)])


@given(begun, courses)
def test_proven_and_commanded_is_only_what_is_held(state: Authority, course: Course) -> None:
    for _, _, after, actions in after_all(state, course):
        assert len(set(after.held)) == len(after.held)
        assert all(needed.section_id in after.held for needed in after.proven)
        assert all(command.needed.section_id in after.held for command in after.commands)
        assert not {command.needed for command in after.commands} & set(after.proven)
        for action in actions:
            if isinstance(action, SendRequest) and action.request.ask is RequestKind.REPORT:
                assert action.request.section_ids == after.held
            if isinstance(action, SendCommand):
                assert action.needed.section_id in after.held


@given(begun, courses_with_crew)
def test_a_state_stays_small_and_hashable(state: Authority, course: Course) -> None:
    """One request a kind, each set of points once in each list: so there are finitely many states."""
    for _, _, after, _ in after_all(state, course):
        assert hash(after) == hash(replace(after))
        assert len({request.ask for request in after.requests}) == len(after.requests)
        for listed in (after.proven, after.unsaid, tuple(command.needed for command in after.commands)):
            assert len(set(listed)) == len(listed)


@given(begun, courses_with_crew)
def test_a_timer_runs_for_all_that_is_sent_and_for_nothing_that_is_over(
    state: Authority, course: Course
) -> None:
    running = timers_of(state)
    for _, event, after, actions in after_all(state, course):
        running = timers_after(running - {event.timer} if isinstance(event, RepeatDue) else running, actions)
        open_ = {one.timer for one in (*after.requests, *after.commands)}
        assert timers_of(after) <= running <= open_


def test_who_claims_where_it_stands_may_be_on_the_line_and_who_wishes_to_enter_is_not() -> None:
    claims = Authority(requests=(OpenRequest(RequestKind.SIGN_ON),))
    assert claims.perhaps_on_line and not replace(claims, entering=True).perhaps_on_line
