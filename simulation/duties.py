"""Which train each stock runs now and next: coming onto the line, turning back, leaving it (運用).

A stock that enters waits outside the portal until the manager has accepted its sign-on and no train truly stands
there; only then is it on the line. Everything here follows from the roster, the truth and what drivers are told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Final

from network.model import SectionKind
from onboard.duty.records import (
    EntryAllowed,
    Finished,
    Leave,
    LeftLine,
    NoSuchWay,
    Told,
    TrainEndsHere,
    WayOrdered,
)
from onboard.mission import NoWay
from onboard.notes import MissionDone
from simulation.agenda import AgendaKind
from simulation.cabs import Cabs
from simulation.events import WORLD, CameLate, Entered, Left, Reversed
from simulation.judge.checkers import Checkers
from simulation.people import Pause
from simulation.result import Waiting
from simulation.setup import STEP_S, STEPS_PER_S
from simulation.world.roster import (
    Duty,
    cut_at,
    ordered_by,
    stabled_at_start,
)
from simulation.world.stage import World
from simulation.world.trains import SIGN
from wayside.config import MANAGER_ID
from wayside.said import BoundaryPassed, ConfirmOutside

RETRY_STEPS: Final = 10 * STEPS_PER_S  # until who stands before a portal looks at it again
_IS_TO: Final[Mapping[Pause, str]] = {
    Pause.ENTRY: "its crew to take it in through the portal",
    Pause.SIGN_OFF: "its crew to sign off",
    Pause.LEAVE: "its train to leave the line",
}


class StockStage(Enum):
    """Where a stock is in its day."""

    OUTSIDE = "outside"
    WAITING = "waiting"  # outside its portal, signing on
    ON_LINE = "on the line"
    DONE = "done"  # nothing follows: it stands where its day ends, or has left


class WrongEnd(RuntimeError):  # noqa: N818 - names what happened
    """A train overran its track, so that it cannot turn back: the run is over."""


def is_behind(slot: int, queue: Sequence[int]) -> bool:
    """Whether another stock has come to the portal sooner, and stands between it and this one."""
    return queue[0] != slot


class Duties:
    """The duties of all stocks."""

    def __init__(self, world: World, cabs: Cabs, checkers: Checkers) -> None:
        self._setup, self._charging = world.setup, world.charging
        self.of_stock = dict(world.drawn)  # as orders have changed them
        self._trains, self._on_board, self._wayside = world.trains, world.on_board, world.wayside
        self._books, self._agenda, self._journal = world.books, world.agenda, world.journal
        self._cabs, self._checkers = cabs, checkers
        self._next = dict.fromkeys(world.trains.stock_ids, 0)
        self._stage = [StockStage.OUTSIDE] * len(world.trains.stock_ids)
        self._becoming: list[Duty] = []
        self.cut: list[str] = []  # trains that orders have left out or ended early
        self._begun_again = set[int]()  # slots whose unit has not finished its last train again since a boot
        self._outside: dict[str, list[int]] = {}  # who stands behind another before a portal, in order
        sections = world.setup.line.sections.values()
        self._portals: Final = {section.id for section in sections if section.kind is SectionKind.PORTAL}
        self._looks_again: dict[int, bool] = {}  # whose portal was taken: whether it may yet come in
        self._due: dict[tuple[Pause, int], int] = {}  # the step at which a crew does something, by slot
        cabs.told.add(self.unit_tells)

    def open(self, step: int) -> None:
        """The controller says which stock is outside; stock stabled on the line is put there."""
        for slot, stock_id in enumerate(self._trains.stock_ids):
            duties = self.of_stock[stock_id]
            if stabled_at_start(duties):
                self._agenda.put(step, AgendaKind.DUTY, stock_id)
                continue
            self._wayside.input(step, MANAGER_ID, ConfirmOutside(stock_id, "controller"))
            if duties:
                self._agenda.put(round(duties[0].comes_s / STEP_S), AgendaKind.DUTY, stock_id)
            else:
                self._stage[slot] = StockStage.DONE

    def finished(self, slot: int) -> bool:
        """Whether nothing follows for a stock."""
        return self._stage[slot] is StockStage.DONE

    def all_done(self) -> bool:
        """Whether nothing follows for any stock, and none moves: a tachometer shows a stand before the wheels do."""
        done = all(stage is StockStage.DONE for stage in self._stage)
        return done and all(self._trains.plants[slot].speed_mps <= 0.0 for slot in self._trains.active())

    def unfinished(self) -> tuple[str, ...]:
        """The stock that has neither truly left the line nor stands where its last duty ends."""
        return tuple(stock for slot, stock in enumerate(self._trains.stock_ids) if not self._truly_done(slot))

    def _truly_done(self, slot: int) -> bool:
        duty = self._trains.duties[slot]
        done = self._stage[slot] is StockStage.DONE
        if not done or duty is None or not self._trains.truths[slot].active:
            return done
        return self._trains.plants[slot].speed_mps <= 0.0 and duty.train.number in self._books.arrived

    def has_duty(self, slot: int) -> bool:
        """Whether the stock has something to do: it is on the line, or outside its portal and wants in."""
        return self._stage[slot] in (StockStage.WAITING, StockStage.ON_LINE)

    def place(self, slot: int) -> str:
        """Where the front truly is, in words."""
        trains = self._trains
        if not trains.truths[slot].active:
            return "no section, outside its portal"
        piece_id, at_m = trains.true_path(slot).locate(float(trains.truths[slot].position_m))
        return f"section {self._setup.line.pieces[piece_id].section_id} at km {at_m / 1000.0:.3f}"

    def waiting(self) -> list[Waiting]:
        """Trains that have not finished: where they are, and what they wait for."""
        waiting: list[Waiting] = []
        for slot, stock_id in enumerate(self._trains.stock_ids):
            if not self.has_duty(slot):
                continue
            number = self._present(slot).train.number
            stands = bool(self._trains.plants[slot].speed_mps == 0.0)
            why = self._crew_is_to(slot) or self._cabs.waits_for(slot)
            waiting.append(Waiting(stock_id, number, self.place(slot), why, stands))
        return waiting

    def _crew_is_to(self, slot: int) -> str:
        """What the crew is about to do at a portal, while its unit works; empty: nothing."""
        if not self._cabs.answers(slot):
            return ""
        return next((said for pause, said in _IS_TO.items() if (pause, slot) in self._due), "")

    def overdue_s(self, now_s: float) -> float:
        """For how long the train that is most behind its plan should have gone on, s; 0 where none is."""
        late_s = 0.0
        for slot, (stage, duty) in enumerate(zip(self._stage, self._trains.duties, strict=True)):
            if stage is StockStage.WAITING:
                late_s = max(late_s, now_s - self._present(slot).comes_s)
            elif stage is StockStage.ON_LINE and duty is not None:
                at = self._books.next_target(slot) - 1
                due_s = duty.mission.targets[at].departure_s
                if due_s is None and at + 1 < len(duty.mission.targets):
                    due_s = duty.comes_s
                late_s = max(late_s, 0.0 if due_s is None else now_s - due_s)
        return late_s

    def take_up(self, slot: int, step: int) -> None:
        """The stock's next train: it waits outside its portal, stands on the line, or turns back.

        Raises WrongEnd where the train stands beyond the track on which it should turn.
        """
        stock_id = self._trains.stock_ids[slot]
        if slot in self._looks_again:
            may = self._looks_again.pop(slot) and self._stage[slot] is StockStage.WAITING
            if may and (slot not in self._on_board.unpowered or self._cabs.is_cut_out(slot)):
                self._enter(slot, self._present(slot), step)
            return
        on_line = self._stage[slot] is StockStage.ON_LINE
        if self._is_yet_to_finish(slot):
            return
        duty = self.of_stock[stock_id][self._next[stock_id]]
        turns = on_line and duty.mission.direction is not self._trains.direction(slot)
        if turns and not self._trains.can_turn(slot, duty):
            raise WrongEnd
        if not on_line and duty.enters and self._queues(slot, duty):
            self._agenda.put(step + RETRY_STEPS, AgendaKind.DUTY, stock_id)
            return
        self._next[stock_id] += 1
        if not on_line and duty.enters:
            self._stage[slot] = StockStage.WAITING
            if duty.late_s > 0.0:
                late = CameLate(unit_id=stock_id, train=duty.train.number, late_s=duty.late_s)
                self._journal.write(step / STEPS_PER_S, WORLD, late)
        elif not on_line:
            self._put_on_line(slot, duty, step)
        else:
            self._books.close_energy(slot, step)
            if turns:
                self._trains.turn(slot, duty)
                self._checkers.reversed(step / STEPS_PER_S, stock_id)
                self._journal.write(step / STEPS_PER_S, WORLD, Reversed(unit_id=stock_id))
            else:
                self._trains.continue_as(slot, duty)
            self._begin(slot, duty, step)
        if slot not in self._on_board.unpowered:
            self._number_follows(slot, step, duty, on_line=on_line, turned=turns)

    def _number_follows(self, slot: int, step: int, duty: Duty, *, on_line: bool, turned: bool) -> None:
        if self._stage[slot] is StockStage.WAITING:
            self._on_board.await_number(slot)
            self._begins(Pause.SIGN_ON, slot, step)
        elif not on_line or slot not in self._on_board.numberless:  # else its crew will enter this one
            happened = self._on_board.enter_number(slot, duty, comes_on_line=not on_line, turned=turned)
            self._cabs.tell(slot, step, happened)

    def _is_yet_to_finish(self, slot: int) -> bool:
        """Whether its unit has booted and been given the number of the train that it had finished: when it has finished
        again it takes the next one. Without power, or a number, it will be given the next one itself.
        """
        duty, lacks = self._trains.duties[slot], self._on_board.unpowered | self._on_board.numberless
        waits = slot in self._begun_again and slot not in lacks
        self._begun_again.discard(slot)
        if waits and duty is not None:
            self._becoming.remove(duty)
        return waits

    def _queues(self, slot: int, duty: Duty) -> bool:
        """Whether another stock waits before the same portal: on the track outside one stands behind the other."""
        portal = duty.mission.spans[0].section_id
        queue = self._outside.setdefault(portal, [])
        if slot not in queue:
            queue.append(slot)
        waiting = [self._present(i) for i, stage in enumerate(self._stage) if stage is StockStage.WAITING]
        if is_behind(slot, queue) or any(other.mission.spans[0].section_id == portal for other in waiting):
            return True
        queue.remove(slot)
        return False

    def power_on(self, slot: int, step: int) -> None:
        """A unit is switched on."""
        if self._cabs.power_on(slot, step):
            self.powered_on(slot, step)

    def commission(self, slot: int, step: int, number: int) -> None:
        """People put a unit into service again that waits for it."""
        if self._cabs.commission(slot, step, number):
            self.powered_on(slot, step)

    def powered_on(self, slot: int, step: int) -> None:
        """A unit has booted: its crew will enter the train number again, and does nothing else before."""
        self._due = {about: due_step for about, due_step in self._due.items() if about[1] != slot}
        if slot in self._looks_again:
            self._looks_again[slot] = False  # until it is accepted again
        on_line = self._trains.duties[slot] is not None and self._trains.truths[slot].active
        if on_line or self._stage[slot] is StockStage.WAITING:
            self._begins(Pause.BOOT, slot, step)
        else:
            self._cabs.off_the_line(slot, step)  # which it did not hear if it had no power then

    def _begins(self, pause: Pause, slot: int, step: int) -> None:
        """A crew begins to do something; what it was about to do before, of the same kind, it does not do."""
        self._due[pause, slot] = self._cabs.pause(pause, slot, step)
        if self._due[pause, slot] == step:
            self.crew_due(pause, slot, step)

    def crew_due(self, pause: Pause, slot: int, step: int) -> None:
        """A crew does what it took its time for; nothing where its unit has lost its power meanwhile."""
        if pause in (Pause.STAND, Pause.KEY, Pause.CROSSING, Pause.FLAG, Pause.GONE):
            self._cabs.crew_due(pause, slot, step)
            return
        if self._due.get((pause, slot)) != step:
            return
        del self._due[pause, slot]
        if slot in self._on_board.unpowered:
            return
        following = self._present(slot)
        match pause:
            case Pause.SIGN_ON | Pause.BOOT if self._stage[slot] is StockStage.WAITING:
                happened = self._on_board.enter_number(slot, following, comes_on_line=True, turned=False)
                self._cabs.tell(slot, step, happened)
            case Pause.BOOT:
                if (duty := self._trains.duties[slot]) is not None:
                    self._begun_again |= {slot} if duty in self._becoming else set()
                    self._cabs.crew_enters_number(slot, step, duty)
            case Pause.ENTRY:
                self._enter(slot, following, step)
            case Pause.SIGN_OFF:
                self._cabs.tell(slot, step, (Leave(),))
            case Pause.LEAVE:
                self._leave(slot, step)
            case _:
                pass  # a sign-on that nobody waits for any more; the rest is no crew's

    def unit_tells(self, slot: int, told: Told, step: int) -> None:
        """What a unit tells its driver."""
        match told:
            case EntryAllowed() if self._stage[slot] is StockStage.WAITING:
                self._begins(Pause.ENTRY, slot, step)
            case Finished():
                self._finish(slot, step)
            case WayOrdered():
                self._go_by(slot, told, step)
            case TrainEndsHere():
                self._end_train(slot, told, step)
            case LeftLine() if self._stage[slot] is StockStage.ON_LINE:
                self._begins(Pause.LEAVE, slot, step)
            case _:
                pass

    def _go_by(self, slot: int, ordered: WayOrdered, step: int) -> None:
        """The driver takes up another way of the same train, and from another track that of the next one, if any."""
        stock_id, line = self._trains.stock_ids[slot], self._setup.believed_line
        at, duties = self._next[stock_id] - 1, self.of_stock[stock_id]
        length_m = self._setup.lengths_m[stock_id]
        try:
            changed = ordered_by(line, duties, at, ordered.route_id, ordered.instead, length_m)
        except NoWay:
            self._cabs.tell(slot, step, (NoSuchWay(),))
            return
        self.of_stock[stock_id], duty = changed, changed[at]
        if self._trains.truths[slot].active:  # else it has yet to come in
            self._trains.go_by(slot, duty)
            self._books.follow(slot, duty, step)
        for following in changed[at + 1 : at + 2]:
            self._on_board.forget_plan(slot, following)
        self._cabs.tell(slot, step, self._on_board.take_up_way(slot, duty))

    def _end_train(self, slot: int, ordered: TrainEndsHere, step: int) -> None:
        """The driver ends the train where it stands; trains up to the one ordered are left out, which begins there."""
        stock_id, line = self._trains.stock_ids[slot], self._setup.believed_line
        at, duties = self._next[stock_id] - 1, self.of_stock[stock_id]
        target, length_m = self._books.next_target(slot) - 1, self._setup.lengths_m[stock_id]
        try:
            if not self._trains.truths[slot].active:
                raise NoWay(f"{stock_id} has yet to come in")
            changed = cut_at(line, duties, at, target, ordered.train, length_m)
        except NoWay:
            self._cabs.tell(slot, step, (NoSuchWay(),))
            return
        self.of_stock[stock_id], (ended, begun) = changed, changed[at : at + 2]
        to = len(duties) - len(changed) + at + 1
        self._cancel(slot, step, (duties[at], ended), duties[at + 1 : to], (duties[to], begun))
        self._trains.go_by(slot, ended)
        self._books.follow(slot, ended, step)
        self._on_board.forget_plan(slot, begun)
        self._cabs.tell(slot, step, self._on_board.take_up_way(slot, ended))

    def _cancel(
        self,
        slot: int,
        step: int,
        first: tuple[Duty, Duty],
        between: tuple[Duty, ...],
        last: tuple[Duty, Duty],
    ) -> None:
        """Writes down what does not come: of two trains what they lack as they are now, of those between all.

        It counts as late as the scenario states; the train that is ended no less than it is now.
        """
        (old, ended), (planned, begun) = first, last
        at = len(ended.train.calls) - 1
        stated_s, late_s = self._setup.dispatch.stated_late_s, step / STEPS_PER_S - old.train.calls[at].last_s
        self._books.ends_here(slot)
        self._books.cancel(slot, old.train, range(at, len(old.train.calls)), max(stated_s, late_s))
        self.cut += [duty.train.number for duty in (old, *between)]
        for duty in between:
            self._books.cancel(slot, duty.train, range(len(duty.train.calls)), stated_s)
        missed = len(planned.train.calls) - len(begun.train.calls)
        self._books.cancel(slot, planned.train, range(missed + 1 if missed else 0), stated_s, begins=True)

    def _enter(self, slot: int, duty: Duty, step: int) -> None:
        """Through the portal, if nothing stands there."""
        if self._trains.stands_in(duty.mission.spans[0].section_id):
            if slot not in self._looks_again:
                self._agenda.put(step + RETRY_STEPS, AgendaKind.DUTY, self._trains.stock_ids[slot])
            self._looks_again[slot] = True
            return
        self._put_on_line(slot, duty, step)

    def _put_on_line(self, slot: int, duty: Duty, step: int) -> None:
        stock_id = self._trains.stock_ids[slot]
        self._stage[slot] = StockStage.ON_LINE
        self._trains.place(slot, duty)
        if self._charging is not None:
            self._charging.enters(slot, step)
        length_m, on = float(self._trains.bodies[slot].length_m), self._trains.pieces_under(slot)
        pieces = (path_step.piece_id for path_step in duty.mission.path.steps)
        under = tuple(piece_id + SIGN[duty.mission.direction] for piece_id in pieces if piece_id in on)
        entered = Entered(unit_id=stock_id, train=duty.train.number, edge_ids=under)
        self._journal.write(step / STEPS_PER_S, WORLD, entered)
        self._checkers.entered(stock_id, length_m, under)
        seen = self._trains.carrier.truth(stock_id)
        edge = seen.piece_id + SIGN[seen.direction]
        self._checkers.observe(step / STEPS_PER_S, stock_id, edge, seen.offset_m, seen.speed_mps)
        self._trains.compare([slot], [seen])
        self._begin(slot, duty, step)

    def _present(self, slot: int) -> Duty:
        """The stock's duty, which it has or waits outside for."""
        stock_id = self._trains.stock_ids[slot]
        return self.of_stock[stock_id][self._next[stock_id] - 1]

    def _begin(self, slot: int, duty: Duty, step: int) -> None:
        self._trains.begin_leg(slot, max(duty.enter_s, step / STEPS_PER_S))
        self._on_board.load_is(slot, float(self._trains.plants[slot].load_share))
        self._books.begin_train(slot, duty, step)
        if self._charging is not None:
            self._charging.begins(slot, duty, step)

    def _finish(self, slot: int, step: int) -> None:
        """The journey is done: turn back, leave the line, or stand."""
        stock_id, duty = self._trains.stock_ids[slot], self._trains.duties[slot]
        if duty is None:
            return
        self._begun_again.discard(slot)
        self._journal.write(step / STEPS_PER_S, stock_id, MissionDone(train=duty.train.number))
        if duty.leaves:
            self._begins(Pause.SIGN_OFF, slot, step)
        elif duty.becomes is not None and duty not in self._becoming:
            self._becoming.append(duty)  # a unit that starts again in its terminus finishes twice
            self._agenda.put(step + round(self._setup.turn_s / STEP_S), AgendaKind.DUTY, stock_id)
        elif duty.becomes is None:
            self._books.stable(slot, step)
            self._stage[slot] = StockStage.DONE

    # trains whose unit is cut out ------------------------------------------------------------------------------------

    def progress(self, slot: int) -> tuple[int, float]:
        """Index of the stock's present duty, and the target where it called last: -1 outside, infinite once over."""
        stage, index = self._stage[slot], self._next[self._trains.stock_ids[slot]] - 1
        if stage is StockStage.WAITING:
            return index, -1.0
        return index, float(self._books.next_target(slot) - 1) if stage is StockStage.ON_LINE else math.inf

    def is_to_turn(self, slot: int) -> bool:
        """Whether the stock stands where its train ends, which neither its unit nor its driver has ended yet."""
        duty = self._trains.duties[slot]
        if duty is None or duty.becomes is None or duty in self._becoming:
            return False
        return self._books.next_target(slot) == len(duty.mission.targets)

    def waits_outside(self, slot: int) -> bool:
        """Whether the stock stands outside its portal."""
        return self._stage[slot] is StockStage.WAITING

    def enter_by_hand(self, slot: int, step: int) -> None:
        """A train whose unit is cut out comes in by its portal."""
        self._enter(slot, self._present(slot), step)

    def finish_by_hand(self, slot: int, step: int) -> bool:
        """Its journey is over; whether it then leaves the line."""
        duty = self._trains.duties[slot]
        if duty is not None and duty.leaves:
            return True
        self._finish(slot, step)
        return False

    def leave_by_hand(self, slot: int, step: int) -> None:
        """It leaves the line by the portal where it stands."""
        done = MissionDone(train=self._present(slot).train.number)
        self._journal.write(step / STEPS_PER_S, self._trains.stock_ids[slot], done)
        self._leave(slot, step)

    def haul_away(self, slot: int, step: int) -> None:
        """Staff take a train without power out of a portal where it stands alone; the manager is not told."""
        under = self._trains.sections_under().get(self._trains.stock_ids[slot], ())
        stands = self._stage[slot] is StockStage.ON_LINE and float(self._trains.plants[slot].speed_mps) == 0.0
        if stands and slot in self._on_board.unpowered and self._portals.issuperset(under):
            self._leave(slot, step)

    def _leave(self, slot: int, step: int) -> None:
        """Off the line, as the contact at its boundary and the driver see; only then is the portal left."""
        stock_id = self._trains.stock_ids[slot]
        self._books.close_energy(slot, step)
        if self._charging is not None:
            self._charging.leaves(slot, step)
        portals = [s for s in self._trains.sections_under()[stock_id] if s in self._portals]
        self._trains.remove(slot)
        self._checkers.train_left(stock_id)
        self._journal.write(step / STEPS_PER_S, WORLD, Left(unit_id=stock_id))
        for portal in portals:
            self._wayside.input(step, MANAGER_ID, BoundaryPassed(portal))
        free_step = self._cabs.off_the_line(slot, step)
        following = self.of_stock[stock_id][self._next[stock_id] :]
        self._stage[slot] = StockStage.OUTSIDE if following else StockStage.DONE
        for duty in following[:1]:
            self._agenda.put(max(round(duty.comes_s / STEP_S), free_step), AgendaKind.DUTY, stock_id)
