"""The cabs of all trains: the world tells the units what happened, and does what they and their crews say.

Here units, crews and cameras meet the agenda, the air and the journal. What a unit tells its driver (the journey is
finished, the line is left, the portal may be entered) goes on to the duties.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Final

from onboard.duty.records import Happening, OffTheLine, SetBack, Told
from simulation.agenda import AgendaKind
from simulation.clock import Clock
from simulation.events import WORLD, Commissioned, PowerOff, PowerOn, Uncommissioned
from simulation.faults.fault import VehiclePart
from simulation.pauses import Pauses
from simulation.people import Pause
from simulation.setup import STEPS_PER_S, step_not_before
from simulation.subscribers import Subscribers
from simulation.world.crew import LOOKS_AGAIN_S, Crew
from simulation.world.roster import Duty
from simulation.world.stage import World

CREW: Final = "crew "
_SEES_TRAIN: Final = "the track ahead: the driver sees a train on it"
_LOST: Final = "it has lost its durable state, and people must commission it"


class Cabs:
    """What passes between the world and the units."""

    def __init__(self, world: World) -> None:
        self.told: Final = Subscribers[int, Told, int]()  # what a unit (slot) tells its driver, the step
        self._trains, self._on_board, self._wayside = world.trains, world.on_board, world.wayside
        self._books, self._agenda, self._journal = world.books, world.agenda, world.journal
        self._charging, self._signs = world.charging, world.signs
        self._guarded = world.wayside.crossings.guarded
        # A timer that is put off still ends a stretch where no crossing is: positions are taken from SUMO there.
        self._one_timer = any(crossing.tells_units for crossing in world.setup.line.crossings.values())
        self._crew = Crew(world.trains, world.on_board, world.wayside, world.journal)
        self._answers: Counter[int] = Counter()  # how many each slot has given
        self._looking: set[int] = set()  # slots whose crew has a next look on the agenda
        self._pauses = Pauses(world.setup)
        self._about_to: set[tuple[Pause, int]] = set()  # what a crew is going to do, by its slot
        self._timer_steps: dict[int, int] = {}
        self._wakes: set[int] = set()  # slots whose unit has a timer running
        self._cut_out: set[int] = set()
        self._frozen: dict[int, list[tuple[Sequence[Happening], Sequence[bytes]]]] = {}

    def tell(
        self, slot: int, step: int, happened: Sequence[Happening] = (), telegrams: Sequence[bytes] = ()
    ) -> None:
        """Put what happened to a unit, and do what it says.

        A unit without power does not hear it; for one that is frozen it waits.
        """
        if slot in self._frozen and slot not in self._on_board.unpowered:
            self._frozen[slot].append((happened, telegrams))
            return
        now_s = step / STEPS_PER_S
        answered = self._on_board.tell(slot, now_s, happened, telegrams)
        if answered is None:
            return
        answer, notes = answered
        self._answers[slot] += 1
        number = self._answers[slot]
        stock_id = self._trains.stock_ids[slot]
        for note in notes:
            self._journal.write(now_s, stock_id, note)
        for telegram in answer.telegrams:
            self._wayside.transmit(step, stock_id, telegram.destination, telegram.data)
        for told in answer.told:
            self.told(slot, told, step)
        self._look(slot, step)
        if self._one_timer and self._answers[slot] > number:
            return  # what it has been told since has set its timer
        wake_s, was_step = answer.wake_at_s, self._timer_steps.get(slot)
        (self._wakes.discard if wake_s is None else self._wakes.add)(slot)
        wake_step = None if wake_s is None else max(step_not_before(wake_s), step + 1)
        if wake_step == was_step:
            return
        if self._one_timer and was_step is not None:
            self._agenda.withdraw(AgendaKind.UNIT_TIMER, stock_id, step)
            del self._timer_steps[slot]
        if wake_step is not None:
            self._timer_steps[slot] = wake_step
            self._agenda.put(wake_step, AgendaKind.UNIT_TIMER, stock_id)

    def _look(self, slot: int, step: int) -> None:
        """Stops are booked by the truth; the crew of a train on the line looks at its display and at the line."""
        self.keys_back(slot, step)
        if not self._trains.truths[slot].active:
            self._crew.on_sight.discard(slot)
            return
        self._books.look_for_arrival(slot, step / STEPS_PER_S)
        shown = self._on_board.shown_to_driver(slot)
        (self._crew.on_sight.add if shown.on_sight or shown.sweeps else self._crew.on_sight.discard)(slot)
        self._crew.look_ahead(slot)
        self._keep_looking(slot, step)
        self._wait_at_crossing(slot, step)
        self._signs.look_ahead(slot)

    def timer(self, slot: int, step: int) -> None:
        """A time asked for with `wake_at_s` has come."""
        if self._timer_steps.get(slot) == step and slot not in self._on_board.unpowered:
            del self._timer_steps[slot]
            self.tell(slot, step)

    def set_clock(self, slot: int, step: int, clock: Clock) -> None:
        """The clock of a unit shows another time from now on; its timers may have run out by it."""
        self._on_board.clocks[slot] = clock
        self.tell(slot, step)

    def claim_besides(self, slot: int, step: int, section_ids: tuple[str, ...]) -> None:
        """A unit claims these besides what it holds, at once and whenever it is asked; none: it is sane again."""
        self._on_board.claims_besides[slot] = section_ids
        self.tell(slot, step)

    def vehicle_shows(self, slot: int, step: int, part: VehiclePart, value: float) -> None:
        """A part of the vehicle is in order or not, or is there in part: its inputs at the unit change."""
        self.tell(slot, step, self._on_board.vehicle_shows(slot, part, value))

    def freeze(self, slot: int, step: int, *, frozen: bool) -> None:
        """The event-driven part of a unit does nothing, or goes on with what has piled up, in its order.

        Physics and the compiled tick go on with the last command, supervised to the stop limit that the unit has: that
        only ever restricts, so nothing that is safe rests on a unit that answers.
        """
        if frozen:
            self._frozen.setdefault(slot, [])
            return
        for happened, telegrams in self._frozen.pop(slot, []):
            self.tell(slot, step, happened, telegrams)

    def watch_out(self) -> bool:
        """While trains run on sight, every driver looks out for others; whether two are so near that it matters."""
        if not self._crew.on_sight:
            return False
        near = [self._crew.watch_out(slot) for slot in self._trains.active()]
        return any(near)

    def drives_by_hand(self, slot: int, *, by_hand: bool, stops_at_crossings: bool = False) -> None:
        """A driver whose unit is cut out looks out for trains, or no longer does; if he has to, for level crossings too
        that it would have asked.
        """
        (self._crew.on_sight.add if by_hand else self._crew.on_sight.discard)(slot)
        (self._crew.by_hand.add if by_hand and stops_at_crossings else self._crew.by_hand.discard)(slot)

    def looks_by_hand(self, slot: int, step: int) -> bool:
        """A driver whose unit is cut out looks along the track, and at the level crossing before which he stands;
        whether he creeps over it.
        """
        self._crew.look_ahead(slot)
        self._wait_at_crossing(slot, step)
        return self._crew.creeps_by_hand(slot)

    def unit_cut_out(self, slot: int, *, out: bool) -> None:
        """A driver has cut the unit out, and goes when people let him, or in again."""
        (self._cut_out.add if out else self._cut_out.discard)(slot)

    def is_cut_out(self, slot: int) -> bool:
        """Whether a driver has cut the unit out."""
        return slot in self._cut_out

    # what is seen of a unit ----------------------------------------------------------------------------------------

    def answers(self, slot: int) -> bool:
        """Whether the unit has power and is not frozen."""
        return slot not in self._on_board.unpowered and slot not in self._frozen

    def wakes(self, slot: int) -> bool:
        """Whether a timer of the unit runs."""
        return slot in self._wakes

    def waits_for(self, slot: int) -> str:
        """What the train waits for by what its unit shows and its driver sees; what ails a unit that shows nothing."""
        if slot in self._on_board.unpowered:
            return self._waits_without_unit(slot)
        if slot in self._frozen:
            return "its unit, which is frozen"
        if slot in self._on_board.numberless:
            return "its crew to enter the train number"
        if self._charging is not None and self._charging.empty(slot):
            return "power: its battery is empty"
        if self._crew.sees_train(slot):
            return _SEES_TRAIN
        others = "".join(f"; {device}: {_LOST}" for device in sorted(self._wayside.uncommissioned))
        return self._on_board.shown_to_driver(slot).waits_for + others

    def _waits_without_unit(self, slot: int) -> str:
        if slot in self._cut_out:
            sees = self._crew.sees_train(slot)
            return _SEES_TRAIN if sees else "leave by people or a signal: its unit is cut out"
        lost = slot in self._on_board.uncommissioned
        return f"its unit: {_LOST}" if lost else "its unit to be switched on"

    # crews ----------------------------------------------------------------------------------------------------------

    def crew_looks(self, slot: int, step: int) -> None:
        """It is time for a crew on sight to look again, whatever the tachometer shows."""
        self._looking.discard(slot)
        self._look_out(slot, step)
        self._keep_looking(slot, step)

    def crew_stands(self, slot: int, step: int) -> None:
        """A train on sight has come to a stand: its crew will look at the points, or say what mark it has reached."""
        if self._crew.has_to_look(slot):
            self._crew.look_ahead(slot)
            self._begins(Pause.STAND, slot, step)
            self._wait_at_crossing(slot, step)
        elif slot in self._crew.by_hand:
            self.looks_by_hand(slot, step)

    def crew_due(self, pause: Pause, slot: int, step: int) -> None:
        """A crew does what it took its time for."""
        self._about_to.discard((pause, slot))
        match pause:
            case Pause.STAND:
                self._look_out(slot, step)
            case Pause.CROSSING | Pause.FLAG:
                guarded = pause is Pause.FLAG and self._crew.waits_at_crossing(slot) in self._guarded
                if pause is Pause.FLAG and not guarded:
                    return
                happened = self._crew.creep(slot, step / STEPS_PER_S, guarded=guarded)
                if happened:
                    self.tell(slot, step, happened)
            case Pause.KEY:
                self._crew.give_keys_back(slot, step / STEPS_PER_S)
            case Pause.GONE:
                self.tell(slot, step, (OffTheLine(),))
            case _:
                raise ValueError(f"{pause} is not for the crew of a train that runs, or has left")

    def off_the_line(self, slot: int, step: int) -> int:
        """Its train is beyond the portal, as its driver enters; the first step at which it may come again."""
        due_step = self.pause(Pause.GONE, slot, step)
        if due_step == step:
            self.crew_due(Pause.GONE, slot, step)
        return due_step + 1

    def _wait_at_crossing(self, slot: int, step: int) -> None:
        """A driver whose train waits for a level crossing to close asks for leave to creep over it, or has the word of
        who guards it, once that one has stopped the road.
        """
        crossing_id = self._crew.waits_at_crossing(slot)
        if crossing_id in self._guarded and (Pause.FLAG, slot) not in self._about_to:
            self._wayside.crossings.stop_road(step, crossing_id, self._trains.stock_ids[slot])
            self._begins(Pause.FLAG, slot, step)
        elif crossing_id:
            self._begins(Pause.CROSSING, slot, step)

    def _begins(self, pause: Pause, slot: int, step: int) -> None:
        """A crew begins to do something, unless it is at it."""
        if (pause, slot) in self._about_to:
            return
        if self.pause(pause, slot, step) == step:
            self.crew_due(pause, slot, step)
        else:
            self._about_to.add((pause, slot))

    def pause(self, pause: Pause, slot: int, step: int) -> int:
        """The step at which a crew does what it now begins; put on the agenda unless that is now."""
        stock_id = self._trains.stock_ids[slot]
        due_step = step + self._pauses.steps(pause, stock_id)
        if due_step > step:
            self._agenda.put(due_step, AgendaKind.CREW, f"{pause.value} {stock_id}")
        return due_step

    def _look_out(self, slot: int, step: int) -> None:
        happened = [] if slot in self._frozen else self._crew.stand(slot, step / STEPS_PER_S)
        if happened:
            self.tell(slot, step, happened)

    def crew_watches(self, slot: int) -> bool:
        """Whether the crew stands before points and looks again until they lie right, or sees to its vehicle."""
        return self._on_board.is_out_of_order(slot) or (slot in self._looking and self._crew.watches(slot))

    def keys_back(self, slot: int, step: int) -> None:
        """A crew that has no more use for a key of points gives it back: the rear may have left a piece of track."""
        if self._crew.keys_over(slot):
            self._begins(Pause.KEY, slot, step)

    def _keep_looking(self, slot: int, step: int) -> None:
        asked = self._on_board.drives_on_sight(slot) or self._on_board.shown_to_driver(slot).confirm
        if slot in self._looking or not asked:
            return
        self._looking.add(slot)
        again = step + round(LOOKS_AGAIN_S * STEPS_PER_S)
        self._agenda.put(again, AgendaKind.SCRIPT, CREW + self._trains.stock_ids[slot])

    def set_back(self, slot: int, step: int, hold_s: float) -> None:
        """The crew sets back the route ahead (進路取消)."""
        self.tell(slot, step, (SetBack(hold_s),))

    # power ----------------------------------------------------------------------------------------------------------

    def power_off(self, slot: int, step: int) -> None:
        """An on-board unit dies; the emergency brake applies itself."""
        if slot in self._on_board.unpowered:
            self._on_board.uncommissioned.discard(slot)
            return
        self._journal.write(step / STEPS_PER_S, WORLD, PowerOff(device_id=self._trains.stock_ids[slot]))
        self._on_board.power_off(slot)
        if slot in self._frozen:
            self._frozen[slot].clear()
        self._timer_steps.pop(slot, None)
        self._wakes.discard(slot)
        self._trains.truths[slot].sight_m = math.inf

    def power_on(self, slot: int, step: int) -> bool:
        """It boots, if it has not lost its durable state; whether it was off, and is not now."""
        if slot not in self._on_board.unpowered:
            return False
        stock_id = self._trains.stock_ids[slot]
        if not self._on_board.power_on(slot):
            self._journal.write(step / STEPS_PER_S, WORLD, Uncommissioned(device_id=stock_id))
            return False
        self._journal.write(step / STEPS_PER_S, WORLD, PowerOn(device_id=stock_id))
        return True

    def commission(self, slot: int, step: int, number: int) -> bool:
        """People put a unit into service again that waits for it; whether it has booted."""
        self._on_board.commission(slot, number)
        commissioned = Commissioned(device_id=self._trains.stock_ids[slot], number=number)
        self._journal.write(step / STEPS_PER_S, WORLD, commissioned)
        return self.power_on(slot, step)

    def crew_enters_number(self, slot: int, step: int, duty: Duty) -> None:
        """After a boot on the line: the train number, and where it stands, as the crew sees it now."""
        stands_at = self._books.stands_at(slot)
        beyond_m = 0.0 if stands_at is None else self._crew.beyond_m(slot, stands_at)
        self.tell(slot, step, self._on_board.switch_on(slot, duty, stands_at, beyond_m))
