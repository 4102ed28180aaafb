"""Deliberate defects: one behaviour switched off at a time, and a named checker or expectation must see it.

`DEFECTS` is the table: what is wrong, in which scenario (of the folder `defects`, or shipped), which switch of
`conftest` makes it so, and who must catch it: checkers by name, expectations by their text, all of those given.
`given` is misbehaviour of somebody against whom the behaviour protects, such as a unit that commands points it does
not hold. Without the defect every scenario, its misbehaviour included, ends with nothing broken and all it expects.
"""

from dataclasses import dataclass
from typing import Final

import pytest

from simulation.judge.checkers import Checker
from study.runner.run import CarrierKind
from tests.nightly import others_nightly
from tests.system.switchboard import RunWith


@dataclass(frozen=True)
class Defect:
    """One row of the table."""

    name: str
    scenario: str
    off: str
    caught_by: tuple[Checker | str, ...]
    given: str = ""


DEFECTS: Final = (
    Defect(
        "a section is granted that another holds",
        "two_trains",
        "grants_what_another_holds",
        (Checker.NO_DOUBLE_GRANT, Checker.SUMO_COLLISION),
    ),
    Defect(
        "grants in the undefined state",
        "manager_loses_its_register",
        "grants_while_undefined",
        (Checker.UNDEFINED_GRANTS_NOTHING, Checker.ONE_TRAIN_A_SECTION),
    ),
    Defect(
        "a restart sets every section free",
        "manager_loses_its_register",
        "starts_with_every_section_free",
        (Checker.UNDEFINED_GRANTS_NOTHING, Checker.ONE_TRAIN_A_SECTION),
    ),
    Defect(
        "a picture accepted without a silent unit",
        "manager_loses_its_register",
        "accepts_a_picture_without_the_silent",
        # What such a picture frees is run through on sight at first: K2 stops before K1, and both stay there.
        (Checker.INSIDE_HOLDING, Checker.EVERYONE_ARRIVES),
    ),
    Defect(
        "tokens begin anew after a restart",
        "manager_loses_its_register",
        "tokens_begin_anew",
        (Checker.TOKENS_GROW,),
    ),
    Defect(
        "leave to come in for two at once",
        "rtri/78_comes_in_at_once",
        "lets_all_come_in",
        (Checker.ONE_COMES_IN, "T2 is not let over the points before T1 stands"),
    ),
    Defect("silence frees what a unit holds", "two_trains", "silence_frees", (Checker.INSIDE_HOLDING,)),
    Defect(
        "the block manager refuses everything",
        "rtri_test_line",
        "refuses_everything",
        (Checker.EVERYONE_ARRIVES,),
    ),
    Defect(
        "what was refused is never asked for again",
        "two_trains",
        "never_asks_again",
        (Checker.NO_DEAD_STATE, Checker.EVERYONE_ARRIVES),
    ),
    Defect(
        "a unit's timers are dropped",
        "rtri_test_line",
        "drops_its_timers",
        (Checker.NO_DEAD_STATE, Checker.EVERYONE_ARRIVES),
    ),
    Defect(
        "points thrown without the token",
        "two_trains",
        "throws_for_anyone",
        (Checker.NO_THROW_UNDER_TRAIN, Checker.POINTS_UNDER_TRAIN),
        "commands_what_it_does_not_hold",
    ),
    Defect(
        "points thrown for a token that is out of date",
        "two_trains",
        "obeys_an_old_token",
        (Checker.POINTS_UNDER_TRAIN,),
        "repeats_an_old_command",
    ),
    Defect(
        "points proven that were not detected",
        "stuck_points",
        "proves_what_it_has_not_detected",
        (Checker.PROVEN_BEFORE_ENTRY, "the train waits before the points"),
    ),
    Defect(
        "sections given back by the front instead of the safe rear",
        "rtri_test_line",
        "releases_at_the_front",
        (Checker.RELEASE_BEHIND_REAR,),
    ),
    Defect(
        "no wait for the proof of points",
        "terminal_out_of_reach",
        "does_not_wait_for_proof",
        (Checker.PROVEN_BEFORE_ENTRY, "the train waits before the points"),
    ),
    Defect(
        "a train runs beyond what it holds",
        "two_trains",
        "runs_beyond_what_it_holds",
        (Checker.INSIDE_HOLDING, Checker.SUMO_COLLISION),
    ),
    Defect(
        "a withdrawn proof still counts",
        "points_turned_by_hand",
        "ignores_a_withdrawn_proof",
        (Checker.PROVEN_BEFORE_ENTRY, "the proof is withdrawn"),
    ),
    Defect(
        "a claim of less than is held",
        "manager_restarts_before_departure",
        "claims_only_where_it_stands",
        # The register then has less than the unit holds, and the train is stopped, as section 5 of the paper has it.
        (Checker.EVERYONE_ARRIVES, "K1 claims all that it was granted"),
    ),
    Defect(
        "a tag accepted outside its window",
        "wrong_tag",
        "believes_any_tag",
        (Checker.WITHIN_BOUNDS, "the unit does not believe it and stops"),
    ),
    Defect(
        "a missing tag is not noticed",
        "missed_tag",
        "expects_no_tag",
        ("the unit finds the tag overdue and stops",),
    ),
    Defect(
        "the bounds of the position do not grow",
        "worn_wheels",
        "bounds_do_not_grow",
        (Checker.WITHIN_BOUNDS,),
    ),
    Defect(
        "full speed after a restart",
        "unit_restart",
        "restarts_at_full_speed",
        ("on sight until position and holdings are known",),
    ),
    Defect(
        "supervision leaves no room to brake",
        "terminal_out_of_reach",
        "supervision_trusts_any_brake",
        (Checker.PROVEN_BEFORE_ENTRY, "the train waits before the points"),
        "service_brake_is_weak",
    ),
    Defect(
        "the crew does not look at the points",
        "on_sight_to_stuck_points",
        "crew_does_not_look",
        (Checker.POINTS_UNDER_TRAIN,),
    ),
    Defect(
        "the crew does not lock the points that it passes",
        "points_never_commanded",
        "crew_does_not_lock",
        (Checker.NO_THROW_UNDER_TRAIN, Checker.POINTS_UNDER_TRAIN),
        "commands_after_the_look",
    ),
    Defect(
        "a telegram takes effect twice",
        "everything_twice",
        "accepts_telegrams_twice",
        (Checker.TELEGRAM_ONCE, "the unit drops second copies", "the manager drops second copies"),
    ),
    Defect(
        "a telegram takes effect twice at manager and terminals",
        "everything_twice",
        "ground_accepts_telegrams_twice",
        (
            Checker.TELEGRAM_ONCE,
            "the manager drops second copies",
            "the terminal of the departure points drops second copies",
        ),
    ),
    Defect(
        "a telegram takes effect twice at a unit",
        "everything_twice",
        "units_accept_telegrams_twice",
        (Checker.TELEGRAM_ONCE, "the unit drops second copies"),
    ),
    Defect(
        "an old grant obeyed after a restart",
        "grant_comes_after_a_restart",
        "obeys_an_earlier_boot",
        (Checker.INSIDE_HOLDING, "K1 drops the grant of the manager's earlier boot"),
    ),
    Defect(
        "a telegram believed whatever its code",
        "two_trains",
        "believes_any_code",
        (Checker.INSIDE_HOLDING,),
        "forges_a_report",
    ),
    Defect(
        "a portal is free as soon as its train may leave",
        "rtri/58b_portal_unit_power",
        "frees_a_portal_at_the_sign_off",
        (Checker.INSIDE_HOLDING, Checker.ONE_TRAIN_A_SECTION),
    ),
    Defect(
        "a barred unit's sections are free",
        "rtri/59_unit_barred",
        "frees_what_a_barred_unit_holds",
        (Checker.ONE_TRAIN_A_SECTION, "T3 does not come into its section"),
    ),
    Defect(
        "nobody can be barred",
        "rtri/59b_unit_claims_falsely",
        "bars_nobody",
        ("two persons bar the mad unit", "and say where its train is", "the line goes on while it is mad"),
    ),
    Defect(
        "a unit runs over a level crossing that has not proved closed",
        "crossing_link",
        "passes_unproven_crossings",
        (Checker.CROSSING_OPEN,),
    ),
    Defect(
        "a unit comes onto a level crossing as soon as that has proved closed",
        "crossing_asked_late",
        "keeps_no_least_time",
        (Checker.CROSSING_WARNING,),
    ),
    Defect(
        "a unit's map lacks a limit",
        "slow_stretch",
        "knows_no_limits",
        (Checker.TOO_FAST,),
    ),
)

# One for each checker.
EVERY_RUN: Final = tuple(
    defect
    for defect in DEFECTS
    if defect.off
    in {
        "grants_what_another_holds",
        "grants_while_undefined",
        "passes_unproven_crossings",
        "keeps_no_least_time",
        "knows_no_limits",
        "lets_all_come_in",
        "tokens_begin_anew",
        "silence_frees",
        "never_asks_again",
        "throws_for_anyone",
        "proves_what_it_has_not_detected",
        "releases_at_the_front",
        "bounds_do_not_grow",
        "crew_does_not_look",
        "accepts_telegrams_twice",
        "obeys_an_earlier_boot",
        "believes_any_code",
    }
)
BASELINES: Final = sorted({(defect.scenario, defect.given) for defect in DEFECTS})
BASELINES_OF_EVERY_RUN: Final = {(defect.scenario, defect.given) for defect in EVERY_RUN[::3]}


def id_of(case: Defect | tuple[str, str]) -> str:
    return case.name.replace(" ", "-") if isinstance(case, Defect) else "-".join(filter(None, case))


@pytest.mark.parametrize("baseline", others_nightly(BASELINES, BASELINES_OF_EVERY_RUN), ids=id_of)
def test_nothing_is_broken_without_a_defect(baseline: tuple[str, str], run_with: RunWith) -> None:
    run, objections = run_with(*baseline)
    assert run.broken == ()
    assert objections == set()


@pytest.mark.parametrize("defect", others_nightly(DEFECTS, EVERY_RUN[::3]), ids=id_of)
def test_a_defect_is_caught(defect: Defect, run_with: RunWith) -> None:
    _, objections = run_with(defect.scenario, defect.given, defect.off)
    assert set(map(str, defect.caught_by)) <= objections


COLLIDING: Final = tuple(defect for defect in DEFECTS if Checker.SUMO_COLLISION in defect.caught_by)


@pytest.mark.parametrize("defect", others_nightly(DEFECTS, COLLIDING), ids=id_of)
def test_a_defect_is_the_same_run_on_sumo(
    defect: Defect, run_with: RunWith, monkeypatch: pytest.MonkeyPatch
) -> None:
    on_plain, objections = run_with(defect.scenario, defect.given, defect.off)
    monkeypatch.undo()  # some switches count what they did
    on_sumo, others = run_with(defect.scenario, defect.given, defect.off, carrier=CarrierKind.SUMO)
    assert on_plain.result.digest == on_sumo.result.digest
    assert on_plain.result.collisions == on_sumo.result.collisions
    assert others == objections
    if defect in COLLIDING:
        assert on_plain.result.collisions


def test_every_checker_catches_some_defect() -> None:
    """But `no-jump`, which no behaviour of a party could break: it watches the carrier; and `pilots-leave`, which only
    people can break: what is left out of substitute working does (test_substitute).
    """
    for defects in (DEFECTS, EVERY_RUN):
        catching = {name for defect in defects for name in defect.caught_by if isinstance(name, Checker)}
        assert set(Checker) - catching == {Checker.NO_JUMP, Checker.PILOTS_LEAVE}


def test_every_defect_has_a_name_and_a_switch_of_its_own(switch_names: frozenset[str]) -> None:
    assert len({defect.name for defect in DEFECTS}) == len({defect.off for defect in DEFECTS}) == len(DEFECTS)
    assert len(DEFECTS) >= 12
    assert {defect.off for defect in DEFECTS} <= switch_names
