"""Each shipped drill of the paper's line fails when the behaviour that it checks is switched off.

Switches are those of `conftest`, by name, and those that no other test needs, here.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

import msgspec
import pytest

from onboard.authority import machine as authority
from onboard.authority import records as sym
from onboard.authority.records import Authority
from onboard.authority.tables import Result, SignOnStanding
from onboard.duty import entering as duty_entering
from onboard.duty import fitness
from onboard.duty import machine as duty_machine
from onboard.duty import orders as duty_orders
from onboard.duty.records import DrivingCommand, Sensed
from onboard.fixes import Fixes
from onboard.localisation.places import Places
from onboard.mission import Mission
from onboard.motion import UnitMotion
from onboard.records import PathData
from onboard.unit import OnboardUnit, Report, UnitAnswer
from radio.envelope import header_of
from simulation.judge.checkers import Checker
from simulation.substitute import by_hand, players
from simulation.world.cable import Cable
from simulation.world.crew import Crew
from simulation.world.on_board import OnBoard
from simulation.world.points import WaysideWorld
from study.drilling.drill import shipped_drills
from tests.nightly import others_nightly
from tests.system.switchboard import RunWith, Switch
from tests.system.switches_on_board import believes_any_tag
from wayside import dispatch, orders
from wayside.config import MANAGER_ID, TerminalConfig, terminal_configs
from wayside.dispatch import DispatchRequest
from wayside.register import Against, Register

FOLDER: Final = "rtri/"
TRAIN_M: Final = 40.0


def remembers_while_cut_out(patch: pytest.MonkeyPatch) -> None:
    """A unit that is cut in again takes what it last knew for what is so."""
    patch.setattr(by_hand, "FORGETS", False)


def gives_no_tickets(patch: pytest.MonkeyPatch) -> None:
    """A pilot rides with every train, and is where the next one is not."""
    patch.setattr(players, "TICKETS", False)


def turns_without_its_position(patch: pytest.MonkeyPatch) -> None:
    """Changes ends, and takes the place of the old front for that of the new one."""
    turn = UnitMotion.turn

    def turned(self: UnitMotion, mission: Mission, path: PathData) -> None:
        turn(self, mission, path)
        self.row.position_m -= TRAIN_M

    patch.setattr(UnitMotion, "turn", turned)


def reports_once(patch: pytest.MonkeyPatch) -> None:
    """A report goes out once; the answer to it, or another, is not waited for."""
    say = authority.say

    def once(state: Authority) -> Result:
        after, actions = say(state)
        said = any(
            isinstance(a, sym.SendRequest) and a.request.ask is sym.RequestKind.REPORT for a in actions
        )
        left = tuple(r for r in after.requests if r.ask is not sym.RequestKind.REPORT)
        return (msgspec.structs.replace(after, requests=left) if said else after), actions

    patch.setattr(authority, "say", once)


def obeys_only_while_it_hears_the_manager(patch: pytest.MonkeyPatch) -> None:
    """Authority with a lease: 20 s after the manager's last word the train may not go on."""
    advance, obey, heard_s = OnboardUnit.advance, UnitMotion.obey, [math.inf]

    def heard(self: OnboardUnit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> UnitAnswer:
        sources = [header.source for data in telegrams if (header := header_of(data)) is not None]
        heard_s[0] = now_s if MANAGER_ID in sources else heard_s[0]
        return advance(self, now_s, telegrams, sensed)

    def obeyed(self: UnitMotion, command: DrivingCommand, now_s: float) -> None:
        obey(self, command, now_s)
        if command.target is not None and now_s - heard_s[0] > 20.0:
            self.row.stop_limit_m = self.row.position_m

    patch.setattr(OnboardUnit, "advance", heard)
    patch.setattr(UnitMotion, "obey", obeyed)


def releases_whole_routes(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(duty_machine, "releases_at_each", lambda *_: False)


def gives_points_back_running(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(duty_entering, "KEEPS", False)


def grants_no_part(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(dispatch, "free_part", lambda *_: ())


def refuses_in_silence(patch: pytest.MonkeyPatch) -> None:
    """A unit that does not do what was ordered tells nobody."""
    patch.setattr(duty_orders, "refuse", lambda *_: None)


def orders_nothing(patch: pytest.MonkeyPatch) -> None:
    def decided(register: Register, asked: DispatchRequest, against: Against | None) -> orders.Decision:
        register, against, shows = dispatch.weigh_request(register, asked, against)
        return orders.Decision(register, against, actions=shows)

    patch.setattr(orders, "decide", decided)


def keeps_a_route_set_back(patch: pytest.MonkeyPatch) -> None:
    table = dict(authority.TABLE)
    table[SignOnStanding.ON_LINE, sym.GiveBack] = lambda state, _event: (state, ())
    patch.setattr(authority, "TABLE", MappingProxyType(table))


def crew_does_not_stop_before_points(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Crew, "_unproven", lambda *_: [])


def ignores_position_faults(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(UnitMotion, "_lose", lambda *_, **_why: [])


def reads_no_tag_after_a_restart(patch: pytest.MonkeyPatch) -> None:
    read = UnitMotion.tag_read

    def blind(self: UnitMotion, tag_id: int, odometer_m: float) -> list[Sensed]:
        return [] if self.command.on_sight else read(self, tag_id, odometer_m)

    patch.setattr(UnitMotion, "tag_read", blind)


def points_unlock_without_power(patch: pytest.MonkeyPatch) -> None:
    power_off = WaysideWorld.power_off

    def unlocked(self: WaysideWorld, step: int, device_id: str) -> None:
        power_off(self, step, device_id)
        for points_id, terminal_id in self._terminal_of.items():
            if terminal_id == device_id:
                self.set_machine(step, replace(self.machines[points_id], locked=False))

    patch.setattr(WaysideWorld, "power_off", unlocked)


def terminal_allows_no_slower_throw(patch: pytest.MonkeyPatch) -> None:
    def strict(*args: Any) -> tuple[TerminalConfig, ...]:  # noqa: ANN401 - handed on
        configs = []
        for config in terminal_configs(*args):
            points = [msgspec.structs.replace(p, throw_limit_s=p.throw_limit_s / 1.5) for p in config.points]
            configs.append(msgspec.structs.replace(config, points=tuple(points)))
        return tuple(configs)

    patch.setattr("study.runner.devices.terminal_configs", strict)


def keeps_the_key_for_ever(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Crew, "give_keys_back", lambda *_: None)


def acknowledges_whatever_is_wrong(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(fitness, "acknowledged", lambda _turn: True)


def leaves_whatever_lies_ahead(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(fitness, "unable_now", lambda _turn: None)


def judges_no_time(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("radio.envelope.CLOCK_SKEW_MAX_S", math.inf)


def has_no_virtual_tags(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Places, "tags_proved", lambda _self: iter(()))


def believes_no_fix_after_a_restart(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Fixes, "_may_be_here", lambda *_, **__: False)


def reaches_over_a_cut(patch: pytest.MonkeyPatch) -> None:
    """A centre that is reached whatever becomes of its cable."""
    patch.setattr(Cable, "severed", False)


def says_everything_over_the_cable(patch: pytest.MonkeyPatch) -> None:
    """The cut of a cable takes away what goes by radio."""
    patch.setattr(Cable, "severed", property(lambda self: bool(self._cuts)))


# what it checks lies in compiled code that no test can patch: that slides widen the bounds (tests/onboard)
NOT_YET: Final = frozenset({"27_slippery_rail"})

LOW_SPEED: Final = "low speed until position and holdings are known"
NOT_ACCEPTED: Final = "nothing is granted before persons have accepted the picture"
NOT_WITHOUT: Final = "the unit is not taken for one that holds nothing"
NOTHING_GRANTED: Final = "nothing is granted while it is off or undefined"
# drill: switch, and one expectation or checker that must object
WITHOUT: Final[Mapping[str, tuple[str | Switch, str]]] = MappingProxyType(
    {
        "01_normal": ("releases_at_the_front", "no invariant is broken"),
        "02_turn_back": (turns_without_its_position, "no invariant is broken"),
        "03_block_held": ("grants_what_another_holds", "the request is refused: section 8 is held"),
        "04_unit_power_position_fixed": ("restarts_at_full_speed", LOW_SPEED),
        "05_unit_power_position_unknown": (
            crew_does_not_stop_before_points,
            "the train is stopped before the points and the crew looks how they lie",
        ),
        "05b_extra_tag": (reads_no_tag_after_a_restart, "it resumes before the points"),
        "06_unit_manager_link": (reports_once, "afterwards all together"),
        "07_unit_terminal_link": ("does_not_wait_for_proof", "no invariant is broken"),
        "08a_tachometer_scale": ("compares_no_axles", "another axle contradicts it"),
        "08b_tachometer_silent": ("restarts_at_full_speed", LOW_SPEED),
        "08c_tachometer_silent_at_start": (ignores_position_faults, "position fault"),
        "08d_tachometer_stuck": (ignores_position_faults, "position fault"),
        "09_manager_power": ("starts_with_every_section_free", NOTHING_GRANTED),
        "09b_manager_power_by_hand": ("starts_with_every_section_free", NOTHING_GRANTED),
        "10_manager_link": ("silence_frees", "no invariant is broken"),
        "11_terminal_link": ("does_not_wait_for_proof", "it does not enter them"),
        "12_terminal_power": ("does_not_wait_for_proof", "it does not enter them"),
        "12b_terminal_power_after_throw": (points_unlock_without_power, "no invariant is broken"),
        "13_tag_not_read": ("expects_no_tag", "position fault: the expected tag was not read"),
        "14a_manager_and_units_in_stations": ("claims_only_where_it_stands", "no invariant is broken"),
        "14b_manager_and_units_on_open_line": (
            "restarts_at_full_speed",
            "K2 runs at low speed until position and holdings are known",
        ),
        "14c_manager_and_units_one_each": ("starts_with_every_section_free", NOT_ACCEPTED),
        "15_crew_comes_late": ("forgets_that_it_was_on_the_line", NOT_WITHOUT),
        "16a_manager_store_lost": ("takes_a_lost_store_for_a_first_start", "it does not start by itself"),
        "16b_unit_store_lost": ("takes_a_lost_store_for_a_first_start", "it does not start by itself"),
        "16c_terminal_store_lost": ("takes_a_lost_store_for_a_first_start", "it does not start by itself"),
        "16d_terminal_store_lost_points_set": ("knows_not_who_relies_on_points", Checker.POINTS_UNDER_TRAIN),
        "20_route_given_back": (keeps_a_route_set_back, "then the manager frees it"),
        "21_points_stuck": ("proves_what_it_has_not_detected", "the train waits before them"),
        "22_points_no_detection": ("proves_what_it_has_not_detected", "but not proven"),
        "23_points_slow": (terminal_allows_no_slower_throw, "they are proven, later"),
        "24_manager_frozen": (obeys_only_while_it_hears_the_manager, "T1 runs on within what it holds"),
        "25_wrong_tag_id": ("believes_any_tag", "the unit does not believe it"),
        "26_tags_swapped": (believes_any_tag, "no invariant is broken"),
        "28_unit_restart_at_departure": ("restarts_at_full_speed", LOW_SPEED),
        "35_one_network_lost": ("hears_the_first_network_alone", "every telegram arrives over the other"),
        "35b_both_networks_lost": ("does_not_wait_for_proof", "no invariant is broken"),
        "40_clock_wrong": (judges_no_time, "the terminal drops its commands as of a time that cannot be"),
        "41_clock_drifts": (judges_no_time, "it does not enter them"),
        "42_doors": ("sees_no_vehicle", "no invariant is broken"),  # it moves off with its doors open
        "44_points_locked_by_crew": (keeps_the_key_for_ever, "every train reaches its station"),
        "45_tags_by_bits": ("expects_no_tag", "the unit finds that a tag is missing"),
        "50_unit_power_before_entry": ("keeps_the_emergency_latch", "and runs"),
        "51_not_at_its_mark": ("asks_no_driver", "it signs off and leaves"),
        "52_unit_frozen": (
            "does_not_wait_for_proof",
            "the train stops before the arrival points, which nobody has thrown",
        ),
        "53_word_without_a_place": ("asks_for_no_place", "their word is refused"),
        "53b_two_wrong_persons": (
            "runs_on_in_a_contradiction",
            "K1's train is stopped for the contradiction",
        ),
        "53c_wrong_word_taken_back": (
            "tells_nobody_of_a_contradiction",
            "K2's train is told to stop when the word is taken back",
        ),
        "54_tachometer_over_reads": (
            "releases_by_the_odometer",
            "nothing is given back before the arrival tag",
        ),
        "56_proof_lost_in_braking": ("ignores_a_withdrawn_proof", "the unit drops the proof"),
        "55_unit_dead_for_good": ("leaves_the_line_unswept", "T2 runs through on sight"),
        "43_brake": (acknowledges_whatever_is_wrong, "not released before"),
        "57_motors_on_a_gradient": (leaves_whatever_lies_ahead, "it does not leave"),
        "58_portal_answer_lost": ("frees_a_portal_at_the_sign_off", "no invariant is broken"),
        "58b_portal_unit_power": ("frees_a_portal_at_the_sign_off", Checker.INSIDE_HOLDING),
        "58c_hauled_out_of_its_portal": (
            "counts_no_train_out",
            "the contact at the boundary frees the portal",
        ),
        "58d_hauled_away_uncounted": ("one_person_suffices", "one person's word frees nothing"),
        "58e_hauled_away_and_asked": ("does_not_hear_that_it_has_left", "no person has to speak for it"),
        "58f_left_untold_and_booted": (
            "silent_after_it_has_left",
            "booted and told that it is off the line, it is heard of, and the portal is free",
        ),
        "58g_left_uncounted_and_booted": (
            "forgets_who_booted_as_it_left",
            "it may have forgotten, which is shown",
        ),
        "59_unit_barred": ("frees_what_a_barred_unit_holds", Checker.ONE_TRAIN_A_SECTION),
        "59b_unit_claims_falsely": ("bars_nobody", "the line goes on while it is mad"),
        "70_no_fix_before_the_mark": (
            "releases_by_the_odometer",
            "nothing is given back before the driver has spoken",
        ),
        "71_fix_beyond_the_arrival_tag": (
            has_no_virtual_tags,
            "what lies behind is given back before it stands",
        ),
        "72_jammed_at_the_terminus": (
            "releases_by_the_odometer",
            "nothing of the arrival is given back before the driver has spoken",
        ),
        "73_restart_without_tags": (believes_no_fix_after_a_restart, "a fix tells the position"),
        "74_silent_wheels_without_tags": ("asks_no_driver", "to its mark"),
        "75b_claim_off_the_path": ("keeps_what_is_off_its_way", "and it leaves the line"),
        "75_claim_far_behind": ("ends_its_way_at_a_gap_behind", "to its mark in the portal"),
        "76_by_section": (releases_whole_routes, "T3 is let onto that track while T1 is on its way"),
        "76b_by_section_power_between": ("starts_with_every_section_free", NOT_ACCEPTED),
        "76c_by_section_reports_lost": (reports_once, "then what both would have freed, at once"),
        "76d_by_section_tag_lies": ("believes_any_tag", "the unit does not believe it"),
        "76e_by_section_crew_comes_late": ("forgets_that_it_was_on_the_line", NOT_WITHOUT),
        "77_follows_in_blocks": (grants_no_part, "T3 is let onto the blocks, not into B"),
        "77b_power_in_a_block": ("starts_with_every_section_free", NOT_ACCEPTED),
        "78_comes_in_at_once": (
            gives_points_back_running,
            "nor given leave for them, though T1's arrival tag says that its rear is in",
        ),
        "80_cable_cut_central": (reaches_over_a_cut, "nothing is granted while the cable is cut"),
        "80b_cable_cut_on_board": (says_everything_over_the_cable, "no telegram is lost in the cable"),
        "90_other_track": (orders_nothing, "T3 is ordered to track 2 of B"),
        "90b_other_track_lost": (orders_nothing, "then it is let on to the other track"),
        "90c_other_track_doubled": (orders_nothing, "T3 stands on track 2 of B"),
        "90d_other_track_refused": (refuses_in_silence, "the manager knows that nothing came of it"),
        "91_route_back": (orders_nothing, "a minute after its time, T1 is asked for its route"),
        "91b_route_back_lost": (orders_nothing, "asked again it gives it back"),
        "91c_route_back_doubled": (orders_nothing, "T2 comes to A while T1 stands there"),
        "91d_route_back_too_late": (orders_nothing, "T1 is asked for its route"),
        "92_ends_early": (orders_nothing, "T1 is ordered to end at A"),
        "92b_ends_early_lost": (orders_nothing, "the order is given, and not heard"),
        "92c_ends_early_doubled": (orders_nothing, "T1 ends at A"),
        "92d_ends_early_report_lost": (orders_nothing, "T1 ends at A"),
        "93_left_out": (orders_nothing, "T1 and T2 are ordered to be left out"),
        "93b_left_out_lost": (orders_nothing, "the order is given, and not heard"),
        "93c_left_out_doubled": (orders_nothing, "T1 ends at A"),
        "130_other_track_late": ("obeys_whenever", "nobody is told that it cannot be done, as it is done"),
        "131_ends_early_late": ("obeys_whenever", "T2 is not ended, and nobody is told that it cannot be"),
        "132_route_back_late": ("obeys_whenever", "it answers nothing"),
        "138_left_out_late": ("obeys_whenever", "T3 is not ended, and nobody is told that it cannot be"),
        "139_who_speaks_says_what_is_shown": (
            "leaves_the_line_unswept",
            "and locked but for trains on sight",
        ),
        "139b_who_speaks_says_what_is_seen": ("nobody_knows_what_is_left_out", "what they leave out is told"),
        "134_terminus_under_authority": (
            "waits_for_units_to_end_trains",
            "T2 is back at A by the pilot's leave, while the block manager is off",
        ),
        "133_lost_in_a_shadow": ("waits_where_no_radio_reaches", Checker.EVERYONE_ARRIVES),
        "135_proofs_of_before": ("goes_by_proofs_of_before", Checker.POINTS_UNDER_TRAIN),
        "136_terminal_dark_points_set": ("looks_at_points_in_silence", Checker.POINTS_UNDER_TRAIN),
        "137_withdrawal_lost": ("withdraws_once", Checker.POINTS_UNDER_TRAIN),
        "95_substitute_working": (remembers_while_cut_out, "no invariant is broken"),
        "95b_pilots_ticket": (gives_no_tickets, "T1 goes by the pilot's ticket"),
        "100_crossing": ("asks_no_crossing_in_time", "it has warned for no less than 34 s"),
        "101_crossing_power": ("passes_unproven_crossings", "the train stops before it"),
        "102_crossing_link": ("passes_unproven_crossings", Checker.CROSSING_OPEN),
        "103_crossing_barriers_stuck": (
            "proves_lamps_alone",
            "the train does not come onto the road while they are up",
        ),
        "104_crossing_undetected": ("proves_what_it_commands", "the device takes its proof back"),
        "105_crossing_asked_late": ("keeps_no_least_time", "closed, the road has its least time"),
        "106_crossing_two_trains": ("closes_once", "so does T3"),
        "107_crossing_contacts": ("counts_no_rear", "the rear opens it"),
        "107b_crossing_contacts_dark": ("counts_one_train_in_the_dark", Checker.CROSSING_OPEN),
        "108_crossing_unit_power": ("opens_in_silence", "the road stays closed"),
        "109_crossing_obstacle": ("creeps_without_looking", Checker.SUMO_COLLISION),
        "111_crossing_freed": ("believes_one_person", "one person frees nothing"),
        "112_crossing_wrong_word": (
            "strikes_off_at_once",
            "the road is closed until the train has come onto it",
        ),
        "113_crossing_over_unheard": ("looks_at_no_road", "and the road opens"),
        "114_crossing_guarded": ("stops_no_road", Checker.CROSSING_OPEN),
        "115_crossing_by_pilot": ("runs_over_crossings_by_hand", Checker.CROSSING_OPEN),
        "115b_crossing_by_pilot_guarded": ("stops_no_road", Checker.CROSSING_OPEN),
        "116_crossing_button": ("feels_no_button", "the device takes its proof back"),
        "117_crossing_protection": ("calls_every_road_clear", "it hears of the vehicle at once"),
        "118_crossing_protection_silent": (
            "passes_unproven_crossings",
            "the train comes onto the road by its driver's leave alone",
        ),
        "119_crossing_detector_blind": ("feels_no_button", Checker.SUMO_COLLISION),
        "120_crossing_departure": ("leaves_unannounced", "its unit asks before it leaves"),
        "121_crossing_departure_late": (
            "leaves_before_the_road_is_ready",
            "the train does not leave while it has not heard that the crossing knows of it",
        ),
        "110_crossing_busy_road": ("is_not_seen_on_the_road", Checker.SUMO_COLLISION),
    }
)


# Of position, radio, manager, persons, points, portals and the cable.
EVERY_RUN: Final = (
    "02_turn_back",
    "06_unit_manager_link",
    "09_manager_power",
    "15_crew_comes_late",
    "20_route_given_back",
    "42_doors",
    "58d_hauled_away_uncounted",
    "59b_unit_claims_falsely",
    "102_crossing_link",
)


@pytest.mark.parametrize("drill", others_nightly(WITHOUT, EVERY_RUN))
def test_a_drill_fails_without_the_behaviour_that_it_checks(drill: str, run_with: RunWith) -> None:
    switched_off, objector = WITHOUT[drill]
    _, objections = run_with(FOLDER + drill, switched_off)
    assert objector in objections


@pytest.mark.nightly
def test_a_driver_on_sight_stops_at_a_halt_whatever_his_unit_knows(run_with: RunWith) -> None:
    """Placed by a tag, but without radio, the unit shows that it runs on sight and tells nobody of an arrival."""

    def drives_while_unplaced(patch: pytest.MonkeyPatch) -> None:
        patch.setattr(
            OnBoard,
            "drives_on_sight",
            lambda self, slot: (
                slot not in self.unpowered
                and self.shown_to_driver(slot).on_sight
                and not self._trains.units[slot].position_known
            ),
        )

    drill = "karasuyama/29_unit_restart_before_a_halt"
    _, objections = run_with(drill, drives_while_unplaced)
    assert "it calls at the halt, before the manager has answered" in objections


def test_no_drill_is_left_out() -> None:
    shipped = {name.removeprefix(FOLDER) for name in shipped_drills() if name.startswith(FOLDER)}
    assert shipped == set(WITHOUT) | NOT_YET
