"""What the dispatcher's, the driver's and the instructor's seats do in a run, and that all of it replays."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import pytest

from console.desk import Desk
from console.protocol import (
    ArmScript,
    AskProtocol,
    ChangeFault,
    DeskAnswer,
    DoAct,
    Fail,
    GoBack,
    Request,
    RunTo,
    SaveDrill,
    SayToSeat,
)
from console.seats import Seat
from console.session import Session
from console.shown import SentSoFar, state_for
from scenario.scenario import Scenario, load_scenario
from simulation.faults.script import ScriptedFault
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S
from study.drilling.drill import find_drill
from study.runner.run import CarrierKind
from tests.console.conftest import TWO
from tests.plain import drill_on_plain

TEN: Final = 36_000
MPS_PER_KMH: Final = 1.0 / 3.6


@contextmanager
def at_desk(scenario: Scenario, until_s: int = 0) -> Iterator[tuple[Session, Desk]]:
    """A session that has run until then, and its desk."""
    with Session(scenario, CarrierKind.PLAIN) as session:
        desk = Desk(session)
        session.run_to(until_s * STEPS_PER_S)
        yield session, desk


def replayed(session: Session, folder: Path) -> RunResult:
    file = folder / "saved.toml"
    file.write_text(session.drill_text("saved", "saved"), "utf-8")
    return drill_on_plain(file).run.result


def act(desk: Desk, seat: Seat, kind: str, unit: str = "", **keys: Any) -> DeskAnswer:  # noqa: ANN401
    return ask(desk, DoAct(act={"kind": kind, **keys}), seat, unit)


def ask(desk: Desk, request: Request, seat: Seat = Seat.INSTRUCTOR, unit: str = "") -> DeskAnswer:
    return desk.ask(seat, request, 0.0, unit)


def test_a_train_driven_by_hand_keeps_to_its_authority_and_replays(
    two_trains: Scenario, tmp_path: Path
) -> None:
    """Full power from the departure on, and nobody brakes: the unit does, and nothing is passed."""
    with at_desk(two_trains, TEN - 30) as (session, desk):
        assert act(desk, Seat.DRIVER, "drive", "K1", target="K1", notch=9).good
        fastest_mps = 0.0
        slot = session.simulation.trains.slot_of["K1"]
        for _ in range(150):
            session.run_to(session.step + STEPS_PER_S)
            desk.cabs = frozenset({"K1"})
            cab = desk.moment.cabs["K1"]
            if cab.permitted_mps is not None and slot in session.simulation.trains.active():
                fastest_mps = max(fastest_mps, cab.speed_mps)
                assert cab.authority_m is None or cab.authority_m > 0.0
        assert fastest_mps > 40.0 * MPS_PER_KMH
        assert cab.by_hand and cab.handle == 9.0
        assert act(desk, Seat.DRIVER, "drive_by_ato", "K1", target="K1").good
        result = session.run_to_end()
        assert all(count == 0 for count in session.simulation.checkers.counts.values())
    again = replayed(session, tmp_path)
    assert (again.digest, again.motion_digest) == (result.digest, result.motion_digest)


def test_a_driver_who_does_not_take_power_does_not_leave(two_trains: Scenario) -> None:
    with at_desk(two_trains, TEN - 30) as (session, desk):
        desk.cabs = frozenset({"K1"})
        act(desk, Seat.DRIVER, "drive", "K1", target="K1", notch=0)
        session.run_to((TEN + 60) * STEPS_PER_S)
        cab = desk.moment.cabs["K1"]
        assert (cab.speed_mps, cab.may_drive, cab.by_hand) == (0.0, True, True)
        assert cab.next_stop == "B" and cab.authority_m is not None and cab.authority_m > 0.0
        act(desk, Seat.DRIVER, "drive", "K1", target="K1", notch=3)
        session.run_to((TEN + 80) * STEPS_PER_S)
        assert desk.moment.cabs["K1"].speed_mps > 0.0


def test_a_driver_sees_and_moves_no_other_train(two_trains: Scenario) -> None:
    with at_desk(two_trains) as (session, desk):
        desk.cabs = frozenset({"K1"})
        refused = act(desk, Seat.DRIVER, "drive", "K1", target="K2", notch=5)
        assert not refused.good and "whose cab" in refused.why
        assert not act(desk, Seat.DRIVER, "hold_train", "K1", target="K1").good
        state, _ = state_for(desk.moment, Seat.DRIVER, SentSoFar(), "K1")
        assert state.cab is not None and state.cab.unit == "K1"
        assert {train.unit for train in state.trains} == {"K1"}
        assert (state.forecast, state.graph, state.points, state.rules) == (None, (), (), ())
        assert desk.moment.known.time_s == session.now_s


def test_a_train_held_by_the_dispatcher_leaves_later_by_that_and_it_replays(
    two_trains: Scenario, tmp_path: Path
) -> None:
    with at_desk(two_trains, TEN - 400) as (session, desk):
        assert act(desk, Seat.DISPATCHER, "hold_train", target="K1", hold_s=520.0).good
        session.run_to((TEN - 300) * STEPS_PER_S)
        assert [bid.unit for bid in desk.moment.known.bids] == ["K1"]
        forecast = {one.train: one for one in desk.moment.forecast}
        held_until_s = TEN - 400 + 520.0
        session.run_to(round((held_until_s + 60.0) * STEPS_PER_S))
        on_its_way = next(one for one in desk.moment.forecast if one.train == "T1")
        result = session.run_to_end()
    left_s = next(s.departure_s for s in result.stops if s.number == "T1" and s.departure_s is not None)
    assert held_until_s <= left_s <= held_until_s + 15.0  # a unit asks again within seconds
    assert forecast["T1"].times_s[0] >= held_until_s - 1.0
    assert on_its_way.times_s[0] == pytest.approx(forecast["T1"].times_s[1], abs=20.0)  # as late as it left
    assert replayed(session, tmp_path).digest == result.digest


def test_what_a_dispatcher_gets_wrong_is_said_in_both_languages_and_counted(two_trains: Scenario) -> None:
    with at_desk(two_trains, TEN - 100) as (session, desk):
        wrong = act(desk, Seat.DISPATCHER, "hold_train", target="K1", behind="K2")
        assert not wrong.good and "over which section" in wrong.why
        assert act(desk, Seat.DISPATCHER, "bar_unit", target="K2").good  # waits for a second person
        assert act(desk, Seat.DISPATCHER, "let_go", target="K1").good  # heard, and refused by the manager
        session.run_to((TEN - 90) * STEPS_PER_S)
        said = session.line.events[-1].shown
        assert said.alarm and "it is not kept back" in said.text and "抑止されていない" in said.text_ja
        score = json.loads(ask(desk, AskProtocol()).text)
    assert [one["seat"] for one in score["refused_acts"]] == ["dispatcher"]
    assert [one["seat"] for one in score["refused_words"]] == ["controller"]


def test_armed_changed_and_told_by_the_instructor_alone_and_it_replays(
    two_trains: Scenario, tmp_path: Path
) -> None:
    with at_desk(two_trains, TEN - 200) as (session, desk):
        fault = {"kind": "power_off", "target": "block-manager", "start": "10:00:20", "duration_s": 30.0}
        arm = ArmScript(faults=(fault,))
        assert not ask(desk, arm, Seat.DISPATCHER).good
        assert ask(desk, arm).good
        late = ask(desk, ArmScript(faults=(fault | {"start": "09:00:00"},)))
        assert not late.good and "a time to come" in late.why
        assert ask(desk, SayToSeat(text="snow", seat=Seat.STAFF)).good
        for seat, texts in ((Seat.STAFF, ["snow"]), (Seat.DISPATCHER, []), (Seat.INSTRUCTOR, ["snow"])):
            state, _ = state_for(desk.moment, seat, SentSoFar())
            assert [message.text for message in state.messages] == texts
        session.run_to((TEN + 25) * STEPS_PER_S)
        assert not desk.moment.known.manager_on
        result = session.run_to_end()
        score = json.loads(ask(desk, AskProtocol()).text)
    power = next(one for one in score["faults"] if "power_off" in one["text"])
    assert power["began_s"] == TEN + 20.0
    assert power["shown_s"] == 0.0 and power["recovered_s"] >= 30.0
    assert (score["digest"], score["trains_arrived"]) == (result.digest, len(result.trains_arrived))
    assert replayed(session, tmp_path).digest == result.digest


def test_a_fault_goes_on_with_other_figures(two_trains: Scenario, tmp_path: Path) -> None:
    with at_desk(two_trains, TEN - 100) as (session, desk):
        loss = {"kind": "loss", "target": "K1 <-> block-manager", "p": 0.2}
        begun = ask(desk, Fail(fault=loss))
        assert begun.good and begun.deed is not None, begun.why
        session.run_to((TEN - 50) * STEPS_PER_S)
        assert not ask(desk, ChangeFault(deed=begun.deed, keys={"no_such_key": 1.0})).good
        changed = ask(desk, ChangeFault(deed=begun.deed, keys={"p": 0.4}))
        assert changed.good and changed.deed == begun.deed + 1
        session.run_to((TEN - 40) * STEPS_PER_S)
        assert [session.can_end(number) for number in (begun.deed, changed.deed)] == [False, True]
        result = session.run_to_end()
    assert replayed(session, tmp_path).digest == result.digest


def test_a_fault_with_other_figures_is_over_when_it_would_have_been(two_trains: Scenario) -> None:
    with at_desk(two_trains, TEN - 100) as (session, desk):
        loss = {"kind": "loss", "target": "K1 <-> block-manager", "p": 0.2, "duration_s": 60.0}
        begun = ask(desk, Fail(fault=loss)).deed
        session.run_to((TEN - 80) * STEPS_PER_S)
        changed = [ask(desk, ChangeFault(deed=begun or 0, keys={"p": 0.4})).deed or 0]
        session.run_to((TEN - 70) * STEPS_PER_S)
        changed.append(ask(desk, ChangeFault(deed=changed[0], keys={"p": 0.6, "duration_s": 90.0})).deed or 0)
        ends = [
            deed.step / STEPS_PER_S + deed.item.duration_s
            for deed in (session.deeds[number] for number in changed)
            if isinstance(deed.item, ScriptedFault) and deed.item.duration_s is not None
        ]
    assert ends == pytest.approx([TEN - 100 + 0.1 + 60.0, TEN - 70 + 0.1 + 90.0])


def scored(desk: Desk) -> dict[str, Any]:
    return dict(json.loads(ask(desk, AskProtocol()).text))


def test_nobody_has_recovered_while_a_train_stands_and_what_it_loses_grows(tmp_path: Path) -> None:
    """K1 is without power between stations from 10:00:40 to 10:07:20 and nobody reacts: T1 is to come to B at 10:02:00
    and to leave at 10:07:00, T3, which waits for it, to leave A at 10:05:00 and to come to B at 10:09:00.
    """
    file = tmp_path / "two.toml"
    file.write_text(TWO, "utf-8")
    with Session(load_scenario(str(file)), CarrierKind.PLAIN) as session:
        desk = Desk(session)
        session.run_to((TEN + 40) * STEPS_PER_S)
        ask(desk, Fail(fault={"kind": "power_off", "target": "K1", "duration_s": 400.0}))
        seen = []
        for after_s in (60, 200, 441, 510):
            session.run_to((TEN + after_s) * STEPS_PER_S)
            seen.append(scored(desk))
        assert [score["faults"][0]["recovered_s"] for score in seen[1:]] == [None] * 3
        assert [score["lost_train_minutes"] for score in seen] == [0.0, 1.33, 5.35, 6.5]
        assert seen[-1]["faults"][0]["shown_s"] == pytest.approx(400.0, abs=20.0)  # it starts again
        assert not act(desk, Seat.DISPATCHER, "hold_train", target="K9").good
        stops = session.run_to_end().stops
        ended = scored(desk)
    came = {(s.number, s.station_id): s.arrival_s or 0.0 for s in stops}
    assert ended["faults"][0]["recovered_s"] == pytest.approx(came["T3", "B"] - TEN - 40.1, abs=0.1)
    assert ended["faults"][0]["acted_s"] == pytest.approx(510.0 - 40.1)
    lost_s = came["T1", "B"] - TEN - 120 + came["T3", "B"] - TEN - 540
    assert ended["lost_train_minutes"] == pytest.approx(lost_s / 60.0, abs=0.01)


def test_nobody_has_recovered_while_the_register_is_not_whole_again(two_trains: Scenario) -> None:
    """A fault of five seconds while the block manager has no power for a minute, long before any train leaves."""
    with at_desk(two_trains, TEN - 400) as (session, desk):
        ask(desk, Fail(fault={"kind": "power_off", "target": "block-manager", "duration_s": 60.0}))
        session.run_to((TEN - 390) * STEPS_PER_S)
        ask(desk, Fail(fault={"kind": "clock", "target": "K1", "duration_s": 5.0}))
        session.run_to((TEN - 380) * STEPS_PER_S)
        assert [one["recovered_s"] for one in scored(desk)["faults"]] == [None, None]
        session.run_to((TEN - 150) * STEPS_PER_S)  # it is whole, and no train is late yet
        power, clock = scored(desk)["faults"]
    assert power["recovered_s"] >= 60.0
    whole_s = power["began_s"] + power["recovered_s"]
    assert clock["began_s"] + clock["recovered_s"] == pytest.approx(whole_s, abs=0.1)


def test_a_fault_of_the_drill_that_is_served_is_in_its_protocol() -> None:
    with Session(load_scenario(find_drill("rtri/09_manager_power")), CarrierKind.PLAIN) as session:
        desk = Desk(session)
        session.run_to((TEN + 4) * STEPS_PER_S)
        assert scored(desk)["faults"] == []
        session.run_to((TEN + 20) * STEPS_PER_S)
        (fault,) = scored(desk)["faults"]
    assert (fault["began_s"], fault["shown_s"], fault["recovered_s"]) == (TEN + 5.0, 0.0, None)


def test_what_was_refused_and_said_is_undone_with_the_rest(two_trains: Scenario) -> None:
    """Otherwise somebody would have acted on a fault who, as the run now is, has not."""
    with at_desk(two_trains, TEN - 200) as (session, desk):
        ask(desk, Fail(fault={"kind": "power_off", "target": "block-manager"}))
        session.run_to((TEN - 150) * STEPS_PER_S)
        assert not act(desk, Seat.DISPATCHER, "hold_train", target="K9").good
        assert ask(desk, SayToSeat(text="snow")).good
        assert scored(desk)["faults"][0]["acted_s"] == pytest.approx(49.9)
        assert ask(desk, GoBack(time_s=TEN - 170.0)).good
        session.run_to((TEN - 100) * STEPS_PER_S)
        score = scored(desk)
    assert (score["refused_acts"], score["messages"], score["faults"][0]["acted_s"]) == ([], [], None)


def test_where_nothing_was_done_there_is_no_drill_to_save(two_trains: Scenario) -> None:
    """`branchline drill` refuses a file in which nothing fails and nobody acts."""
    with at_desk(two_trains) as (_, desk):
        nothing = ask(desk, SaveDrill(id="saved"))
        assert not nothing.good and "something that was done" in nothing.why
        act(desk, Seat.DISPATCHER, "hold_train", target="K1")
        assert ask(desk, SaveDrill(id="saved")).good


def test_what_was_armed_before_is_kept_when_one_goes_back_and_what_came_later_is_not(
    two_trains: Scenario,
) -> None:
    with at_desk(two_trains, TEN - 200) as (session, desk):
        fault = {"kind": "power_off", "target": "block-manager", "start": "10:00:20", "duration_s": 30.0}
        ask(desk, ArmScript(faults=(fault,)))
        session.run_to((TEN - 100) * STEPS_PER_S)
        act(desk, Seat.DISPATCHER, "hold_train", target="K1")
        session.run_to(TEN * STEPS_PER_S)
        assert ask(desk, GoBack(time_s=TEN - 150.0)).good
        assert [deed.step for deed in session.deeds] == [(TEN + 20) * STEPS_PER_S]
        assert ask(desk, RunTo(time_s=TEN + 25.0)).good
        session.run_to((TEN + 25) * STEPS_PER_S)
        assert not desk.moment.known.manager_on


def test_a_forecast_is_sent_when_it_is_another(two_trains: Scenario) -> None:
    with at_desk(two_trains) as (session, desk):
        first, had = state_for(desk.moment, Seat.DISPATCHER, SentSoFar())
        again, had = state_for(desk.moment, Seat.DISPATCHER, had)
        session.run_to(session.step + 60 * STEPS_PER_S)
        later, _ = state_for(desk.moment, Seat.DISPATCHER, had)
    assert first.forecast and again.forecast is None and later.forecast
