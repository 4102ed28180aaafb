"""The loop that joins all parties: the compiled kernel, the carrier, the wayside, the units, the checkers.

Pure simulated time: a run is a function of its setup and seed. `step` counts steps of 0.1 s from midnight.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from host.devices import Fleet
from network.model import Direction, Leg
from onboard.records import EVENT_STOPPED
from onboard.unit import Finished, LeftLine, Noted, Phase, Transmit, UnitAction
from radio.air import Air
from simulation.agenda import Agenda, Due
from simulation.carriers.carrier import Carrier, Truth
from simulation.faults.injector import Injector
from simulation.journal import Journal
from simulation.judge.checkers import Checkers, PointsFacts
from simulation.result import RunResult
from simulation.sensors.eyes import Eyes
from simulation.setup import STEP_S, STEPS_PER_S, Setup
from simulation.world.books import Books
from simulation.world.crew import LOOKS_AGAIN_S, Crew
from simulation.world.kernel import STANDING_STEPS_MAX, advance, new_sheet
from simulation.world.points import WaysideWorld, header_of
from simulation.world.records import (
    PASSED_CAMERA,
    PASSED_FRONT,
    PASSED_REAR,
    PASSED_TAG,
    TRACE,
)
from simulation.world.roster import Duty, draw_up, stabled_at_start
from simulation.world.trains import Trains
from sumo_cfg.truth_map import NetMap
from wayside.config import MANAGER_ID
from wayside.said import ConfirmOutside

TRACE_ROWS_FIRST: Final = 200_000
PORTAL_RETRY_S: Final = 10.0
OPENING_S: Final = 600.0  # the run begins this long before the first thing planned
SIGN: Final = {Direction.DOWN: "+", Direction.UP: "-"}

Progress = Callable[[float, float, int], None]  # now s, end s, trains arrived


class Simulation:
    """One run. `run` may be called once."""

    def __init__(
        self,
        setup: Setup,
        carrier_of: Callable[[float], Carrier],
        fleet: Fleet,
        net: NetMap,
        master_key: bytes,
        link: str,
    ) -> None:
        self.setup: Final = setup
        self.journal = Journal()
        lengths = {s: float(t.row[0]["length_m"]) for s, t in setup.trains.items()}
        self._duties: Mapping[str, tuple[Duty, ...]] = draw_up(
            setup.believed_line, setup.timetable, lengths, setup.portal_lead_s
        )
        first_s = min(duty.enter_s for duties in self._duties.values() for duty in duties)
        last_s = max(c.last_s for t in setup.timetable.trains.values() for c in t.calls)
        self._begin_step = round(math.floor((first_s - OPENING_S) / 60.0) * 60.0 / STEP_S)
        self._limit_step = round((last_s + setup.time_limit_s) / STEP_S)
        self._step = self._begin_step
        self._carrier = carrier_of(self._begin_step / STEPS_PER_S)
        self.trains = Trains(setup, self._carrier, master_key)
        self._agenda = Agenda()
        self.wayside = WaysideWorld(
            setup.line,
            fleet,
            Air(setup.air, setup.seed),
            self._agenda,
            self.journal,
            self.trains.covered,
            self.trains.stock_ids,
        )
        facts = {
            p.id: PointsFacts(p.section_id, p.stem_piece, p.normal_piece, p.reverse_piece, p.initial)
            for p in setup.line.points.values()
        }
        portals = [s.id for s in setup.line.sections.values() if s.kind.value == "portal"]
        self.checkers = Checkers(net, facts, portals)
        self.journal.watch(self.checkers.journal)
        self._link = link
        self._next_duty = dict.fromkeys(self.trains.stock_ids, 0)
        self._books = Books(self.trains)
        self._trace = np.zeros(TRACE_ROWS_FIRST, dtype=TRACE)
        self._trace_used = 0
        self._sheet = new_sheet(len(self.trains.stock_ids))
        self._moved_step = self._begin_step
        self._timer_steps: dict[str, int] = {}
        self._broken = ""
        self._becoming: list[Duty] = []
        self._looking: set[int] = set()  # slots whose crew has a next look on the agenda
        self._eyes = Eyes(self.trains, self._agenda)
        self._crew = Crew(self.trains, self.wayside.machines.__getitem__, self.journal)
        self._injector = Injector(
            setup.script,
            setup.seed,
            self.trains,
            self.wayside,
            self.journal,
            self._agenda,
            self._unit_power,
            self._give_back,
        )

    @property
    def now_s(self) -> float:
        """Simulated time, s since midnight."""
        return self._step / STEPS_PER_S

    def run(self, progress: Progress | None = None) -> RunResult:
        """Run to the end: all trains done, the time limit, a stall, or a collision."""
        try:
            self._open()
            because = self._loop(progress)
        finally:
            collisions = self._carrier.collisions()
            self._carrier.close()
        return self._result(because, collisions)

    # the course of the run ---------------------------------------------------------------------------------------

    def _open(self) -> None:
        """Power on; the controller says which stock is outside; stock stabled on the line is put there."""
        self.wayside.start(self._step)
        self._injector.start(self._step)
        for stock_id in self.trains.stock_ids:
            duties = self._duties[stock_id]
            if stabled_at_start(duties):
                self._agenda.put(self._step, Due.DUTY, stock_id)
                continue
            self.wayside.input(self._step, MANAGER_ID, ConfirmOutside(stock_id, "controller"))
            if duties:
                self._agenda.put(round(duties[0].enter_s / STEP_S), Due.DUTY, stock_id)

    def _loop(self, progress: Progress | None) -> str:
        end_s = self._limit_step / STEPS_PER_S
        while True:
            self._handle_due()
            if self._all_done():
                return "all trains have finished"
            if self._broken:
                return self._broken
            if self._step >= self._limit_step:
                return "the time limit of the run"
            if self._stalled():
                return "no train can move any more"
            self._advance()
            if progress is not None:
                progress(self.now_s, end_s, len(self._books.arrived))

    def _handle_due(self) -> None:
        while (item := self._agenda.pop_due(self._step)) is not None:
            now_s = self.now_s
            if item.kind is Due.POINTS:
                self.wayside.points_due(self._step, item.subject)
            elif item.kind is Due.TO_DEVICE:
                others = self._agenda.pop_all(self._step, Due.TO_DEVICE, item.subject)
                data = [i.data for i in (item, *others) if i.data is not None]
                self.wayside.advance(self._step, item.subject, data)
            elif item.kind is Due.TO_UNIT and item.data is not None:
                slot = self.trains.slot_of[item.subject]
                if slot in self.trains.unpowered:
                    self.journal.write(now_s, "world", "lost_at_dead_device", device=item.subject)
                    continue
                actions = self.trains.on_board[slot].receive(item.data, now_s)
                header = header_of(item.data)
                self._apply(slot, actions, None if header is None else header.sequence)
            elif item.kind is Due.UNIT_TIMER:
                slot = self.trains.slot_of[item.subject]
                if self._timer_steps.get(item.subject) == self._step and slot not in self.trains.unpowered:
                    del self._timer_steps[item.subject]
                    self._apply(slot, self.trains.on_board[slot].timer(now_s))
            elif item.kind is Due.SCRIPT and item.subject.startswith("crew "):
                slot = self.trains.slot_of[item.subject.removeprefix("crew ")]
                self._looking.discard(slot)
                self._crew_stands(slot)
                self._keep_looking(slot)
            elif item.kind is Due.SCRIPT:
                self._injector.due(self._step, item.subject)
            elif item.kind is Due.CAMERA:
                slot = self.trains.slot_of[item.subject]
                seen_m = self._eyes.frame(slot, self._step)
                self._apply(slot, self.trains.on_board[slot].frame_taken(seen_m))
            elif item.kind is Due.DUTY:
                self._take_up_duty(self.trains.slot_of[item.subject])

    def _advance(self) -> None:
        """Let the kernel run to the next event, the carrier after it, then look at what happened."""
        trains, sheet = self.trains, self._sheet
        steps = min(STANDING_STEPS_MAX, self._limit_step - self._step)
        next_due = self._agenda.next_step()
        if next_due is not None:
            steps = min(steps, next_due - self._step)
        if self._trace_used + steps * len(trains.stock_ids) > self._trace.size:
            self._trace = np.concatenate([self._trace, np.zeros(self._trace.size, dtype=TRACE)])
        done, self._trace_used, count = advance(
            trains.stock, trains.pool.track, sheet, self._trace, self._trace_used, self._step, steps
        )
        moving: list[int] = sheet.movers[:count].tolist()
        both = zip(sheet.passed.tolist(), sheet.events.tolist(), strict=True)
        bits = [(slot, passed, events) for slot, (passed, events) in enumerate(both) if passed or events]
        for slot, passed, _ in bits:
            if passed & PASSED_FRONT and trains.at_end_of_track(slot):
                self._unsafe(slot, "ran off the end of the track")
                self._broken = "a train ran off the end of the track"
                return
            if passed & PASSED_FRONT:
                self._cross_points(slot)
        speeds = sheet.speeds_mps[:count, :done].tolist()
        hit = self._carrier.run(
            [(trains.stock_ids[s], row) for s, row in zip(moving, speeds, strict=True)], done
        )
        self._step += hit or done
        if moving:
            self._moved_step = self._step
        if hit:  # the kernel may have run on beyond it, so its sums are no measure any more
            self._observe(trains.active())
            self._collided()
            return
        if moving:
            self._compare(moving, self._observe(moving))
        for slot, passed, events in bits:
            self._report(slot, passed, events)

    def _observe(self, slots: list[int]) -> list[Truth]:
        """Truth to the checkers; only trains that moved can have changed anything."""
        now_s = self.now_s
        seen = [self._carrier.truth(self.trains.stock_ids[slot]) for slot in slots]
        for slot, truth in zip(slots, seen, strict=True):
            edge = truth.piece_id + SIGN[truth.direction]
            stock_id = self.trains.stock_ids[slot]
            self.checkers.observe(now_s, stock_id, edge, truth.offset_m, truth.speed_mps)
        return seen

    def _compare(self, slots: list[int], seen: list[Truth]) -> None:
        """The carrier's positions against the kernel's, then the worst moment of each unit's bounds to the checkers."""
        trains = self.trains
        trains.compare(slots, seen)
        for slot, (out_m, step, *stated) in zip(slots, self._sheet.worst[: len(slots)].tolist(), strict=True):
            if out_m != -math.inf and not trains.misled(slot):
                self.checkers.bounds(step / STEPS_PER_S, trains.stock_ids[slot], *stated)

    def _collided(self) -> None:
        for text in self._carrier.collisions():
            self.journal.write(self.now_s, "world", "collision", text=text)
        self._broken = "a collision"

    def _cross_points(self, slot: int) -> None:
        """The front is about to leave its piece: over points it goes where the blades really lie."""
        line = self.setup.line
        before, expected = self.trains.crossing(slot)
        leaving, entering = line.pieces[before], line.pieces[expected]
        if leaving.leg is Leg.STEM and leaving.points_id == entering.points_id and leaving.points_id:
            points = line.points[leaving.points_id]
            position = self.wayside.position_of(points.id)
            if position is None:
                self._unsafe(slot, f"ran onto points {points.id} that lie in no position")
                return
            onto = points.normal_piece if position.value == "normal" else points.reverse_piece
            if onto != expected:
                self._unsafe(slot, f"was sent the wrong way at points {points.id}")
                self.trains.divert(slot, onto)
        elif leaving.points_id and leaving.leg in (Leg.NORMAL, Leg.REVERSE) and entering.leg is Leg.STEM:
            position = self.wayside.position_of(leaving.points_id)
            if position is None or position.value != leaving.leg.value:
                self._unsafe(slot, f"ran through points {leaving.points_id} set against it")
                self.wayside.force(self._step, leaving.points_id)

    def _unsafe(self, slot: int, text: str) -> None:
        self.journal.write(self.now_s, "world", "unsafe", unit=self.trains.stock_ids[slot], text=text)

    def _report(self, slot: int, passed: int, events: int) -> None:
        """Tell the unit what its sensors saw at the end of this step."""
        trains = self.trains
        unit = trains.on_board[slot]
        now_s = self.now_s
        if passed & (PASSED_FRONT | PASSED_REAR):
            trains.set_boundaries(slot)
        self._books.look_for_departure(slot, now_s)
        if passed & PASSED_TAG:
            tag_id, read_id, odometer_m = trains.read_tag(slot)
            self.journal.write(now_s, "world", "tag_passed", unit=unit.facts.unit_id, tag=tag_id)
            if read_id is not None and slot not in trains.unpowered:
                self._apply(slot, unit.tag_read(read_id, odometer_m, now_s))
                if trains.units[slot].position_known:
                    trains.position_fixed(slot)
        if passed & PASSED_CAMERA:
            self._eyes.begin(slot, self._step)
        if events and slot not in trains.unpowered:
            at = unit.at
            self._apply(slot, unit.events(events, now_s))
            if events & EVENT_STOPPED and unit.at == at:
                self._crew_stands(slot)

    # power of units, crews ------------------------------------------------------------------------------------

    def _unit_power(self, stock_id: str, on: bool) -> None:
        """Switch an on-board unit off, or on again: the crew then enters the train number."""
        slot = self.trains.slot_of[stock_id]
        if on == (slot not in self.trains.unpowered):
            return
        self.journal.write(self.now_s, "world", "power_on" if on else "power_off", device=stock_id)
        if not on:
            self.trains.power_off(slot)
            return
        before = self.trains.on_board[slot]
        stood_at = before.at if before.stands_at is None else before.stands_at
        stands = before.phase is not Phase.RUNNING
        stands = stands and (before.phase is not Phase.RESTARTED or before.stands_at is not None)
        self.trains.power_on(slot)
        duty = self.trains.duties[slot]
        if duty is None or not self.trains.truths[slot].active:
            return
        unit = self.trains.on_board[slot]
        pattern = self.trains.pattern_rows(slot)
        actions = unit.restart(
            duty.mission, pattern, self.now_s, ready_s=self.now_s, stands_at=stood_at if stands else None
        )
        self._apply(slot, actions)

    def _give_back(self, stock_id: str, hold_s: float) -> None:
        """The crew sets back the route ahead (進路取消)."""
        slot = self.trains.slot_of[stock_id]
        if slot not in self.trains.unpowered:
            self._apply(slot, self.trains.on_board[slot].give_back(self.now_s, hold_s))

    def _crew_stands(self, slot: int) -> None:
        """A train on sight stands: the crew looks at the points, or has reached a mark."""
        if self.trains.plants[slot].speed_mps > 0.0 or slot in self.trains.unpowered:
            return
        seen = self._crew.stand(slot, self.now_s)
        unit = self.trains.on_board[slot]
        if seen.passable is not None:
            self._apply(slot, unit.checked_by_crew(seen.passable, self.now_s))
        elif seen.to_throw is not None:
            self._apply(slot, unit.throw_by_crew(seen.to_throw, self.now_s))
        elif seen.target is not None:
            self._apply(slot, unit.arrived_on_sight(seen.target, self.now_s))

    def _keep_looking(self, slot: int) -> None:
        """The crew of a train on sight looks every now and then, whatever the tachometer shows."""
        if slot in self._looking or not self._crew.on_sight(slot):
            return
        self._looking.add(slot)
        again = f"crew {self.trains.stock_ids[slot]}"
        self._agenda.put(self._step + round(LOOKS_AGAIN_S * STEPS_PER_S), Due.SCRIPT, again)

    # duties ---------------------------------------------------------------------------------------

    def _take_up_duty(self, slot: int) -> None:
        """The stock's next train: it comes onto the line, or the stock turns back."""
        stock_id = self.trains.stock_ids[slot]
        duty = self._duties[stock_id][self._next_duty[stock_id]]
        on_line = bool(self.trains.truths[slot].active)
        if not on_line and duty.enters and self._portal_busy(duty):
            self._agenda.put(self._step + round(PORTAL_RETRY_S / STEP_S), Due.DUTY, stock_id)
            return
        turns = on_line and duty.mission.direction is not self.trains.direction(slot)
        if turns and not self.trains.can_turn(slot, duty):
            self._unsafe(slot, "overran its track and cannot turn back")
            self._broken = "a train overran its track and cannot turn back"
            return
        self._next_duty[stock_id] += 1
        unit = self.trains.on_board[slot]
        now_s = self.now_s
        actions: list[UnitAction] = []
        if on_line:
            if turns:
                self._books.close_energy(slot)
                self.trains.turn(slot, duty)
                self.checkers.reversed(now_s, stock_id)
                self.journal.write(now_s, "world", "reversed", unit=stock_id)
                actions += unit.change_ends(now_s)
            else:
                self._books.close_energy(slot)
                self.trains.continue_as(slot, duty)
        else:
            self.trains.place(slot, duty)
            self._appear(slot, duty)
        self._books.begin_train(slot, duty, self._step)
        pattern = self.trains.pattern_rows(slot)
        actions += unit.begin(duty.mission, pattern, now_s, ready_s=now_s, signing_on=not on_line)
        self._apply(slot, actions)

    def _portal_busy(self, duty: Duty) -> bool:
        section = duty.mission.spans[0].section_id
        return any(
            section in unit.authority.section_ids()
            for unit in self.trains.on_board
            if unit.phase is not Phase.GONE
        )

    def _appear(self, slot: int, duty: Duty) -> None:
        stock_id = self.trains.stock_ids[slot]
        length_m = float(self.trains.bodies[slot].length_m)
        position_m = float(self.trains.truths[slot].position_m)
        path = duty.mission.path
        under = [
            step.piece_id + SIGN[duty.mission.direction]
            for step in path.steps
            if step.end_m > position_m - length_m and step.start_m < position_m
        ]
        self.journal.write(
            self.now_s, "world", "entered", unit=stock_id, train=duty.train.number, edges=under
        )
        self.checkers.entered(stock_id, length_m, under)
        self.trains.compare([slot], self._observe([slot]))

    # actions of units ---------------------------------------------------------------------------------------------

    def _apply(self, slot: int, actions: list[UnitAction], sequence: int | None = None) -> None:
        unit = self.trains.on_board[slot]
        stock_id = self.trains.stock_ids[slot]
        for action in actions:
            if isinstance(action, Transmit):
                self.wayside.transmit(self._step, stock_id, action.destination, action.data, action.kind)
            elif isinstance(action, Noted):
                data = dict(action.data)
                if action.what == "took_effect" and sequence is not None:
                    data |= {"receiver": stock_id, "sequence": sequence}
                self.journal.write(self.now_s, stock_id, action.what, **data)
            elif isinstance(action, Finished):
                self._finished(slot)
            elif isinstance(action, LeftLine):
                self._left(slot)
        self._books.look_for_arrival(slot, self.now_s)
        self._crew.look_ahead(slot)
        self._keep_looking(slot)
        self._eyes.look_ahead(slot)
        if unit.wake_at_s < math.inf:
            wake_step = max(math.ceil(unit.wake_at_s / STEP_S - 1e-6), self._step + 1)
            if self._timer_steps.get(stock_id) != wake_step:
                self._timer_steps[stock_id] = wake_step
                self._agenda.put(wake_step, Due.UNIT_TIMER, stock_id)

    def _finished(self, slot: int) -> None:
        """The mission is done: turn back, leave the line, or stand."""
        stock_id = self.trains.stock_ids[slot]
        duty = self.trains.duties[slot]
        if duty is None:
            return
        self.journal.write(self.now_s, stock_id, "mission_done", train=duty.train.number)
        if duty.leaves:
            self._apply(slot, self.trains.on_board[slot].leave(self.now_s))
        elif duty.becomes is not None and duty not in self._becoming:
            self._becoming.append(duty)  # a unit that starts again in its terminus finishes twice
            after = self._step + round(self.setup.change_ends_s / STEP_S)
            self._agenda.put(after, Due.DUTY, stock_id)
        else:
            self._books.close_energy(slot)

    def _left(self, slot: int) -> None:
        stock_id = self.trains.stock_ids[slot]
        self._books.close_energy(slot)
        self.trains.remove(slot)
        self.checkers.left(stock_id)
        self.journal.write(self.now_s, "world", "left", unit=stock_id)
        following = self._next_duty[stock_id]
        if following < len(self._duties[stock_id]):
            enter_step = round(self._duties[stock_id][following].enter_s / STEP_S)
            self._agenda.put(max(enter_step, self._step + 1), Due.DUTY, stock_id)

    # the end ------------------------------------------------------------------------------------------------------

    def _all_done(self) -> bool:
        for slot, stock_id in enumerate(self.trains.stock_ids):
            if self._next_duty[stock_id] < len(self._duties[stock_id]):
                return False
            if self.trains.on_board[slot].phase not in (Phase.FINISHED, Phase.GONE, Phase.OFF):
                return False
        return True

    def _stalled(self) -> bool:
        """Nothing has moved for long although a train waits for a section."""
        if (self._step - self._moved_step) / STEPS_PER_S < self.setup.stall_limit_s:
            return False
        return any(
            unit.authority.refusal for unit in self.trains.on_board if unit.authority.asked is not None
        )

    def _result(self, because: str, collisions: tuple[str, ...]) -> RunResult:
        self._books.close()
        arrived = self._books.arrived
        trains = self.setup.timetable.trains.values()
        planned = tuple(t.number for t in trains if t.revenue)
        empty = tuple(t.number for t in trains if not t.revenue)
        self.checkers.finish(self.now_s, {number: number in arrived for number in (*planned, *empty)})
        trace = self._trace[: self._trace_used].copy()
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
            waiting=self._books.waiting(),
            violations=self.checkers.violations,
            collisions=collisions,
            telegrams=self.wayside.telegrams,
            trace=trace,
            spans=self._books.spans,
            journal=self.journal,
            ended_because=because,
            learned=self.trains.learned(),
            learned_from=self.trains.learned_from(),
        )
