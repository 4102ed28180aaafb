"""The tree of docs/safety.md: hazards, claims, why they are claimed, and the commands and tests that show it."""

from __future__ import annotations

from typing import Final, NamedTuple


class SafetyClaim(NamedTuple):
    """A claim about a hazard: `because` is the argument; commands of `branchline` and tests show it."""

    says: str
    because: str
    commands: tuple[str, ...] = ()
    tests: tuple[str, ...] = ()


class SafetyHazard(NamedTuple):
    """What must not happen, and the claims that together keep it from happening."""

    name: str
    claims: tuple[SafetyClaim, ...]


_EXPLORE: Final = "tests/verify/test_explore.py::test_every_state_is_safe_and_alive"
HAZARDS: Final = (
    SafetyHazard(
        "Two trains in one section",
        (
            SafetyClaim(
                "A section has one holder, and a train is only where it holds",
                "one register, one holder by type; every state of a small line, with losses, delays, power cuts and"
                " wrong words, is looked at",
                ("verify explore 1/1/0/0", "verify recount small.cert"),
                (_EXPLORE, "tests/verify/test_recount.py::test_it_holds_whatever_way_it_came"),
            ),
            SafetyClaim(
                "Runs are where the exploration has been",
                "every state that two units and a section of a run come to is one of an explored state, or is"
                " counted with what the model lacks",
                ("verify inside rtri/12_terminal_power",),
                (
                    "tests/verify/test_inside.py::test_a_day_lies_inside",
                    "tests/verify/test_inside.py::test_a_defect_falls_outside",
                ),
            ),
            SafetyClaim(
                "A breach would be seen",
                "checkers see the true positions alone and share no code with what they check; each finds its breach",
                ("drill rtri/12_terminal_power",),
                (
                    "tests/simulation/judge/test_checkers.py::test_each_checker_finds_its_breach_and_nothing_else",
                    "tests/simulation/judge/test_following.py::test_checkers_share_nothing_with_what_they_check",
                    "tests/system/test_defects.py::test_a_defect_is_caught",
                ),
            ),
        ),
    ),
    SafetyHazard(
        "A train on points that are not locked, or that move under it",
        (
            SafetyClaim(
                "A terminal throws only under the newest token, and locks for it",
                "the grant is proven offline by its code; tokens and locks outlive a power cut",
                ("verify explore 0/1/0/0/0/0/1",),
                (
                    _EXPLORE,
                    "tests/verify/test_explore.py::test_an_old_token_that_is_obeyed_moves_points_under_a_train",
                    "tests/host/test_device.py::test_a_terminal_remembers_its_tokens_over_a_power_cut",
                ),
            ),
            SafetyClaim(
                "A terminal without its memory takes no older token than the last, and its holder hears how points lie",
                "people tell it the last token of each section, and whose that was; nobody else relies on its points: a"
                " proof counts for the holder alone, and ends where persons have spoken for it",
                ("drill rtri/16d_terminal_store_lost_points_set",),
                (
                    "tests/wayside/test_point_terminal.py::test_who_may_rely_on_points_hears_how_they_lie_where_the_memory_was_lost",
                    "tests/simulation/test_injector.py::test_a_terminal_commissioned_again_takes_no_command_under_an_older_token_than_the_last_given",
                ),
            ),
            SafetyClaim(
                "A proof that is withdrawn too late to stop is told apart from one in time",
                "the judge works out the braking distance by the guaranteed brake alone",
                ("drill rtri/12b_terminal_power_after_throw",),
                (
                    "tests/simulation/judge/test_locking.py::test_lost_farther_away_the_train_could_have_stopped",
                ),
            ),
        ),
    ),
    SafetyHazard(
        "A train beyond its stop limit",
        (
            SafetyClaim(
                "No driving law passes a limit",
                "limits, interventions and stop lie outside the laws, and the stronger brake counts",
                ("run rtri_test_line",),
                ("tests/onboard/driving/laws/test_laws.py::test_no_law_passes_the_limit_or_the_target",),
            ),
            SafetyClaim(
                "A train whose wheels slide is supervised by no less than its true speed",
                "the axle that the slide protection lets go tells it, down to a stated least adhesion; until then, and"
                " without that, the speed before the slide counts",
                ("drill rtri/27_slippery_rail",),
                (
                    "tests/onboard/driving/test_slides.py::test_no_train_runs_faster_than_supervision_takes_it_to_run",
                    "tests/onboard/driving/test_slides.py::test_where_no_least_adhesion_is_stated_the_speed_before_the_slide_stays",
                ),
            ),
        ),
    ),
    SafetyHazard(
        "A train where its unit does not believe it to be",
        (
            SafetyClaim(
                "The truth stays within the stated bounds while sensors fail within their contracts",
                "bounds are intervals, cut only by what is surely so; a search changes places, sizes and joint faults"
                " towards the edge",
                ("verify bounds --runs 200", "reproduce position-fusion --quick"),
                (
                    "tests/verify/test_bounds.py::test_no_searched_run_leaves_its_bounds",
                    "tests/verify/test_bounds.py"
                    "::test_it_finds_a_reflection_in_a_slide_when_receivers_forgive_it_and_not_otherwise",
                ),
            ),
        ),
    ),
    SafetyHazard(
        "A telegram that is not true is believed",
        (
            SafetyClaim(
                "Whoever has not the pair's key, and whoever repeats or holds back, has no effect",
                "each threat after EN 50159 has its defence (the table below); a run with an intruder is the same run",
                ("verify intruders",),
                (
                    "tests/verify/test_intruders.py::test_an_intruder_has_no_effect",
                    "tests/verify/test_intruders.py::test_without_codes_he_has",
                ),
            ),
            SafetyClaim(
                "A unit that lies with its own keys stops the line, and two persons bar it",
                "what contradicts the register stops grants; a bar outlives restarts",
                ("drill rtri/59_unit_barred", "drill rtri/59b_unit_claims_falsely"),
                (
                    "tests/wayside/test_barring.py::test_a_false_claim_stops_the_line_until_its_unit_is_barred_and_two_persons_say_where_it_is",
                    "tests/wayside/test_barring.py::test_no_restart_forgets_a_bar",
                ),
            ),
            SafetyClaim(
                "Nobody else is on the planes between processes",
                "one socket in a private folder; random keys a run; the time plane is authenticated",
                ("run rtri_test_line --link zenoh",),
                (
                    "tests/host/test_over_zenoh.py::test_a_foreign_session_ends_the_run",
                    "tests/host/test_lockstep.py::test_what_is_not_ours_takes_no_effect_and_ends_the_run",
                ),
            ),
            SafetyClaim(
                "What is on another machine is who its certificate says, and says what is its own alone",
                "both ends of TLS show a certificate of an authority that signs no more; a rule for each name; whoever"
                " has joined without the invitation to this run ends it",
                ("certificates rtri_test_line certs --address 192.0.2.1",),
                (
                    "tests/host/test_over_tls.py::test_who_cannot_prove_who_he_is_joins_nothing",
                    "tests/host/test_over_tls.py::test_an_invitation_with_the_certificate_of_another_ends_the_run",
                    "tests/host/test_over_tls.py::test_what_is_not_a_partys_to_say_does_not_arrive",
                    "tests/host/test_over_tls.py::test_a_denied_party_takes_no_part",
                    "tests/system/test_far_parties.py::test_a_run_with_parties_elsewhere_is_the_same_to_the_byte",
                ),
            ),
        ),
    ),
    SafetyHazard(
        "Something is freed because nothing is known",
        (
            SafetyClaim(
                "After a restart nothing is known, and nothing is granted until all have spoken or are spoken for",
                "UNKNOWN is derived, so that it cannot be forgotten; silence frees nothing",
                ("drill rtri/09_manager_power", "drill rtri/16a_manager_store_lost"),
                (
                    _EXPLORE,
                    "tests/host/test_device.py::test_a_lost_ledger_stays_lost_until_a_device_has_a_new_one",
                    "tests/host/test_store.py::test_a_store_is_blank_until_people_commission_it",
                    "tests/verify/test_kills.py::test_a_party_killed_at_any_point_leaves_nothing_and_the_day_ends",
                    "tests/verify/test_kills.py::test_one_that_is_stopped_for_a_while_changes_nothing",
                    "tests/host/test_over_zenoh.py::test_a_process_of_an_earlier_boot_that_is_still_there_ends_the_run",
                ),
            ),
            SafetyClaim(
                "One person's wrong word frees nothing that a train is in",
                "a word counts once two persons have said it, or the unit says the same",
                ("drill rtri/53b_two_wrong_persons", "verify explore 0/0/0/1"),
                (_EXPLORE,),
            ),
        ),
    ),
    SafetyHazard(
        "A train on a level crossing that is open to the road",
        (
            SafetyClaim(
                "A front comes onto the road only when it is closed, and for its least time",
                "a proof is sent while lamps and barriers are detected so, and silence takes it away; every state of a"
                " crossing and a train that comes, with losses, power cuts and both networks lost, is looked at",
                ("verify explore 1/1/1 --crossing barriers", "verify explore 1/0/0/0/1 --crossing warning"),
                (
                    "tests/verify/test_crossing.py::test_no_train_comes_onto_an_open_road_and_each_passes",
                    "tests/verify/test_crossing.py::test_with_a_loss_a_power_cut_and_both_networks_lost",
                    "tests/verify/test_crossing.py::test_a_rule_that_is_switched_off_is_noticed",
                    "tests/wayside/test_crossing_on_air.py"
                    "::test_no_train_comes_onto_an_open_road_and_every_train_comes_over_it",
                ),
            ),
            SafetyClaim(
                "It does not open under a train",
                "it opens by the unit's word alone, it remembers who has announced itself, and a unit gives it up only"
                " surely short of it or beyond",
                ("drill rtri/101_crossing_power", "drill rtri/108_crossing_unit_power"),
                ("tests/onboard/crossings/test_machine.py::test_what_follows",),
            ),
            SafetyClaim(
                "In runs the road is closed in time whatever fails",
                "random runs on drawn lines with crossings; the checkers look at what lamps and barriers truly show",
                ("drill rtri/102_crossing_link",),
                (
                    "tests/system/test_crossings.py"
                    "::test_whatever_fails_no_train_comes_onto_an_open_road_and_all_arrive",
                    "tests/system/chaos/test_chaos.py::test_a_slice",
                ),
            ),
        ),
    ),
    SafetyHazard(
        "Nothing moves any more, and people improvise",
        (
            SafetyClaim(
                "When faults end and people act, every train arrives",
                "from each explored state some way without troubles leads to the end; random runs with up to twelve"
                " faults all arrive, and each situation that they are meant to come to was come to",
                ("verify explore 1/1/0/0", "verify explore 0/0/0/0 --trains 3", "drill rtri/21_points_stuck"),
                (
                    _EXPLORE,
                    "tests/system/chaos/test_chaos.py::test_a_slice",
                    "tests/system/chaos/test_swarms.py::test_swarms_come_to_everything_that_is_meant",
                ),
            ),
        ),
    ),
)
NOT_SHOWN: Final = (
    "That two trains and four sections stand for any number: it is argued, and three trains are explored with a lost"
    " telegram and a power cut.",
    "Metres: that brakes guarantee what they are said to, that tags lie where the file has them, that rear and front"
    " are where lengths say. These are assumptions of every claim above.",
    "That a train can be braked on less adhesion than the design's: supervision knows of it then, and brakes, and it"
    " runs on. Before the protection sees a slide both axles may be up to 1 m/s slower than the train, in three steps"
    " of a thousand; rails with less than `[driving] least_adhesion`, and axles that lie while they slide, are not"
    " covered.",
    "More than one power cut, and persons' errors together with other troubles, in the exploration; in runs they are"
    " sampled.",
    "Two persons who agree on what is not so of a unit after the block manager's power has failed, as of a train that"
    " waits before its portal, allowed in, and whose unit is not heard: theirs is the only word there is"
    " (`ExploredLine(agree=True)`, nine steps; without the power failure nothing breaks).",
    "Two persons who agree that no train comes to a level crossing while one does that the device cannot hear: one that"
    " is slower on the road than 65 s, one whose unit is frozen and no longer sees its proof die, one that contacts"
    " have counted in. Of any other the unit speaks in time, or its proof has died and it stops.",
    "States of three units at once: a run is held against the exploration by pairs and one section at a time, without"
    " what is on the air; trains that begin on the line, barred units and lost stores are in runs, not in the model.",
    "Of level crossings, road vehicles, detectors, contacts and the persons who free one are in runs, not in the"
    " exploration.",
    "An intruder who takes telegrams off the air as he likes (deletion) or has a unit's own keys: the first delays,"
    " the second stops the line until he is barred.",
    "Devices on other machines: that their programs are the same, and that folders are carried to them in secret."
    " Whoever can reach the address may keep parties from joining; whoever has a certificate of the run can end it.",
    "The program's own environment: interpreter, libraries, operating system, processor.",
    "Any safety integrity level. The words *after EN 50159* name the threats looked at, not a certification.",
)
