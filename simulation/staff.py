"""Staff who react (係員): with `[people] react` people put right what is off, lost, broken or silent, by what is so.

They see that something has no power, that points do not lie as they must, and what the block manager shows its
controller; after a time of their own (`[people]`) they do what the rules of operation say, and again, less and less
often, while it is as it was: switch on what is off, or put it into service again; wind points to where no train is in
the way, or to where the crew of one needs them that has stopped short of the blades; bar a unit that claims what is not
so, and unbar it, again where that did not get through; see to the picture of the line until it is accepted; say, two of
them, at a level crossing whose road is closed that no train comes there; guard one that is out of order; and for a unit
whose word the manager waits for, or does not hear, two of them say where its train truly stands and what it shows that
it holds, with what their word cannot free; bring a generator to a set without the charge to go on. They act through the
injector's door, so that what they did can be written down as acts of a drill.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf
from typing import Final

from network.model import SectionKind
from onboard.crossing_notes import CrossingCreep
from onboard.notes import CrewCheckedPoints, CrewWaitsAtPoints, Holds
from radio.chance import generator
from radio.envelope import ON_THE_AIR_S
from radio.messages import ClaimQuery
from radio.noted import Sent
from simulation.events import Acted, CrossingEntered, CutOut, JournalEntry, Left, PowerOn
from simulation.faults.crossings import IN_ORDER
from simulation.faults.script import Act, ActKind, Trigger
from simulation.injector import Injector
from simulation.mad_units import MadUnits
from simulation.pauses import Pauses
from simulation.people import Pause
from simulation.roads_closed import RoadsClosedForNothing
from simulation.setup import STEP_S, STEPS_PER_S
from simulation.world.point_machine import MachineState, PointMachine
from simulation.world.stage import World
from wayside import acts
from wayside.acts import IN_STATION
from wayside.config import MANAGER_ID, ReentryMode
from wayside.crossing_said import CrossingProven
from wayside.register import ReentryStage
from wayside.said import (
    Accepted,
    Barred,
    ConfirmedByHand,
    Freed,
    Granted,
    Outside,
    PictureChanged,
    Refused,
    Started,
)

LOOKS_EVERY_STEPS: Final = STEPS_PER_S
AGAIN_S: Final = 40.0  # assumed: before the same is done again, and each time as much longer,
TIRED_AFTER: Final = 8  # up to so many times
CONTROLLER, STAFF = "controller", "staff"
LINE: Final = ""  # what an act aims at that is about the whole line


class Staff:
    """The people of one run; `acts` is what they did."""

    def __init__(self, world: World, injector: Injector, roads: RoadsClosedForNothing) -> None:
        self.acts: list[Act] = []
        self._setup, self._injector = world.setup, injector
        self._trains, self._on_board, self._wayside = world.trains, world.on_board, world.wayside
        self._charging, self._pauses = world.charging, Pauses(world.setup)
        self._next_look: float = -inf
        self._word_from_s = -inf  # before, what was granted may be on the air, and nobody's word is taken
        self._from_s: dict[tuple[Pause, str], float] = {}  # when people act on what they have seen
        self._restores = False  # the manager has lost the picture of the line
        self._stage: ReentryStage | None = None  # of its re-entry; None: nobody looks at it yet
        self._awaited: dict[str, None] = {}  # units whose word the manager waits for
        self._bars: dict[
            str, dict[str, bool]
        ] = {}  # what each person said last: whether a unit is to be barred
        self._speaks_until_s: dict[str, float] = {}
        self._spoke: dict[
            str, dict[str, tuple[str, ...]]
        ] = {}  # what each person has said that a unit holds, since that was known, or while the line is restored
        self._routes: dict[str, set[str]] = {}  # what each unit was granted and has not given back
        self._shown: dict[str, set[str]] = {}  # what each unit has shown last that it holds
        self._not_freed: dict[
            str, set[str]
        ] = {}  # what a unit holds in the picture and their word cannot free
        self._waits_at: dict[str, str] = {}  # by points: the unit whose crew waits for them to lie otherwise
        self._forgetful: set[str] = set()  # units that have booted since they were granted anything
        self._left: set[str] = set()  # units that were on the line
        # Level crossings over which trains had to creep, or that drivers saw open.
        self._reported: set[str] = set()
        self._again_s: dict[tuple[ActKind, str, str], float] = {}
        self._tries: Counter[tuple[ActKind, str, str]] = Counter()
        self._roads = roads
        self._mad = MadUnits(world.trains.slot_of, self._held)
        world.journal.watch(self._see)

    def _see(self, entry: JournalEntry) -> None:
        """An entry of the journal was written: what the manager shows its controller."""
        self._mad.see(entry)
        match entry.event:
            case Started(epoch=epoch) if entry.who == MANAGER_ID:
                self._awaited = dict.fromkeys(self._trains.stock_ids)
                self._restores, self._stage = epoch > 1, None
                self._word_from_s = entry.t_s + ON_THE_AIR_S
                self._again_s.clear()
                self._spoke.clear()
                self._from_s = {key: at for key, at in self._from_s.items() if key[0] not in _OF_MANAGER}
            case PictureChanged(stage=stage):
                self._stage = ReentryStage(stage)
                self._restores = self._stage is not ReentryStage.DEFINED
                if not self._restores:
                    self._spoke.clear()
            case Sent(source=source, receiver=unit_id, kind=ClaimQuery.__name__) if source == MANAGER_ID:
                self._awaited.setdefault(unit_id)
            case (
                Accepted(unit_id=unit_id)
                | Outside(unit_id=unit_id)
                | ConfirmedByHand(unit_id=unit_id)
                | Refused(unit_id=unit_id, why=acts.SPEAKS)
            ):
                self._awaited.pop(unit_id, None)
                self._not_freed.pop(unit_id, None)
                if not self._restores:
                    self._spoke.pop(unit_id, None)
                self._from_s.pop((Pause.SILENT, unit_id), None)
            case Acted(act=act, target=unit_id, section_ids=section_ids) if act in _WORDS:
                self._spoke.setdefault(unit_id, {})[entry.who] = section_ids
            case Acted(act=ActKind.ENTER_SECTION.value, target=unit_id, section_ids=section_ids) if (
                unit_id and entry.who not in (CONTROLLER, STAFF)
            ):
                said = self._spoke.setdefault(unit_id, {})
                said[entry.who] = (*said.get(entry.who, ()), *section_ids)
            case _:
                self._see_units(entry)

    def _see_units(self, entry: JournalEntry) -> None:
        """What becomes of units, crossings and points: barred, gone, crept over, waited at."""
        match entry.event:
            case Acted(act=act, target=unit_id) if act in _BARS:
                self._bars.setdefault(unit_id, {})[entry.who] = _BARS[act]
            case Barred(unit_id=unit_id) if entry.who == MANAGER_ID:
                self._awaited.setdefault(unit_id)
                self._word_from_s = entry.t_s + ON_THE_AIR_S
            case Refused(unit_id=unit_id, section_ids=section_ids, why=why) if why.endswith(IN_STATION):
                self._not_freed.setdefault(unit_id, set()).update(section_ids)
            case Left(unit_id=unit_id):
                self._left.add(unit_id)
                self._routes.pop(unit_id, None)
            case CrossingCreep(crossing_id=crossing_id):
                self._reported.add(crossing_id)
            case CrossingEntered(crossing_id=road) if not self._wayside.crossings.is_closed(road):
                self._reported.add(road)
            case CrossingProven():
                self._reported.discard(entry.who)
            case CrewWaitsAtPoints(points_id=points_id):
                self._waits_at[points_id] = entry.who
            case CrewCheckedPoints(points_id=points_id):
                self._waits_at.pop(points_id, None)
            case _:
                self._see_grants(entry)

    def _see_grants(self, entry: JournalEntry) -> None:
        """What units were granted and have given back, as people remember it, and which of them have forgotten it."""
        match entry.event:
            case Granted(unit_id=unit_id, section_ids=section_ids):
                self._routes.setdefault(unit_id, set()).update(section_ids)
                self._forgetful.discard(unit_id)
            case Freed(unit_id=unit_id, section_ids=section_ids):
                self._routes.get(unit_id, set()).difference_update(section_ids)
            case PowerOn(device_id=unit_id):
                self._forgetful.add(unit_id)
                self._shown.pop(unit_id, None)
            case CutOut(unit_id=unit_id):
                self._routes.pop(unit_id, None)
            case Holds(section_ids=section_ids):
                left = self._shown.get(entry.who, set()).difference(section_ids)
                self._shown[entry.who] = set(section_ids)
                self._routes.get(entry.who, set()).difference_update(left)
            case _:
                pass

    def look(self, step: int, *, worked_by_people: bool = False) -> None:
        """Look round, if it is time. Stretches are not cut for it, so it may be late by one of them. While people work
        the line without the block manager, staff see to nothing but roads.
        """
        t_s = step * STEP_S
        if worked_by_people:
            self._see_to_roads(t_s)
            return
        if step < self._next_look:
            return
        self._next_look = step + LOOKS_EVERY_STEPS
        self._see_to_power(t_s)
        self._see_to_batteries(t_s)
        for points_id in self._wayside.machines:
            self._see_to_points(t_s, points_id)
        self._see_to_bars(t_s)
        self._see_to_roads(t_s)
        self._see_to_guards(t_s)
        if MANAGER_ID not in self._wayside.down:
            self._see_to_picture(t_s)
            for unit_id in list(self._awaited):
                if self._ripe(Pause.SILENT, unit_id, t_s):
                    self._speak_for(t_s, unit_id)

    def _ripe(self, pause: Pause, what: str, t_s: float) -> bool:
        """Whether people have taken their time since they saw this first, which may be now."""
        key = (pause, what)
        if key not in self._from_s:
            self._from_s[key] = t_s + self._pauses.steps(pause, what) * STEP_S
        return t_s >= self._from_s[key]

    def _act(self, t_s: float, kind: ActKind, target: str, person: str) -> None:
        """Do it after a time of their own, and not again at once."""
        self._act_as_seen(t_s, partial(Act, kind, target, _NOW, person))

    def _act_as_seen(self, t_s: float, look: Callable[[], Act | None]) -> None:
        """Do what is seen to be needed; who comes to do it looks again, and does what is needed then, if anything."""
        if (act := look()) is None or t_s < self._again_s.get(key := (act.kind, act.target, act.person), t_s):
            return
        kind, _, person = key
        self._tries[key] += 1
        self._again_s[key] = t_s + AGAIN_S * min(self._tries[key], TIRED_AFTER)
        # Nobody says two things at once.
        from_s = max(t_s + STEP_S, self._speaks_until_s.get(person, t_s))
        at_s = round(from_s + self._pauses.steps(Pause.WORD, person) * STEP_S, 1)
        self._speaks_until_s[person] = at_s

        def done() -> Act | None:
            early = kind in _OF_THE_LINE and at_s <= self._word_from_s
            if early or (seen := look()) is None:
                self._again_s.pop(key, None)
                self._tries[key] -= 1
                return None
            self.acts.append(replace(seen, trigger=Trigger(at_s=at_s)))
            return self.acts[-1]

        self._injector.add(act, at_s, done)

    def _see_to_bars(self, t_s: float) -> None:
        """Two persons bar a unit, or unbar it once it is known what it holds, and say it again where a device does not
        know it. A register that is being restored has nothing of it, and on the open line takes its own word alone.
        """
        for kind, unit_id in self._mad.due(t_s, self._setup.people.mean_s(Pause.SILENT)):
            awaited = unit_id in self._awaited and self._mad.is_barred(unit_id)
            if kind is ActKind.UNBAR_UNIT and awaited and not self._restores:
                continue  # their word was too early: the register would have of it what it claimed falsely
            for person in (CONTROLLER, STAFF):
                self._act(t_s, kind, unit_id, person)
        for unit_id, words in self._bars.items():
            bar = next(iter(words.values()))
            agreed = len(words) > 1 and set(words.values()) == {bar}
            if not agreed or all(
                self._mad.is_barred(unit_id, device) is bar for device in self._wayside.party_ids
            ):
                self._from_s.pop((Pause.PICTURE, unit_id), None)
            elif self._ripe(Pause.PICTURE, unit_id, t_s):
                for person in words:
                    self._act(t_s, ActKind.BAR_UNIT if bar else ActKind.UNBAR_UNIT, unit_id, person)

    # power and points ---------------------------------------------------------------------------------------------

    def _see_to_power(self, t_s: float) -> None:
        """Switch on what is off; put into service again what has power and has lost its durable state."""
        units = {self._trains.stock_ids[slot]: slot for slot in sorted(self._on_board.unpowered)}
        off = (*units, *sorted(self._wayside.down))
        for key in [key for key in self._from_s if key[0] is Pause.POWER and key[1] not in off]:
            del self._from_s[key]
        for party_id in off:
            if self._ripe(Pause.POWER, party_id, t_s):
                blank = (
                    units.get(party_id) in self._on_board.uncommissioned
                    or party_id in self._wayside.uncommissioned
                )
                self._act(t_s, ActKind.COMMISSION if blank else ActKind.POWER_ON, party_id, STAFF)

    def _see_to_batteries(self, t_s: float) -> None:
        """Bring a generator to a set that stands where nothing charges it, without the charge to go on."""
        if (charging := self._charging) is None:
            return
        for slot in self._trains.active():
            unit_id = self._trains.stock_ids[slot]
            if not charging.helpless(slot):
                self._from_s.pop((Pause.REACH, unit_id), None)
            elif self._ripe(Pause.REACH, unit_id, t_s):
                self._act(t_s, ActKind.BRING_POWER, unit_id, STAFF)

    def _see_to_roads(self, t_s: float) -> None:
        """Two persons say at a level crossing that no train comes, where that is so and its road is closed."""
        closed = self._roads.for_nothing()
        for key in [key for key in self._from_s if key[0] is Pause.ROAD and key[1] not in closed]:
            del self._from_s[key]
        for crossing_id in closed:
            if crossing_id not in self._wayside.down and self._ripe(Pause.ROAD, crossing_id, t_s):
                for person in (CONTROLLER, STAFF):
                    self._act_as_seen(t_s, partial(self._free_road, crossing_id, person))

    def _free_road(self, crossing_id: str, person: str) -> Act | None:
        closed = crossing_id in self._roads.for_nothing()
        return Act(ActKind.FREE_ROAD, crossing_id, _NOW, person) if closed else None

    def _see_to_guards(self, t_s: float) -> None:
        """Somebody goes to a level crossing that is out of order, as is seen or as a driver who crept over it, or
        came onto it open, has reported, and guards it until it is in order and has proved closed again.
        """
        crossings = self._wayside.crossings
        for crossing_id, equipment in crossings.equipment.items():
            broken = crossing_id in self._wayside.down or equipment.condition != IN_ORDER
            if not broken and crossing_id not in self._reported:
                self._from_s.pop((Pause.GUARD, crossing_id), None)
                if crossing_id in crossings.guarded:
                    self._act(t_s, ActKind.LEAVE_ROAD, crossing_id, STAFF)
            elif crossing_id not in crossings.guarded and self._ripe(Pause.GUARD, crossing_id, t_s):
                self._act(t_s, ActKind.GUARD_ROAD, crossing_id, STAFF)

    def _see_to_points(self, t_s: float, points_id: str) -> None:
        if not self._need_staff(points_id):
            self._from_s.pop((Pause.POINTS, points_id), None)
        elif self._ripe(Pause.POINTS, points_id, t_s):
            self._act_as_seen(t_s, partial(self._wind, points_id))

    def _need_staff(self, points_id: str) -> bool:
        machine = self._wayside.machines[points_id]
        between = machine.state is MachineState.BETWEEN
        return bool(self._asked_for(points_id, machine) or machine.stuck or between)

    def _wind(self, points_id: str) -> Act | None:
        if not self._need_staff(points_id):
            return None
        machine = self._wayside.machines[points_id]
        position = self._asked_for(points_id, machine) or self._safe(points_id, machine)
        return Act(ActKind.REPAIR_POINTS, points_id, _NOW, STAFF, position=position) if position else None

    def _asked_for(self, points_id: str, machine: PointMachine) -> str:
        """How a crew needs points that lie otherwise, with its train in their section and short of the blades, where
        no unit throws them; empty: none does, or others are in the way.
        """
        unit_id = self._waits_at.get(points_id, "")
        if not unit_id or machine.key or machine.state is not MachineState.AT_REST:
            return ""
        points, slot = self._setup.line.points[points_id], self._trains.slot_of[unit_id]
        legs = {points.normal_piece: "normal", points.reverse_piece: "reverse"}
        near = [
            (other, piece)
            for other in self._trains.active()
            for piece in self._trains.pieces_under(other) & {points.stem_piece, *legs}
        ]
        if len(near) != 1 or near[0][0] != slot:
            return ""
        way = (step.piece_id for step in self._trains.true_path(slot).steps)
        needed = next((legs[piece] for piece in way if piece in legs), "")
        return needed if machine.position is None or machine.position.value != needed else ""

    def _safe(self, points_id: str, machine: PointMachine) -> str:
        """As they lie, or as the train on them needs them; lying nowhere and free, either; empty: wait."""
        if machine.position is not None:
            return machine.position.value
        points = self._setup.line.points[points_id]
        under = {piece for slot in self._trains.active() for piece in self._trains.pieces_under(slot)}
        legs = {points.normal_piece: "normal", points.reverse_piece: "reverse"}
        taken = [position for piece, position in legs.items() if piece in under]
        if taken:
            return taken[0] if len(taken) == 1 else ""
        if points.stem_piece in under:
            return ""
        tries = self._tries[ActKind.REPAIR_POINTS, points_id, STAFF]
        chance = generator(self._setup.seed, "staff", points_id, str(tries), *self._setup.today)
        return tuple(legs.values())[int(chance.integers(2))]

    # the picture of the line --------------------------------------------------------------------------------------

    def _see_to_picture(self, t_s: float) -> None:
        """By hand all of it is entered again and again; else the controller looks by himself until he can accept it."""
        if not self._restores or not self._ripe(Pause.PICTURE, LINE, t_s):
            return
        self._see_to_words(t_s)
        if self._setup.operation.reentry is ReentryMode.BY_HAND:
            self._enter_all(t_s)
            return
        self._say_who_left(t_s)
        self._say_what_was_granted(t_s)
        if (
            ActKind.REENTER_ASSISTED,
            LINE,
            CONTROLLER,
        ) not in self._again_s or self._stage is ReentryStage.COMPLETE:
            self._act(t_s, ActKind.REENTER_ASSISTED, LINE, CONTROLLER)

    def _see_to_words(self, t_s: float) -> None:
        """Who has said more of a unit than is so takes it back once the unit speaks for itself: it would block."""
        for unit_id, said in self._spoke.items():
            for person in said:
                self._act_as_seen(t_s, partial(self._taken_back, unit_id, person))

    def _taken_back(self, unit_id: str, person: str) -> Act | None:
        said = self._spoke.get(unit_id, {}).get(person, ())
        if unit_id in self._awaited or not set(said).difference(self._held(self._trains.slot_of[unit_id])):
            return None
        return Act(ActKind.TAKE_BACK, unit_id, _NOW, person)

    def _say_who_left(self, t_s: float) -> None:
        """By which portal those have left that the manager may yet have on the line; else all is to be swept."""
        for slot, unit_id in enumerate(self._trains.stock_ids):
            if unit_id in self._left:
                self._act_as_seen(t_s, partial(self._off_the_line, slot, CONTROLLER))

    def _say_what_was_granted(self, t_s: float) -> None:
        """What units were granted and have forgotten: else another train may come to where they have to go on."""
        for slot in self._trains.active():
            self._act_as_seen(t_s, partial(self._entered_as_granted, slot))

    def _entered_as_granted(self, slot: int) -> Act | None:
        granted, unit_id = self._granted_ahead(slot), self._trains.stock_ids[slot]
        return Act(ActKind.ENTER_SECTION, unit_id, _NOW, CONTROLLER, granted) if granted else None

    def _granted_ahead(self, slot: int) -> tuple[str, ...]:
        """What lies ahead of the train of the route that its unit has forgotten, as the controller remembers it."""
        unit_id, line = self._trains.stock_ids[slot], self._setup.line
        if unit_id not in self._forgetful:
            return ()
        front_m = float(self._trains.truths[slot].position_m)
        pieces = (step.piece_id for step in self._trains.true_path(slot).steps if step.start_m > front_m)
        route = self._routes.get(unit_id, set())
        others = (under for other, under in self._trains.sections_under().items() if other != unit_id)
        free = route.difference(*others)
        return tuple(dict.fromkeys(s for p in pieces if (s := line.pieces[p].section_id) in free))

    def _enter_all(self, t_s: float) -> None:
        """Two persons enter every section of the line, alike; one accepts the picture."""
        for person in (CONTROLLER, STAFF):
            for unit_id in (*self._trains.stock_ids, LINE):
                self._act_as_seen(t_s, partial(self._entered, unit_id, person))
        self._act(t_s, ActKind.ACCEPT_PICTURE, LINE, CONTROLLER)

    def _entered(self, unit_id: str, person: str) -> Act | None:
        """What is a unit's, or nobody's; none: there is no such section."""
        held = {other: self._held(slot) for slot, other in enumerate(self._trains.stock_ids)}
        taken = {section for mine in held.values() for section in mine}
        free = tuple(section for section in self._setup.line.sections if section not in taken)
        sections = held.get(unit_id, free)
        return Act(ActKind.ENTER_SECTION, unit_id, _NOW, person, sections) if sections else None

    def _speak_for(self, t_s: float, unit_id: str) -> None:
        """Two persons say of a silent unit what is so, and so does who has said anything else of it: for their word
        counts only where nobody has it in more.
        """
        slot = self._trains.slot_of[unit_id]
        for person in dict.fromkeys((CONTROLLER, STAFF, *self._spoke.get(unit_id, ()))):
            self._act_as_seen(t_s, partial(self._off_the_line, slot, person))
            self._act_as_seen(t_s, partial(self._standing, slot, person))

    def _off_the_line(self, slot: int, person: str) -> Act | None:
        if self._held(slot):
            return None
        unit_id, portal = self._trains.stock_ids[slot], self._portal(slot)
        return Act(ActKind.CONFIRM_OUTSIDE, unit_id, _NOW, person, place=portal)

    def _standing(self, slot: int, person: str) -> Act | None:
        """What a train is in and holds, with what the word cannot free; of one that moves nobody can say it."""
        unit_id, held = self._trains.stock_ids[slot], self._held(slot)
        if not held or self._trains.plants[slot].speed_mps > 0.0:
            return None
        said = {*held, *self._not_freed.get(unit_id, ())}
        in_order = tuple(section for section in self._setup.line.sections if section in said)
        return Act(ActKind.CONFIRM_HOLDING, unit_id, _NOW, person, in_order)

    def _portal(self, slot: int) -> str:
        """The portal before which stock that is not on the line stands."""
        duty, line = self._trains.duties[slot], self._setup.line
        spans = () if duty is None else duty.mission.spans
        portals = [section.id for section in line.sections.values() if section.kind is SectionKind.PORTAL]
        return next((s.section_id for s in reversed(spans) if s.section_id in portals), (*portals, "")[0])

    def _held(self, slot: int) -> tuple[str, ...]:
        """What the train occupies, and what its unit shows or has forgotten beyond that, in the order of the line;
        of one that is off it, the portal by which it may come in at any time.
        """
        under = self._trains.sections_under().get(self._trains.stock_ids[slot])
        shown = self._on_board.shown_to_driver(slot).held
        if under is None:
            return () if slot in self._on_board.unpowered else shown
        held = under.union(shown, self._granted_ahead(slot))
        return tuple(section for section in self._setup.line.sections if section in held)


_NOW: Final = Trigger(at_s=0.0)  # of what is seen; when it is done is said then
_BARS: Final = {ActKind.BAR_UNIT.value: True, ActKind.UNBAR_UNIT.value: False}
_OF_THE_LINE: Final = (
    ActKind.CONFIRM_HOLDING,
    ActKind.CONFIRM_OUTSIDE,
    ActKind.TAKE_BACK,
    ActKind.ENTER_SECTION,
)
_WORDS: Final = tuple(kind.value for kind in _OF_THE_LINE[:3])
_OF_MANAGER: Final = (Pause.PICTURE, Pause.SILENT)
