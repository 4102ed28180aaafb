"""A run that is worked is the run of its script: nothing depends on who looks when, and what was done replays."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from console.session import Session
from network.errors import InputError
from scenario.scenario import Scenario, load_scenario
from simulation.loop import Simulation
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S
from study.drilling.drill import run_drill
from study.runner.run import PartyLink, simulation_of
from tests.nightly import A_FIFTH

TEN: Final = 36_000 * STEPS_PER_S  # T1's departure


@dataclass(frozen=True)
class Uncut:
    scenario: Scenario
    result: RunResult


@pytest.fixture(scope="module")
def two(two_trains: Scenario) -> Uncut:
    """Its run without a desk."""
    with simulation_of(two_trains.setup) as simulation:
        return Uncut(two_trains, simulation.run())


def replayed(session: Session, folder: Path) -> RunResult:
    file = folder / "saved.toml"
    file.write_text(session.drill_text("saved", "saved"), "utf-8")
    return run_drill(str(file), PartyLink.SIMULATED).run.result


@A_FIFTH
@given(st.lists(st.integers(1, 900), min_size=1, max_size=40))
def test_where_somebody_looks_moves_nothing(two: Uncut, waits: list[int]) -> None:
    with Session(two.scenario) as session:
        for steps in waits:
            session.run_to(session.step + steps)
        found = session.run_to_end()
    assert (found.digest, found.motion_digest) == (two.result.digest, two.result.motion_digest)


DEEDS: Final[tuple[tuple[str, dict[str, Any]], ...]] = (
    ("fault", {"kind": "power_off", "target": "block-manager", "duration_s": 45.0}),
    ("fault", {"kind": "restart", "target": "K1"}),
    ("fault", {"kind": "loss", "target": "K1 <-> block-manager", "p": 0.4}),
    ("fault", {"kind": "slippery", "target": "K2", "factor": 0.6}),
    ("act", {"kind": "give_back", "target": "K2", "hold_s": 60.0}),
    ("act", {"kind": "reenter_assisted"}),
    ("end", {}),
)


def do(session: Session, what: str, table: dict[str, Any]) -> None:
    """Whatever can be done; the last fault that lasts is ended."""
    if session.ended is not None:
        return
    if what == "fault":
        session.fail(table)
    elif what == "act":
        session.act(table)
    else:
        for number in reversed(range(len(session.deeds))):
            if session.can_end(number):
                session.end_fault(number)
                return


@A_FIFTH
@given(st.lists(st.tuples(st.integers(0, 1200), st.sampled_from(DEEDS)), min_size=1, max_size=8))
def test_what_is_done_replays_to_the_byte(
    two: Uncut, tmp_path: Path, deeds: list[tuple[int, tuple[str, dict[str, Any]]]]
) -> None:
    with Session(two.scenario) as session:
        session.run_to(TEN - 300)
        for steps, (what, table) in deeds:
            session.run_to(session.step + steps)
            do(session, what, table)
        worked = session.run_to_end()
    if not session.deeds:
        return
    again = replayed(session, tmp_path)
    assert (again.digest, again.motion_digest) == (worked.digest, worked.motion_digest)
    assert again.ended_because is worked.ended_because


def test_a_stretch_that_is_not_run_anew_replays_otherwise(
    two: Uncut, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What makes the two tests above hold is `Simulation._cut`: without it the deed comes where the stretch ends."""

    def not_cut(_simulation: Simulation, _step: int) -> None:
        pass

    with monkeypatch.context() as patched, Session(two.scenario) as session:
        patched.setattr(Simulation, "_cut", not_cut)
        session.run_to(TEN + 203)
        session.fail({"kind": "restart", "target": "K1"})
        worked = session.run_to_end()
    assert replayed(session, tmp_path).digest != worked.digest


def test_a_deed_takes_effect_in_the_next_step(two: Uncut) -> None:
    """The kernel runs up to 5 s ahead, and 0.2 s at pace 1 are two steps."""
    with Session(two.scenario) as session:
        session.run_to(TEN + 203)
        began = session.deeds[session.fail({"kind": "restart", "target": "K1"})].step
        session.run_to(began)
        told = [entry.t_s for entry in session.journal.entries if type(entry.event).__name__ == "FaultBegan"]
    assert began == TEN + 204
    assert told == [began / STEPS_PER_S]


def test_two_deeds_of_one_moment_take_two_steps(two: Uncut) -> None:
    """A drill file keeps faults and acts in two lists, so an order of both within one step could not be written."""
    with Session(two.scenario) as session:
        session.run_to(TEN)
        session.act({"kind": "give_back", "target": "K2"})
        session.fail({"kind": "restart", "target": "K1"})
        assert [deed.step for deed in session.deeds] == [TEN + 1, TEN + 2]


def test_going_back_undoes_what_came_after(two: Uncut) -> None:
    """What-if: with the fault, then back before it and on without: as it was. A fault ended later lasts again."""
    with Session(two.scenario) as session:
        session.run_to(TEN)
        fault = session.fail({"kind": "power_off", "target": "block-manager"})
        session.run_to(TEN + 600)
        session.end_fault(fault)
        with_it = session.run_to_end()
        assert with_it.digest != two.result.digest
        session.go_back(TEN + 300)
        assert session.deeds[fault].over_step is None
        session.run_to(TEN + 600)
        session.end_fault(fault)
        assert session.run_to_end().digest == with_it.digest
        session.go_back(TEN)
        assert session.deeds == []
        assert session.run_to_end().digest == two.result.digest


def test_what_is_refused_says_why_and_changes_nothing(two: Uncut) -> None:
    with Session(two.scenario) as session:
        session.run_to(TEN)
        with pytest.raises(InputError, match=r"desk: fault.target is 'K9'; expected a device"):
            session.fail({"kind": "power_off", "target": "K9"})
        with pytest.raises(InputError, match=r"desk: act.kind is 'sing'"):
            session.act({"kind": "sing"})
        with pytest.raises(InputError, match="a fault in force"):
            session.end_fault(0)
        with pytest.raises(InputError, match="expected a time from"):
            session.go_back(TEN + 1)
        assert session.deeds == []
        assert session.run_to_end().digest == two.result.digest
        with pytest.raises(InputError, match="a run that has not ended"):
            session.fail({"kind": "restart", "target": "K1"})


def test_a_day_whose_failures_are_drawn_is_refused() -> None:
    with pytest.raises(InputError, match="late; expected no failures"):
        Session(load_scenario("karasuyama_bad_days"))
