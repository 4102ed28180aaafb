"""The loop that joins all parties: the compiled kernel, the carrier, the wayside, the units, the checkers.

Pure simulated time: a run is a function of its setup and seed. `step` counts steps of 0.1 s from midnight.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from host.parties import Parties
from host.units import Units
from onboard.duty.records import FoundByOtherSensor, Looked, TagBelieved
from onboard.records import EVENT_STOPPED
from radio.noted import LostWhere
from simulation.agenda import AgendaKind, Item
from simulation.cabs import CREW, Cabs
from simulation.carriers.carrier import Truth
from simulation.carriers.road import CarrierOf, Road
from simulation.carriers.road_shown import ObstacleDetectors
from simulation.duties import Duties, WrongEnd
from simulation.events import WORLD, BatteryAt, Collision, Danger, TagPassed, Unsafe
from simulation.facts import checkers_of
from simulation.faults.script import Act, Script, ScriptedFault
from simulation.foreseen import ForeseenStretch, Stretches, TrainMotion
from simulation.injector import Injector
from simulation.journal import Journal
from simulation.judge.speed import NOT_RUN, RunSince
from simulation.late_day import late_day
from simulation.people import Pause
from simulation.platforms import Platforms
from simulation.result import Ending, RunResult, StopRecord, numbers_due
from simulation.setup import STEP_S, STEPS_PER_S, Setup
from simulation.staff import Staff
from simulation.toes import Toes
from simulation.vigil import Vigil
from simulation.worked_by_people import worked_by_people
from simulation.world.charging import Charging
from simulation.world.kernel import STANDING_STEPS_MAX
from simulation.world.records import (
    PASSED_FROM_A_STAND,
    PASSED_FRONT,
    PASSED_REAR,
    PASSED_TAG,
    PASSED_TO_A_STAND,
)
from simulation.world.roster import begins_s, drawn_up
from simulation.world.stage import world_of
from simulation.world.trains import SIGN
from sumo_cfg.truth_map import NetMap

WATCHING_STEPS: Final = 5  # while drivers on sight look out for another train

Progress = Callable[[float, float, int], None]  # now s, end s, trains arrived


class Simulation:
    """One run. `run` may be called once, or its parts, in their order."""

    def __init__(
        self,
        setup: Setup,
        carrier_of: CarrierOf,
        parties: Parties,
        net: NetMap,
        units: Units,
        link: str,
        journal: Journal | None = None,
        road: Road | None = None,
        detectors: ObstacleDetectors | None = None,
    ) -> None:
        self.setup: Final = setup
        self.journal = journal or Journal()
        duties = drawn_up(setup, setup.believed_line)
        self._begin_step = round(begins_s(duty for drawn in duties.values() for duty in drawn) / STEP_S)
        self._limit_step = round(setup.latest_end_s / STEP_S)
        self._step = self._begin_step
        self._carrier = carrier_of(self._begin_step / STEPS_PER_S, road)
        world = world_of(setup, duties, self.journal, self._carrier, parties, units, road)
        self.trains: Final = world.trains
        self.wayside: Final = world.wayside
        self.on_board: Final = world.on_board
        self._agenda, self._books = world.agenda, world.books
        self._charging, self._signs, self._lookout = world.charging, world.signs, world.lookout
        self.checkers = checkers_of(setup, net, self.trains.stock_ids)
        self.journal.watch(self.checkers.journal)
        self.trains.rail_is.add(self._rail_is)
        self._link = link
        self._cabs = Cabs(world)
        self._duties = Duties(world, self._cabs, self.checkers)
        day = late_day(setup)
        self._platforms = Platforms(world, self._cabs, day)
        self._toes = Toes(world, self._unsafe)
        self._road, self._detectors = road, detectors or self.wayside.crossings
        self._stretches = Stretches(self.trains)
        self._ahead: ForeseenStretch | None = None
        self._moved_step = self._begin_step
        self._broken: Ending | None = None
        self._vigil = Vigil(world, self._cabs, self._duties, self.checkers, self._begin_step)
        self._closed = False
        self._collisions: tuple[str, ...] = ()
        script = replace(setup.script, faults=(*setup.script.faults, *day.failures))
        self.by_people: Final = worked_by_people(world, self._cabs, self._duties)
        by_role = None if self.by_people is None else self.by_people.act
        self.injector: Final = Injector(script, world, self._cabs, self._duties, self._platforms, by_role)
        self.staff: Final = Staff(world, self.injector, self._vigil.roads) if setup.people.react else None

    @property
    def step(self) -> int:
        """The present step."""
        return self._step

    @property
    def begin_step(self) -> int:
        """The step at which the run began."""
        return self._begin_step

    @property
    def now_s(self) -> float:
        """Simulated time, s since midnight."""
        return self._step / STEPS_PER_S

    def run(self, progress: Progress | None = None, stop: Callable[[], bool] | None = None) -> RunResult:
        """Run to the end: all trains done, the time limit, a stall, a collision, or a wish to `stop`."""
        try:
            self.begin()
            return self.finish(progress, stop)
        finally:
            self.close()

    def close(self) -> None:
        """Release the carrier. May be called more than once."""
        if not self._closed:
            self._closed = True
            self._collisions = self._carrier.collisions()
            self._carrier.close()

    # the course of the run: `begin`, then `settle` and `advance` in turn, then `finish` ---------------------------

    def begin(self) -> None:
        """Let everything begin that has a time of its own."""
        self.wayside.start(self._step)
        self.injector.start(self._step)
        if self.by_people is not None:
            self.by_people.begin(self._step)
        self._duties.open(self._step)

    def finish(self, progress: Progress | None = None, stop: Callable[[], bool] | None = None) -> RunResult:
        """Run on to the end, or until between two stretches somebody wants it to `stop`."""
        end_s = self._limit_step / STEPS_PER_S
        while (because := self.settle()) is None:
            if stop is not None and stop():
                because = Ending.STOPPED
                break
            self.go_on()
            if progress is not None:
                progress(self.now_s, end_s, len(self._books.arrived))
        return self.result_of(because)

    def go_on(self) -> None:
        """Run one stretch, and look whether anybody waits for nothing."""
        self.advance()
        self._vigil.look(self._step)

    def result_of(self, because: Ending) -> RunResult:
        """What the run leaves behind that has ended, and why; the carrier is released."""
        self.close()
        return self._result(because, self._collisions)

    def settle(self) -> Ending | None:
        """Do what is due now. Returns why the run is over; None while it goes on."""
        self._lookout.look(self._step)
        if self.staff is not None:
            busy = self.by_people is not None and self.by_people.busy
            self.staff.look(self._step, worked_by_people=busy)
        while (item := self._agenda.pop_due(self._step)) is not None:
            self._handle(item)
        if self.by_people is not None:
            self.by_people.look(self._step)
        if self._duties.all_done() and not (self.staff is not None and self._vigil.roads.for_nothing()):
            return Ending.FINISHED
        if self._broken is not None:
            return self._broken
        if self._step >= self._limit_step:
            return Ending.TIME_LIMIT if self.setup.until_s == math.inf else Ending.PART_OVER
        return Ending.STALLED if self._stalled() else None

    @property
    def horizon_step(self) -> int:
        """No stretch that begins now goes beyond this step."""
        horizon = min(self._step + STANDING_STEPS_MAX, self._limit_step)
        next_due = self._agenda.next_step()
        return horizon if next_due is None else min(horizon, next_due)

    def has_finished(self, stock_id: str) -> bool:
        """Whether nothing follows for a stock."""
        return self._duties.finished(self.trains.slot_of[stock_id])

    def sample_at(self, slot: int, step: int) -> np.void | None:
        """The last sample of a train's run until a step; None: it has not run for long, or not yet."""
        return self._stretches.sample_at(slot, step)

    @property
    def arrived(self) -> tuple[str, ...]:
        """Numbers of the trains that have come to their last stop."""
        return tuple(self._books.arrived)

    @property
    def stops(self) -> Sequence[StopRecord]:
        """Every call that a train has made, by the truth."""
        return self._books.stops

    def waits_for(self, slot: int) -> str:
        """What a train waits for by what its unit shows and its driver sees."""
        return self._cabs.waits_for(slot)

    def carry_out(self, script: Script) -> None:
        """From now on a script is carried out, as if it had been that of the setup, which must have had none."""
        self.injector.take_up(script, self._step)

    def _handle(self, item: Item) -> None:
        step, subject = self._step, item.subject
        match item.kind:
            case AgendaKind.POINTS:
                self.wayside.points_due(step, subject)
            case AgendaKind.TO_DEVICE:
                others = self._agenda.pop_all(step, AgendaKind.TO_DEVICE, subject)
                self.wayside.advance(step, subject, [i.data for i in (item, *others) if i.data is not None])
            case AgendaKind.TO_UNIT:
                if item.data is not None:
                    self._to_unit(self.trains.slot_of[subject], subject, item.data)
            case AgendaKind.UNIT_TIMER:
                self._cabs.timer(self.trains.slot_of[subject], step)
            case AgendaKind.SCRIPT if subject.startswith(CREW):
                self._cabs.crew_looks(self.trains.slot_of[subject.removeprefix(CREW)], step)
            case AgendaKind.SCRIPT:
                self.injector.due(step, subject)
            case AgendaKind.PEOPLE:
                self._platforms.due(step, subject)
            case AgendaKind.DUTY:
                self._take_up_duty(self.trains.slot_of[subject])
            case AgendaKind.PROCEDURE:
                pass  # it ends a stretch, so that people look round
            case AgendaKind.CREW:
                pause, stock_id = subject.split(" ", 1)
                self._duties.crew_due(Pause(pause), self.trains.slot_of[stock_id], step)

    def _to_unit(self, slot: int, stock_id: str, data: bytes) -> None:
        if slot in self.on_board.unpowered:
            self.wayside.lost(self._step, stock_id, data, LostWhere.RECEIVER_OFF)
        else:
            self._cabs.tell(slot, self._step, (), (data,))

    def _take_up_duty(self, slot: int) -> None:
        try:
            self._duties.take_up(slot, self._step)
        except WrongEnd:
            self._unsafe(slot, Danger.CANNOT_TURN)
            self._broken = Ending.CANNOT_TURN

    def foresee(self) -> int:
        """Let the kernel run the stretch that begins now; the step where it ends, as things are due at present.

        The carrier has not moved and nobody has looked: that is for `advance`. What is `insert`ed before that step cuts
        the stretch there, as if it had been due when the stretch began; nothing else of a run depends on who foresees.
        """
        if self._ahead is None:
            self._ahead = self._stretches.run(self._step, self._stretch_end(), keep=True)
        return self._step + self._ahead.done

    def insert(self, item: ScriptedFault | Act, step: int) -> int:
        """A fault or act begins at a step to come, as if the script of the setup had ended with it; its number.

        ValueError for a step that is not to come, or at which something else of the script is due: see `is_free`.
        """
        self._check_free(step)
        number = self.injector.insert(item, step)
        self._cut(step)
        return number

    def end_fault(self, number: int, step: int) -> None:
        """An inserted fault is over at a step to come, as if that had been its duration. ValueError as for `insert`."""
        self._check_free(step)
        self.injector.end_at(number, step)
        self._cut(step)

    def is_free(self, step: int) -> bool:
        """Whether a step is to come and nothing of a script is due at it: whoever acts then acts alone."""
        return step > self._step and not self._agenda.is_due(step, AgendaKind.SCRIPT)

    def motion_at(self, slot: int, step: int) -> TrainMotion:
        """A train at a step of the stretch that was foreseen. ValueError where none was."""
        if self._ahead is None:
            raise ValueError("nobody foresees this stretch")
        return self._ahead.motion_of(slot, step - self._step, self._stretches.sheet)

    def _check_free(self, step: int) -> None:
        if not self.is_free(step):
            raise ValueError(f"step {step} is not free")

    def _cut(self, step: int) -> None:
        """The stretch that was foreseen ends at `step` if it would end later: it is run anew from where it began."""
        ahead = self._ahead
        if ahead is None or ahead.before is None or step >= self._step + ahead.done:
            return  # with nothing foreseen, what is due counts when the stretch begins
        self._ahead = self._stretches.again(ahead, self._step, step)

    def advance(self) -> None:
        """Let the kernel run to the next event, the carrier after it, then look at what happened."""
        trains, sheet, road = self.trains, self._stretches.sheet, self._road
        ahead = self._ahead or self._stretches.run(self._step, self._stretch_end(), keep=road is not None)
        self._ahead = None
        hit, carried = 0, 0
        if road is not None:
            # Before points are looked up for the last step, to which a stretch that is cut short never comes.
            carried = max(ahead.done - 1, 0)  # nothing is run where something has come due meanwhile
            hit = self._carry(self._stretches.columns(ahead, 0, carried), 0, carried)
            if hit and not self._carrier.collisions():
                ahead, hit, carried = self._stretches.again(ahead, self._step, self._step + hit), 0, hit
        done = ahead.done
        moving = ahead.moving(sheet)
        both = zip(sheet.passed.tolist(), sheet.events.tolist(), strict=True)
        bits = [(slot, passed, events) for slot, (passed, events) in enumerate(both) if passed or events]
        for slot, passed, _ in bits:
            if passed & PASSED_FRONT and not hit and trains.at_end_of_track(slot):
                self._unsafe(slot, Danger.END_OF_TRACK)
                self._broken = Ending.END_OF_TRACK
                return
            if passed & PASSED_FRONT and not hit:
                self._toes.cross(slot, self._step)
        columns = self._stretches.columns(ahead, 0, hit or done)
        if not hit:
            hit = self._carry(columns, carried, done)
        self._step += hit or done
        if moving if self._charging is None else self._charging.goes_on(moving):
            self._moved_step = self._step
        if hit and self._carrier.collisions():
            # The kernel may have run on beyond it, so its sums are no measure any more.
            active = trains.active()
            self._observe(active, [NOT_RUN] * len(active))
            self._collided()
            return
        if moving:
            ran = (RunSince(STEP_S, speeds[: hit or done]) for _, speeds in columns)
            trains.compare(moving, self._observe(moving, ran))
        self._judge_bounds()
        for slot, passed, events in bits:
            self._report(slot, passed, events)
        if self._charging is not None:
            self._look_at_pantographs(self._charging)
        if road is not None:
            road.tell(self._detectors)

    def _carry(self, columns: Sequence[tuple[str, Sequence[float]]], first: int, last: int) -> int:
        """Let the carrier run a part of a stretch; after how many steps of the stretch somebody must look, or 0."""
        part = [(unit_id, speeds[first:]) for unit_id, speeds in columns] if first else columns
        hit = self._carrier.run(part, last - first)
        return first + hit if hit else 0

    def _stretch_end(self) -> int:
        """Where the stretch that begins now ends at the latest."""
        self._lookout.follow()
        watched_step = self._step + WATCHING_STEPS
        return min(self.horizon_step, watched_step) if self._cabs.watch_out() else self.horizon_step

    def _look_at_pantographs(self, charging: Charging) -> None:
        """Who moved with it up; who is on sight at a stop and held until it is down has no timer to look again; whose
        battery is low.
        """
        for slot, level in charging.levels():
            low = BatteryAt(unit_id=self.trains.stock_ids[slot], level=level)
            self.journal.write(self.now_s, WORLD, low)
        for slot in charging.moved_connected():
            self._unsafe(slot, Danger.PANTOGRAPH_UP)
        for slot in charging.look(self._step):
            if self.on_board.shown_to_driver(slot).on_sight:
                self._cabs.tell(slot, self._step, (Looked(),))

    def _observe(self, slots: list[int], runs: Iterable[RunSince]) -> list[Truth]:
        """Truth to the checkers, and how each ran there; only trains that moved can have changed anything."""
        now_s = self.now_s
        seen = [self._carrier.truth(self.trains.stock_ids[slot]) for slot in slots]
        for slot, truth, ran in zip(slots, seen, runs, strict=True):
            edge = truth.piece_id + SIGN[truth.direction]
            stock_id = self.trains.stock_ids[slot]
            self.checkers.observe(now_s, stock_id, edge, truth.offset_m, truth.speed_mps, ran)
        return seen

    def _judge_bounds(self) -> None:
        """The worst moment of each unit's bounds to the checkers; one that stands may find itself elsewhere too."""
        trains = self.trains
        for slot, (out_m, step, *stated) in enumerate(self._stretches.sheet.worst.tolist()):
            believes = slot not in self.on_board.unpowered and not trains.premises.is_false(slot)
            if believes and out_m != -math.inf:
                self.checkers.bounds(step / STEPS_PER_S, trains.stock_ids[slot], *stated)

    def _collided(self) -> None:
        struck = {} if self._road is None else {each.text: each for each in self._road.struck}
        for text in self._carrier.collisions():
            self.journal.write(self.now_s, WORLD, struck.get(text) or Collision(text=text))
        self._broken = Ending.COLLISION

    def _rail_is(self, slot: int, share: float) -> None:
        self.checkers.rail(self.now_s, self.trains.stock_ids[slot], share)

    def _unsafe(self, slot: int, danger: Danger, points_id: str = "") -> None:
        happened = Unsafe(unit_id=self.trains.stock_ids[slot], danger=danger, points_id=points_id)
        self.journal.write(self.now_s, WORLD, happened)

    def _report(self, slot: int, passed: int, events: int) -> None:
        """Tell the unit what its sensors saw at the end of this step."""
        trains, cabs, step = self.trains, self._cabs, self._step
        if passed & (PASSED_FRONT | PASSED_REAR):
            trains.set_boundaries(slot)
        if passed & PASSED_REAR:
            cabs.keys_back(slot, step)
        if passed & PASSED_FROM_A_STAND and self._platforms.are_open(slot, step):
            self._unsafe(slot, Danger.DOORS_OPEN)
        self._books.look_for_departure(slot, self.now_s)
        self._books.look_for_arrival(slot, self.now_s)
        if self._charging is not None:
            self._charging.note_passed(slot, passed, step)
        if passed & PASSED_TAG:
            tag_id, read_id, odometer_m = trains.read_tag(slot)
            self.journal.write(self.now_s, WORLD, TagPassed(unit_id=trains.stock_ids[slot], tag_id=tag_id))
            if read_id is not None and slot not in self.on_board.unpowered:
                sensed = self.on_board.tag_read(slot, read_id, odometer_m)
                cabs.tell(slot, step, sensed)
                if any(isinstance(what, TagBelieved) for what in sensed):
                    trains.position_fixed(slot, lies=read_id != tag_id)
        if events:
            sensed = self.on_board.tick_events(slot, events)
            cabs.tell(slot, step, sensed)
            if any(isinstance(what, TagBelieved | FoundByOtherSensor) for what in sensed):
                trains.position_fixed(slot, lies=trains.last_fix_lies(slot))
        if passed & PASSED_TO_A_STAND or events & EVENT_STOPPED:
            cabs.crew_stands(slot, step)

    def _stalled(self) -> bool:
        """Nothing has moved for long although a train should have gone on."""
        still_s = (self._step - self._moved_step) / STEPS_PER_S
        limit_s = self.setup.limits.stall_limit_s
        return still_s >= limit_s and self._duties.overdue_s(self.now_s) >= limit_s

    def _result(self, because: Ending, collisions: tuple[str, ...]) -> RunResult:
        self._books.close(self._step)
        if self._charging is not None:
            self._charging.close(self._step)
        arrived = self._books.arrived
        planned, empty = numbers_due(self.setup.timetable, self.now_s if because.of_part else math.inf)
        cut = self._duties.cut
        judged = () if because.of_part else tuple(n for n in (*planned, *empty) if n not in cut)
        self.checkers.finish(self.now_s, {number: number in arrived for number in judged})
        trace = self._stretches.trace()
        units = (self.trains.stock_ids[slot] for slot in self.on_board.uncommissioned)
        self.journal.add_to_digest(trace.tobytes())
        return RunResult(
            name=self.setup.name,
            seed=self.setup.seed,
            link=self._link,
            stock_ids=self.trains.stock_ids,
            begin_step=self._begin_step,
            end_step=self._step,
            trains_planned=planned,
            trains_arrived=tuple(n for n in arrived if n in planned),
            empty_planned=empty,
            empty_arrived=tuple(n for n in arrived if n in empty),
            stops=self._books.stops,
            energy=self._books.energy,
            waiting=self._duties.waiting(),
            violations=self.checkers.violations,
            outside_design=self.checkers.outside_design,
            slippery=self.checkers.slippery,
            collisions=collisions,
            telegrams=self.wayside.telegrams,
            trace=trace,
            spans=self._books.spans,
            journal=self.journal,
            ended_because=because,
            cut=tuple(cut),
            unfinished=self._duties.unfinished(),
            courses=self.injector.courses,
            uncommissioned=tuple(sorted((*units, *self.wayside.uncommissioned))),
            learned=self.on_board.learned(),
            learned_from=self.on_board.learned_from(),
            fixes=self.trains.fixes(),
            road={} if self._road is None else self._road.totals.of,
            battery=() if self._charging is None else tuple(self._charging.records),
        )
