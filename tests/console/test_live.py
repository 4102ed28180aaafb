"""The desk in its own thread: what waits on it never makes it wait, and its run is that of its script."""

from pathlib import Path
from queue import Queue
from threading import Event
from typing import Final

import pytest

from console.desk import Desk
from console.live import WAITING_MAX, LiveDesk
from console.protocol import DeskAnswer, DoAct, Fail, Request, RunTo, SaveDrill, SetPace
from console.seats import Seat
from network.errors import InputError
from scenario.scenario import Scenario, load_scenario
from simulation.setup import STEPS_PER_S
from study.drilling.drill import run_drill
from study.runner.run import PartyLink, simulation_of

LONG_S: Final = 60.0  # no test waits so long


class Visitor:
    """Asks, and waits for the answer, or for a moment of some kind."""

    def __init__(self, scenario: Scenario) -> None:
        self._changed = Event()
        self.live = LiveDesk(scenario, self._changed.set)

    def ask(self, request: Request, seat: Seat = Seat.INSTRUCTOR) -> DeskAnswer:
        answers: Queue[DeskAnswer] = Queue()
        self.live.ask(seat, request, answers.put)
        return answers.get(timeout=LONG_S)

    def run_to(self, time_s: float) -> None:
        assert self.ask(RunTo(time_s=time_s)).good
        while self.live.moment.known.running or self.live.moment.known.time_s < time_s:
            if self.live.moment.known.ended:
                return
            assert self._changed.wait(LONG_S)
            self._changed.clear()


def test_what_seats_do_is_saved_as_a_drill_of_the_same_events(two_trains: Scenario, tmp_path: Path) -> None:
    visitor = Visitor(two_trains)
    visitor.live.start()
    try:
        visitor.run_to(36_010.0)
        assert visitor.ask(
            Fail(fault={"kind": "power_off", "target": "block-manager", "duration_s": 60.0})
        ).good
        visitor.run_to(36_020.0)
        assert not visitor.live.moment.known.manager_on
        assert {section.state.value for section in visitor.live.moment.known.sections} == {"undefined"}
        visitor.run_to(36_090.0)
        assert visitor.ask(DoAct(act={"kind": "reenter_assisted"}), Seat.DISPATCHER).good
        visitor.run_to(80_000.0)
        text = visitor.ask(SaveDrill(id="saved"), Seat.STAFF).text  # once it has ended
        ended_s = visitor.live.moment.known.time_s
    finally:
        visitor.live.stop()
    assert visitor.live.error is None
    file = tmp_path / "saved.toml"
    file.write_text(text, "utf-8")
    drill = run_drill(str(file), PartyLink.SIMULATED)
    assert drill.passed
    assert drill.run.result.end_step / STEPS_PER_S == ended_s


def test_who_asks_too_much_at_once_is_told_so_and_the_run_does_not_wait(two_trains: Scenario) -> None:
    """Nobody takes anything from the queue before the desk has begun."""
    live = LiveDesk(two_trains, lambda: None)
    said: list[DeskAnswer] = []
    for number in range(WAITING_MAX + 3):
        live.ask(Seat.GUEST, SetPace(number=number, factor=1.0), said.append)
    assert [answer.number for answer in said] == [WAITING_MAX, WAITING_MAX + 1, WAITING_MAX + 2]
    assert all("busy" in answer.why for answer in said)


def test_whoever_asks_something_of_a_run_that_breaks_off_is_answered(
    two_trains: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    def breaks(_desk: Desk, *_asked: object) -> DeskAnswer:
        raise ZeroDivisionError

    monkeypatch.setattr(Desk, "ask", breaks)
    visitor = Visitor(two_trains)
    visitor.live.start()
    try:
        for number in (3, 4):
            answer = visitor.ask(SetPace(number=number, factor=1.0))
            assert (answer.number, answer.good) == (number, False) and "no more" in answer.why
    finally:
        visitor.live.stop()
    assert visitor.live.is_over and isinstance(visitor.live.error, ZeroDivisionError)


def test_what_keeps_it_from_beginning_is_raised_where_it_was_begun() -> None:
    live = LiveDesk(load_scenario("karasuyama_bad_days"), lambda: None)
    with pytest.raises(InputError, match="no failures"):
        live.start()


def test_the_line_without_a_desk_ends_when_the_desk_leaves_it_alone(two_trains: Scenario) -> None:
    visitor = Visitor(two_trains)
    visitor.live.start()
    try:
        visitor.run_to(80_000.0)
        ended_s, because = visitor.live.moment.known.time_s, visitor.live.moment.known.ended
    finally:
        visitor.live.stop()
    with simulation_of(two_trains.setup) as simulation:
        alone = simulation.run()
    assert (ended_s, because) == (alone.end_step / STEPS_PER_S, alone.ended_because.value)
