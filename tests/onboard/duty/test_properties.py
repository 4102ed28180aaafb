"""What always holds of a unit, whatever happens to it: breadth first on a small line, and at random on longer courses.

The steps are those of `verify.lone_unit`: the real machines, a train that moves as it is let, telegrams that
answer well or ill, people, tags and timers.
"""

import pickle
from collections.abc import Iterator
from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from onboard.authority import machine as authority_machine
from onboard.authority import report
from onboard.authority.machine import TABLE
from onboard.authority.records import (
    Authority,
    Cleared,
    ConfirmationHeard,
    GrantHeard,
    RequestKind,
    SendCommand,
    SetTimer,
    SignOffHeard,
    SignOnHeard,
    StopTimer,
    Timer,
    Withdrawn,
)
from onboard.authority.tables import Result, SignOnStanding
from onboard.duty import duty_step, fitness, machine, on_sight
from onboard.duty.duty_step import DutyStep
from onboard.duty.records import (
    ABLE,
    ASK,
    LEAVE,
    RELEASE,
    AtMark,
    Begin,
    DrivingOrder,
    DutyPhase,
    OffTheLine,
    PointsSeen,
    PointsWrong,
    SetBack,
    SetTimerAt,
    SwitchedOn,
    TelegramHeard,
    TimerDue,
)
from onboard.duty.shown import command_of
from onboard.duty.stop_limit import cleared_sections
from onboard.duty_parameters import ReleaseRule
from onboard.plan import DutyPlan
from verify import lone_unit
from verify.breadth import Explored, explore
from verify.lone_unit import (
    END,
    PLANS,
    ExploredRun,
    Step,
    X,
    course,
    events_from,
    first,
    may_start,
    phase_name,
    steps,
)

SMALL_BYTES = 4096  # of a state, written out


def check_holds_what_was_granted(before: ExploredRun, step: Step) -> None:
    """Sections come by the manager's word, or where the crew enters the train number."""
    gained = set(step.run.state.authority.held) - set(before.state.authority.held)
    match step.event:
        case TelegramHeard(GrantHeard(answers=True, fresh=True, newer=True) | SignOnHeard(answers=True)):
            assert gained <= set(step.event.event.section_ids)
        case Begin(signs_on=True):
            assert gained <= {step.event.plan.spans[0].section_id}
        # what a unit claims that knows where it is
        case _ if not before.state.authority.on_line and step.run.known:
            assert gained in (set(), set(step.run.under))
        case _:
            assert not gained


def check_drops_what_is_clear(before: ExploredRun, step: Step) -> None:
    """Sections go when a tag proves them to be behind and the safe rear has left them, when not entered, by the
    driver's eye at a mark, or by the manager's word on signing on or off.
    """
    after = step.run
    dropped = set(before.state.authority.held) - set(after.state.authority.held)
    plan = PLANS[after.plan]
    match step.event:
        case SetBack():
            assert dropped.isdisjoint(s.section_id for s in plan.spans[: after.place.perhaps])
        case AtMark():
            assert dropped <= {s.section_id for s in plan.spans[: plan.stops[step.event.stop].clear]}
        case Begin() | SwitchedOn() | OffTheLine() | TelegramHeard(SignOnHeard(answers=True)):
            pass
        case _:
            proved = max((tag.clear for tag in plan.tags[: after.read + 1]), default=0)
            assert dropped <= {s.section_id for s in plan.spans[: min(proved, after.place.clear)]}
            assert dropped.isdisjoint(after.under)


def check_points(before: ExploredRun, step: Step) -> None:
    """Proven only while held, or by the crew's eye on sight; no command of points that may be under the train."""
    after = step.run
    authority = after.state.authority
    crew_may_have_seen = DutyPhase.ON_SIGHT in (before.state.phase, after.state.phase)
    for needed in set(authority.proven) - set(before.state.authority.proven):
        assert authority.holds(needed.section_id) or isinstance(step.event, PointsSeen) or crew_may_have_seen
    assert all(authority.holds(command.needed.section_id) for command in authority.commands)
    if not after.known:
        assert not (before.known and authority.commands), "the front may be anywhere, so on them too"
        new = {c.needed for c in authority.commands} - {c.needed for c in before.state.authority.commands}
        assert not new or isinstance(step.event, PointsWrong)
        return
    if after.state.phase in (DutyPhase.OFF, DutyPhase.LEAVING, DutyPhase.GONE):
        return
    perhaps = {span.section_id for span in PLANS[after.plan].spans[: after.place.perhaps]}
    assert perhaps.isdisjoint(command.needed.section_id for command in authority.commands)
    for action in step.actions:
        if isinstance(action, SendCommand) and not isinstance(step.event, TimerDue | TelegramHeard):
            assert action.needed.section_id not in perhaps


def timers_named(run: ExploredRun) -> set[Timer]:
    """Timers without which this state would wait for ever."""
    state = run.state
    named = {one.timer for one in (*state.authority.requests, *state.authority.commands) if one.sent}
    if not state.released:
        named.add(RELEASE)
    if state.unable is not None:
        named.add(ABLE)
    last = len(PLANS[run.plan].stops) - 1
    if state.phase is DutyPhase.STANDING and state.at < last:
        named |= {timer for timer, over in ((ASK, state.may_ask), (LEAVE, state.may_leave)) if not over}
    if state.phase is DutyPhase.RUNNING and not state.may_ask:
        named.add(ASK)
    if state.phase is DutyPhase.ON_SIGHT and state.stands_at not in (None, last) and not state.may_leave:
        named.add(LEAVE)
    return named


def timers_after(running: frozenset[Timer], step: Step) -> frozenset[Timer]:
    """Those that run after a step, as `onboard.unit` keeps them."""
    left = set(running) - ({step.event.timer} if isinstance(step.event, TimerDue) else set())
    for action in step.actions:
        if isinstance(action, SetTimer | SetTimerAt):
            left.add(action.timer)
        if isinstance(action, StopTimer):
            left.discard(action.timer)
    return frozenset(left)


def waits_for_nothing(run: ExploredRun) -> bool:
    """Neither anything outstanding nor a timer, and the train does not move; its duty not over."""
    state = run.state
    if state.phase in (DutyPhase.OFF, DutyPhase.LEAVING, DutyPhase.GONE, DutyPhase.FINISHED):
        return False  # the crew's turn
    if state.authority.requests or state.authority.commands or timers_named(run):
        return False
    if command_of(PLANS[run.plan], state).confirm:
        return False  # the driver is asked, and looks again and again
    looks = state.phase is DutyPhase.ON_SIGHT and not run.known  # its crew looks, or calls for help
    return not (run.moves or may_start(run) or (looks and command_of(PLANS[run.plan], state).drive))


def check_waits_for_something(run: ExploredRun) -> None:
    assert not waits_for_nothing(run), run


def check_contradiction_stops(before: ExploredRun, step: Step) -> None:
    """It drives no more from the event on that tells of it, until all it holds is confirmed and nothing contested, but
    within its section where it hears nothing.
    """
    was, after = before.state.authority, step.run.state.authority
    if step.run.state.phase in (DutyPhase.OFF, DutyPhase.LEAVING, DutyPhase.GONE):
        return
    shown = command_of(PLANS[step.run.plan], step.run.state)
    unheard = shown.within_section and not isinstance(step.event, TelegramHeard)
    assert unheard or not (after.mismatch and shown.drive)
    if after.mismatch and not was.mismatch:
        assert DrivingOrder.STOP in step.actions
    if after.mismatch:
        assert unheard or DrivingOrder.RELEASE not in step.actions
        assert DrivingOrder.DEPART not in step.actions
    if was.mismatch and not after.mismatch:
        match step.event:
            case TelegramHeard(ConfirmationHeard(answers=True, contested=())):
                assert set(step.event.event.section_ids) == set(was.held)
            case (
                TelegramHeard(SignOnHeard(answers=True) | SignOffHeard(answers=True)) | Begin() | SwitchedOn()
            ):
                pass
            case _:
                raise AssertionError(step.event)


def check_stays_where_it_is_unable(before: ExploredRun, step: Step) -> None:
    """It neither leaves nor asks for a route, and shows its driver why."""
    after = step.run
    if after.state.phase is not DutyPhase.STANDING or not after.state.may_ask or after.place.unable is None:
        assert after.state.phase is DutyPhase.STANDING or after.state.unable is None
        assert after.place.unable is None or DrivingOrder.DEPART not in step.actions
        return
    assert after.state.unable == after.place.unable == command_of(PLANS[after.plan], after.state).unable
    asked = after.state.authority.open(RequestKind.ROUTE)
    assert asked is None or before.state.authority.open(RequestKind.ROUTE) is not None


def check(before: ExploredRun, step: Step) -> None:
    check_stays_where_it_is_unable(before, step)
    check_contradiction_stops(before, step)
    check_holds_what_was_granted(before, step)
    check_drops_what_is_clear(before, step)
    check_points(before, step)
    check_waits_for_something(step.run)


@pytest.fixture(scope="module", params=ReleaseRule)
def explored(request: pytest.FixtureRequest) -> Iterator[Explored[ExploredRun]]:
    with pytest.MonkeyPatch.context() as patch:
        release_by(patch, request.param)
        yield explore(first(), events_from, phase_name, 1500)


def release_by(patch: pytest.MonkeyPatch, rule: ReleaseRule) -> None:
    patch.setattr(lone_unit, "TIMES", replace(lone_unit.TIMES, release=rule))


def test_every_state_reached_first_keeps_the_rules(explored: Explored[ExploredRun]) -> None:
    for run in explored.states:
        for step in steps(run):
            check(run, step)


def test_states_are_small_and_their_parts_bounded(explored: Explored[ExploredRun]) -> None:
    assert {run.state.phase for run in explored.states} == set(DutyPhase)
    for run in explored.states:
        state = run.state
        assert hash(state) == hash(replace(state))
        assert len(pickle.dumps(state)) < SMALL_BYTES
        for listed in (state.authority.held, state.authority.proven, state.authority.unsaid, state.wanted):
            assert len(set(listed)) == len(listed)


@given(st.lists(st.integers(0, 1000), max_size=120), st.booleans(), st.sampled_from(ReleaseRule))
def test_whatever_happens_the_rules_hold(choices: list[int], willing: bool, rule: ReleaseRule) -> None:
    """`willing`: the first thing that can happen is taken more often, so that courses get far."""
    with pytest.MonkeyPatch.context() as patch:
        release_by(patch, rule)
        follow(choices, willing)


def follow(choices: list[int], willing: bool) -> None:
    run, running = ExploredRun(), frozenset[Timer]()
    for choice in choices:
        possible = list(steps(run))
        if not possible:
            return
        step = possible[(choice // 2 if willing and choice % 2 else choice) % len(possible)]
        check(run, step)
        running = timers_after(running, step)
        assert timers_named(step.run) <= running
        run = step.run


def test_a_run_gets_through(explored: Explored[ExploredRun]) -> None:
    """So that what is checked is more than the beginning: the train arrives, turns, and leaves the line."""
    assert any(run.plan == 1 and run.state.phase is DutyPhase.STANDING for run in explored.states)
    assert any(run.spot == END and run.state.phase is DutyPhase.FINISHED for run in explored.states)


def frees_one_more(plan: DutyPlan, authority: Authority, clear: int) -> tuple[str, ...]:
    return tuple(s.section_id for s in plan.spans[: clear + 1] if authority.holds(s.section_id))


def clears_by_the_odometer(turn: DutyStep) -> None:
    cleared = cleared_sections(turn.plan, turn.state.authority, turn.state.place.clear)
    if cleared:
        turn.authority(Cleared(cleared))


def forgets(state: Authority, event: ConfirmationHeard) -> Result:
    after, actions = report.confirmed(state, event)
    return replace(after, mismatch=""), actions


SWITCHES: Final[dict[str, tuple[object, str, object]]] = {
    "waits for the rear": (duty_step, "cleared_sections", frees_one_more),
    "waits for the arrival tag": (machine, "clear_behind", clears_by_the_odometer),
    "withdraws throws under the front": (machine, "points_perhaps_under", lambda *_: ()),
    "withdraws throws when the position is lost": (on_sight, "Withdrawn", lambda _: Withdrawn(())),
    "stays where it is unable": (fitness, "unable_now", lambda _: None),
    "stops where register and unit contradict each other": (machine, "react", lambda _: None),
    "waits until they agree": (
        authority_machine,
        "TABLE",
        {**TABLE, (SignOnStanding.ON_LINE, ConfirmationHeard): forgets},
    ),
}


@pytest.mark.parametrize("off", SWITCHES)
def test_a_rule_switched_off_is_found(off: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(*SWITCHES[off])
    found = explore(course(), events_from, phase_name, 1000)
    with pytest.raises(AssertionError):
        for run in found.states:
            for step in steps(run):
                check(run, step)


def test_the_points_of_the_small_line_are_on_both_plans() -> None:
    assert all(any(X in span.points for span in plan.spans) for plan in PLANS)
