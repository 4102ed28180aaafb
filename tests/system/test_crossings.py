"""Level crossings in whole runs of the paper's line: whatever fails, no train comes onto an open road, and all arrive;
by contacts the warning lasts as long as the train takes from there. Tables and figures of a day say so.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.crossings import talk
from onboard.notes import Departs
from scenario.scenario import load_scenario
from simulation.events import BarrierState, CrossingBarriers, CrossingEntered, CrossingLamps
from simulation.faults.crossings import BarriersStuck, CrossingUndetected, LampsDead
from simulation.faults.devices import Frozen, PowerCut, Restart
from simulation.faults.links import Cut, Delay, Duplicate, FaultyLink, Loss
from simulation.faults.script import Script, ScriptedFault, Trigger
from simulation.result import RunResult
from simulation.setup import Setup
from study.collect.crossings import crossing_tables
from study.drilling.drill import find_drill
from study.measures.day_figures import EVENTS, day_figures
from study.measures.road_closures import roads_closed
from study.runner.outcome import broken_rules, unfinished
from study.runner.run import simulation_of
from tests.nightly import A_FIFTH

TEN_S: Final = 36_000.0
LINK: Final = FaultyLink.parse("* <-> C1")
STEP_S: Final = 0.1


@cache
def drill(name: str) -> Setup:
    return replace(load_scenario(find_drill(f"rtri/{name}")).setup, script=Script())


def run(name: str, *failures: ScriptedFault) -> RunResult:
    setup = replace(drill(name), script=Script(failures))
    with simulation_of(setup) as simulation:
        return simulation.run()


FAULTS: Final = (
    PowerCut(target="C1"),
    Restart(target="C1"),
    Frozen(target="C1"),
    Cut(target=LINK),
    Loss(target=LINK, p=0.5),
    Delay(target=LINK, seconds=3.0),
    Duplicate(target=LINK, p=0.5),
    BarriersStuck(target="C1"),
    LampsDead(target="C1"),
    CrossingUndetected(target="C1"),
    PowerCut(target="K1"),
)
FAILURES = st.builds(
    lambda fault, at_s, for_s: ScriptedFault(
        fault, Trigger(at_s=TEN_S + at_s), None if fault.momentary else for_s
    ),
    st.sampled_from(FAULTS),
    st.floats(-60.0, 120.0).map(lambda at_s: round(at_s, 1)),
    st.floats(1.0, 120.0).map(lambda for_s: round(for_s, 1)),
)


@pytest.mark.parametrize(("from_s", "lasts_s"), [(-30.0, 60.0), (-5.0, 600.0), (5.0, 30.0), (30.0, 10.0)])
def test_a_crossing_that_freezes_is_closed_as_by_contacts_nobody_asks_it(
    from_s: float, lasts_s: float
) -> None:
    """Its watchdog lets the relays fall; when it goes on, it opens once who it has counted in is out."""
    frozen = ScriptedFault(Frozen(target="C1"), Trigger(at_s=TEN_S + from_s), lasts_s)
    result = run("107_crossing_contacts", frozen)
    assert (list(broken_rules(result)), list(unfinished(result))) == ([], [])
    lamps = [e.event.lit for e in result.journal.entries if isinstance(e.event, CrossingLamps)]
    assert lamps[-1] is (lasts_s > 60.0 and result.end_step / 10.0 < TEN_S + from_s + lasts_s)


@A_FIFTH
@given(st.lists(FAILURES, min_size=1, max_size=3))
def test_whatever_fails_no_train_comes_onto_an_open_road_and_all_arrive(
    failures: list[ScriptedFault],
) -> None:
    result = run("100_crossing", *failures)
    assert list(broken_rules(result)) == []
    assert list(unfinished(result)) == []


def test_a_unit_that_needs_no_proof_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(talk, "may_pass", lambda *_: True)
    result = run("100_crossing", ScriptedFault(Cut(target=LINK), Trigger(at_s=TEN_S - 60.0), 300.0))
    assert {violation.checker for violation in result.violations} == {"crossing-open"}


def times_s(result: RunResult, setup: Setup, *kilometrages_m: float) -> list[float]:
    """When the front was at these kilometrages, s, by the trace, whose rows lie a second apart: path and kilometrage of
    this line differ by the beginning of section 3.
    """
    rows = result.trace[result.trace["slot"] == 0]
    begin_m = setup.line.pieces["3"].from_m
    found: list[float] = []
    for at_m in kilometrages_m:
        after = int((rows["position_m"] + begin_m >= at_m).argmax())
        low, high = rows[after - 1], rows[after]
        share = (at_m - begin_m - low["position_m"]) / (high["position_m"] - low["position_m"])
        found.append(float(low["step"] + share * (high["step"] - low["step"])) * STEP_S)
    return found


def test_by_contacts_the_warning_lasts_as_long_as_the_way_from_the_first_of_them() -> None:
    """From 0.5 km to the edge of the road at 0.847 km; it is closed 15 s after the contact."""
    setup, result = drill("107_crossing_contacts"), run("107_crossing_contacts")
    contact_s, road_s = times_s(result, setup, 500.0, 847.0)
    entries = list(result.journal.entries)
    lit = next(e for e in entries if isinstance(e.event, CrossingLamps) and e.event.lit)
    closed = next(
        e for e in entries if isinstance(e.event, CrossingBarriers) and e.event.state is BarrierState.LOWERED
    )
    entered = next(e for e in entries if isinstance(e.event, CrossingEntered))
    assert lit.t_s == pytest.approx(contact_s, abs=2.0 * STEP_S)
    assert entered.t_s == pytest.approx(road_s, abs=2.0 * STEP_S)
    assert closed.t_s - lit.t_s == pytest.approx(15.0, abs=STEP_S)
    assert entered.t_s - lit.t_s == pytest.approx(road_s - contact_s, abs=2.0 * STEP_S)


def test_a_departure_is_delayed_by_what_the_warning_lacks() -> None:
    """Nothing is heard until 10 s after it should have left: then 15 s to closed, 1 s for the telegram and 15 s more,
    less its run to the road, which its unit takes for 4 s shorter at most; and the road has its least time.
    """
    planned = run("121_crossing_departure_late")
    cut = ScriptedFault(Cut(target=LINK), Trigger(at_s=TEN_S - 600.0), 610.0)
    late = run("121_crossing_departure_late", cut)
    leaves_s, late_s = (
        next(e.t_s for e in result.journal.entries if isinstance(e.event, Departs))
        for result in (planned, late)
    )
    line = drill("121_crossing_departure_late").line
    (usual,), (short,) = (crossing_tables(result, line)["warnings"].to_dicts() for result in (planned, late))
    assert (leaves_s, usual["from_stand"]) == (pytest.approx(TEN_S, abs=0.1), True)
    assert 35.0 - 1.0 <= usual["warned_s"] <= 35.0 + 4.0
    lit_s = short["at_s"] - short["warned_s"]
    needs_s = lit_s + 15.0 + 1.0 + 15.0 - (usual["at_s"] - leaves_s)
    assert TEN_S + 10.0 < lit_s < late_s
    assert needs_s <= late_s <= needs_s + 4.0
    assert 15.0 <= short["closed_s"] <= 20.0
    assert list(broken_rules(late)) == []


def test_tables_and_figures_of_a_day_say_how_long_the_road_was_closed_and_warned() -> None:
    """By contacts from 0.5 km to the rear at 0.853 km, and 8 s until the barriers are up; by radio for 35 s."""
    setup, result = drill("107_crossing_contacts"), run("107_crossing_contacts")
    length_m = setup.lengths_m["K1"]
    contact_s, road_s, rear_s = times_s(result, setup, 500.0, 847.0, 853.0 + length_m)
    made = crossing_tables(result, setup.line)
    *quiet, hour = made["crossings"].to_dicts()
    (passage,) = made["warnings"].to_dicts()
    begun_s = result.begin_step * STEP_S  # each hour has its row, those too in which nothing came
    assert [row["hour"] for row in (*quiet, hour)] == list(range(int(begun_s // 3600.0), 11))
    assert {(row["closed_s"], row["closures"], row["trains"]) for row in quiet} <= {(0.0, 0, 0)}
    assert passage["warned_s"] == pytest.approx(road_s - contact_s, abs=2.0 * STEP_S)
    assert passage["closed_s"] == pytest.approx(road_s - contact_s - 15.0, abs=2.0 * STEP_S)
    assert (passage["train"], passage["from_stand"], hour["hour"]) == ("T1", False, 10)
    assert hour["closed_s"] == pytest.approx(rear_s + 8.0 - contact_s, abs=4.0 * STEP_S)
    assert (hour["closures"], hour["trains"], hour["warned_s_min"]) == (1, 1, passage["warned_s"])
    figures = day_figures(result, setup)
    assert figures.closed_road_min == pytest.approx(hour["closed_s"] / 60.0, abs=1e-3)
    assert figures.least_warned_s == passage["warned_s"]
    # as a sweep keeps them
    kept = [entry for entry in result.journal.entries if isinstance(entry.event, EVENTS)]
    end_s = result.end_step * STEP_S
    assert roads_closed(kept, end_s) == roads_closed(result.journal.entries, end_s)
    by_radio = crossing_tables(run("100_crossing"), setup.line)["warnings"].to_dicts()
    assert [row["warned_s"] for row in by_radio] == [pytest.approx(35.0, abs=1.0)]


def test_roads_are_not_open_for_longer_by_trains_that_do_not_come() -> None:
    setup, result = drill("107_crossing_contacts"), run("107_crossing_contacts")
    figures = day_figures(replace(result, stops=[]), setup)
    day_min = (result.end_step - result.begin_step) * STEP_S / 60.0
    assert figures.missing == ("T1",)
    assert (figures.closed_road_min, figures.least_warned_s) == (pytest.approx(day_min, abs=1e-3), 0.0)


@pytest.mark.nightly
def test_by_radio_the_warning_is_as_long_for_every_train_of_a_day(
    tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    """The Karasuyama weekday with radio all along and 19 crossings: between stations, before and behind halts.

    A train that has run for 45 s when its front comes warns for 35 s, and longer by 1 s and its bound over its speed at
    most; but for one in fifty, which brakes meanwhile, as every train does before Karasuyama: half a second longer.
    """
    kms = (0.35, 1.2, 2.5, 3.62, 3.76, 5.0, 5.85, 6.85, 8.0, 9.5, 11.2, 12.2)
    kms += (13.0, 14.55, 15.2, 16.5, 17.3, 18.5, 19.9)
    rows = [
        f'{{ id = "C{i}", section = "{"HSK-OGN" if km < 12.4 else "OGN-KRS"}", km = {km} }}'
        for i, km in enumerate(kms)
    ]
    covered = '"alignments.main.coverage" = [{ from_km = -1.0, to_km = 20.304 }]'
    head = 'extends = "karasuyama_weekday"\nid = "crossed"\nname = "Crossings of a weekday"\n[patch.line]\n'
    text = f"{head}set = {{ {covered} }}\nadd.crossings = [{', '.join(rows)}]\n"
    (tmp_path / "crossed.toml").write_text(text, encoding="utf-8")
    with simulation_of(load_scenario(str(tmp_path / "crossed.toml")).setup) as simulation:
        result = simulation.run()
    assert list(broken_rules(result)) == []
    lit_s: dict[str, float] = {}
    left_s: dict[str, float] = {}
    warned_s: list[float] = []
    over_s: list[float] = []
    for entry in result.journal.entries:
        match entry.event:
            case CrossingLamps(crossing_id=crossing_id, lit=True):
                lit_s[crossing_id] = entry.t_s
            case Departs():
                left_s[entry.who] = entry.t_s
            case CrossingEntered(unit_id=unit_id, crossing_id=crossing_id, speed_mps=speed_mps):
                if entry.t_s - left_s[unit_id] < 45.0:
                    continue
                begun_s = lit_s[crossing_id]
                warned_s.append(entry.t_s - begun_s)
                trace = result.trace[result.trace["slot"] == result.stock_ids.index(unit_id)]
                row = trace[trace["step"] <= round(begun_s / STEP_S)][-1]
                beyond_m = max(float(row["bound_ahead_m"] + row["estimate_error_m"]), 0.0)
                over_s.append(warned_s[-1] - 36.0 - beyond_m / speed_mps)
            case _:
                pass
    constant = sum(over <= 0.0 for over in over_s)
    figures = f"{constant} of {len(warned_s)} warned for 35 s to 1 s and bound over speed"
    record_property("figures", f"{figures}; all for {min(warned_s):.1f} to {max(warned_s):.1f} s")
    assert len(warned_s) > 300
    assert min(warned_s) >= 34.0
    assert constant >= 0.98 * len(warned_s)
    assert max(over_s) < 0.5
