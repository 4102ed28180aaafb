"""The hazards of level crossings, among those of the interlocking."""

from __future__ import annotations

from typing import Final

from documents.hazard import Hazard
from simulation.judge.checkers import Checker

CROSSING_HAZARDS: Final = (
    Hazard(
        "A train on a level crossing whose road is open",
        "the device, its link, its lamps or barriers fail, or it is asked late",
        "the movement limit lies before the road until the device proves it closed, and again when a proof is taken"
        " back or not said again; over it unproven only from a stand and on sight, by a driver's leave or the word of"
        " who has stopped its road by hand; so does a driver whose unit is cut out",
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
            "rtri/107b_crossing_contacts_dark",
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
        "the train comes sooner than its unit said, the crossing was asked late, or the train begins beyond a contact",
        "a proof counts only where even at full speed the front comes no sooner than the least time after it, and a"
        " departure that warns waits for the road",
        ("onboard.crossings.machine", "onboard.crossings.ahead"),
        (Checker.CROSSING_WARNING,),
        (
            "rtri/105_crossing_asked_late",
            "rtri/120_crossing_departure",
            "rtri/121_crossing_departure_late",
        ),
        ("a unit comes onto a level crossing as soon as that has proved closed",),
    ),
    Hazard(
        "A road that stays closed for ever, so that people drive round its barriers",
        "who has announced itself dies, is barred or cannot be heard, or turns between contacts",
        "two persons say at the crossing that no train comes: proofs are taken back, and who says nothing for 65 s"
        " is struck off",
        ("wayside.level_crossing",),
        (Checker.NO_DEAD_STATE,),
        ("rtri/111_crossing_freed", "rtri/113_crossing_over_unheard"),
    ),
)
