"""Persons at posts of substitute working: what they have taken over, and each step that they do or leave out.

A person may do a step in its turn, out of it, or for a train that is not in the book, or leave it out. Nothing refuses
that but equipment and where people and trains are (`LineSight.refuses`); what its table had it wait for is written
down. A step takes the time that it takes the players, except that a person has noticed what there is to notice. One
that was begun in its turn, and that the world does not let be done as its time is over, is done when it does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from simulation.agenda import AgendaKind
from simulation.events import StepOutOfOrder, StepRefused
from simulation.faults.script import Act, ActKind
from simulation.procedure import ActingRole, Part, ProcedureRow, WorkingStep
from simulation.setup import STEPS_PER_S
from simulation.substitute.doing import StepsDone
from simulation.substitute.hops import Hop
from simulation.substitute.sight import NOT_CUT_OUT, NOT_HERE, LineSight
from simulation.substitute.work import Work
from simulation.world.stage import World

NOT_IN_FORCE: Final = "substitute working is not in force there"
NOT_TAKEN: Final = "nobody has taken that role"
NOT_YET_THERE: Final = "nobody is there yet"
DONE_BEFORE: Final = "it has been done, or is being done"
BEHIND_ANOTHER: Final = "another train is in the book"
NO_STEP: Final = "there is no such step in this working"
NOT_THEIRS: Final = "that is another role's"
TOO_EARLY: Final = "what it waits for has not come"
WAYS_OF_GOING: Final = (WorkingStep.TICKET, WorkingStep.BOARD)  # of which one is done


@dataclass(frozen=True, slots=True)
class BegunStep:
    """A step that a person does, until `due_step`; `in_turn`: it was next, and the world let it."""

    work: Work
    row: ProcedureRow
    hop: Hop | None
    post: str
    due_step: int
    in_turn: bool


class PersonsAtPosts:
    """The posts that persons have taken, and what they are doing."""

    def __init__(self, world: World, sight: LineSight, steps: StepsDone) -> None:
        self._agenda, self._journal = world.agenda, world.journal
        self._sight, self._steps = sight, steps
        self.taken: set[str] = set()
        self.begun: list[BegunStep] = []

    def act(self, works: Sequence[Work], act: Act, step: int) -> None:
        """A person takes a post, gives it back, or does or leaves out a step of its."""
        if act.kind is ActKind.TAKE_ROLE:
            self.taken.add(act.target)
            return
        if act.target not in self.taken:
            self._refuse(act.block, act.step, NOT_TAKEN, act.target, step, None)
            return
        if act.kind is ActKind.HAND_BACK_ROLE:
            self.taken.discard(act.target)
            return
        work = next((work for work in works if work.name == act.block and not work.over), None)
        if work is None:
            self._refuse(act.block, act.step, NOT_IN_FORCE, act.target, step, None)
        elif act.kind is ActKind.DO_STEP:
            self._begin(work, act, step)
        else:
            self._leave_out(work, act, step)

    def look(self, step: int) -> None:
        """What is due is done."""
        for begun in [each for each in self.begun if each.due_step <= step]:
            if self._ends(begun, step):
                self.begun.remove(begun)

    def is_in_turn(self, work: Work, row: ProcedureRow, hop: Hop | None, step: int) -> bool:
        """Whether a step is next by its table, and the world lets it be done."""
        return self._is_due(work, row, hop) and self._sight.lets(work, row, hop, step)

    # one step ---------------------------------------------------------------------------------------------------------

    def _begin(self, work: Work, act: Act, step: int) -> None:
        hop, row = self._meant(work, act)
        why = self._why_not(work, row, hop, act, step)
        if row is None or why:
            self._refuse(work.name, act.step, why, act.target, step, hop)
            return
        in_turn = self.is_in_turn(work, row, hop, step)
        if not in_turn and (why := self._sight.refuses(work, row, hop)):
            self._refused(work, row, hop, why, act.target, step)
            return
        due_step = self._steps.takes_until(work, row, hop, step, by_person=True)
        self.begun.append(BegunStep(work, row, hop, act.target, due_step, in_turn))
        self._agenda.put(due_step, AgendaKind.PROCEDURE, "person")

    def _meant(self, work: Work, act: Act) -> tuple[Hop | None, ProcedureRow | None]:
        """Which train's way, and which row, an act is about; by ticket or with the pilot is the person's choice."""
        wanted = WorkingStep(act.step)
        part = next((row.part for row in work.table if row.step is wanted), None)
        hop = self._hop(work, act.train) if part is Part.TRAIN else None
        book = work.book_of(hop)
        ticket = book.ticket if wanted not in WAYS_OF_GOING else wanted is WorkingStep.TICKET
        rows = work.rows_of(replace(book, ticket=ticket))
        return hop, next((row for row in rows if row.step is wanted), None)

    def _hop(self, work: Work, train: str) -> Hop | None:
        """The train's way: that in the book, one that a person is at, or the next that is not over."""
        if work.book.hop is not None and train in ("", work.book.hop.train):
            return work.book.hop
        ahead = [hop for hop in work.hops if hop.train == train]
        aside = next((hop for hop in ahead if hop in work.aside), None)
        return aside or next(
            (h for h in ahead if not self._sight.is_over(h) and h not in work.taken_as_over), None
        )

    def _why_not(self, work: Work, row: ProcedureRow | None, hop: Hop | None, act: Act, step: int) -> str:
        """Why nobody who has this post can do it; empty: it may be tried."""
        if row is None:
            return NO_STEP
        if row.part is Part.TRAIN and hop is None:
            return NOT_HERE
        if act.target not in work.posts(row, hop):
            return NOT_THEIRS
        if row.step is not WorkingStep.MAN and not self._steps.is_there(act.target, step):
            return NOT_YET_THERE
        other = {*WAYS_OF_GOING} if row.step in WAYS_OF_GOING else {row.step}
        under_way = any(b.work is work and b.row.step is row.step and b.hop == hop for b in self.begun)
        return DONE_BEFORE if under_way or other & work.book_of(hop).steps else ""

    def _is_due(self, work: Work, row: ProcedureRow, hop: Hop | None) -> bool:
        ending = WorkingStep.STOP in work.book.done or row.part is Part.END
        in_book = row.part is not Part.TRAIN or (hop is not None and hop == work.book.hop)
        return in_book and row in work.book.due_rows(work.rows, ending=ending)

    def _ends(self, begun: BegunStep, step: int) -> bool:
        """The time of a step is over: it is done if it can be; whether it is over with."""
        work, row, hop = begun.work, begun.row, begun.hop
        if work.over or row.step in work.book_of(hop).steps:
            return True
        if self.is_in_turn(work, row, hop, step):
            self._do(begun, step)
            return True
        if begun.in_turn:
            return not self._is_due(work, row, hop)  # what it was for is over; else the world is waited for
        if why := self._sight.refuses(work, row, hop):
            self._refused(work, row, hop, why, begun.post, step)
            return True
        early = StepOutOfOrder(**_of(work.name, row.step, self._what_lacks(work, row, hop), hop))
        self._journal.write(step / STEPS_PER_S, begun.post, early)
        self._do(begun, step)
        return True

    def _do(self, begun: BegunStep, step: int) -> None:
        work, row, hop = begun.work, begun.row, begun.hop
        if hop is not None and work.book.hop is None:
            work.take_up(hop, ticket=row.step is WorkingStep.TICKET)
        if row.step in WAYS_OF_GOING:
            work.keep(hop, replace(work.book_of(hop), ticket=row.step is WorkingStep.TICKET))
        own = begun.post if row.who is ActingRole.OPERATORS else ""
        self._steps.do(work, row, hop, step, own)

    def _what_lacks(self, work: Work, row: ProcedureRow, hop: Hop | None) -> str:
        """What a step out of its turn is done before."""
        book = replace(work.book_of(hop), done=work.book.done)
        if lacks := book.lacks(row, work.rows_of(book)):
            return f"before {', '.join(step.value for step in lacks)}"
        other = work.book.hop
        return BEHIND_ANOTHER if row.part is Part.TRAIN and other is not None and other != hop else TOO_EARLY

    def _leave_out(self, work: Work, act: Act, step: int) -> None:
        hop, row = self._meant(work, act)
        why = self._why_not(work, row, hop, act, step)
        if not why and row is not None and row.part is Part.TRAIN and hop != work.book.hop:
            why = BEHIND_ANOTHER if work.book.hop is not None else NOT_HERE
        if row is None or why:
            self._refuse(work.name, act.step, why, act.target, step, hop)
            return
        own = act.target if row.who is ActingRole.OPERATORS else ""
        self._steps.leave_out(work, row, "left out", step, own)

    # refusals ---------------------------------------------------------------------------------------------------------

    def _refused(
        self, work: Work, row: ProcedureRow, hop: Hop | None, why: str, post: str, step: int
    ) -> None:
        if why == NOT_CUT_OUT and hop is not None:
            self._steps.unit_restrains(hop, step)
        self._refuse(work.name, row.step.value, why, post, step, hop)

    def _refuse(self, block: str, wanted: str, why: str, post: str, step: int, hop: Hop | None) -> None:
        refused = StepRefused(**_of(block, wanted, why, hop))
        self._journal.write(step / STEPS_PER_S, post, refused)


def _of(block: str, step: str, why: str, hop: Hop | None) -> dict[str, str]:
    """What is written of a step."""
    named = {} if hop is None else {"unit_id": hop.stock_id, "train": hop.train}
    return {"block": block, "step": str(step), "why": why, **named}
