"""The people who work a line by substitute working, as the program plays them: by the tables of `simulation.procedure`.

They begin when the block manager has failed and end when it is back. For each section between stations, and each
station, a book says what has been done; the players do the next step of its table once the world lets them, after the
time that it takes them. A step that the scenario has them leave out is written down, has no effect, and they go on as
though it had been done. Nothing refuses that but equipment: a unit that is not cut out, points under a train.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

from network.model import SectionKind
from simulation.agenda import AgendaKind
from simulation.cabs import Cabs
from simulation.duties import Duties
from simulation.events import WORLD, ProcedureStep, StepLeftOut, UnitRestrains
from simulation.pauses import Pauses
from simulation.people import Pause
from simulation.procedure import (
    PROCEDURES,
    WITHIN_STATION,
    ActingRole,
    Part,
    ProcedureRow,
    Regime,
    WorkingStep,
    rows_of_train,
)
from simulation.setup import STEPS_PER_S
from simulation.substitute.book import BlockBook
from simulation.substitute.by_hand import HandDriver
from simulation.substitute.hops import Hop, hops_of
from simulation.substitute_settings import Substitute
from simulation.world.stage import World
from wayside.config import MANAGER_ID

BY_ITSELF: Final = frozenset(
    {WorkingStep.GO}
)  # left out, its effect comes all the same: the driver leaves by himself
NOBODY: Final = "nobody is there"
TICKETS = True  # off: a pilot rides with every train
NEED_NOT_BE_EMPTY = True  # off: also a section that never had a pilot must be empty first
BY_ROAD = True  # off: he waits for a train that brings him to where he is needed


@dataclass(slots=True)
class Work:
    """One section or station: by which table it is worked, and its book. `due_step`: when the row under way is done;
    `taken_as_over`: ways of trains that people take as over though nobody has said so.
    """

    name: str
    block: bool
    ends: tuple[str, ...]
    table: tuple[ProcedureRow, ...]
    hops: list[Hop] = field(default_factory=list)
    book: BlockBook = field(default_factory=BlockBook)
    row: ProcedureRow | None = None
    due_step: int = 0
    gone_s: float = 0.0
    taken_as_over: set[Hop] = field(default_factory=set[Hop])
    over: bool = False
    home: str = ""  # where its pilot begins

    @property
    def rows(self) -> tuple[ProcedureRow, ...]:
        """The table as it is for the train in the book."""
        return rows_of_train(self.table, ticket=self.book.ticket)


class SubstitutePlayers:
    """The dispatcher, operators, pilots and drivers of one run."""

    def __init__(self, world: World, cabs: Cabs, duties: Duties, settings: Substitute) -> None:
        self._setup, self._settings = world.setup, settings
        self._trains, self._on_board, self._wayside = world.trains, world.on_board, world.wayside
        self._agenda, self._journal, self._duties = world.agenda, world.journal, duties
        self._pauses: Final = Pauses(world.setup)
        self.drivers: Final = HandDriver(
            world, cabs, duties, settings.speed_mps, world.setup.unit.dwell_min_s
        )
        self._hops: Final = hops_of(world.drawn)
        self._works: list[Work] = []
        self._posts_s: dict[str, float] = {}  # when somebody is at a station
        self._cut_in_steps: dict[int, int] = {}

    @property
    def busy(self) -> bool:
        """Whether substitute working is in force, or trains are yet to be handed back to their units."""
        return bool(self._works) or MANAGER_ID in self._wayside.down

    def begin(self, step: int) -> None:
        """Nothing to do before the block manager fails."""

    def look(self, step: int) -> None:
        """All look round: what is due is done."""
        if not self._works and MANAGER_ID in self._wayside.down:
            self._works = self._new_works()
            self._posts_s = {}
        if not self._works:
            return
        self.drivers.look(step)
        ending = MANAGER_ID not in self._wayside.down
        for work in self._works:
            while self._goes_on(work, step, ending=ending):
                pass
        if all(work.over for work in self._works):
            self._hand_back(step)

    def _new_works(self) -> list[Work]:
        works: dict[str, Work] = {}
        for hop in self._hops:
            ends = tuple(dict.fromkeys((hop.origin, hop.destination))) if hop.block else (hop.work,)
            rows = PROCEDURES[self._settings.regime_of(hop.block)] if hop.block else WITHIN_STATION
            work = works.setdefault(hop.work, Work(hop.work, bool(hop.block), tuple(sorted(ends)), rows))
            work.hops.append(hop)
        return list(works.values())

    def _hand_back(self, step: int) -> None:
        """Drivers cut their units in again, each in his own time."""
        for slot in list(self.drivers.driven):
            if slot not in self._cut_in_steps:
                pause = self._pauses.steps(Pause.BOARD, self._trains.stock_ids[slot])
                self._cut_in_steps[slot] = step + pause + 1
                self._wake(self._cut_in_steps[slot])
            elif step >= self._cut_in_steps[slot] and self._stands_still(slot):
                self.drivers.cut_in(slot, step)
                del self._cut_in_steps[slot]
        if not self.drivers.driven:
            self._works = []

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
        row = work.row or work.book.next_row(work.rows, ending=ending)
        if row is None:
            return self._next_train(work, step, ending=ending)
        return self._does(work, row, step)

    def _had_no_pilot(self, work: Work) -> bool:
        """Whether the working of a section ends before a pilot was named: who stands in it is under authority."""
        done = work.book.done
        return NEED_NOT_BE_EMPTY and work.block and WorkingStep.STOP in done and WorkingStep.PILOT not in done

    def _does(self, work: Work, row: ProcedureRow, step: int) -> bool:
        """Do a step, leave it out, or begin with it and go on when its time is over; whether it stands in the book."""
        if work.row is None and (why := self._is_left_out(work, row)):
            return self._leave_out(work, row, why, step)
        if not self._ready(work, row, step):
            work.row = None
            return False
        if work.row is None:
            work.row, work.due_step = row, self._takes_until(work, row, step)
            self._wake(work.due_step)
        if step < work.due_step:
            return False
        work.row = None
        self._done(work, row, step)
        return True

    def _next_train(self, work: Work, step: int, *, ending: bool) -> bool:
        """Take up the next train of the plan, if it stands where it is to leave; or find that all is over."""
        book = work.book
        if ending:
            work.over = book.ended(work.rows) or WorkingStep.ORDER not in book.done
            return False
        hop = self._next_hop(work)
        if hop is None or not book.begun(work.rows):
            return False
        soon = step / STEPS_PER_S >= hop.planned_s - self._settings.ask_before_s
        if not (soon and self._stands(hop)):
            return False
        work.book = book.takes(hop, ticket=self._goes_by_ticket(work, hop))
        return True

    def _goes_by_ticket(self, work: Work, hop: Hop) -> bool:
        """Whether the pilot stays where he is, for the next train leaves from there too."""
        has_tickets = TICKETS and WorkingStep.TICKET in {row.step for row in work.table}
        if not has_tickets or work.book.pilot != hop.origin:
            return False
        following = self._next_hop(work, after=hop)
        return following is not None and following.origin == hop.origin

    def _withdraw(self, work: Work) -> None:
        """The ordinary working is to come back: a train that has not left is not taken up any more."""
        hop = work.book.hop
        if hop is not None and self._stands(hop):
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
        hop = work.book.hop
        left = StepLeftOut(
            block=work.name,
            step=row.step.value,
            why=why,
            unit_id="" if hop is None else hop.stock_id,
            train="" if hop is None else hop.train,
        )
        self._journal.write(step / STEPS_PER_S, self._author(work, row), left)
        work.book = work.book.after(row, left_out=True)
        if row.step is WorkingStep.CLEAR:  # who is not at his station by his time has surely gone through
            now_s = step / STEPS_PER_S
            work.taken_as_over |= {h for h in work.hops if h.planned_s < now_s and not self._stands(h)}
        elif row.step is WorkingStep.ARRIVED and hop is not None:
            work.taken_as_over.add(hop)
        if row.step in BY_ITSELF:
            self._effect(work, row, step)
        return True

    def _is_left_out(self, work: Work, row: ProcedureRow) -> str:
        """Why a step is not done, in words; empty: it is."""
        hop = work.book.hop
        train = "" if hop is None or row.part is not Part.TRAIN else hop.train
        if self._is_needless(work, row):
            return "the pilot stays aboard"
        if any(left.holds(row.step, work.name, train) for left in self._settings.left_out):
            return "left out"
        if row.falls_with is not None and row.falls_with in work.book.left_out:
            return f"without {row.falls_with.value}"
        absent = [end for end in self._doers(work, row) if self._is_absent(work, end)]
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

    def _is_absent(self, work: Work, end: str) -> bool:
        return WorkingStep.MAN in work.book.left_out and not self._is_staffed(end)

    def _is_staffed(self, end: str) -> bool:
        """Whether a station has an operator; a portal is another line's, which has one."""
        section = self._setup.line.sections.get(end)
        portal = section is not None and section.kind is SectionKind.PORTAL
        return portal or end in self._settings.staffed

    # what the world has to let them do ---------------------------------------------------------------------------

    def _ready(self, work: Work, row: ProcedureRow, step: int) -> bool:
        hop = work.book.hop
        if row.part is Part.TRAIN and hop is not None:
            return self._lets_train(work, row.step, hop, step)
        if row.step in (WorkingStep.CLEAR, WorkingStep.EMPTY):
            return not work.block or self._is_clear(work.name)
        return row.step is not WorkingStep.STOP or MANAGER_ID not in self._wayside.down

    def _lets_train(self, work: Work, kind: WorkingStep, hop: Hop, step: int) -> bool:
        match kind:
            case WorkingStep.AGREE:
                lets = self._are_free(hop.after_block, hop.stock_id)
            case WorkingStep.POINTS:
                ahead = hop.section_ids if not work.block else ()
                lets = self._are_free((*self._points_sections(hop), *ahead), hop.stock_id)
            case WorkingStep.BOARD:
                lets = work.book.pilot in (*(work.ends if BY_ROAD else (hop.origin,)), hop.stock_id)
            case WorkingStep.CUT_OUT:
                lets = self._may_come_in(hop)
            case WorkingStep.GO:
                lets = step / STEPS_PER_S >= hop.planned_s
            case WorkingStep.ARRIVED:
                lets = self._is_over(hop) and self._stands_still(self._trains.slot_of[hop.stock_id])
            case _:
                lets = True
        return lets

    def _is_clear(self, block: str) -> bool:
        """No train is in the section, and no unit that works shows its driver that it may run into it."""
        if self._trains.stands_in(block):
            return False
        slots = (slot for slot in self._trains.active() if slot not in self._on_board.unpowered)
        return not any(block in self._on_board.shown_to_driver(slot).held for slot in slots)

    def _are_free(self, section_ids: tuple[str, ...], stock_id: str) -> bool:
        under = self._trains.sections_under()
        others = (sections for other, sections in under.items() if other != stock_id)
        return not any(sections.intersection(section_ids) for sections in others)

    def _points_sections(self, hop: Hop) -> tuple[str, ...]:
        return tuple(self._setup.line.points[points].section_id for points, _ in hop.points)

    def _may_come_in(self, hop: Hop) -> bool:
        slot = self._trains.slot_of[hop.stock_id]
        outside = not self._trains.truths[slot].active
        return not (outside and self._trains.stands_in(hop.begins_in))

    def _should_have_arrived(self, work: Work, step: int) -> bool:
        hop = work.book.hop
        return hop is None or step / STEPS_PER_S >= work.gone_s + hop.run_s

    # where trains are by what operators see -----------------------------------------------------------------------

    def _stands(self, hop: Hop) -> bool:
        """Whether the train stands where the way begins, on the line or outside its portal."""
        slot = self._trains.slot_of[hop.stock_id]
        duty, at = self._duties.progress(slot)
        begins = (-1.0, 0.0) if hop.begin == 0 else (float(hop.begin),)
        if (duty, at) not in [(hop.duty, target) for target in begins]:
            return False
        return at < 0.0 or self._stands_still(slot)

    def _is_over(self, hop: Hop) -> bool:
        """Whether the train has come to where the way ends, or further."""
        return self._duties.progress(self._trains.slot_of[hop.stock_id]) >= (hop.duty, float(hop.end))

    def _stands_still(self, slot: int) -> bool:
        return not self._trains.truths[slot].active or self._trains.plants[slot].speed_mps == 0.0

    def _next_hop(self, work: Work, after: Hop | None = None) -> Hop | None:
        over = work.taken_as_over
        return next(
            (hop for hop in work.hops if hop not in over and hop != after and not self._is_over(hop)), None
        )

    # doing it -----------------------------------------------------------------------------------------------------

    def _takes_until(self, work: Work, row: ProcedureRow, step: int) -> int:
        """The step at which it will have been done."""
        hop = work.book.hop
        if row.step is WorkingStep.MAN:
            return max([step, *(self._post(end, step) for end in work.ends if not self._is_staffed(end))])
        if row.step is WorkingStep.BOARD and hop is not None and work.book.pilot in work.ends:
            away = work.book.pilot != hop.origin
            step += self._pauses.steps(Pause.REACH, f"pilot {work.name}") if away else 0
        times = max(len(hop.points), 1) if hop is not None and row.step is WorkingStep.POINTS else 1
        who = self._author(work, row)
        return step + sum(self._pauses.steps(row.pause, who) for _ in range(times))

    def _post(self, end: str, step: int) -> int:
        """When somebody is at a station: he is sent once."""
        if end not in self._posts_s:
            self._posts_s[end] = step / STEPS_PER_S + self._pauses.steps(Pause.REACH, end) / STEPS_PER_S
        return round(self._posts_s[end] * STEPS_PER_S)

    def _done(self, work: Work, row: ProcedureRow, step: int) -> None:
        hop = work.book.hop if row.part is Part.TRAIN else None
        said = ProcedureStep(
            block=work.name,
            step=row.step.value,
            to_whom=row.to.value,
            says=row.says.format(block=work.name, train="" if hop is None else hop.train),
            unit_id="" if hop is None else hop.stock_id,
            train="" if hop is None else hop.train,
        )
        self._journal.write(step / STEPS_PER_S, self._author(work, row), said)
        work.book = work.book.after(row)
        self._effect(work, row, step)

    def _effect(self, work: Work, row: ProcedureRow, step: int) -> None:
        """What a step does besides being said."""
        hop = work.book.hop
        if row.step is WorkingStep.PILOT:
            work.home = self._pilot_begins_at(work)
            work.book = replace(work.book, pilot=work.home)
        elif row.step is WorkingStep.RELEASE:
            work.book = replace(work.book, pilot="")
        if hop is None:
            return
        slot = self._trains.slot_of[hop.stock_id]
        match row.step:
            case WorkingStep.POINTS:
                self._set_points(work, hop, step)
            case WorkingStep.BOARD:
                work.book = replace(work.book, pilot=hop.stock_id)
            case WorkingStep.CUT_OUT:
                self.drivers.cut_out(slot, step)
            case WorkingStep.GO:
                work.gone_s = step / STEPS_PER_S
                if not self.drivers.let_go(slot, hop.end, step):
                    self._journal.write(step / STEPS_PER_S, WORLD, UnitRestrains(unit_id=hop.stock_id))
            case WorkingStep.ALIGHT:
                work.book = replace(work.book, pilot=hop.destination)
            case _:
                pass

    def _pilot_begins_at(self, work: Work) -> str:
        hop = self._next_hop(work)
        return work.ends[0] if hop is None else hop.origin

    def _set_points(self, work: Work, hop: Hop, step: int) -> None:
        """Those at ends where somebody is."""
        for points_id, position in hop.points:
            station = self._setup.line.points[points_id].section_id
            end = hop.destination if station in hop.after_block else hop.origin
            if work.block and self._is_absent(work, end):
                continue
            self._wayside.repair(step, points_id, position)

    def _author(self, work: Work, row: ProcedureRow) -> str:
        """Who writes it down: the role, and for operators and pilots where."""
        hop = work.book.hop
        match row.who:
            case ActingRole.DISPATCHER:
                return "dispatcher"
            case ActingRole.PILOT:
                return f"pilot {work.name}"
            case ActingRole.DRIVER if hop is not None:
                return f"driver {hop.train}"
            case ActingRole.RECEIVING if hop is not None:
                return f"operator {hop.destination or work.name}"
            case ActingRole.SENDING if hop is not None:
                return f"operator {hop.origin or work.name}"
            case _:
                return f"operators {work.name}"

    def _wake(self, step: int) -> None:
        self._agenda.put(step, AgendaKind.PROCEDURE, "players")
