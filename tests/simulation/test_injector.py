"""What link faults make of telegrams, and what people enter, without a world around."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Position
from onboard.duty.records import DrivingCommand
from radio.air import Delivery
from simulation.agenda import Agenda
from simulation.events import WORLD, Acted, FaultBegan, FaultOver, PointsMoving
from simulation.faults import links
from simulation.faults.devices import LostStore, PowerCut, Restart
from simulation.faults.fault import InForce
from simulation.faults.points import Stuck
from simulation.faults.script import Act, ActKind, Script, ScriptedFault, Trigger, matcher_of
from simulation.faults.tag_reader import Miss
from simulation.injector import Injector
from simulation.journal import Journal
from simulation.people import People
from simulation.setup import STEPS_PER_S
from simulation.world.point_machine import PointMachine
from wayside.point_terminal import Commitment, TerminalMemory
from wayside.said import (
    Accepted,
    AcceptPicture,
    ConfirmHolding,
    ConfirmOutside,
    EnterSection,
    Freed,
    Granted,
    PictureChanged,
    Started,
    TakeBack,
)

SENT = (Delivery(100, b"telegram"),)


AT_ONCE = People(times=0.0)


class World:
    """Stands for trains and wayside; keeps what is done to it."""

    def __init__(self, *script: ScriptedFault | Act, seed: int = 1, people: People = AT_ONCE) -> None:
        self.inputs: list[tuple[str, Any]] = []
        self.switched: list[tuple[str, bool]] = []
        self.repaired: list[str] = []
        self.given_back: list[tuple[str, float]] = []
        self.commissioned: list[tuple[str, int]] = []
        self.lost: list[str | int] = []
        self.memories: list[bytes] = []
        self.hauled: list[str] = []
        shown = [DrivingCommand(on_line=True, held=("3", "5")), DrivingCommand(on_line=False, held=("PW",))]
        on_board: Any = SimpleNamespace(
            shown_to_driver=shown.__getitem__,
            unpowered=set[int](),
            uncommissioned={0},
            lose_store=self.lost.append,
        )
        self.unpowered, self.under = on_board.unpowered, dict[str, frozenset[str]]()
        self.wayside: Any
        trains: Any = SimpleNamespace(
            stock_ids=("K1", "K2"),
            slot_of={"K1": 0, "K2": 1},
            tag_faults={},
            sections_under=lambda: self.under,
            setup=SimpleNamespace(people=people, seed=seed, today=()),
        )
        self.trains, self.tag_faults = trains, trains.tag_faults
        self.wayside = SimpleNamespace(
            section_ids=("PW", "3", "5"),
            input=lambda _step, device, value: self.inputs.append((device, value)),
            machines={"P7": PointMachine("P7", 5.0, Position.NORMAL)},
            set_machine=lambda _step, machine: self.wayside.machines.update({machine.points_id: machine}),
            repair=lambda _step, points, _position: self.repaired.append(points),
            power_on=lambda _step, device: self.switched.append((device, True)),
            power_off=lambda _step, device: self.switched.append((device, False)),
            points_of={"B-W": {"P7": "7"}},
            uncommissioned={"B-W"},
            lose_store=self.lost.append,
            commission=self._commission,
        )
        self.journal, self.agenda, self.in_force = Journal(), Agenda(), InForce()
        world: Any = SimpleNamespace(
            setup=trains.setup,
            journal=self.journal,
            agenda=self.agenda,
            in_force=self.in_force,
            trains=trains,
            wayside=self.wayside,
            on_board=on_board,
            charging=None,
            road=None,
        )
        cabs: Any = SimpleNamespace(
            power_off=lambda slot, _step: self.switched.append((trains.stock_ids[slot], False)),
            set_back=lambda slot, _step, hold_s: self.given_back.append((trains.stock_ids[slot], hold_s)),
        )
        duties: Any = SimpleNamespace(
            power_on=lambda slot, _step: self.switched.append((trains.stock_ids[slot], True)),
            commission=lambda slot, _step, number: self.commissioned.append((trains.stock_ids[slot], number)),
            haul_away=lambda slot, _step: self.hauled.append(trains.stock_ids[slot]),
        )
        told = Script(
            tuple(s for s in script if isinstance(s, ScriptedFault)),
            tuple(s for s in script if isinstance(s, Act)),
        )
        self.injector = Injector(told, world, cabs, duties, platforms=cabs)
        self.injector.start(0)

    def _commission(self, _step: int, device_id: str, number: int, vital: bytes) -> None:
        self.commissioned.append((device_id, number))
        self.memories.append(vital)

    def run_to(self, step: int) -> None:
        while (item := self.agenda.pop_due(step)) is not None:
            self.injector.due(item.step, item.subject)

    def sent(self, source: str, destination: str) -> tuple[Delivery, ...]:
        return links.disturbed(self.in_force, source, destination, SENT)


def failing(fault: links.LinkFault) -> ScriptedFault:
    return ScriptedFault(fault, Trigger(at_s=1.0), 10.0)


ALL = links.FaultyLink("*", "*", both_ways=True)


def test_a_cut_lasts_as_long_as_it_is_said_to_and_cuts_no_other_link() -> None:
    world = World(failing(links.Cut(target=links.FaultyLink("K1", "block-manager", both_ways=True))))
    assert world.sent("K1", "block-manager") == SENT
    world.run_to(1 * STEPS_PER_S)
    assert world.sent("K1", "block-manager") == world.sent("block-manager", "K1") == ()
    assert world.sent("K2", "block-manager") == world.sent("K1", "B-W") == SENT
    world.run_to(11 * STEPS_PER_S)
    assert world.sent("K1", "block-manager") == SENT
    assert [type(entry.event) for entry in world.journal.entries] == [FaultBegan, FaultOver]


def test_one_way_cuts_one_way() -> None:
    world = World(failing(links.Cut(target=links.FaultyLink("B-W", "K1"))))
    world.run_to(10)
    assert world.sent("B-W", "K1") == ()
    assert world.sent("K1", "B-W") == SENT


@given(st.integers(0, 2**16))
def test_a_flip_turns_exactly_one_bit(seed: int) -> None:
    world = World(failing(links.Flip(target=ALL, p=1.0)), seed=seed)
    world.run_to(10)
    (delivery,) = world.sent("K1", "B-W")
    turned = [a ^ b for a, b in zip(delivery.data, SENT[0].data, strict=True)]
    assert sum(byte.bit_count() for byte in turned) == 1
    assert delivery.step == SENT[0].step


@pytest.mark.parametrize(
    ("fault", "steps"),
    [
        (links.Delay(target=ALL, seconds=3.0), [130]),
        (links.Reorder(target=ALL, p=1.0, seconds=1.5), [115]),
        (links.Reorder(target=ALL, p=0.0), [100]),
        (links.Duplicate(target=ALL, p=1.0), [100, 101]),
        (links.Loss(target=ALL, p=1.0), []),
        (links.Loss(target=ALL, p=0.0), [100]),
    ],
)
def test_when_a_disturbed_telegram_arrives(fault: links.LinkFault, steps: list[int]) -> None:
    world = World(failing(fault))
    world.run_to(10)
    found = world.sent("K1", "B-W")
    assert [delivery.step for delivery in found] == steps
    assert all(delivery.data == SENT[0].data for delivery in found)


def test_losses_come_as_often_as_said_and_the_same_with_the_same_seed() -> None:
    def lost(seed: int) -> list[bool]:
        world = World(failing(links.Loss(target=ALL, p=0.3)), seed=seed)
        world.run_to(10)
        return [not world.sent("K1", "B-W") for _ in range(2000)]

    assert lost(1) == lost(1) != lost(2)
    assert sum(lost(1)) / 2000 == pytest.approx(0.3, abs=0.04)  # four standard deviations


def test_what_fails_on_two_links_at_once_is_drawn_for_each() -> None:
    units = ("K1", "K2")
    world = World(*(failing(links.Loss(target=links.FaultyLink(unit, "B-W"), p=0.5)) for unit in units))
    world.run_to(10)
    alike = sum(world.sent("K1", "B-W") == world.sent("K2", "B-W") for _ in range(2000))
    assert alike / 2000 == pytest.approx(0.5, abs=0.045)  # four standard deviations


def test_power_goes_off_and_comes_back_on_units_and_devices() -> None:
    off = [ScriptedFault(PowerCut(target=target), Trigger(at_s=1.0), 2.0) for target in ("K1", "B-W")]
    world = World(*off, ScriptedFault(Restart(target="block-manager"), Trigger(at_s=5.0)))
    world.run_to(29)
    assert world.switched == [("K1", False), ("B-W", False)]
    world.run_to(100)
    assert world.switched[2:] == [
        ("K1", True),
        ("B-W", True),
        ("block-manager", False),
        ("block-manager", True),
    ]


def test_a_store_is_lost_with_the_power() -> None:
    world = World(*(ScriptedFault(LostStore(target=who), Trigger(at_s=1.0), 5.0) for who in ("K1", "B-W")))
    world.run_to(2 * STEPS_PER_S)
    assert world.switched == [("K1", False), ("B-W", False)]
    assert world.lost == [0, "B-W"]
    world.run_to(6 * STEPS_PER_S)
    assert world.switched[2:] == [("K1", True), ("B-W", True)]
    assert len(world.lost) == 2


def test_people_commission_what_waits_for_it_each_time_with_a_greater_number() -> None:
    acts = [Act(ActKind.COMMISSION, who, Trigger(at_s=1.0)) for who in ("K1", "K2", "B-W", "B-E", "K1")]
    world = World(*acts)
    world.run_to(1 * STEPS_PER_S)
    assert world.commissioned == [("K1", 2), ("B-W", 2), ("K1", 3)]


def test_a_terminal_commissioned_again_takes_no_command_under_an_older_token_than_the_last_given() -> None:
    """Whoever was given the section last goes on; of one that persons spoke for, nobody does. Either may rely on the
    points; who has given the section back does not.
    """
    world = World(*(Act(ActKind.COMMISSION, "B-W", Trigger(at_s=at_s)) for at_s in (1.0, 2.0, 3.0)))
    for unit_id, token in (("K1", 5), ("K2", 6)):
        granted = Granted(unit_id=unit_id, section_ids=("5", "7"), token=token, route_id="r")
        world.journal.write(0.5, "block-manager", granted)
    again = Accepted(unit_id="K2", section_ids=("7",), token=9, was="unknown")
    world.journal.write(0.6, "block-manager", again)
    world.run_to(1 * STEPS_PER_S)
    world.journal.write(1.5, "block-manager", Freed(unit_id="K2", section_ids=("7",), by="Sato"))
    world.run_to(2 * STEPS_PER_S)
    world.journal.write(2.5, "block-manager", again)
    world.journal.write(2.6, "block-manager", Freed(unit_id="K2", section_ids=("7",), token=9))
    world.run_to(3 * STEPS_PER_S)
    memories = [msgspec.msgpack.decode(vital, type=TerminalMemory) for vital in world.memories]
    relied_on = {"P7": Commitment("K2", None, 6)}
    assert memories == [
        TerminalMemory({"7": 6}, relied_on),
        TerminalMemory({"7": 7}, relied_on),
        TerminalMemory({"7": 9}),
    ]


def test_an_event_begins_a_fault_with_its_delay() -> None:
    from simulation.faults.script import matcher_of

    on = matcher_of("points P7 move")
    world = World(ScriptedFault(Miss(target="602"), Trigger(on=on, after_s=2.0), 3.0))
    world.run_to(1000)
    assert world.tag_faults == {}
    world.journal.write(200.0, WORLD, PointsMoving(points_id="P7", target=Position.REVERSE))
    world.run_to(2020)
    assert world.tag_faults == {602: None}
    world.run_to(2050)
    assert world.tag_faults == {}


def test_re_entry_by_hand_enters_every_section_by_what_units_on_the_line_hold() -> None:
    world = World(Act(ActKind.REENTER_BY_HAND, "", Trigger(at_s=1.0), "Sato"))
    world.run_to(10)
    assert world.inputs == [
        ("block-manager", EnterSection("PW", None, "Sato")),
        ("block-manager", EnterSection("3", "K1", "Sato")),
        ("block-manager", EnterSection("5", "K1", "Sato")),
        ("block-manager", AcceptPicture("Sato")),
    ]


SLOW = People(sigma=0.0, word_s=4.0)


def test_words_of_a_person_come_one_after_the_other() -> None:
    """Without a pace of its own each word takes a time of `[people]`; with one, that."""
    for act, every in ((Act(ActKind.REENTER_BY_HAND, "", Trigger(at_s=1.0)), 40), (_PACED, 20)):
        world = World(act, people=SLOW)
        for count in range(1, 5):
            world.run_to(10 + every * count - 1)
            assert len(world.inputs) == count - 1
            world.run_to(10 + every * count)
            assert len(world.inputs) == count


_PACED = Act(ActKind.REENTER_BY_HAND, "", Trigger(at_s=1.0), pace_s=2.0)


def test_several_sections_are_several_words_the_first_at_the_time_of_the_act() -> None:
    world = World(Act(ActKind.ENTER_SECTION, "K1", Trigger(at_s=1.0), "Sato", ("PW", "3", "5")), people=SLOW)
    counts = []
    for step in (9, 10, 49, 50, 89, 90):
        world.run_to(step)
        counts.append(len(world.inputs))
    assert counts == [0, 1, 1, 2, 2, 3]


def test_who_waits_for_an_event_acts_some_time_after_it() -> None:
    at_points = matcher_of("points P7 move")
    act = Act(ActKind.TAKE_BACK, "K1", Trigger(on=at_points), "Sato")
    said = replace(act, trigger=replace(act.trigger, after_s=1.0))
    for item, begins in ((act, 140), (said, 110)):
        world = World(item, people=SLOW)
        world.journal.write(10.0, WORLD, PointsMoving(points_id="P7", target=Position.NORMAL))
        world.run_to(begins - 1)
        assert world.inputs == []
        world.run_to(begins)
        assert len(world.inputs) == 1


def test_re_entry_by_hand_enters_where_trains_truly_stand_too() -> None:
    """Of a unit that holds nothing its crew says by voice where the train is."""
    world = World(Act(ActKind.REENTER_BY_HAND, "", Trigger(at_s=1.0), "Sato"))
    world.trains.sections_under = lambda: {"K2": {"PW"}}
    world.run_to(10)
    assert ("block-manager", EnterSection("PW", "K2", "Sato")) in world.inputs


def test_a_controller_accepts_the_gathered_claims_once_nothing_is_missing() -> None:
    """Looks at the picture every ten seconds: it is incomplete from the manager's second start on."""
    world = World(Act(ActKind.REENTER_ASSISTED, "", Trigger(at_s=2.0), "Sato"))
    world.journal.write(1.0, "block-manager", Started(epoch=2))
    world.run_to(419)
    assert world.inputs == []
    world.journal.write(42.0, "block-manager", PictureChanged(stage="complete", inputs=0))
    world.run_to(419)
    assert world.inputs == []
    world.run_to(420)
    assert world.inputs == [("block-manager", AcceptPicture("Sato"))]


@pytest.mark.parametrize(
    ("act", "sections", "unsaid"),
    [
        (ActKind.CONFIRM_HOLDING, ("3", "5"), ()),
        (ActKind.CONFIRM_HOLDING, ("3",), ("5",)),
        (ActKind.CONFIRM_OUTSIDE, (), ("3", "5")),
        (ActKind.TAKE_BACK, (), ()),
    ],
)
def test_what_a_word_leaves_out_is_told(
    act: ActKind, sections: tuple[str, ...], unsaid: tuple[str, ...]
) -> None:
    """Of what its unit shows; of one without power, of what its train stands in."""
    world = World(*(Act(act, "K1", Trigger(at_s=at_s), "staff", sections) for at_s in (1.0, 2.0)))
    world.run_to(10)
    world.unpowered.add(0)
    world.under["K1"] = frozenset({"3"})
    world.run_to(20)
    told = [e.event.unsaid_section_ids for e in world.journal.entries if isinstance(e.event, Acted)]
    assert told == [unsaid, tuple(section_id for section_id in unsaid if section_id == "3")]


def test_other_acts_reach_whom_they_are_meant_for() -> None:
    world = World(
        Act(ActKind.ENTER_SECTION, "K2", Trigger(at_s=1.0), sections=("3",)),
        Act(ActKind.ACCEPT_PICTURE, "", Trigger(at_s=1.0)),
        Act(ActKind.GIVE_BACK, "K1", Trigger(at_s=1.0), "crew", hold_s=60.0),
        Act(ActKind.HAUL_AWAY, "K2", Trigger(at_s=1.0), "staff"),
        Act(ActKind.CONFIRM_OUTSIDE, "K2", Trigger(at_s=1.0), "staff", place="PW"),
        Act(ActKind.TAKE_BACK, "K2", Trigger(at_s=1.0), "staff"),
        Act(ActKind.CONFIRM_HOLDING, "K2", Trigger(at_s=1.0), "staff", ("3",)),
    )
    world.run_to(10)
    assert world.inputs == [
        ("block-manager", EnterSection("3", "K2", "controller")),
        ("block-manager", ConfirmOutside("K2", "staff", "PW")),
        ("block-manager", TakeBack("K2", "staff")),
        ("block-manager", ConfirmHolding("K2", ("3",), "staff")),
        ("block-manager", AcceptPicture("controller")),
    ]
    assert world.given_back == [("K1", 60.0)]
    assert world.hauled == ["K2"]


def test_a_person_who_switches_on_ends_every_power_cut_of_the_device() -> None:
    cuts = [ScriptedFault(PowerCut(target="B-W"), Trigger(at_s=at_s), 100.0) for at_s in (1.0, 2.0)]
    other = ScriptedFault(PowerCut(target="K1"), Trigger(at_s=1.0))
    world = World(*cuts, other, Act(ActKind.POWER_ON, "B-W", Trigger(at_s=5.0), "staff"))
    world.run_to(50)
    assert world.switched[-1] == ("B-W", True)
    told = len(world.journal.entries)
    world.run_to(2000)
    assert len(world.journal.entries) == told  # their own ends are nothing any more
    assert [course.over_s for course in world.injector.courses] == [5.0, 5.0, None, None]


def test_a_repair_ends_the_faults_of_those_points_for_good() -> None:
    stuck = [ScriptedFault(Stuck(target="P7"), Trigger(at_s=at_s)) for at_s in (1.0, 2.0)]
    world = World(*stuck, Act(ActKind.REPAIR_POINTS, "P7", Trigger(at_s=5.0), "staff", position="normal"))
    world.run_to(40)
    assert world.wayside.machines["P7"].stuck
    world.run_to(60)
    assert not world.wayside.machines["P7"].stuck
    assert world.repaired == ["P7"]


def test_started_again_without_power_a_device_stays_off() -> None:
    off = ScriptedFault(PowerCut(target="B-W"), Trigger(at_s=1.0), 10.0)
    world = World(off, ScriptedFault(Restart(target="B-W"), Trigger(at_s=5.0)))
    world.run_to(60)
    assert not any(on for _, on in world.switched)
    world.run_to(110)
    assert world.switched[-1] == ("B-W", True)


def test_an_act_added_during_the_run_is_done_at_its_time_after_those_of_the_script() -> None:
    accept = Act(ActKind.ACCEPT_PICTURE, "", Trigger(at_s=30.0))
    world = World(ScriptedFault(PowerCut(target="A-W"), Trigger(at_s=1.0), 5.0), accept)
    world.run_to(100)
    switch_on = Act(ActKind.POWER_ON, "K1", Trigger(at_s=40.0), "staff")
    world.injector.add(switch_on, 40.0)
    world.injector.add(replace(accept, person="staff"), 20.0)
    world.run_to(399)
    assert world.inputs == [
        ("block-manager", AcceptPicture("staff")),
        ("block-manager", AcceptPicture("controller")),
    ]
    assert [course.begun_s for course in world.injector.courses] == [1.0, 30.0, 20.0]
    world.run_to(400)
    assert [course.item for course in world.injector.courses[1:]] == [
        accept,
        switch_on,
        replace(accept, person="staff"),
    ]


def test_who_looks_again_says_what_is_so_then_or_nothing() -> None:
    world = World()
    before = Act(ActKind.CONFIRM_HOLDING, "K1", Trigger(at_s=0.0), sections=("3",))
    now = replace(before, sections=("3", "3-4", "4"))
    world.injector.add(before, 20.0, lambda: now)
    world.injector.add(before, 30.0, lambda: None)
    world.injector.add(before, 40.0)
    world.run_to(400)
    assert [word.section_ids for _, word in world.inputs] == [now.sections, before.sections]
    assert [(course.item, course.begun_s) for course in world.injector.courses] == [
        (now, 20.0),
        (before, 40.0),
    ]


def test_a_script_can_be_taken_up_later() -> None:
    """As if it had been there from the beginning: the same items at the same steps, what is past at once."""
    failures = (
        ScriptedFault(links.Cut(target=links.FaultyLink("K1", "K2")), Trigger(at_s=12.0), 5.0),
        ScriptedFault(Restart(target="K1"), Trigger(at_s=3.0, after_s=1.0)),
    )
    world = World()
    world.injector.take_up(Script(failures), 100)
    due = []
    while (item := world.agenda.pop_due(1000)) is not None:
        due.append((item.step, item.subject))
        world.injector.due(item.step, item.subject)
    assert due == [(100, "begin 1"), (120, "begin 0"), (170, "end 0")]
    assert world.switched == [("K1", False), ("K1", True)]
    assert [course.item for course in world.injector.courses] == list(failures)
    world.injector.take_up(Script((replace(failures[0], trigger=Trigger(at_s=25.0)),)), 200)  # behind those
    world.run_to(250)
    assert [course.item for course in world.injector.courses][:2] == list(failures)
    assert [course.begun_s for course in world.injector.courses] == [12.0, 10.0, 25.0]


def test_a_script_that_waits_for_events_cannot_be_taken_up() -> None:
    trigger = Trigger(on=matcher_of("points P7 move"))
    with pytest.raises(ValueError, match="by time"):
        World().injector.take_up(Script((ScriptedFault(Restart(target="K1"), trigger),)), 100)
