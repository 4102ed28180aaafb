"""The people who work a line by substitute working, as the program plays them: by the tables of `simulation.procedure`.

They begin when the block manager has failed and end when it is back. For each section between stations, and each
station, a book says what has been done; the players do the next step of its table once the world lets them, after the
time that it takes them. A step that the scenario has them leave out is written down, has no effect, and they go on as
though it had been done. Nothing refuses that but equipment: a unit that is not cut out, points under a train.
A step whose post a person has taken waits for that person (`substitute.persons`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from simulation.agenda import AgendaKind
from simulation.cabs import Cabs
from simulation.duties import Duties
from simulation.faults.script import Act
from simulation.procedure import ActingRole, Part, ProcedureRow, Regime, WorkingStep
from simulation.setup import STEPS_PER_S
from simulation.substitute.by_hand import HandDriver
from simulation.substitute.doing import StepsDone
from simulation.substitute.hops import Hop
from simulation.substitute.persons import PersonsAtPosts
from simulation.substitute.sight import LineSight
from simulation.substitute.work import Work, works_of
from simulation.substitute_settings import Substitute
from simulation.world.stage import World
from wayside.config import MANAGER_ID

NOBODY: Final = "nobody is there"
STAYS_ABOARD: Final = "the pilot stays aboard"
TICKETS = True  # off: a pilot rides with every train
STOPS_AT_CROSSINGS = (
    True  # off: drivers whose unit is cut out run over level crossings that nobody has announced them at
)
NEED_NOT_BE_EMPTY = True  # off: also a section that never had a pilot must be empty first


class SubstitutePlayers:
    """The dispatcher, operators, pilots and drivers of one run."""

    def __init__(self, world: World, cabs: Cabs, duties: Duties, settings: Substitute) -> None:
        self._settings = settings
        self._trains, self._wayside, self._agenda = world.trains, world.wayside, world.agenda
        self.drivers: Final = HandDriver(
            world,
            cabs,
            duties,
            settings.speed_mps,
            world.setup.unit.dwell_min_s,
            stops_at_crossings=STOPS_AT_CROSSINGS,
        )
        self.sight: Final = LineSight(world, duties, self.drivers)
        self._steps: Final = StepsDone(world, settings, self.drivers, self.sight)
        self.persons: Final = PersonsAtPosts(world, self.sight, self._steps)
        self._hops: tuple[Hop, ...] = ()  # by which the books are
        self.works: list[Work] = []
        self._cut_in_steps: dict[int, int] = {}

    @property
    def busy(self) -> bool:
        """Whether substitute working is in force, or trains are yet to be handed back to their units."""
        return bool(self.works) or MANAGER_ID in self._wayside.down

    def begin(self, step: int) -> None:
        """Nothing to do before the block manager fails."""

    def act(self, act: Act, step: int) -> None:
        """A person does something as one of these people."""
        self.persons.act(self.works, act, step)

    def look(self, step: int) -> None:
        """All look round: what is due is done."""
        if MANAGER_ID in self._wayside.down:
            self._begin_works()
        if not self.works:
            return
        self._follow_orders()
        self.drivers.look(step)
        self.persons.look(step)
        for work in self.works:
            ending = self.is_ending(work)
            while self._goes_on(work, step, ending=ending):
                pass
        if all(work.over for work in self.works):
            self._hand_back(step)

    def _begin_works(self) -> None:
        """The block manager is off: all is to be worked, also what had been ended before it failed again."""
        if not self.works:
            self._hops = self.sight.hops
            self.works = works_of(self._hops, self._settings)
            self._steps.begin()
        elif any(work.over for work in self.works) and not all(work.over for work in self.works):
            anew = {work.name: work for work in works_of(self._hops, self._settings)}
            self.works = [anew[work.name] if work.over else work for work in self.works]

    def _follow_orders(self) -> None:
        """What trains were ordered before the manager failed, and do only now, changes their ways; one that has been
        got ready for another way is taken up anew.
        """
        if self.sight.hops is self._hops:
            return
        self._hops = self.sight.hops
        anew = {work.name: work.hops for work in works_of(self._hops, self._settings)}
        for work in self.works:
            work.hops = anew.get(work.name, [])
            if work.book.hop not in (None, *work.hops) and WorkingStep.GO not in work.book.steps:
                work.row = None
                work.book = work.book.train_over(work.rows)

    def is_ending(self, work: Work) -> bool:
        """Whether the ordinary working is to come back: the block manager is there, or a person has said so."""
        return MANAGER_ID not in self._wayside.down or WorkingStep.STOP in work.book.done

    def _hand_back(self, step: int) -> None:
        """Drivers cut their units in again, each in his own time."""
        for slot in list(self.drivers.driven):
            if slot not in self._cut_in_steps:
                self._cut_in_steps[slot] = self._steps.cuts_in_at(slot, step)
                self._wake(self._cut_in_steps[slot])
            elif step >= self._cut_in_steps[slot] and self.sight.stands_still(slot):
                self.drivers.cut_in(slot, step)
                del self._cut_in_steps[slot]
        if not self.drivers.driven:
            self.works = []

    # one book ---------------------------------------------------------------------------------------------------------

    def _goes_on(self, work: Work, step: int, *, ending: bool) -> bool:
        """Do what is next in a book, if it can be done now; whether something was."""
        if work.over:
            return False
        if ending:
            self._withdraw(work)
            if self._had_no_pilot(work):
                work.over = True
                return False
        if work.book.finished(work.rows):
            work.book = work.book.train_over(work.rows)
        # a person has let the train go meanwhile
        if work.row is not None and work.row.step in work.book.steps:
            work.row = None
        due = work.book.due_rows(work.rows, ending=ending)
        if not due and work.row is None:
            return self._next_train(work, step, ending=ending)
        row = work.row or self._own(work, due)
        if row is None:
            return False
        if self._is_persons(work, row):
            work.row = None
            return self._falls(work, row, step)
        return self._does(work, row, step)

    def _own(self, work: Work, due: Sequence[ProcedureRow]) -> ProcedureRow | None:
        """The first of these that waits for no person, or that falls whoever it waits for."""
        return next(
            (row for row in due if not self._is_persons(work, row) or self._falls_by_itself(work, row)), None
        )

    def _is_persons(self, work: Work, row: ProcedureRow) -> bool:
        return not self.persons.taken.isdisjoint(work.posts(row, work.book.hop))

    def _falls(self, work: Work, row: ProcedureRow, step: int) -> bool:
        why = self._falls_by_itself(work, row)
        return bool(why) and self._leave_out(work, row, why, step)

    def _had_no_pilot(self, work: Work) -> bool:
        """Whether the working of a section ends before a pilot was named: who stands in it is under authority."""
        done = work.book.done
        return NEED_NOT_BE_EMPTY and work.block and WorkingStep.STOP in done and WorkingStep.PILOT not in done

    def _does(self, work: Work, row: ProcedureRow, step: int) -> bool:
        """Do a step, leave it out, or begin with it and go on when its time is over; whether it stands in the book."""
        if work.row is None and (why := self._is_left_out(work, row)):
            return self._leave_out(work, row, why, step)
        if not self.sight.lets(work, row, work.book.hop, step):
            work.row = None
            return False
        if work.row is None:
            work.row, work.due_step = row, self._steps.takes_until(work, row, work.book.hop, step)
            self._wake(work.due_step)
        if step < work.due_step:
            return False
        work.row = None
        self._steps.do(work, row, work.book.hop, step)
        return True

    def _next_train(self, work: Work, step: int, *, ending: bool) -> bool:
        """Take up the next train of the plan, if it stands where it is to leave; or find that all is over."""
        book = work.book
        if ending:
            work.over = book.ended(work.rows) or WorkingStep.ORDER not in book.done
            return False
        gone = next((hop for hop, aside in work.aside.items() if WorkingStep.GO in aside.of_train), None)
        if gone is not None:  # a person has let it go out of its turn
            work.take_up(gone, ticket=False)
            return True
        hop = self.sight.next_hop(work)
        if hop is None or not book.begun(work.rows):
            return False
        soon = step / STEPS_PER_S >= hop.planned_s - self._settings.ask_before_s
        if not (soon and self.sight.stands(hop)):
            return False
        work.take_up(hop, ticket=self._goes_by_ticket(work, hop))
        return True

    def _goes_by_ticket(self, work: Work, hop: Hop) -> bool:
        """Whether the pilot stays where he is, for the next train leaves from there too."""
        has_tickets = TICKETS and WorkingStep.TICKET in {row.step for row in work.table}
        if not has_tickets or work.book.pilot != hop.origin:
            return False
        following = self.sight.next_hop(work, after=hop)
        return following is not None and following.origin == hop.origin

    def _withdraw(self, work: Work) -> None:
        """The ordinary working is to come back: a train that has not left is not taken up any more."""
        hop = work.book.hop
        if hop is not None and self.sight.stands(hop):
            slot = self._trains.slot_of[hop.stock_id]
            train = self.drivers.driven.get(slot)
            if train is None or not train.runs:
                work.row = None
                if train is not None:
                    train.to = train.at
                work.book = work.book.train_over(work.rows)

    def _leave_out(self, work: Work, row: ProcedureRow, why: str, step: int) -> bool:
        if row.step is WorkingStep.ARRIVED and not self._should_have_arrived(work, step):
            return False  # by the plan he takes it as arrived
        self._steps.leave_out(work, row, why, step)
        return True

    def _should_have_arrived(self, work: Work, step: int) -> bool:
        hop = work.book.hop
        return hop is None or step / STEPS_PER_S >= work.gone_s + hop.run_s

    def _is_left_out(self, work: Work, row: ProcedureRow) -> str:
        """Why a step is not done, in words; empty: it is."""
        hop = work.book.hop
        train = "" if hop is None or row.part is not Part.TRAIN else hop.train
        if self._is_needless(work, row):
            return STAYS_ABOARD
        if any(left.holds(row.step, work.name, train) for left in self._settings.left_out):
            return "left out"
        return self._falls_by_itself(work, row)

    def _falls_by_itself(self, work: Work, row: ProcedureRow) -> str:
        """Why nobody can do a step, or need do it, in words; empty: it can be done."""
        if self._is_needless(work, row):
            return STAYS_ABOARD
        if row.falls_with is not None and row.falls_with in work.book.left_out:
            return f"without {row.falls_with.value}"
        absent = [end for end in self._doers(work, row) if self._steps.is_absent(work, end)]
        return NOBODY if absent and row.step is not WorkingStep.MAN and row.part is not Part.END else ""

    def _is_needless(self, work: Work, row: ProcedureRow) -> bool:
        """By 指導式 the pilot does not leave the train before it is back."""
        hop = work.book.hop
        shuttle = self._settings.regime_of(work.name) is Regime.SHUTTLE
        return shuttle and row.step is WorkingStep.ALIGHT and hop is not None and hop.destination != work.home

    def _doers(self, work: Work, row: ProcedureRow) -> tuple[str, ...]:
        """At which ends somebody has to be for it."""
        hop = work.book.hop
        if not work.block or self._settings.regime_of(work.name) is Regime.DISPATCHER:
            return ()
        if row.who is ActingRole.OPERATORS and row.step is WorkingStep.CLEAR:
            return work.ends
        if hop is None:
            return ()
        return {ActingRole.SENDING: (hop.origin,), ActingRole.RECEIVING: (hop.destination,)}.get(row.who, ())

    def _wake(self, step: int) -> None:
        self._agenda.put(step, AgendaKind.PROCEDURE, "players")
