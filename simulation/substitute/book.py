"""What the operators of one section have done so far (閉そく簿), and which step of the procedure is next.

Pure: a step is next once all that it needs stands in the book, done or left out; whether the world lets it be done is
for the players. One train at a time is in the book.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from simulation.procedure import Part, ProcedureRow, WorkingStep
from simulation.substitute.hops import Hop


@dataclass(frozen=True, slots=True)
class BlockBook:
    """`done`: steps to begin and to end; `of_train`: those for the train whose way `hop` is; `left_out`: of all these,
    those that were not done though people go on as though they had been. `pilot`: where the pilot is by the book, a
    station, or the stock whose train he rides; empty: nobody is named. `ticket`: the train goes by his ticket.
    """

    done: frozenset[WorkingStep] = frozenset()
    hop: Hop | None = None
    of_train: frozenset[WorkingStep] = frozenset()
    left_out: frozenset[WorkingStep] = frozenset()
    pilot: str = ""
    ticket: bool = False

    @property
    def steps(self) -> frozenset[WorkingStep]:
        """All that stands in it, done or left out."""
        return self.done | self.of_train

    def lacks(self, row: ProcedureRow, rows: Sequence[ProcedureRow]) -> tuple[WorkingStep, ...]:
        """What a step needs, itself or by what it needs, and does not stand in the book; `rows`: the whole table."""
        needed, has = set(row.needs), self.steps
        for other in reversed(rows):
            needed |= set(other.needs) if other.step in needed else set()
        return tuple(other.step for other in rows if other.step in needed and other.step not in has)

    def due_rows(self, rows: Sequence[ProcedureRow], *, ending: bool) -> tuple[ProcedureRow, ...]:
        """The steps not in the book that are due now and lack nothing, in the order of the table.

        A train may be in it before all is done that begins the working, where persons have let it.
        """
        parts = {Part.BEGIN, Part.TRAIN} if self.hop is not None else {Part.END} if ending else {Part.BEGIN}
        due = (row for row in rows if row.part in parts and row.step not in self.steps)
        return tuple(row for row in due if not self.lacks(row, rows))

    def begun(self, rows: Sequence[ProcedureRow]) -> bool:
        """Whether trains may be taken up."""
        return all(row.step in self.done for row in rows if row.part is Part.BEGIN)

    def ended(self, rows: Sequence[ProcedureRow]) -> bool:
        """Whether the ordinary working is in force again."""
        return all(row.step in self.done for row in rows if row.part is Part.END)

    def after(self, row: ProcedureRow, *, left_out: bool = False) -> BlockBook:
        """The book with a step in it, done or left out."""
        left = self.left_out | {row.step} if left_out else self.left_out - {row.step}
        if row.part is Part.TRAIN:
            return replace(self, of_train=self.of_train | {row.step}, left_out=left)
        return replace(self, done=self.done | {row.step}, left_out=left)

    def takes(self, hop: Hop, *, ticket: bool = False) -> BlockBook:
        """The book as a train is taken up."""
        return replace(self, hop=hop, of_train=frozenset(), ticket=ticket)

    def train_over(self, rows: Sequence[ProcedureRow]) -> BlockBook:
        """The book with no train in it any more."""
        of_trains = {row.step for row in rows if row.part is Part.TRAIN}
        left_out = self.left_out - of_trains
        return replace(self, hop=None, of_train=frozenset(), left_out=left_out, ticket=False)

    def finished(self, rows: Sequence[ProcedureRow]) -> bool:
        """Whether all is done for the train in it."""
        return self.hop is not None and all(
            row.step in self.of_train for row in rows if row.part is Part.TRAIN
        )
