"""Persons in roles of substitute working: each step by hand, left out, out of its turn, given back to the program."""

import json
from pathlib import Path
from typing import Any, Final

import pytest
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from console.books import works_shown
from console.desk import Desk
from console.protocol import AskProtocol, DoAct, StepState
from console.seats import Seat
from console.session import Session
from documents.steps_left_out import without
from network.errors import InputError
from scenario.scenario import Scenario
from simulation.events import (
    ProcedureStep,
    StepLeftOut,
    StepNoted,
    StepOutOfOrder,
    StepRefused,
    UnitRestrains,
)
from simulation.judge.checkers import Checker
from simulation.procedure import PROCEDURES, Part, Regime, WorkingStep, rows_of_train
from simulation.setup import STEPS_PER_S
from simulation.substitute import persons, sight
from simulation.substitute.players import SubstitutePlayers
from simulation.substitute_settings import LeftOutStep
from study.runner.run import CarrierKind
from tests.console.at_posts import AtPosts, drill_of, of_regime
from tests.console.test_seats_at_work import replayed
from tests.nightly import A_FIFTH, others_nightly
from tests.plain import drill_on_plain, run_on_plain

DRILL: Final = "rtri/95_substitute_working"
TICKETS: Final = "rtri/95b_pilots_ticket"
FEW = settings(A_FIFTH, phases=[Phase.explicit, Phase.generate], suppress_health_check=list(HealthCheck))
PEOPLE: Final = ("dispatcher", "operator A", "operator B", "operator PW", "operator PE")
PILOTS: Final = ("pilot 1", "pilot 6", "pilot 11")
DRIVERS: Final = ("driver K1", "driver K2")
EVERYBODY: Final = (*PEOPLE, *PILOTS, *DRIVERS)
OFF_S: Final = 36_010.0  # the block manager loses its power


def on_plain(scenario: Scenario) -> Session:
    return Session(scenario, CarrierKind.PLAIN)


def noted(session: Session, kind: type[Any] = StepNoted) -> list[tuple[str, str, str]]:
    """What was written of steps that were not simply done: by whom, which, and why."""
    return [(e.who, e.event.step, e.event.why) for e in session.journal.entries if isinstance(e.event, kind)]


def done_in(session: Session) -> list[tuple[str, str]]:
    """Section or station, and step."""
    told = [e.event for e in session.journal.entries if isinstance(e.event, ProcedureStep)]
    return [(event.block, event.step) for event in told]


def done(session: Session) -> list[str]:
    return [step for _, step in done_in(session)]


@pytest.mark.parametrize(
    ("name", "regime", "ticket"),
    [
        (DRILL, Regime.TELEPHONE, False),
        pytest.param(DRILL, Regime.DISPATCHER, False, marks=pytest.mark.nightly),
        (TICKETS, Regime.TELEPHONE, True),
    ],
)
def test_every_step_by_hand_no_rule_breaks_and_all_arrive(
    name: str, regime: Regime, ticket: bool, tmp_path: Path
) -> None:
    """No step is the program's; its times are, so trains are not much later than if it had played all."""
    with on_plain(of_regime(name, regime)) as session:
        at = AtPosts(session, EVERYBODY)
        result = at.result()
        assert result.violations == () and not result.unfinished
        assert noted(session) == []
        rows = rows_of_train(PROCEDURES[regime], ticket=ticket)
        # With the ticket both trains are through before there is anything to end.
        wanted = {row.step.value for row in rows if not (ticket and row.part is Part.END)}
        assert wanted <= set(done(session))
        if regime is Regime.TELEPHONE:  # of the other one the file does not know
            assert replayed(session, tmp_path).digest == result.digest


def test_a_step_waits_for_the_person_and_for_nobody_else() -> None:
    """Operator A does nothing: the sections at station A wait for him, and the one that he is not at goes on."""
    with on_plain(drill_of(DRILL)) as session:
        AtPosts(session, ["operator A"])
        session.run_to(round((OFF_S + 300.0) * STEPS_PER_S))
        steps = done_in(session)
        assert {step for block, step in steps if block in ("1", "6")} == {"order"}
        assert ("11", "agree") in steps
        waited = [
            (work.block, shown.step)
            for work in works_shown(session)
            for shown in work.steps
            if shown.state is StepState.NEXT
        ]
        assert waited == [("6", "man"), ("1", "man")]


def test_a_person_leaves_out_what_the_program_would_have_and_the_same_comes_of_it() -> None:
    """Nobody agrees to T3: by a person and by `[[left_out]]` the same rule is broken by the same train."""
    with on_plain(drill_of(DRILL)) as session:
        at = AtPosts(session, ["operator A"])
        while not [s for s in at.steps(StepState.NEXT) if s[1] == "agree"]:
            for step in at.steps(StepState.NEXT):
                at.do(*step)
            session.next_event()
        at.do("operator A", "agree", "1", "T3", kind="leave_out_step")
        by_person = at.result()
        assert noted(session) == [("operator A", "agree", "left out")]
        score = json.loads(at.desk.ask(Seat.INSTRUCTOR, AskProtocol(), 0.0).text)
    left = LeftOutStep(step=WorkingStep.AGREE, block="1", train="T3")
    scenario = without(drill_of(DRILL), left, until_s=float("inf"))
    by_program = run_on_plain(scenario).result
    found = [[(v.checker, v.subject) for v in one.violations] for one in (by_person, by_program)]
    assert found[0] == found[1] == [(Checker.PILOTS_LEAVE, "1 K2")]
    with on_plain(scenario) as session:
        AtPosts(session).run()
        played = json.loads(Desk(session).ask(Seat.INSTRUCTOR, AskProtocol(), 0.0).text)
    told = [[(one["who"], one["what"], one["text"]) for one in each["steps"]] for each in (score, played)]
    assert told[0] == told[1] and len(told[0]) == 1
    assert "列車 T3" in score["steps"][0]["text_ja"]


def test_a_train_let_go_before_its_steps_is_written_down_and_seen_by_the_rule() -> None:
    """Operator PW lets T3 go with its unit cut out, and neither asked nor heard anything: all that is passed over."""
    with on_plain(drill_of(DRILL)) as session:
        at = AtPosts(session, ["operator PW", "operator A", "driver K2", "pilot 1"])
        while (
            "pilot" not in done(session)
            or not at.steps(StepState.NEXT)
            or at.steps(StepState.NEXT)[0][1] != "ask"
        ):
            for step in at.steps(StepState.NEXT):
                at.do(*step)
            session.next_event()
        at.do("operator PW", "go", "1", "T3")  # equipment: its unit is not cut out
        at.session.run_to(session.step + 300)
        assert noted(session, StepRefused) == [("operator PW", "go", sight.NOT_CUT_OUT)]
        assert any(isinstance(e.event, UnitRestrains) for e in session.journal.entries)
        at.do("driver K2", "cut_out", "1", "T3")
        at.session.run_to(session.step + 1500)
        at.do("operator PW", "go", "1", "T3")
        at.session.run_to(session.step + 300)
        early = noted(session, StepOutOfOrder)
        assert [(who, step) for who, step, _ in early] == [("driver K2", "cut_out"), ("operator PW", "go")]
        assert early[1][2] == "before ask, agree, points, board"
        assert {step for _, step, why in noted(session, StepLeftOut) if why == "passed over"} >= {
            "ask",
            "agree",
            "board",
        }
        result = at.result()
        assert Checker.PILOTS_LEAVE in {violation.checker for violation in result.violations}


def test_a_section_said_to_be_clear_with_a_train_in_it_is_the_accident() -> None:
    """V3 stands between Hoshakuji and Ogane with its unit dead, and the operator of Ogane says that nothing does."""
    with on_plain(without(drill_of("karasuyama/95b_train_in_the_section"), until_s=25_900.0)) as session:
        at = AtPosts(session, ["operator OGN"])
        block = "HSK-OGN"
        while (block, "man") not in done_in(session):
            at.run(session.now_s + 60.0)
        at.run(session.now_s + 120.0)
        assert at.steps(StepState.WAITS) == [("operator OGN", "clear", block, "")]
        at.do("operator OGN", "clear", block)
        result = at.result()
        assert noted(session)[0] == ("operator OGN", "clear", persons.TOO_EARLY)
        found = [v for v in result.violations if v.checker == Checker.ONE_TRAIN_A_SECTION]
        assert block in found[0].subject


@pytest.mark.parametrize(
    ("post", "step", "block", "train", "why"),
    [
        ("operator A", "clear", "1", "", persons.NOT_TAKEN),
        ("pilot 6", "board", "6", "T3", sight.NOT_HERE),
        ("pilot 1", "board", "1", "T3", sight.NO_PILOT),
        ("pilot 1", "ticket", "1", "T3", sight.NO_PILOT),
        ("pilot 1", "alight", "1", "T3", sight.NOT_ABOARD),
        ("operator PW", "go", "1", "T3", sight.NOT_CUT_OUT),
        ("operator PW", "ask", "1", "T1", persons.NOT_HERE),
        ("operator B", "clear", "6", "", persons.NOT_YET_THERE),
    ],
)
def test_what_equipment_and_bodies_do_not_let_is_refused_and_written_down(
    post: str, step: str, block: str, train: str, why: str
) -> None:
    """Just after the manager has failed: nobody is a pilot yet, station B has nobody, T3 stands before its portal."""
    with on_plain(drill_of(DRILL)) as session:
        session.run_to(round((OFF_S + 40.0) * STEPS_PER_S))
        at = AtPosts(session, [] if why is persons.NOT_TAKEN else [post])
        at.do(post, step, block, train)
        session.run_to(session.step + 200)
        assert (post, step, why) in noted(session, StepRefused)
        assert noted(session, StepOutOfOrder) == []
        shown = session.line.events
        assert any(e.shown.alarm and e.shown.who == post and not e.truth for e in shown)


@pytest.mark.parametrize("kept_s", others_nightly([60.0, 240.0, 480.0], [240.0]))
def test_a_role_given_back_is_played_on_by_the_program(kept_s: float) -> None:
    with on_plain(drill_of(DRILL)) as session:
        at = AtPosts(session, EVERYBODY)
        at.run(OFF_S + kept_s)
        for post in EVERYBODY:
            at.hand_back(post)
        before = len(done(session))
        result = session.run_to_end()
        assert result.violations == () and not result.unfinished
        assert noted(session) == [] and len(done(session)) > before


def test_each_seat_may_have_its_own_roles_and_no_other() -> None:
    with on_plain(drill_of(DRILL)) as session:
        desk = Desk(session)

        def takes(seat: Seat, post: str, unit: str = "") -> str:
            act = DoAct(act={"kind": "take_role", "target": post})
            return desk.ask(seat, act, 0.0, unit).why

        assert takes(Seat.STAFF, "operator A") == takes(Seat.DISPATCHER, "dispatcher") == ""
        assert takes(Seat.STAFF, "pilot 6") == takes(Seat.DRIVER, "driver K1", "K1") == ""
        assert "a role that the seat staff may have" in takes(Seat.STAFF, "dispatcher")
        assert "a role that the seat dispatcher may have" in takes(Seat.DISPATCHER, "operator A")
        assert "a role that the seat driver may have" in takes(Seat.DRIVER, "driver K2", "K1")
        assert "what the seat guest may do" in takes(Seat.GUEST, "operator A")
        assert "operator A" in takes(Seat.STAFF, "operator X")  # the nearest ones are named
        wrong = {"kind": "do_step", "target": "operator A", "step": "agree", "block": "6"}
        why = desk.ask(Seat.STAFF, DoAct(act=wrong), 0.0).why
        assert "a step of operator A in 6: one of man, clear, pilot, ask, points" in why
        assert desk.welcome(Seat.STAFF).works and not desk.welcome(Seat.GUEST).posts


def test_without_substitute_working_there_are_no_roles(two_trains: Scenario) -> None:
    with on_plain(two_trains) as session:
        desk = Desk(session)
        assert "take_role" not in desk.welcome(Seat.STAFF).acts
        with pytest.raises(InputError, match=r"no such act without \[substitute\]"):
            session.act({"kind": "take_role", "target": "dispatcher"})


DEEDS = st.lists(
    st.tuples(
        st.floats(0.0, 900.0),
        st.sampled_from(EVERYBODY),
        st.sampled_from(["take", "back", "early", "leave"]),
        st.integers(0, 30),
    ),
    max_size=8,
)


@FEW
@given(deeds=DEEDS)
@example(deeds=[(0.0, "operator A", "take", 0), (200.0, "operator A", "back", 0)])
@example(
    deeds=[
        (0.0, "operator PW", "take", 0),
        (0.0, "operator A", "take", 0),
        (150.0, "operator PW", "early", 5),
    ]
)
def test_whoever_does_what_in_which_order_a_rule_breaks_only_where_it_is_written(
    deeds: list[tuple[float, str, str, int]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Persons who follow the page take and give back roles at any time; some do a step out of its turn or leave it
    out. Where nobody does, no rule breaks and all arrive. In any case it replays to the byte.
    """
    with on_plain(drill_of(DRILL)) as session:
        at = AtPosts(session)
        for after_s, post, what, pick in sorted(deeds):
            at.run(OFF_S + after_s)
            if session.ended is not None:
                break
            if what == "take":
                at.take(post)
            elif what == "back" and post in at.posts:
                at.hand_back(post)
            elif steps := at.steps(StepState.LATER, StepState.WAITS, StepState.NEXT):
                own, step, block, train = steps[pick % len(steps)]
                at.do(own, step, block, train, "do_step" if what == "early" else "leave_out_step")
        result = at.result()
        wrong = [entry for entry in noted(session) if entry[2] != sight.NOT_CUT_OUT]
        if not wrong:
            assert result.violations == () and not result.unfinished
        text = session.drill_text("saved", "saved")
    folder = tmp_path_factory.mktemp("saved")
    (folder / "saved.toml").write_text(text, "utf-8")
    again = drill_on_plain(folder / "saved.toml").run.result
    assert (again.digest, again.motion_digest) == (result.digest, result.motion_digest)


def test_a_person_whose_step_the_program_does_too_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """What makes a step wait is `SubstitutePlayers._is_persons`."""
    monkeypatch.setattr(SubstitutePlayers, "_is_persons", lambda *_: False)
    with on_plain(drill_of(DRILL)) as session:
        AtPosts(session, ["operator A"])
        session.run_to(round((OFF_S + 300.0) * STEPS_PER_S))
        assert ("6", "clear") in done_in(session)
