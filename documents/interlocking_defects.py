"""Rules of the interlocking and what notices when one is taken away, as data. A test holds every name to what exists.

Each was switched off by hand, and the test named failed; those of `tests/system` run whole lines with the defect.
"""

from __future__ import annotations

from typing import Final, NamedTuple


class GuardedRule(NamedTuple):
    """A rule, the module that keeps it, and a test that fails without it: file::function, from `tests/`."""

    rule: str
    module: str
    test: str


CAUGHT: Final = (
    GuardedRule(
        "a disputed unit blocks the line",
        "wayside.register",
        "wayside/test_contradictions.py::test_a_disputed_unit_blocks_the_line",
    ),
    GuardedRule(
        "points count as entered by the certain front",
        "onboard.duty.machine",
        "onboard/duty/test_machine.py::test_points_count_as_entered_only_where_the_front_surely_is",
    ),
    GuardedRule(
        "the same when normal running is resumed",
        "onboard.duty.on_sight",
        "onboard/duty/test_machine.py::test_resuming_it_counts_only_points_as_entered_where_the_front_surely_is",
    ),
    GuardedRule(
        "what is entered and proved counts on this mission alone",
        "onboard.duty.machine",
        "onboard/duty/test_properties.py::test_every_state_reached_first_keeps_the_rules",
    ),
    GuardedRule(
        "arrival points are kept until the train stands, where others must not come in before",
        "onboard.duty.entering",
        "onboard/duty/test_entering.py::test_arrival_points_are_kept_until_it_stands",
    ),
    GuardedRule(
        "a route is not given back while moving",
        "onboard.duty.machine",
        "onboard/duty/test_machine.py::test_row",
    ),
    GuardedRule(
        "throws that may be under the front are withdrawn, when the position is lost, too",
        "onboard.duty.on_sight",
        "onboard/duty/test_machine.py::test_row",
    ),
    GuardedRule(
        "an ambiguous tag fixes nothing",
        "onboard.localisation.tags",
        "onboard/localisation/test_tags.py::test_an_ambiguous_tag_fixes_nothing",
    ),
    GuardedRule(
        "after a restart the old position is not believed",
        "onboard.motion",
        "onboard/test_unit.py::test_switched_on_again_it_knows_nothing_and_stands_braked",
    ),
    GuardedRule(
        "normal speed needs the manager's word",
        "onboard.duty.on_sight",
        "onboard/duty/test_machine.py::test_row",
    ),
    GuardedRule(
        "an old request after a restart is not a repetition",
        "wayside.block_manager",
        "wayside/test_block_manager.py::test_a_request_of_a_new_boot_is_no_repetition_of_the_old_ones",
    ),
    GuardedRule(
        "a claim that is not fresh is none",
        "wayside.block_manager",
        "wayside/test_block_manager.py::test_a_claim_that_may_date_from_before_the_restart_is_asked_again",
    ),
    GuardedRule(
        "an acceptance dies with a new contradiction",
        "wayside.reentry",
        "wayside/test_silent_units.py::test_an_acceptance_dies_with_a_new_contradiction",
    ),
    GuardedRule(
        "a unit that has booted says that it does not know",
        "host.unit",
        "host/test_unit_memory.py::test_after_a_boot_it_claims_nothing_only_if_it_was_surely_off_the_line",
    ),
    GuardedRule(
        "an empty claim of a unit on the ledger is swept for",
        "wayside.reentry",
        "wayside/test_forgetful_units.py::test_an_empty_claim_of_one_that_was_on_the_line_is_shown_and_the_line_is_swept",
    ),
    GuardedRule(
        "a blank store is no first start",
        "host.boot",
        "host/test_store.py::test_a_store_is_blank_until_people_commission_it",
    ),
    GuardedRule(
        "the store is on disk (fsync) before it counts",
        "host.store",
        "host/test_store.py::test_it_is_on_the_disk_before_it_takes_the_place_of_the_old_one",
    ),
    GuardedRule(
        "what changes is kept before a telegram leaves",
        "host.device",
        "host/test_device.py::test_what_changes_is_kept_before_a_telegram_of_it_is_made",
    ),
    GuardedRule(
        "a frozen party keeps what piled up",
        "simulation.cabs",
        "simulation/world/test_frozen.py::test_a_frozen_unit_keeps_what_piled_up",
    ),
    GuardedRule(
        "slippery is slippery",
        "simulation.faults.rail",
        "simulation/faults/test_fold.py::test_at_every_time_a_quantity_is_what_those_in_force_make_of_it",
    ),
    GuardedRule(
        "points run through are forced, and stay so until repaired",
        "simulation.world.point_machine",
        "simulation/world/test_point_machine.py::test_forced_open_until_repaired",
    ),
    GuardedRule(
        "running onto points in no position is noted",
        "simulation.toes",
        "simulation/test_cross_points.py::test_towards_the_blades",
    ),
    GuardedRule(
        "release waits for the tag",
        "onboard.duty.arrival",
        "onboard/test_release.py::test_without_the_tag_it_would",
    ),
    GuardedRule(
        "the odometer is a second condition of the release",
        "onboard.duty.arrival",
        "onboard/test_unit.py::test_after_the_tag_sections_are_given_back_by_the_safe_rear",
    ),
    GuardedRule(
        "a virtual tag waits for a fix beyond it",
        "onboard.localisation.places",
        "onboard/test_fixes.py::test_no_place_is_passed_before_a_fix_proves_it",
    ),
    GuardedRule(
        "a position is found only where the register has the train",
        "onboard.fixes",
        "onboard/test_fixes.py::test_and_nowhere_else",
    ),
    GuardedRule(
        "a boot that persons spoke for is challenged",
        "wayside.block_manager",
        "wayside/test_acts.py::test_what_a_boot_says_that_persons_spoke_for_is_challenged",
    ),
    GuardedRule(
        "an accepted sign-off frees nothing",
        "wayside.leaving",
        "wayside/test_leaving.py::test_what_is_switched_off_is_seen",
    ),
    GuardedRule(
        "barring frees nothing",
        "wayside.acts",
        "wayside/test_barring.py::test_what_is_switched_off_is_seen",
    ),
    GuardedRule(
        "nobody waits for nothing",
        "simulation.judge.liveness",
        "onboard/duty/test_properties.py::test_every_state_reached_first_keeps_the_rules",
    ),
)
