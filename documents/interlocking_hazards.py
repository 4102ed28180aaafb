"""The hazards of the interlocking as data: cause, what prevents them and where, who watches, what shows it.

A test holds modules, drills and names of defects to what exists, and asks for every checker at least once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from simulation.judge.checkers import Checker


@dataclass(frozen=True, slots=True)
class Hazard:
    """One hazard. `drills` are shipped ones, `defects` names in tests/system/test_defects.py."""

    hazard: str
    cause: str
    prevention: str
    modules: tuple[str, ...]
    watched_by: tuple[Checker, ...]
    drills: tuple[str, ...] = ()
    defects: tuple[str, ...] = ()


HAZARDS: Final = (
    Hazard(
        "A train on a level crossing whose road is open",
        "the device, its link, its lamps or barriers fail, or it is asked late",
        "the movement limit lies before the road until the device proves it closed, and again when a proof is taken"
        " back or not said again; over it unproven only from a stand and on sight, by a driver's leave or the word of who has"
        " stopped its road by hand; so does a driver whose unit is cut out",
        ("onboard.crossings.machine", "onboard.crossings.talk", "wayside.level_crossing"),
        (Checker.CROSSING_OPEN,),
        (
            "rtri/100_crossing",
            "rtri/101_crossing_power",
            "rtri/102_crossing_link",
            "rtri/103_crossing_barriers_stuck",
            "rtri/104_crossing_undetected",
            "rtri/106_crossing_two_trains",
            "rtri/107_crossing_contacts",
            "rtri/108_crossing_unit_power",
            "rtri/112_crossing_wrong_word",
            "rtri/114_crossing_guarded",
            "rtri/115_crossing_by_pilot",
            "rtri/115b_crossing_by_pilot_guarded",
        ),
        ("a unit runs over a level crossing that has not proved closed",),
    ),
    Hazard(
        "A road vehicle on a level crossing before the train",
        "it stalls on the road that is closed, or drives over one that cannot be closed",
        "what a detector sees, or a button that is pressed, takes the proof away, by contacts the word that the road is"
        " clear; nobody creeps onto a road on which he sees something stand, and for"
        " a train that creeps drivers stop. Inside braking distance it is struck",
        ("wayside.level_crossing", "onboard.crossings.talk"),
        (Checker.SUMO_COLLISION,),
        (
            "rtri/109_crossing_obstacle",
            "rtri/110_crossing_busy_road",
            "rtri/116_crossing_button",
            "rtri/117_crossing_protection",
            "rtri/118_crossing_protection_silent",
            "rtri/119_crossing_detector_blind",
        ),
    ),
    Hazard(
        "A road that is closed just before the train",
        "the train comes sooner than its unit said, or the crossing was asked late",
        "a proof counts only where even at full speed the front comes no sooner than the least time after it",
        ("onboard.crossings.machine", "onboard.crossings.ahead"),
        (Checker.CROSSING_WARNING,),
        ("rtri/105_crossing_asked_late",),
        ("a unit comes onto a level crossing as soon as that has proved closed",),
    ),
    Hazard(
        "Two trains in one section",
        "the block manager grants what another unit holds",
        "the register maps a section to one holder, so that two cannot be written down",
        ("wayside.register", "wayside.block_manager"),
        (Checker.NO_DOUBLE_GRANT, Checker.ONE_TRAIN_A_SECTION, Checker.SUMO_COLLISION),
        ("rtri/03_block_held",),
        ("a section is granted that another holds",),
    ),
    Hazard(
        "A route is granted over a train nobody remembers",
        "the block manager lost its register in a restart",
        "every unit is unknown after a restart; nothing is granted before all are vouched for and a person accepts",
        ("wayside.reentry", "wayside.register"),
        (Checker.UNDEFINED_GRANTS_NOTHING, Checker.ONE_TRAIN_A_SECTION),
        ("rtri/09_manager_power",),
        ("grants in the undefined state", "a restart sets every section free"),
    ),
    Hazard(
        "The restored picture lacks a train or a section",
        "a person accepts too early or enters wrongly, or a unit claims only where it stands",
        "a unit's own full claim outranks entries; for a silent unit two persons must say the same, and where it is",
        ("wayside.reentry", "wayside.acts", "onboard.authority.machine"),
        (Checker.INSIDE_HOLDING, Checker.ONE_TRAIN_A_SECTION),
        (
            "rtri/09_manager_power",
            "rtri/09b_manager_power_by_hand",
            "rtri/14a_manager_and_units_in_stations",
            "rtri/14b_manager_and_units_on_open_line",
            "rtri/14c_manager_and_units_one_each",
        ),
        ("a picture accepted without a silent unit", "a claim of less than is held"),
    ),
    Hazard(
        "A train whose unit has just booted is taken for one that is outside",
        "manager and unit lost their power; the unit is asked before its crew has entered a train number",
        "a unit keeps whether it may be on the line, and says then that it does not know; the empty claim of one"
        " that was is swept for",
        ("onboard.authority.sign_on", "host.unit", "wayside.reentry"),
        (Checker.SUMO_COLLISION, Checker.INSIDE_HOLDING),
        ("rtri/15_crew_comes_late",),
    ),
    Hazard(
        "A lost durable state is taken for a first start",
        "the disk of a party was replaced",
        "no party starts from a blank store: people commission it, with a number and tokens beyond all that were used",
        ("host.store", "host.boot", "simulation.faults.commissioning"),
        (Checker.UNDEFINED_GRANTS_NOTHING, Checker.TOKENS_GROW, Checker.EVERYONE_ARRIVES),
        (
            "rtri/16a_manager_store_lost",
            "rtri/16b_unit_store_lost",
            "rtri/16c_terminal_store_lost",
        ),
    ),
    Hazard(
        "Two persons are wrong about a silent unit that is on the line",
        "a train with its radio cut is said to stand, or to have left, where it does not",
        "a place must be named, in a station; what no unit speaks for is locked until a train on sight has run through;"
        " who is heard again and claims what another holds stops both",
        ("wayside.acts", "wayside.reentry", "onboard.authority.agreement", "simulation.world.crew"),
        (Checker.SUMO_COLLISION, Checker.INSIDE_HOLDING),
        (
            "rtri/53_word_without_a_place",
            "rtri/53b_two_wrong_persons",
            "rtri/53c_wrong_word_taken_back",
            "rtri/55_unit_dead_for_good",
        ),
    ),
    Hazard(
        "A section is freed under a train",
        "its unit cannot be heard for a while",
        "only the holder's own report, its leaving or a person frees; there are no leases",
        ("wayside.block_manager",),
        (Checker.INSIDE_HOLDING,),
        (
            "rtri/06_unit_manager_link",
            "rtri/35_one_network_lost",
            "rtri/35b_both_networks_lost",
            "rtri/10_manager_link",
            "rtri/24_manager_frozen",
            "rtri/80_cable_cut_central",
            "rtri/80b_cable_cut_on_board",
        ),
        ("silence frees what a unit holds",),
    ),
    Hazard(
        "A section is given back with the rear still in it",
        "the unit goes by its front, by its estimate, or by a tachometer that shows too much",
        "released at the arrival tag, or section by section at any but the one that tells a lost position; where no"
        " tags are read by a fix that lies wholly beyond its place, or by the driver; and by the safe rear besides:"
        " estimate less bound less length; dropped on board before it is reported",
        (
            "onboard.duty.arrival",
            "onboard.localisation.places",
            "onboard.duty.stop_limit",
            "onboard.authority.machine",
        ),
        (Checker.RELEASE_BEHIND_REAR, Checker.INSIDE_HOLDING),
        (
            "rtri/01_normal",
            "rtri/20_route_given_back",
            "rtri/54_tachometer_over_reads",
            "rtri/70_no_fix_before_the_mark",
            "rtri/71_fix_beyond_the_arrival_tag",
            "rtri/72_jammed_at_the_terminus",
            "rtri/76_by_section",
            "rtri/76b_by_section_power_between",
            "rtri/76c_by_section_reports_lost",
            "rtri/76d_by_section_tag_lies",
            "rtri/76e_by_section_crew_comes_late",
            "karasuyama/76_by_section_links",
            "karasuyama/76b_by_section_power_between",
            "karasuyama/76c_by_section_crew_comes_late",
        ),
        ("sections given back by the front instead of the safe rear",),
    ),
    Hazard(
        "A train overruns its stop into the way of another that comes in",
        "two trains come to a loop at once, on a line with less room beyond its marks than an overrun may take",
        "a train has leave, the capability to command its arrival points, only while nobody else comes in or goes over"
        " points that it would foul, or whose overrun would foul its own; it keeps its arrival points until it stands",
        ("wayside.entering", "onboard.duty.entering"),
        (Checker.ONE_COMES_IN,),
        ("rtri/78_comes_in_at_once",),
        ("leave to come in for two at once",),
    ),
    Hazard(
        "People who work the line while the block manager is off let a train into a section with another in it",
        "the block manager is dead, trains run with their units cut out",
        "one pilot belongs to a section, and no train comes in without him, or before both ends agreed on it and heard"
        " of the last one's arrival; a unit that was cut out has forgotten what it held, and claims nothing false",
        ("simulation.procedure", "simulation.substitute.book", "simulation.substitute.by_hand"),
        (Checker.PILOTS_LEAVE, Checker.ONE_TRAIN_A_SECTION, Checker.INSIDE_HOLDING),
        (
            "karasuyama/95_substitute_working",
            "karasuyama/95b_train_in_the_section",
            "karasuyama/95c_way_on_opens_late",
            "rtri/95_substitute_working",
            "rtri/95b_pilots_ticket",
        ),
    ),
    Hazard(
        "On a line with line signals and no units two trains are let into one section",
        "a train is sent off past a signal at stop, or by the substitute aspect, which no machine checks",
        "the machine clears one end of a section and counts trains in and out; where a train leaves at stop, a detector"
        " of wrong departures holds the other end at stop. Nothing restrains the train that is sent off: by units or a"
        " centre it has no authority",
        ("simulation.line_signals.machine", "simulation.line_signals.working"),
        (Checker.ONE_TRAIN_A_SECTION, Checker.SUMO_COLLISION),
        (
            "shigaraki/01_as_it_was",
            "shigaraki/02_on_board",
            "shigaraki/03_by_the_centre",
            "shigaraki/04_detector_works",
            "mangfall/01_as_it_was",
            "mangfall/02_on_board",
            "mangfall/03_by_the_centre",
        ),
    ),
    Hazard(
        "A train that follows another in virtual blocks meets one that comes against it, or stands for ever",
        "a part of a way is granted, the rest of which is held",
        "only behind trains that run the same way, to a place where the radio reaches, and if it is proven that all can"
        " still finish; else whole or not at all",
        ("wayside.parts", "wayside.dispatch", "onboard.authority.route"),
        (
            Checker.ONE_TRAIN_A_SECTION,
            Checker.INSIDE_HOLDING,
            Checker.EVERYONE_ARRIVES,
            Checker.NO_DEAD_STATE,
        ),
        ("rtri/77_follows_in_blocks", "rtri/77b_power_in_a_block"),
    ),
    Hazard(
        "An order of the dispatcher lets a train on against another, or leaves it without a way",
        "an order is lost, doubled, or comes when the train has left",
        "an order is a telegram that the unit takes at a stop or refuses; nothing counts as done before the unit asks"
        " by the other way, or reports that it has given its route back; proven when given, and again when asked for",
        ("wayside.orders", "onboard.duty.orders"),
        (Checker.INSIDE_HOLDING, Checker.EVERYONE_ARRIVES, Checker.NO_DEAD_STATE),
        (
            "rtri/90_other_track",
            "rtri/90b_other_track_lost",
            "rtri/90c_other_track_doubled",
            "rtri/91_route_back",
            "rtri/91b_route_back_lost",
            "rtri/91c_route_back_doubled",
            "rtri/91d_route_back_too_late",
            "rtri/92_ends_early",
            "rtri/92b_ends_early_lost",
            "rtri/92c_ends_early_doubled",
            "rtri/92d_ends_early_report_lost",
        ),
    ),
    Hazard(
        "A grant of the past takes effect",
        "a telegram comes after the manager or the unit has started again",
        "boot epochs in every envelope; a grant counts for the request outstanding, with a greater token only",
        ("radio.envelope", "onboard.authority.machine"),
        (Checker.INSIDE_HOLDING, Checker.TOKENS_GROW),
        ("karasuyama/30_links_delayed", "karasuyama/32_links_reorder"),
        ("an old grant obeyed after a restart", "tokens begin anew after a restart"),
    ),
    Hazard(
        "A telegram is older than its receiver takes it for",
        "the clock of a party is wrong",
        "by its own clock a receiver drops what is too old and what comes from the future; timers go by what passes",
        ("radio.envelope", "radio.elapsed"),
        (Checker.INSIDE_HOLDING, Checker.PROVEN_BEFORE_ENTRY),
        (
            "rtri/40_clock_wrong",
            "rtri/41_clock_drifts",
            "karasuyama/40_clock_wrong",
            "karasuyama/41_clock_drifts",
        ),
    ),
    Hazard(
        "A telegram acts twice",
        "the air delivers copies",
        "sequence numbers; requests are repeated with the same correlation, and answers count once",
        ("radio.envelope",),
        (Checker.TELEGRAM_ONCE,),
        ("karasuyama/31_links_duplicate",),
        (
            "a telegram takes effect twice",
            "a telegram takes effect twice at manager and terminals",
            "a telegram takes effect twice at a unit",
        ),
    ),
    Hazard(
        "A forged or damaged telegram is obeyed",
        "bit errors, or a stranger who sends",
        "a keyed hash with a key for each pair of parties",
        ("radio.envelope", "radio.keys"),
        (Checker.INSIDE_HOLDING,),
        ("karasuyama/33_links_flip",),
        ("a telegram believed whatever its code",),
    ),
    Hazard(
        "Points are thrown under a train",
        "a command by a unit that does not hold them, or no longer does",
        "a terminal checks the grant's capability by itself, and obeys the greatest token it has seen",
        ("wayside.point_terminal",),
        (Checker.NO_THROW_UNDER_TRAIN, Checker.POINTS_UNDER_TRAIN),
        ("rtri/12b_terminal_power_after_throw",),
        ("points thrown without the token", "points thrown for a token that is out of date"),
    ),
    Hazard(
        "A train runs onto points that lie wrong or loose",
        "no throw, a machine that sticks, a terminal that is off or out of reach",
        "the stop limit stays before points until position and lock are proven under the own token",
        ("onboard.duty.stop_limit", "wayside.point_terminal"),
        (Checker.PROVEN_BEFORE_ENTRY, Checker.POINTS_UNDER_TRAIN),
        (
            "rtri/07_unit_terminal_link",
            "rtri/11_terminal_link",
            "rtri/12_terminal_power",
            "rtri/21_points_stuck",
            "rtri/22_points_no_detection",
            "rtri/23_points_slow",
            "rtri/80_cable_cut_central",
        ),
        ("no wait for the proof of points", "points proven that were not detected"),
    ),
    Hazard(
        "Points lose their position after they were proven",
        "turned by hand, forced open, detection lost",
        "the terminal withdraws the proof unasked, the unit takes its stop limit back; too late to stop, it brakes, and"
        " the points stay locked for it (judged by the guaranteed brake)",
        ("wayside.point_terminal", "onboard.authority.machine", "simulation.judge.locking"),
        (Checker.PROVEN_BEFORE_ENTRY, Checker.POINTS_UNDER_TRAIN),
        ("rtri/56_proof_lost_in_braking",),
        ("a withdrawn proof still counts",),
    ),
    Hazard(
        "A train runs past the end of what it holds",
        "the driver or the automatic driving does not brake",
        "supervision brakes by what the brakes are guaranteed to give, down to a declared design adhesion, from the"
        " front that may be furthest ahead; what less adhesion leads to is told apart",
        ("onboard.driving.supervision", "onboard.duty.stop_limit"),
        (Checker.INSIDE_HOLDING, Checker.PROVEN_BEFORE_ENTRY, Checker.SUMO_COLLISION),
        (),
        ("supervision leaves no room to brake", "a train runs beyond what it holds"),
    ),
    Hazard(
        "A train starts or runs on that is not fit to",
        "a door that is not closed, a brake without its pressure, less pull than the gradients of its way need",
        "no departure before the unit sees both in order, and none to a stop that it predicts not to reach; on the way"
        " the emergency brake, until all is in order again",
        ("onboard.vehicle", "onboard.duty.fitness"),
        (Checker.INSIDE_HOLDING, Checker.PROVEN_BEFORE_ENTRY),
        (
            "rtri/42_doors",
            "rtri/43_brake",
            "rtri/57_motors_on_a_gradient",
            "karasuyama/42_doors",
            "karasuyama/43_brake",
        ),
    ),
    Hazard(
        "The unit believes a false position",
        "a tag that reads as another or is missing, tags swapped, a tachometer that lies, worn or sliding wheels",
        "bounds that grow with the way; a tag counts only where it may lie, a missing one is noticed: stop, on sight",
        ("onboard.localisation.tachometer", "onboard.unit", "onboard.localisation.reader"),
        (Checker.WITHIN_BOUNDS,),
        (
            "rtri/08a_tachometer_scale",
            "rtri/08b_tachometer_silent",
            "rtri/08c_tachometer_silent_at_start",
            "rtri/08d_tachometer_stuck",
            "rtri/13_tag_not_read",
            "rtri/25_wrong_tag_id",
            "rtri/26_tags_swapped",
            "rtri/27_slippery_rail",
            "rtri/45_tags_by_bits",
            "karasuyama/45_tags_by_bits",
        ),
        (
            "a tag accepted outside its window",
            "a missing tag is not noticed",
            "the bounds of the position do not grow",
        ),
    ),
    Hazard(
        "A unit that has restarted runs as if it knew",
        "its power failed on the way",
        "it is stopped, then runs on sight until a tag or fix gives the position and the manager what it holds",
        ("onboard.unit",),
        (Checker.INSIDE_HOLDING, Checker.PROVEN_BEFORE_ENTRY),
        (
            "rtri/04_unit_power_position_fixed",
            "rtri/05b_extra_tag",
            "rtri/28_unit_restart_at_departure",
            "karasuyama/28_unit_restart_out_of_coverage",
            "karasuyama/29_unit_restart_before_a_halt",
            "rtri/73_restart_without_tags",
            "rtri/74_silent_wheels_without_tags",
            "rtri/75_claim_far_behind",
            "rtri/75b_claim_off_the_path",
        ),
        ("full speed after a restart",),
    ),
    Hazard(
        "A train on sight runs onto points unseen",
        "no tag before the points, so no position and no pattern",
        "the crew stops before the points, looks, and passes only if they lie and are locked as needed",
        ("simulation.world.crew",),
        (Checker.PROVEN_BEFORE_ENTRY, Checker.POINTS_UNDER_TRAIN),
        ("rtri/05_unit_power_position_unknown",),
        ("the crew does not look at the points",),
    ),
    Hazard(
        "Points are thrown after a crew has looked at them",
        "another's command, or the own unit's under the same token, once the train passes on sight",
        "the crew locks the machine on the spot and keeps its key until the rear has left; its terminal refuses",
        ("simulation.world.crew", "simulation.world.point_machine", "wayside.point_terminal"),
        (Checker.NO_THROW_UNDER_TRAIN, Checker.POINTS_UNDER_TRAIN),
        ("rtri/44_points_locked_by_crew", "karasuyama/44_points_locked_by_crew"),
        ("the crew does not lock the points that it passes",),
    ),
    Hazard(
        "A portal is given away while a train stands in it",
        "a unit signs off, and does not hear that it may leave: an answer lost, or its power",
        "an accepted sign-off frees nothing; the contact at the boundary, or the unit once its train has left, does",
        ("wayside.leaving", "onboard.authority.sign_on"),
        (Checker.INSIDE_HOLDING, Checker.ONE_TRAIN_A_SECTION),
        (
            "rtri/58_portal_answer_lost",
            "rtri/58b_portal_unit_power",
            "rtri/58c_hauled_out_of_its_portal",
            "rtri/58d_hauled_away_uncounted",
            "karasuyama/58_portal_answer_lost",
            "karasuyama/58b_portal_unit_power",
            "karasuyama/58c_hauled_out_of_its_portal",
        ),
        ("a portal is free as soon as its train may leave",),
    ),
    Hazard(
        "A unit claims what is not so",
        "a unit is defective, or its key is stolen",
        "its claim stops the line until two persons bar it and two say where it is; what it holds stays its own",
        ("wayside.barring", "wayside.acts", "wayside.point_terminal"),
        (Checker.INSIDE_HOLDING, Checker.ONE_TRAIN_A_SECTION),
        (
            "rtri/59_unit_barred",
            "rtri/59b_unit_claims_falsely",
            "karasuyama/59_unit_barred",
            "karasuyama/59b_unit_claims_falsely",
        ),
        ("a barred unit's sections are free", "nobody can be barred"),
    ),
    Hazard(
        "A road that stays closed for ever, so that people drive round its barriers",
        "who has announced itself dies, is barred or cannot be heard, or turns between contacts",
        "two persons say at the crossing that no train comes: proofs are taken back, and who says nothing for a minute is"
        " struck off",
        ("wayside.level_crossing",),
        (Checker.NO_DEAD_STATE,),
        ("rtri/111_crossing_freed", "rtri/113_crossing_over_unheard"),
    ),
    Hazard(
        "Everything stands for ever",
        "safe, and of no use: refusals without end, lost telegrams that nobody repeats, a phase that waits for nothing",
        "whatever is open is repeated by a timer until it is answered; a train that stands says what it waits for",
        ("onboard.authority.machine", "wayside.block_manager"),
        (Checker.EVERYONE_ARRIVES, Checker.NO_DEAD_STATE),
        (
            "karasuyama/34_links_loss",
            "rtri/02_turn_back",
            "rtri/50_unit_power_before_entry",
            "rtri/51_not_at_its_mark",
            "rtri/52_unit_frozen",
            "karasuyama/51_route_given_back_at_halt",
        ),
        (
            "the block manager refuses everything",
            "what was refused is never asked for again",
            "a unit's timers are dropped",
        ),
    ),
    Hazard(
        "The run itself is false",
        "a train put where no train can have run",
        "SUMO's position is compared with the sum of the speeds at every look",
        ("simulation.world.trains",),
        (Checker.NO_JUMP,),
    ),
)

REMAINING: Final = (
    "Two persons who agree on the same wrong word about a silent unit, while its train runs at speed: drivers see each"
    " other, but from more than 60 km/h 200 m do not suffice.",
    "Two trains in one section after such a word: both stand and say why, and people must part them.",
    "A crew that passes points without looking, while their unit has no position: handling outside the system"
    " (section 4.4 (3) of the paper).",
    "A clock that is slow by as much as its link is late, both more than the age limit: such a telegram counts as new"
    " (`radio.envelope`); sequence, boot, correlation and token still hold it.",
    "Wheels that slide further than the bounds allow for, until the next tag or the tachometer's own check finds it.",
    "Less adhesion than the design counts on (`[driving] design_adhesion_share`): a train may run past its stop limit;"
    " every such run says so.",
)
