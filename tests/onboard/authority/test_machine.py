"""Walks the table of the authority machine: every event in every state, refusals included."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction, Position, Route
from onboard.authority.machine import (
    NEVER,
    REFUSED_REPEAT_S,
    REPEAT_S,
    Action,
    Ask,
    Authority,
    BeginOnLine,
    CheckedByCrew,
    Cleared,
    EndOnLine,
    Event,
    GiveBack,
    Heard,
    PointsNeeded,
    Send,
    Throw,
    Tick,
    TurnedBack,
    step,
    waiting_for_radio,
)
from onboard.notes import Holds
from radio.messages import (
    AnyMessage,
    Capability,
    Claim,
    ClaimQuery,
    HoldingConfirmed,
    HoldingReport,
    PointsCommand,
    PointsProof,
    PointsRefusalReason,
    PointsRefused,
    RefusalReason,
    Restarted,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    SignOff,
    SignOffAccepted,
    SignOffRefused,
    SignOn,
    SignOnAccepted,
    SignOnRefused,
)

MANAGER, TERMINAL = "BM", "A-E"
ROUTE = Route("3>8", Direction.DOWN, "3", "8", ("5", "6", "7", "8"), ("3",), ())
SECTIONS = ROUTE.section_ids
POINTS = PointsNeeded("P5", Position.NORMAL, "5", TERMINAL)
CAPABILITIES = (Capability(TERMINAL, "5", b"five"), Capability("B-W", "7", b"seven"))
NOW_S = 100.0


def heard(message: AnyMessage, correlation: int = 0, source: str = MANAGER, fresh: bool = True) -> Heard:
    return Heard(source, message, fresh, correlation)


def grant(token: int = 20) -> RouteGranted:
    return RouteGranted(ROUTE.id, SECTIONS, token, CAPABILITIES)


def proof(token: int = 20, position: Position | None = Position.NORMAL, locked: bool = True) -> PointsProof:
    return PointsProof("P5", position, locked, position is not None, token)


def after(state: Authority, *events: Event) -> Authority:
    for event in events:
        state, _ = step(state, event, NOW_S, True)
    return state


def sent(actions: tuple[Action, ...]) -> list[AnyMessage]:
    return [action.message for action in actions if isinstance(action, Send)]


OFF = Authority("V1", MANAGER)
SIGNING_ON = after(OFF, BeginOnLine(("3",)))
ON_LINE = after(SIGNING_ON, heard(SignOnAccepted(("3",), 10, None, ()), SIGNING_ON.sign_correlation))
ASKING = after(ON_LINE, Ask(ROUTE))
HOLDING = after(ASKING, heard(grant(), ASKING.ask_correlation))
THROWING = after(HOLDING, Throw((POINTS,)))
PROVEN = after(THROWING, heard(proof(), source=TERMINAL))
REPORTING = after(PROVEN, Cleared(("3", "5")))
SIGNING_OFF = after(ON_LINE, EndOnLine())
STATES = {
    "off": OFF,
    "signing on": SIGNING_ON,
    "on line": ON_LINE,
    "asking": ASKING,
    "holding": HOLDING,
    "throwing": THROWING,
    "proven": PROVEN,
    "reporting": REPORTING,
    "signing off": SIGNING_OFF,
}
ALL = frozenset(STATES)
ON = ALL - {"off", "signing on"}


def answer(message: AnyMessage, source: str = MANAGER) -> Callable[[Authority], Heard]:
    """A telegram that answers whatever request of its kind is outstanding."""
    name = {
        SignOnAccepted: "sign_correlation",
        SignOnRefused: "sign_correlation",
        SignOffAccepted: "sign_correlation",
        SignOffRefused: "sign_correlation",
        RouteGranted: "ask_correlation",
        RouteRefused: "ask_correlation",
        HoldingConfirmed: "report_correlation",
    }.get(type(message))
    return lambda state: heard(message, getattr(state, name) if name else 0, source)


def always(event: Event) -> Callable[[Authority], Event]:
    return lambda _state: event


# Event, and the states in which it changes the state; in all others it changes nothing.
TABLE: dict[str, tuple[Callable[[Authority], Event], frozenset[str]]] = {
    "begin": (always(BeginOnLine(("3",))), ALL - ON),
    "end": (always(EndOnLine()), frozenset({"on line", "asking"})),
    "ask": (always(Ask(ROUTE)), ON - {"asking"}),
    "throw": (always(Throw((POINTS,))), frozenset({"holding"})),
    "throw not held": (always(Throw((replace(POINTS, section_id="99"),))), frozenset()),
    "cleared": (always(Cleared(("3",))), ALL - {"off", "reporting"}),
    "cleared not held": (always(Cleared(("99",))), frozenset()),
    "checked by crew": (always(CheckedByCrew(POINTS)), ALL - {"proven"}),
    "give back": (
        always(GiveBack(("7", "8"))),
        frozenset({"asking", "holding", "throwing", "proven", "reporting"}),
    ),
    "give back what is not held": (always(GiveBack(("99",))), frozenset({"asking"})),
    "turned back": (always(TurnedBack()), frozenset({"holding", "throwing", "proven", "reporting"})),
    "tick": (always(Tick()), frozenset()),
    "sign-on accepted": (answer(SignOnAccepted(("3",), 10, None, ())), frozenset({"signing on"})),
    "sign-on accepted, newer token": (
        answer(SignOnAccepted(("3",), 99, None, ())),
        ALL - {"off"},
    ),
    "sign-on refused": (answer(SignOnRefused(RefusalReason.HELD, "3", "V2")), frozenset({"signing on"})),
    "sign-off accepted": (answer(SignOffAccepted()), frozenset({"signing off"})),
    "sign-off refused": (answer(SignOffRefused(RefusalReason.STILL_HOLDING)), frozenset({"signing off"})),
    "granted": (answer(grant()), frozenset({"asking"})),
    "granted to another boot": (lambda s: replace(answer(grant())(s), fresh=False), frozenset()),
    "granted in answer to an older request": (
        lambda s: replace(answer(grant())(s), correlation=s.ask_correlation - 1),
        frozenset(),
    ),
    "granted with the token it has": (answer(grant(10)), frozenset()),
    "granted another route": (answer(RouteGranted("3>9", SECTIONS, 20, ())), frozenset()),
    "granted other sections": (answer(RouteGranted(ROUTE.id, ("5", "6"), 20, ())), frozenset()),
    "route refused": (answer(RouteRefused(ROUTE.id, RefusalReason.HELD, "6", "V2")), frozenset({"asking"})),
    "another route refused": (answer(RouteRefused("3>9", RefusalReason.HELD)), frozenset()),
    "proof": (answer(proof(), TERMINAL), frozenset({"throwing"})),
    "proof of another token": (answer(proof(19), TERMINAL), frozenset()),
    "proof from another terminal": (answer(proof(), "B-W"), frozenset()),
    "proof from the manager": (answer(proof()), frozenset()),
    "wrong position": (answer(proof(position=Position.REVERSE), TERMINAL), frozenset({"proven"})),
    "not detected": (answer(proof(position=None), TERMINAL), frozenset({"proven"})),
    "not locked": (answer(proof(locked=False), TERMINAL), frozenset({"proven"})),
    "points refused": (
        answer(PointsRefused("P5", PointsRefusalReason.NOT_DETECTED, 20), TERMINAL),
        frozenset({"throwing"}),
    ),
    "points refused for another token": (
        answer(PointsRefused("P5", PointsRefusalReason.NOT_DETECTED, 19), TERMINAL),
        frozenset(),
    ),
    "points refused by another terminal": (
        answer(PointsRefused("P5", PointsRefusalReason.NOT_DETECTED, 20), "B-W"),
        frozenset(),
    ),
    "confirmed": (answer(HoldingConfirmed(("6", "7", "8"), 20)), frozenset({"reporting"})),
    "confirmed too much": (answer(HoldingConfirmed(("5", "6", "7", "8"), 20)), frozenset()),
    "confirmed an older report": (
        lambda s: heard(HoldingConfirmed(("6", "7", "8"), 20), s.report_correlation - 1),
        frozenset(),
    ),
    "claim query": (answer(ClaimQuery()), frozenset()),
    "restarted": (answer(Restarted()), frozenset()),
    "request": (answer(RouteRequest("V2", ROUTE.id, SECTIONS)), frozenset()),
    "report": (answer(HoldingReport((), 99)), frozenset()),
    "sign-on": (answer(SignOn("V2", ("3",))), frozenset()),
    "sign-off": (answer(SignOff("V2", 1)), frozenset()),
    "claim": (answer(Claim(("3",), 99)), frozenset()),
    "command": (answer(PointsCommand("P5", Position.REVERSE, "5", 20, b"")), frozenset()),
}


@pytest.mark.parametrize("state_name", STATES)
@pytest.mark.parametrize("event_name", TABLE)
def test_every_event_in_every_state(event_name: str, state_name: str) -> None:
    make, changing = TABLE[event_name]
    state = STATES[state_name]
    next_state, actions = step(state, make(state), NOW_S + 0.1, True)
    if event_name == "restarted":  # only the timers of what is open may move
        before, after_it = (
            replace(s, next_sign_s=0.0, next_ask_s=0.0, next_report_s=0.0, commands=())
            for s in (state, next_state)
        )
        assert before == after_it
        return
    assert (next_state != state) is (state_name in changing)
    if state_name not in changing and event_name != "claim query":
        assert actions == ()


@pytest.mark.parametrize("state_name", STATES)
@pytest.mark.parametrize("event_name", sorted(set(TABLE) - {"claim query"}))
def test_nothing_is_sent_where_the_radio_does_not_reach(event_name: str, state_name: str) -> None:
    state = STATES[state_name]
    event = TABLE[event_name][0](state)
    assert sent(step(state, event, NOW_S + 100.0, False)[1]) == []


@pytest.mark.parametrize("state_name", STATES)
@pytest.mark.parametrize("event_name", sorted(set(TABLE) - {"begin", "sign-on accepted", "granted"}))
def test_sections_come_only_by_sign_on_and_grant(event_name: str, state_name: str) -> None:
    state = STATES[state_name]
    if event_name == "sign-on accepted, newer token" and state_name == "signing on":
        return
    next_state, _ = step(state, TABLE[event_name][0](state), NOW_S, True)
    assert set(next_state.section_ids()) <= set(state.section_ids())


@pytest.mark.parametrize("state_name", STATES)
@pytest.mark.parametrize("event_name", sorted(set(TABLE) - {"proof", "checked by crew"}))
def test_points_are_proven_only_by_a_proof(event_name: str, state_name: str) -> None:
    state = STATES[state_name]
    next_state, _ = step(state, TABLE[event_name][0](state), NOW_S, True)
    assert set(next_state.proven) <= set(state.proven)


@pytest.mark.parametrize(
    ("state", "kind"),
    [
        (SIGNING_ON, SignOn),
        (ASKING, RouteRequest),
        (THROWING, PointsCommand),
        (REPORTING, HoldingReport),
        (SIGNING_OFF, SignOff),
    ],
)
def test_an_open_request_is_repeated_with_its_correlation_until_answered(
    state: Authority, kind: type[AnyMessage]
) -> None:
    first: Send | None = None
    for repeat in range(1, 6):
        at_s = NOW_S + repeat * REPEAT_S
        assert state.next_timer_s() == pytest.approx(at_s)
        assert sent(step(state, Tick(), at_s - 0.1, True)[1]) == []
        state, actions = step(state, Tick(), at_s, True)
        again = next(a for a in actions if isinstance(a, Send))
        assert isinstance(again.message, kind)
        assert first in (None, again)
        first = again


@pytest.mark.parametrize("state", [SIGNING_ON, ASKING, THROWING, REPORTING, SIGNING_OFF])
def test_out_of_reach_a_request_waits_and_goes_out_as_soon_as_the_radio_reaches(state: Authority) -> None:
    away, actions = step(state, Tick(), NOW_S + 1.0, False)
    assert sent(actions) == []
    assert waiting_for_radio(away)
    assert len(sent(step(away, Tick(), NOW_S + 500.0, True)[1])) == 1
    assert not waiting_for_radio(step(away, Tick(), NOW_S + 500.0, True)[0])


def test_nothing_open_asks_for_no_timer() -> None:
    assert OFF.next_timer_s() == ON_LINE.next_timer_s() == PROVEN.next_timer_s() == NEVER


def test_a_duplicate_grant_takes_effect_once() -> None:
    again = heard(grant(), ASKING.ask_correlation)
    assert step(HOLDING, again, NOW_S, True) == (HOLDING, ())
    asked_anew = after(HOLDING, Ask(ROUTE))
    assert step(asked_anew, again, NOW_S, True) == (asked_anew, ())
    relabelled = heard(grant(20), asked_anew.ask_correlation)
    assert step(asked_anew, relabelled, NOW_S, True) == (asked_anew, ())


def test_a_grant_renews_token_and_capability_of_sections_already_held() -> None:
    asked = after(HOLDING, Ask(ROUTE))
    renewed = after(asked, heard(grant(30), asked.ask_correlation))
    assert renewed.section_ids() == ("3", *SECTIONS)
    assert [held.token for held in renewed.held] == [10, 30, 30, 30, 30]


def test_a_refusal_is_followed_by_a_new_request_which_may_be_granted() -> None:
    refusal = heard(RouteRefused(ROUTE.id, RefusalReason.HELD, "6", "V2"), ASKING.ask_correlation)
    refused, actions = step(ASKING, refusal, NOW_S, True)
    assert "section 6 of V2" in refused.refusal
    assert sent(actions) == []
    assert step(refused, refusal, NOW_S, True) == (refused, ())
    assert step(refused, heard(grant(), ASKING.ask_correlation), NOW_S, True) == (refused, ())
    again, actions = step(refused, Tick(), NOW_S + REFUSED_REPEAT_S, True)
    assert sent(actions) == [RouteRequest("V1", ROUTE.id, SECTIONS)]
    assert again.ask_correlation > ASKING.ask_correlation
    granted = after(again, heard(grant(), again.ask_correlation))
    assert granted.section_ids() == ("3", *SECTIONS)
    assert granted.refusal == ""


@pytest.mark.parametrize("reason", [RefusalReason.NOT_SIGNED_ON, RefusalReason.STALE_TOKEN])
def test_a_manager_that_lost_sight_of_the_unit_gets_a_report(reason: RefusalReason) -> None:
    _, actions = step(ASKING, heard(RouteRefused(ROUTE.id, reason), ASKING.ask_correlation), NOW_S, True)
    assert sent(actions) == [HoldingReport(("3",), 10)]
    _, actions = step(SIGNING_OFF, heard(SignOffRefused(reason), SIGNING_OFF.sign_correlation), NOW_S, True)
    assert sent(actions) == [HoldingReport(("3",), 10)]


def test_a_lost_confirmation_is_healed_by_the_next_report() -> None:
    _, actions = step(REPORTING, Tick(), NOW_S + REPEAT_S, True)
    assert sent(actions) == [HoldingReport(("6", "7", "8"), 20)]
    confirmed = after(REPORTING, heard(HoldingConfirmed(("8", "7", "6"), 20), REPORTING.report_correlation))
    assert not confirmed.report_due


def test_a_report_that_waits_says_what_is_held_when_it_goes_out() -> None:
    more = after(REPORTING, Cleared(("6",)))
    assert after(more, heard(HoldingConfirmed(("6", "7", "8"), 20), REPORTING.report_correlation)) == more
    _, actions = step(more, Tick(), NOW_S + REPEAT_S, True)
    assert sent(actions) == [HoldingReport(("7", "8"), 20)]


def test_a_report_refused_for_its_token_is_repeated_under_the_newer_one() -> None:
    stale = heard(HoldingConfirmed(("5", "6", "7", "8"), 25), REPORTING.report_correlation)
    state, actions = step(REPORTING, stale, NOW_S, True)
    assert state.section_ids() == ("6", "7", "8")
    assert sent(actions) == [HoldingReport(("6", "7", "8"), 25)]
    assert state.report_due


def test_with_a_newer_token_an_older_grant_no_longer_counts() -> None:
    """The manager freed what that grant gave when it took the report made under the newer token."""
    both = after(ASKING, Cleared(()), heard(SignOnAccepted(("3",), 25, None, ())))
    assert both.token == 25
    assert both.ask_correlation > ASKING.ask_correlation
    assert after(both, heard(grant(25), ASKING.ask_correlation)) == both
    assert after(both, heard(grant(25), both.ask_correlation)) == both
    assert after(both, heard(grant(26), both.ask_correlation)).holds("8")


def test_the_answer_to_a_claim_brings_capabilities_but_never_sections() -> None:
    message = SignOnAccepted(("3", *SECTIONS, "9"), 25, None, CAPABILITIES)
    state = after(HOLDING, heard(message))
    assert state.section_ids() == HOLDING.section_ids()
    assert {held.section_id: held.token for held in state.held} == {
        "3": 10,
        "5": 25,
        "6": 20,
        "7": 25,
        "8": 20,
    }


@pytest.mark.parametrize("covered", [True, False])
@pytest.mark.parametrize("state_name", STATES)
def test_a_claim_query_is_answered_at_once_with_all_that_is_held(state_name: str, covered: bool) -> None:
    state = STATES[state_name]
    _, actions = step(state, heard(ClaimQuery(), 77), NOW_S, covered)
    assert actions[0] == Send(MANAGER, Claim(state.section_ids(), state.token), 77)


def test_a_restarted_peer_gets_what_is_open_again_at_once() -> None:
    _, actions = step(THROWING, heard(Restarted(), source=TERMINAL), NOW_S + 0.5, True)
    assert sent(actions) == [PointsCommand("P5", Position.NORMAL, "5", 20, b"five")]
    _, actions = step(ASKING, heard(Restarted()), NOW_S + 0.5, True)
    assert sent(actions) == [RouteRequest("V1", ROUTE.id, SECTIONS)]
    assert step(PROVEN, heard(Restarted()), NOW_S + 0.5, True) == (PROVEN, ())


def test_each_terminal_of_a_section_gets_its_own_capability() -> None:
    both = (*CAPABILITIES, Capability("A-F", "5", b"other"))
    message = RouteGranted(ROUTE.id, SECTIONS, 20, both)
    holding = after(ASKING, heard(message, ASKING.ask_correlation))
    other = PointsNeeded("P6", Position.REVERSE, "5", "A-F")
    _, actions = step(holding, Throw((POINTS, other)), NOW_S, True)
    assert [(m.points_id, m.mac) for m in sent(actions) if isinstance(m, PointsCommand)] == [
        ("P5", b"five"),
        ("P6", b"other"),
    ]


def test_a_section_dropped_takes_its_proofs_and_commands_along() -> None:
    assert after(PROVEN, Cleared(("5",))).proven == ()
    assert after(THROWING, Cleared(("5",))).commands == ()
    _, actions = step(PROVEN, Cleared(("3",)), NOW_S, True)
    notes = [i for i, a in enumerate(actions) if isinstance(a, Holds)]
    sends = [i for i, a in enumerate(actions) if isinstance(a, Send)]
    assert notes[0] < sends[0]  # dropped here before it is said


def test_turning_back_forgets_proofs_and_reverses_what_is_held() -> None:
    turned = after(PROVEN, TurnedBack())
    assert turned.section_ids() == ("8", "7", "6", "5", "3")
    assert turned.proven == ()
    assert turned.commands == ()


def test_a_withdrawn_proof_can_be_asked_for_again() -> None:
    lost = after(PROVEN, heard(proof(position=None), source=TERMINAL))
    assert lost.proven == ()
    _, actions = step(lost, Throw((POINTS,)), NOW_S, True)
    assert sent(actions) == [PointsCommand("P5", Position.NORMAL, "5", 20, b"five")]


def test_giving_back_while_a_grant_may_be_on_its_way() -> None:
    """The manager has granted the route already: the report under its newer token frees it again."""
    given, actions = step(ASKING, GiveBack(SECTIONS), NOW_S, True)
    assert sent(actions) == [HoldingReport(("3",), 10)]
    assert given.asked is None
    assert step(given, heard(grant(), ASKING.ask_correlation), NOW_S, True) == (given, ())
    stale = heard(HoldingConfirmed(("3", *SECTIONS), 20), given.report_correlation)
    again, actions = step(given, stale, NOW_S, True)
    assert sent(actions) == [HoldingReport(("3",), 20)]
    assert not after(again, heard(HoldingConfirmed(("3",), 20), again.report_correlation)).report_due


def test_what_the_crew_saw_before_the_grant_does_not_outlast_it() -> None:
    """Until then another train may have thrown the points."""
    checked = after(ASKING, CheckedByCrew(POINTS))
    assert checked.proven == (POINTS,)
    granted = after(checked, heard(grant(), checked.ask_correlation))
    assert granted.proven == ()
    assert after(granted, Throw((POINTS,))).commands[0].needed == POINTS


@given(
    st.lists(
        st.tuples(
            st.sampled_from(sorted(set(TABLE) - {"checked by crew"})), st.floats(0.0, 10.0), st.booleans()
        ),
        max_size=30,
    )
)
def test_whatever_happens_the_invariants_hold(course: list[tuple[str, float, bool]]) -> None:
    state, now_s = OFF, 0.0
    for name, later_s, covered in course:
        now_s += later_s
        before = state
        state, actions = step(state, TABLE[name][0](state), now_s, covered)
        held = state.section_ids()
        assert len(set(held)) == len(held)
        assert all(needed.section_id in held for needed in state.proven)
        assert all(command.needed.section_id in held for command in state.commands)
        assert not {c.needed for c in state.commands} & set(state.proven)
        assert state.correlation >= before.correlation
        for action in actions:
            if isinstance(action, Send) and isinstance(action.message, HoldingReport):
                assert action.message.section_ids == held
