"""Substitute working: followed, nothing breaks; with any steps left out, checkers and positions say the same of it."""

from dataclasses import replace
from pathlib import Path
from typing import Final

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from documents.steps_left_out import outcome_of, shared_sections, without
from onboard.notes import MissionDone
from scenario.scenario import Scenario, load_scenario
from simulation.events import CutOut, ProcedureStep, StepLeftOut, UnitRestrains
from simulation.judge.checkers import Checker
from simulation.judge.log import Log
from simulation.procedure import PROCEDURES, Regime, WorkingStep, rows_of_train
from simulation.substitute import by_hand, players, sight
from simulation.substitute_settings import LeftOutStep
from study.drilling.drill import find_drill
from tests.nightly import A_FIFTH, others_nightly
from tests.plain import drill_of, drill_on_plain, run_on_plain
from tests.trains import timetable_of

DRILL: Final = "rtri/95_substitute_working"
# K2's unit dies as it stands in the first section, where the other end could let nobody in.
STANDS: Final = """
extends = "rtri_test_line"
id = "stands"
name = "A train stands in the section"
timetable = "rtri_two_trains"
people = { react = true, notice_s = 20.0, reach_s = 60.0 }
limits = { time_limit_s = 3600.0 }
substitute = { staffed = ["A", "B"], speed_kmh = 35.0 }

[[fault]]
kind = "power_off"
target = "block-manager"
start = "10:00:10"
duration_s = 1600.0

[[fault]]
kind = "power_off"
target = "K1"
start = "10:00:38"
duration_s = 1200.0
"""
AGAIN_TIMES: Final = timetable_of(
    "times",
    "rtri_test_line",
    "T1 down, stabled to portal:PE: A 1 -/10:06:00; B 1 10:08:00/10:09:00",
    "T2 up, portal:PE to stabled: B 2 10:25:00/-",
    dwell_min_s=20,
    K1="T1 T2",
)
AGAIN: Final = """
extends = "rtri_test_line"
id = "again"
name = "A stock that leaves the line and comes again"
timetable = "times.toml"
people = { react = true, notice_s = 20.0, reach_s = 60.0 }
substitute = { staffed = ["A", "B"], speed_kmh = 35.0 }

[[fault]]
kind = "power_off"
target = "block-manager"
start = "10:00:00"
duration_s = 3600.0
"""
STEPS: Final = [row.step for row in PROCEDURES[Regime.TELEPHONE]]


def _scenario(regime: Regime = Regime.TELEPHONE, drill: str = DRILL) -> Scenario:
    scenario = load_scenario(find_drill(drill))
    setup = scenario.setup
    assert setup.substitute is not None
    substitute = setup.substitute.model_copy(update={"regime": regime})
    return replace(scenario, setup=replace(setup, substitute=substitute))


def _stands(folder: Path) -> Scenario:
    file = folder / "stands.toml"
    file.write_text(STANDS, "utf-8")
    return load_scenario(str(file))


@pytest.mark.parametrize("regime", [Regime.TELEPHONE, Regime.DISPATCHER])
def test_followed_no_rule_breaks_and_all_arrive(regime: Regime) -> None:
    result = run_on_plain(_scenario(regime)).result
    assert result.violations == ()
    assert not result.unfinished
    done = [e.event.step for e in result.journal.entries if isinstance(e.event, ProcedureStep)]
    rows = rows_of_train(PROCEDURES[regime], ticket=False)
    assert {row.step.value for row in rows} <= set(done)
    assert any(isinstance(entry.event, CutOut) for entry in result.journal.entries)
    assert not shared_sections(result, _scenario().setup.line, _scenario().setup.lengths_m)


@pytest.mark.parametrize("by_road", [True, False])
def test_a_pilot_goes_by_road_to_where_no_train_brings_him(
    by_road: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By 指導指令式 there are no tickets: he has ridden with T1, and T3 waits for him where that came from."""
    monkeypatch.setattr(sight, "BY_ROAD", by_road)
    scenario = _scenario(Regime.DISPATCHER, "rtri/95b_pilots_ticket")
    setup = scenario.setup
    near = replace(setup, people=setup.people.model_copy(update={"reach_s": 300.0}))
    result = run_on_plain(replace(scenario, setup=near)).result
    told = [entry for entry in result.journal.entries if isinstance(entry.event, ProcedureStep)]
    boards = [t.t_s for t in told if (t.event.step, t.event.block) == ("board", "6")]  # type: ignore[union-attr]
    assert len(boards) == 1 + by_road
    assert result.violations == ()


def test_a_stock_that_has_left_by_hand_comes_in_again(tmp_path: Path) -> None:
    """Its unit is cut out already; within the hour that the manager is off it is at B."""
    (tmp_path / "times.toml").write_text(AGAIN_TIMES, "utf-8")
    (tmp_path / "again.toml").write_text(AGAIN, "utf-8")
    result = run_on_plain(tmp_path / "again.toml").result
    done = {e.event.train: e.t_s for e in result.journal.entries if isinstance(e.event, MissionDone)}
    assert done["T2"] < 11 * 3600.0
    assert result.violations == ()


def test_a_unit_that_remembers_what_was_before_it_was_cut_out_claims_what_is_not_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(by_hand, "FORGETS", False)
    assert any(
        violation.checker == Checker.INSIDE_HOLDING
        for violation in run_on_plain(_scenario()).result.violations
    )


def test_nobody_is_let_in_while_a_train_stands_in_the_section(tmp_path: Path) -> None:
    scenario = _stands(tmp_path)
    assert not outcome_of(scenario).by_positions
    unasked = outcome_of(without(scenario, LeftOutStep(step=WorkingStep.CLEAR), until_s=38_000.0))
    assert unasked.by_positions
    assert unasked.by_checkers
    assert unasked.pilots_rule


def test_a_unit_that_is_not_cut_out_does_not_let_the_train_go() -> None:
    scenario = without(_scenario(), LeftOutStep(step=WorkingStep.CUT_OUT), until_s=float("inf"))
    result = run_on_plain(scenario).result
    assert any(isinstance(entry.event, UnitRestrains) for entry in result.journal.entries)
    assert not [v for v in result.violations if v.checker == Checker.ONE_TRAIN_A_SECTION]


def test_a_step_is_left_out_for_one_train_alone() -> None:
    left = LeftOutStep(step=WorkingStep.AGREE, block="1", train="T3")
    result = run_on_plain(without(_scenario(), left, until_s=float("inf"))).result
    told = [e.event for e in result.journal.entries if isinstance(e.event, StepLeftOut)]
    assert [(t.step, t.block, t.train) for t in told] == [("agree", "1", "T3")]
    assert [v.subject for v in result.violations] == ["1 K2"]


OMISSIONS = st.sets(st.sampled_from(STEPS), max_size=6)


@pytest.fixture(scope="module")
def days(tmp_path_factory: pytest.TempPathFactory) -> tuple[Scenario, Scenario]:
    return _scenario(), _stands(tmp_path_factory.mktemp("days"))


@given(steps=OMISSIONS, stands=st.booleans())
@example(steps={WorkingStep.CLEAR}, stands=True)
@example(steps={WorkingStep.MAN, WorkingStep.AGREE, WorkingStep.ARRIVED}, stands=False)
@settings(A_FIFTH, suppress_health_check=list(HealthCheck))
def test_whatever_is_left_out_checkers_and_positions_agree(
    steps: set[WorkingStep], stands: bool, days: tuple[Scenario, Scenario]
) -> None:
    left = [LeftOutStep(step=step) for step in sorted(steps)]
    found = outcome_of(without(days[stands], *left, until_s=38_000.0))
    if not any("wrong way" in danger for danger in found.unsafe):  # where it went then is not in the plan
        assert bool(found.by_positions) is found.by_checkers
    assert found.by_checkers or not found.by_positions
    if not steps:
        assert not found.pilots_rule and not found.by_positions


def test_a_checker_that_sees_no_train_in_a_section_is_noticed(
    days: tuple[Scenario, Scenario], monkeypatch: pytest.MonkeyPatch
) -> None:
    note = Log.note

    def blind(
        self: Log, t_s: float, checker: Checker, subject: str, text: str, *, outside: bool = False
    ) -> None:
        if checker is not Checker.ONE_TRAIN_A_SECTION:
            note(self, t_s, checker, subject, text, outside=outside)

    monkeypatch.setattr(Log, "note", blind)
    found = outcome_of(without(days[1], LeftOutStep(step=WorkingStep.CLEAR), until_s=38_000.0))
    assert found.by_positions and not found.by_checkers


def test_the_drill_passes() -> None:
    assert drill_on_plain(DRILL).passed


@pytest.mark.parametrize("need_not", [True, False])
def test_a_section_that_never_had_a_pilot_need_not_be_empty_as_the_working_ends(
    need_not: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K1 has lost its power between the stations, and waits for the picture, which waits for K2 to be cut in."""
    monkeypatch.setattr(players, "NEED_NOT_BE_EMPTY", need_not)
    result = drill_of(
        tmp_path,
        f'extends = "{find_drill(DRILL)}"\nid = "off"\nexpect = []\nlimits.time_limit_s = 1200.0\n'
        '[[patch.fault.add]]\nkind = "power_off"\ntarget = "K1"\nstart = "10:00:41"\nduration_s = 60.0\n',
    ).run.result
    broken = {violation.checker for violation in result.violations}
    assert broken == (set() if need_not else {Checker.EVERYONE_ARRIVES})


def test_a_unit_cut_in_without_power_is_not_held_to_what_it_held_before(tmp_path: Path) -> None:
    """Its telegrams are lost as it asks for its first route, so people alone say where it stands, and it is dark."""
    run = drill_of(
        tmp_path,
        f'extends = "{find_drill(DRILL)}"\nid = "lost"\nexpect = []\n'
        '[[patch.fault.add]]\nkind = "cut"\ntarget = "K1 -> block-manager"\nstart = "09:59:14.9"\nduration_s = 60.0\n',
    ).run
    assert run.result.violations == ()
    assert not run.result.unfinished


# K2 comes from the east to track 1 of B, and is to be gone again before K1 comes there from A.
ONE_TRACK: Final = timetable_of(
    "one_track",
    "rtri_test_line",
    "T2 up, portal:PE to becomes:T3: B 1 10:02:00/-",
    "T3 down, from:T2 to portal:PE: B 1 -/10:06:00",
    "T1 down, stabled to stabled: A 1 -/10:10:00; B 1 10:12:00/-",
    dwell_min_s=20,
    K2="T2 T3",
    K1="T1",
)
MEET: Final = {
    # Both come late, as staff take a quarter of an hour to B: each is next in the book of its section.
    "two books": (("A",), 900.0, "09:57:00", ""),
    # K2 stands before the line with its way into B, which its unit alone knows of, and a door that is open.
    "authority": (
        ("A", "B"),
        60.0,
        "10:01:30",
        '[[fault]]\nkind = "doors"\ntarget = "K2"\nstart = "09:58:30"\nduration_s = 890.0\n',
    ),
}


@pytest.mark.parametrize("looks", [True, False])
@pytest.mark.parametrize("how", others_nightly(MEET, ["two books"]))
def test_two_are_not_let_into_one_track(
    how: str, looks: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not looks:
        monkeypatch.setattr(
            sight.LineSight, "_may_be_let_in", lambda self, hop, ids: self._are_free(ids, hop.stock_id)
        )
    staffed, reach_s, off, fault = MEET[how]
    (tmp_path / "one_track.toml").write_text(ONE_TRACK, "utf-8")
    file = tmp_path / "meet.toml"
    file.write_text(
        'extends = "rtri_test_line"\nid = "meet"\nname = "meet"\ntimetable = "one_track.toml"\n'
        f"people = {{ react = true, notice_s = 20.0, reach_s = {reach_s}, sigma = 0.0 }}\n"
        "limits = { stall_limit_s = 10800.0 }\n"
        f"substitute = {{ staffed = {list(staffed)}, speed_kmh = 35.0 }}\n{fault}"
        f'[[fault]]\nkind = "power_off"\ntarget = "block-manager"\nstart = "{off}"\nduration_s = 3600.0\n',
        "utf-8",
    )
    result = run_on_plain(file).result
    met = [v for v in result.violations if v.checker == Checker.ONE_TRAIN_A_SECTION.value]
    assert bool(met) is not looks
    assert bool(result.unfinished) is (not looks and how == "authority")


def test_a_manager_that_fails_again_as_its_sections_are_handed_back_holds_nobody_up(tmp_path: Path) -> None:
    """One section is ended a minute after it is back, another is not as it fails for two hours more."""
    text = Path(find_drill("karasuyama/95_substitute_working")).read_text("utf-8").partition("[[expect]]")[0]
    again = text[text.index("[[fault]]") :].replace('"06:44:00"', '"08:45:00"')
    file = tmp_path / "again.toml"
    file.write_text(text + again, "utf-8")
    run = run_on_plain(without(load_scenario(str(file)), until_s=11.5 * 3600.0))
    ordered = [
        entry.event.block
        for entry in run.result.journal.entries
        if isinstance(entry.event, ProcedureStep) and entry.event.step == WorkingStep.ORDER.value
    ]
    assert {block: ordered.count(block) for block in ordered} == {"OGN-KRS": 2, "HSK-OGN": 1, "HSK": 2}
    assert run.result.violations == ()
    assert run.summary["late_s_max"] < 7200.0  # nobody waited for its power
