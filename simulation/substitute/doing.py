"""How a step of substitute working is done or left out, by whomever: what is written down, and what comes of it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from network.model import SectionKind
from simulation.events import WORLD, ProcedureStep, StepLeftOut, UnitRestrains
from simulation.pauses import Pauses
from simulation.people import Pause
from simulation.procedure import ActingRole, Part, Post, ProcedureRow, WorkingStep
from simulation.setup import STEPS_PER_S
from simulation.substitute.by_hand import HandDriver
from simulation.substitute.hops import Hop
from simulation.substitute.sight import LineSight
from simulation.substitute.work import Work, is_post, place_of
from simulation.substitute_settings import Substitute
from simulation.world.stage import World

# left out, its effect comes all the same: the driver leaves by himself
BY_ITSELF: Final = frozenset({WorkingStep.GO})
PASSED_OVER: Final = "passed over"


class StepsDone:
    """What is done of the procedure in one run."""

    def __init__(self, world: World, settings: Substitute, drivers: HandDriver, sight: LineSight) -> None:
        self._setup, self._settings = world.setup, settings
        self._trains, self._wayside, self._journal = world.trains, world.wayside, world.journal
        self._drivers, self._sight = drivers, sight
        self._pauses: Final = Pauses(world.setup)
        self._posts_s: dict[str, float] = {}  # when somebody is at a station

    def begin(self) -> None:
        """Substitute working comes into force: nobody has been sent anywhere."""
        self._posts_s = {}

    def cuts_in_at(self, slot: int, step: int) -> int:
        """The step at which a driver, told now, has cut his unit in."""
        return step + self._pauses.steps(Pause.BOARD, self._trains.stock_ids[slot]) + 1

    def takes_until(
        self, work: Work, row: ProcedureRow, hop: Hop | None, step: int, *, by_person: bool = False
    ) -> int:
        """The step at which it will have been done. A person has noticed already what others take time to notice."""
        if row.step is WorkingStep.MAN:
            return max([step, *(self._post(end, step) for end in work.ends if not self.is_staffed(end))])
        if row.pause is Pause.NOTICE and by_person:
            return step
        if row.step is WorkingStep.BOARD and hop is not None and work.book.pilot in work.ends:
            away = work.book.pilot != hop.origin
            step += self._pauses.steps(Pause.REACH, f"pilot {work.name}") if away else 0
        times = max(len(hop.points), 1) if hop is not None and row.step is WorkingStep.POINTS else 1
        who = author_of(work, row, hop)
        return step + sum(self._pauses.steps(row.pause, who) for _ in range(times))

    def _post(self, end: str, step: int) -> int:
        """When somebody is at a station: he is sent once."""
        if end not in self._posts_s:
            self._posts_s[end] = step / STEPS_PER_S + self._pauses.steps(Pause.REACH, end) / STEPS_PER_S
        return round(self._posts_s[end] * STEPS_PER_S)

    def is_there(self, post: str, step: int) -> bool:
        """Whether who has a post is at it: an operator has to come to a station that has none."""
        if not is_post(post, Post.OPERATOR):
            return True
        end = place_of(post)
        return self.is_staffed(end) or step / STEPS_PER_S >= self._posts_s.get(end, math.inf)

    def is_absent(self, work: Work, end: str) -> bool:
        """Whether nobody came to a station that has no operator."""
        return WorkingStep.MAN in work.book.left_out and not self.is_staffed(end)

    def is_staffed(self, end: str) -> bool:
        """Whether a station has an operator; a portal is another line's, which has one."""
        section = self._setup.line.sections.get(end)
        portal = section is not None and section.kind is SectionKind.PORTAL
        return portal or end in self._settings.staffed

    def do(self, work: Work, row: ProcedureRow, hop: Hop | None, step: int, author: str = "") -> None:
        """A step is done, in the book or, of a train that is not in it, beside it."""
        hop = hop if row.part is Part.TRAIN else None
        said = ProcedureStep(
            block=work.name,
            step=row.step.value,
            to_whom=row.to.value,
            says=row.says.format(block=work.name, train="" if hop is None else hop.train),
            unit_id="" if hop is None else hop.stock_id,
            train="" if hop is None else hop.train,
        )
        self._journal.write(step / STEPS_PER_S, author or author_of(work, row, hop), said)
        work.keep(hop, work.book_of(hop).after(row))
        self._effect(work, row, hop, step)

    def leave_out(self, work: Work, row: ProcedureRow, why: str, step: int, author: str = "") -> None:
        """A step is left out, and people go on as though it had been done."""
        hop = work.book.hop
        self._write_left_out(work, row, hop, why, step, author)
        work.book = work.book.after(row, left_out=True)
        if row.step is WorkingStep.CLEAR:
            self._believe_clear(work, step)
        elif row.step is WorkingStep.ARRIVED and hop is not None:
            work.taken_as_over.add(hop)
        if row.step in BY_ITSELF:
            self._effect(work, row, hop, step)

    def _believe_clear(self, work: Work, step: int) -> None:
        """Nobody has found out what is in it: who is not at his station by his time has surely gone through."""
        now_s = step / STEPS_PER_S
        late = {h for h in work.hops if h.planned_s < now_s and not self._sight.stands(h)}
        work.taken_as_over |= late

    def _write_left_out(
        self, work: Work, row: ProcedureRow, hop: Hop | None, why: str, step: int, author: str = ""
    ) -> None:
        left = StepLeftOut(
            block=work.name,
            step=row.step.value,
            why=why,
            unit_id="" if hop is None else hop.stock_id,
            train="" if hop is None else hop.train,
        )
        self._journal.write(step / STEPS_PER_S, author or author_of(work, row, hop), left)

    def _effect(self, work: Work, row: ProcedureRow, hop: Hop | None, step: int) -> None:
        """What a step does besides being said."""
        if row.step is WorkingStep.CLEAR and not self._sight.lets(work, row, hop, step):
            self._believe_clear(work, step)
        elif row.step is WorkingStep.PILOT:
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
                self._drivers.cut_out(slot, step)
            case WorkingStep.GO:
                work.gone_s = step / STEPS_PER_S
                self._pass_over(work, hop, step)
                if not self._drivers.let_go(slot, hop.end, step):
                    self.unit_restrains(hop, step)
            case WorkingStep.ARRIVED if not self._sight.is_over(hop):
                work.taken_as_over.add(hop)
            case WorkingStep.ALIGHT:
                work.book = replace(work.book, pilot=hop.destination)
            case _:
                pass

    def unit_restrains(self, hop: Hop, step: int) -> None:
        """A driver was told to go whose unit does not let him."""
        self._journal.write(step / STEPS_PER_S, WORLD, UnitRestrains(unit_id=hop.stock_id))

    def _pass_over(self, work: Work, hop: Hop, step: int) -> None:
        """The train goes: what should have been done for it before, and was not, has been left out."""
        book = work.book_of(hop)
        rows = [row for row in work.rows_of(book) if row.part is Part.TRAIN]
        go = next(i for i, row in enumerate(rows) if row.step is WorkingStep.GO)
        for row in rows[:go]:
            if row.step not in book.of_train:
                self._write_left_out(work, row, hop, PASSED_OVER, step)
                book = book.after(row, left_out=True)
        work.keep(hop, book)

    def _pilot_begins_at(self, work: Work) -> str:
        hop = self._sight.next_hop(work)
        return work.ends[0] if hop is None else hop.origin

    def _set_points(self, work: Work, hop: Hop, step: int) -> None:
        """Those at ends where somebody is."""
        for points_id, position in hop.points:
            station = self._setup.line.points[points_id].section_id
            end = hop.destination if station in hop.after_block else hop.origin
            if work.block and self.is_absent(work, end):
                continue
            self._wayside.repair(step, points_id, position)


def author_of(work: Work, row: ProcedureRow, hop: Hop | None) -> str:
    """Who writes it down: the role, and for operators and pilots where."""
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
