"""A centre that can't be reached: no train gets further than it might already, and nobody waits for nothing afterwards.

The paper's line with two trains, cut at any moment for any time, all of it or a part.
"""

from dataclasses import replace
from functools import cache
from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.notes import Holds
from radio.noted import Lost, LostWhere
from scenario.scenario import load_scenario
from simulation.events import FaultBegan, FaultOver, PointsMoving
from simulation.faults.cable import WHOLE, CutCable
from simulation.faults.script import Script, ScriptedFault, Trigger
from simulation.result import RunResult
from simulation.settings import Interlocking
from simulation.setup import Setup
from simulation.world.cable import Cable
from study.drilling.drill import find_drill
from study.measures.register_holds import section_holds
from study.measures.wait_text import text_of
from study.measures.waits import CABLE_CUT, waits_of
from study.record.wait import Cause
from study.runner.outcome import broken_rules, unfinished
from study.runner.run import CarrierKind, simulation_of
from tests.nightly import A_FIFTH
from wayside.said import Granted

TEN_S: Final = 36_000.0  # T1's departure
ON_THE_WAY_S: Final = 0.3  # what was sent before the cut still arrives, a step later, and is acted on


@cache
def two_trains(interlocking: Interlocking) -> Setup:
    setup = load_scenario(find_drill("rtri/80b_cable_cut_on_board")).setup
    operation = setup.operation.model_copy(update={"interlocking": interlocking})
    return replace(setup, operation=operation, script=Script())


def run(interlocking: Interlocking, *cuts: tuple[str, float, float, float]) -> RunResult:
    """With the cable cut: where, how far along, s after ten, for how long."""
    failures = tuple(
        ScriptedFault(CutCable(target=stretch, along_share=along), Trigger(at_s=TEN_S + at_s), for_s)
        for stretch, along, at_s, for_s in cuts
    )
    with simulation_of(
        replace(two_trains(interlocking), script=Script(failures)), carrier=CarrierKind.PLAIN
    ) as simulation:
        return simulation.run()


def moved_on_while_cut(result: RunResult) -> list[str]:
    """Who was granted anything, or which points moved, while all of the cable was cut."""
    entries = result.journal.entries
    cut_s = next(e.t_s for e in entries if isinstance(e.event, FaultBegan))
    over_s = next((e.t_s for e in entries if isinstance(e.event, FaultOver)), result.end_step / 10.0)
    held: dict[str, set[str]] = {}
    found: list[str] = []
    for entry in entries:
        cut = cut_s + ON_THE_WAY_S < entry.t_s < over_s
        match entry.event:
            case Holds(section_ids=sections):
                if cut and not set(sections) <= held.get(entry.who, set()):
                    found.append(f"{entry.who} holds {sections}")
                held[entry.who] = set(sections)
            case Granted(unit_id=unit) if cut:
                found.append(f"{unit} is granted a route")
            case PointsMoving(points_id=points) if cut:
                found.append(f"{points} move")
            case _:
                pass
    return found


def lost_in_the_cable(result: RunResult) -> int:
    lost = [e.event for e in result.journal.entries if isinstance(e.event, Lost)]
    return sum(event.where is LostWhere.CABLE for event in lost)


@A_FIFTH
@given(st.floats(-30.0, 420.0), st.floats(5.0, 900.0))
def test_while_all_is_cut_nobody_gets_further_and_afterwards_all_arrive(at_s: float, for_s: float) -> None:
    result = run(Interlocking.CENTRAL, (WHOLE, 0.5, at_s, for_s))
    assert moved_on_while_cut(result) == []
    assert broken_rules(result) == []  # no-dead-state is one of them
    assert unfinished(result) == ()


@A_FIFTH
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["A - B", WHOLE]), st.floats(0, 1), st.floats(-30.0, 420.0), st.floats(5.0, 300.0)
        ),
        min_size=1,
        max_size=3,
    )
)
def test_whatever_is_cut_nothing_is_broken_and_all_arrive(
    cuts: list[tuple[str, float, float, float]],
) -> None:
    result = run(Interlocking.CENTRAL, *cuts)
    assert broken_rules(result) == []
    assert unfinished(result) == ()


def test_a_cable_that_is_never_cut_is_no_difference() -> None:
    assert run(Interlocking.CENTRAL).digest == run(Interlocking.ONBOARD).digest


def test_on_board_the_same_cut_changes_no_train() -> None:
    whole, cut = run(Interlocking.ONBOARD), run(Interlocking.ONBOARD, (WHOLE, 0.5, 1.0, 300.0))
    assert lost_in_the_cable(cut) == 0
    assert whole.stops == cut.stops
    assert (whole.trace == cut.trace).all()


def test_without_the_cable_in_the_way_the_property_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """The switch: a centre that is reached all the same."""
    monkeypatch.setattr(Cable, "severed", False)
    assert moved_on_while_cut(run(Interlocking.CENTRAL, (WHOLE, 0.5, 1.0, 300.0)))


def test_the_reason_of_a_wait_is_the_cable() -> None:
    """T1 before the points of B, T3 outside: both for the cable while it is cut, and neither after."""
    result = run(Interlocking.CENTRAL, (WHOLE, 0.5, 1.0, 300.0))
    setup = two_trains(Interlocking.CENTRAL)
    holds = section_holds(result, setup.line, setup.lengths_m)
    waits = [w for w in waits_of(result, setup, holds) if w.reason == CABLE_CUT]
    assert {(w.unit, w.cause) for w in waits} >= {("K1", Cause.POINTS_PROOF), ("K2", Cause.ANSWER)}
    assert all(TEN_S < w.from_s < w.to_s < TEN_S + 310.0 for w in waits)
    assert "the cable to the centre is cut" in text_of(waits[0]).en
    assert lost_in_the_cable(result) > 20
