"""The book of a section: each step is next only when all that its rule needs is in it, and never twice."""

from itertools import combinations

import pytest

from simulation.procedure import (
    PROCEDURES,
    WITHIN_STATION,
    Part,
    ProcedureRow,
    Regime,
    WorkingStep,
    rows_of_train,
)
from simulation.substitute.book import BlockBook
from simulation.substitute.hops import Hop

HOP = Hop("V1", "T1", 0, 0, 1, "S", "A", "B", "A.1", ("S", "B.1"), ("B.1",), (), 0.0, 60.0)
TABLES = {
    **{regime.value: rows_of_train(rows, ticket=False) for regime, rows in PROCEDURES.items()},
    "by ticket": rows_of_train(PROCEDURES[Regime.TELEPHONE], ticket=True),
    "within a station": WITHIN_STATION,
}
CASES = [
    pytest.param(rows, row, id=f"{name}: {row.step.value}") for name, rows in TABLES.items() for row in rows
]


def next_row(book: BlockBook, rows: tuple[ProcedureRow, ...], *, ending: bool) -> ProcedureRow | None:
    return next(iter(book.due_rows(rows, ending=ending)), None)


def _book(row: ProcedureRow, steps: frozenset[WorkingStep]) -> BlockBook:
    if row.part is Part.TRAIN:
        return BlockBook(done=steps, hop=HOP)
    return BlockBook(done=steps)


@pytest.mark.parametrize(("rows", "row"), CASES)
def test_a_step_is_next_once_all_that_it_needs_is_done_and_not_before(
    rows: tuple[ProcedureRow, ...], row: ProcedureRow
) -> None:
    others = frozenset(other.step for other in rows) - {row.step}
    ending = row.part is Part.END
    assert next_row(_book(row, others), rows, ending=ending) is row
    for missing in row.needs:
        assert next_row(_book(row, others - {missing}), rows, ending=ending) is not row
    assert next_row(_book(row, others | {row.step}), rows, ending=ending) is None


@pytest.mark.parametrize("name", TABLES)
def test_from_the_first_step_a_table_leads_through_all_of_them_in_its_order(name: str) -> None:
    rows, book, done = TABLES[name], BlockBook(), []
    while (row := next_row(book, rows, ending=False)) is not None:
        book = book.after(row)
        done.append(row)
    assert book.begun(rows)
    book = book.takes(HOP)
    while (row := next_row(book, rows, ending=False)) is not None:
        book = book.after(row)
        done.append(row)
    assert book.finished(rows)
    book = book.train_over(rows)
    while (row := next_row(book, rows, ending=True)) is not None:
        book = book.after(row)
        done.append(row)
    assert book.ended(rows)
    assert tuple(done) == rows


def test_needs_are_steps_that_stand_before() -> None:
    for rows in TABLES.values():
        for earlier, row in combinations(rows, 2):
            assert row.step not in earlier.needs
        steps = [row.step for row in rows]
        assert len(steps) == len(set(steps))
        assert all(set(row.needs) <= set(steps) for row in rows)


def test_what_is_left_out_stands_in_the_book_as_done_and_as_left_out() -> None:
    rows = PROCEDURES[Regime.TELEPHONE]
    order, man = rows[0], rows[1]
    book = BlockBook().after(order).after(man, left_out=True)
    assert man.step in book.done
    assert book.left_out == {man.step}
    following = next_row(book, rows, ending=False)
    assert following is not None
    assert following.step is WorkingStep.CLEAR


def test_what_was_left_out_for_one_train_is_not_for_the_next() -> None:
    rows = PROCEDURES[Regime.TELEPHONE]
    ask = next(row for row in rows if row.step is WorkingStep.ASK)
    book = (
        BlockBook(left_out=frozenset({WorkingStep.MAN})).takes(HOP).after(ask, left_out=True).train_over(rows)
    )
    assert book.left_out == {WorkingStep.MAN}
