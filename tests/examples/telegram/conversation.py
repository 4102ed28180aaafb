"""Manager and unit talk, as in a run but for the world: who says what, and whether the train leaves; JSON a story.

The train of the test line stands at A from 9:50 and leaves at 10:00; at 9:55 a person has it held back (`hold`), lets
it go at 10:05 (`release`), or does neither.
"""

from __future__ import annotations

import json
import sys

from host.unit import UnitConfig, unit_of
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.timetable import load_timetable
from onboard.duty.records import Begin, PlaceInJoints
from onboard.duty_parameters import DutyParameters
from onboard.mission import plan_mission
from onboard.plan import plan_of
from onboard.unit import Report
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from wayside.actions import Send
from wayside.block_manager import Heard, step
from wayside.config import ManagerConfig, RouteEntry, SectionEntry
from wayside.register import start

MASTER, MANAGER, UNIT = b"m" * 32, "block-manager", "K1"
STANDS = PlaceInJoints(known=True, here=0, sure=1, perhaps=1, reach=1, near=0)
MINUTE_S = 60.0


def tell(story: str) -> None:
    line = load_line(shipped_line("rtri_test_line"))
    train = load_timetable(shipped_timetable("rtri_test_line"), line).trains["T1"]
    plan = plan_of(plan_mission(line, train, "3", None, None), 40.0)
    config = ManagerConfig(
        line.id,
        MANAGER,
        (UNIT,),
        tuple(SectionEntry(section_id) for section_id in line.sections),
        tuple(RouteEntry(leg.route_id, leg.from_section, leg.section_ids) for leg in plan.legs),
    )
    terminals = {points.terminal_id for points in line.points.values()}
    unit = unit_of(
        UnitConfig(line.id, UNIT, MANAGER, DutyParameters(20.0, 45.0, 5.0)),
        Endpoint(key_ring(MASTER, UNIT, (MANAGER, *terminals)), 1),
    )
    desk = Endpoint(key_ring(MASTER, MANAGER, (UNIT,)), 1)
    register = start(config, 1, {}, ())
    said: list[tuple[float, str, str]] = []
    now_s = 9 * 3600.0 + 50 * MINUTE_S
    answer = unit.advance(now_s, (), Report(STANDS, (Begin(plan, signs_on=True),)))
    persons = persons_of(story)
    while now_s < 10 * 3600.0 + 10 * MINUTE_S:
        events = persons.pop(now_s, [])
        for telegram in answer.telegrams:
            heard = desk.open(telegram.data, now_s) if telegram.destination == MANAGER else None
            if isinstance(heard, Received):
                said.append((now_s, UNIT, type(heard.message).__name__))
                events.append(Heard(heard.source, heard.epoch, heard.fresh, heard.correlation, heard.message))
        back = []
        for event in events:
            before = dict(register.holders)
            register, actions = step(register, event, now_s)
            if not isinstance(event, Heard):
                assert dict(register.holders) == before
            for action in actions:
                if isinstance(action, Send):
                    said.append((now_s, MANAGER, type(action.message).__name__))
                    back.append(desk.seal(UNIT, action.message, now_s, action.correlation))
        now_s += 1.0
        answer = unit.advance(now_s, back, Report(STANDS))
    sys.stdout.write(
        json.dumps({"said": said, "held": sorted(register.holders), "waits_for": answer.command.waits_for})
        + "\n"
    )


def persons_of(story: str) -> dict[float, list[object]]:
    """What a person enters at the manager, by time."""
    if story == "neither":
        return {}
    from wayside.said import HoldTrain

    held = {9 * 3600.0 + 55 * MINUTE_S: [HoldTrain(UNIT, "controller", hold=True)]}
    return (
        held
        if story == "hold"
        else held | {10 * 3600.0 + 5 * MINUTE_S: [HoldTrain(UNIT, "controller", hold=False)]}
    )


for name in sys.argv[1:]:
    tell(name)
