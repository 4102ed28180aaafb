"""What may follow from many states of the line at once, by tables of what may follow at each party.

A state is one number of 64 bits: the ground (manager, terminals, what is left of the budgets) and a cell for each
train. Whatever happens concerns one or two of these at a time, so it is computed once for each pair that comes and
looked up for all states that have it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np

from verify import tokens
from verify.cells import (
    AFTER,
    CELL_BITS,
    COSTS,
    EFFECT_BITS,
    FINISHED,
    GRANTED,
    GROUND,
    GUARD,
    GUARD_OF,
    HEAD,
    HELD,
    IN_USE,
    NEAR,
    NEEDS,
    NEVER,
    OCCUPIED,
    OLDEST,
    SAID,
    SEEN_OR_SHOWN,
    SPEAKS,
    TOKEN_BITS,
    TrainCells,
)
from verify.columns import Block, Columns, Which
from verify.explored_line import ANY, TERMINALS, UnwishedFor, mask_of
from verify.happening import GuardKind
from verify.parties import ExploredParties, LocalEvent, Numbered, Sends, StepKind
from verify.search import Keys
from verify.tables import Choices, GrowingRows, Numbers, Once
from verify.terminal import lie_code

MANAGER_BITS, TERMINAL_BITS, LEFT_BITS = 20, 14, 12
# by how many trains there are; the ground has the rest
CELL_BITS_OF: Final = {1: CELL_BITS, 2: CELL_BITS, 3: 15}
# columns of a manager, of a terminal, and of a choice of theirs
EPOCH, COUNTER, TOKENS, GRANTS, MAY_GRANT, ON_SIGHT, BAD = range(7)
HOLDS: Final = 7
LIE, MEMORY = range(2)
NEXT, TROUBLE, ABOUT, STANDS, WORD, CORRECTS, QUIET = range(7)
EFFECT: Final = 7


class Expansion:
    """Successors of states, and rules, for whole arrays."""

    def __init__(self, parties: ExploredParties) -> None:
        self.parties: Final = parties
        self._units: Final = range(len(parties.units))
        cells = CELL_BITS_OF[len(self._units)]
        self.bits: Final = (64 - len(self._units) * cells, *(cells for _ in self._units))
        self.grounds: Final = Numbered[tuple[bool, tuple[int, ...], tuple[int, ...]]]()
        self.lefts: Final = Numbered[tuple[int, ...]]()
        self.cells: Final = tuple(TrainCells(parties, unit, self.grounds) for unit in self._units)
        self._bits: Final = Numbered[int]()
        self._managers: Final = GrowingRows(HOLDS + len(self._units))
        self._terminals: Final = tuple(GrowingRows(2) for _ in TERMINALS)
        self._manager_choices: Final = Choices(EFFECT + len(self._units), self._manager_events)
        self._persons_choices: Final = Choices(EFFECT + len(self._units), self._persons_err)
        self._terminal_choices: Final = tuple(
            Choices(EFFECT + len(self._units), partial(self._terminal_events, i))
            for i in range(len(TERMINALS))
        )
        self._spent: Final = Once(self._spend, 1, LEFT_BITS, 4)
        self._manager_hears: Final = tuple(
            Once(partial(self._heard, u), 2 + len(self._units), MANAGER_BITS, 20) for u in self._units
        )
        self._terminal_hears: Final = tuple(
            tuple(
                Once(partial(self._t_heard, i, u), 1 + len(self._units), TERMINAL_BITS, 20)
                for u in self._units
            )
            for i in range(len(TERMINALS))
        )
        self._boundary: Final = Once(self._passed, 1 + len(self._units), MANAGER_BITS)
        self._by_hand: Final = tuple(
            Once(partial(self._locked, i), 1 + len(self._units), TERMINAL_BITS, 1)
            for i in range(len(TERMINALS))
        )
        self._manager_anew: Final = Once(self._manager_in_order, 1, MANAGER_BITS, TOKEN_BITS)
        self._terminal_anew: Final = tuple(
            Once(partial(self._terminal_in_order, i), 1, TERMINAL_BITS, TOKEN_BITS)
            for i in range(len(TERMINALS))
        )
        self.ground_keys: Final = Numbered[tuple[int, ...]]()
        self._ground_rows: Final = GrowingRows(2 + len(TERMINALS))
        self._ground: Final = Once(
            self._ground_of, 1, MANAGER_BITS, *(TERMINAL_BITS,) * len(TERMINALS), LEFT_BITS
        )
        self.lefts.number(tuple(parties.line.budgets))

    # packing ----------------------------------------------------------------------------------------------------------

    def start(self) -> Keys:
        """The one state in which all begins."""
        zero = np.zeros(1, np.int64)
        return self.packed(Columns(zero, (zero,) * len(TERMINALS), zero, (zero,) * len(self._units)))

    def packed(self, columns: Columns) -> Keys:
        """States as numbers."""
        ground = self._ground(columns.manager, *columns.terminals, columns.left)[:, 0]
        keys = np.zeros(len(ground), np.int64)
        cells = (of.in_states.of(numbers) for of, numbers in zip(self.cells, columns.cells, strict=True))
        for numbers, bits in zip((ground, *cells), self.bits, strict=True):
            if len(numbers) and int(numbers.max()) >> bits:
                raise OverflowError(f"more than 2 ** {bits} parts of states: a state does not fit 64 bits")
            keys = keys << bits | numbers
        return keys.view(np.uint64)

    def columns(self, keys: Keys) -> Columns:
        """The parts of states."""
        numbers, parts = keys.view(np.int64), list[Numbers]()
        for bits in reversed(self.bits):
            parts.insert(0, numbers & (1 << bits) - 1)
            numbers = numbers >> bits
        ground, *cells = parts
        manager, *terminals, left = (self._ground_rows.column(i)[ground] for i in range(2 + len(TERMINALS)))
        numbered = tuple(of.in_states.things[n] for of, n in zip(self.cells, cells, strict=True))
        return Columns(manager, tuple(terminals), left, numbered)

    def _ground_of(self, *key: int) -> tuple[int]:
        number = self.ground_keys.number(key)
        if number == len(self._ground_rows):
            self._ground_rows.add(key)
        return (number,)

    # successors -------------------------------------------------------------------------------------------------------

    def following(self, keys: Keys) -> tuple[Numbers, Keys, Numbers]:
        """Index of the state that each follows from, what follows, and with what trouble."""
        states = self.columns(keys)
        blocks = [block for block in self._blocks(states) if len(block.source)]
        if not blocks:
            none = np.zeros(0, np.int64)
            return none, none.view(np.uint64), none
        after = Columns(
            np.concatenate([b.after.manager for b in blocks]),
            tuple(np.concatenate([b.after.terminals[i] for b in blocks]) for i in range(len(TERMINALS))),
            np.concatenate([b.after.left for b in blocks]),
            tuple(np.concatenate([b.after.cells[u] for b in blocks]) for u in self._units),
        )
        source = np.concatenate([b.source for b in blocks])
        return source, self.packed(self._settled(after)), np.concatenate([b.trouble for b in blocks])

    def _blocks(self, states: Columns) -> Iterator[Block]:
        for unit in self._units:
            yield self._of_cells(states, unit)
            yield self._to_manager(states, unit)
            for index in range(len(TERMINALS)):
                yield self._to_terminal(states, unit, index)
        yield self._of_manager(states, self._manager_choices)
        may_err = np.flatnonzero(
            self._spent(states.left, np.full(len(states.left), UnwishedFor.WORD))[:, 0] >= 0
        )
        errs = self._of_manager(states.at(may_err), self._persons_choices)
        yield errs._replace(source=may_err[errs.source])
        for index in range(len(TERMINALS)):
            yield self._of_terminal(states, index)

    def _of_cells(self, states: Columns, unit: int) -> Block:
        source, column = self.cells[unit].choices.of(states.cells[unit])
        guard, of = column(GUARD), column(GUARD_OF)
        may = np.ones(len(source), bool)
        free = guard == GuardKind.FREE
        for other in (other for other in self._units if other != unit):
            occupied = self.cells[other].rows.column(OCCUPIED)[states.cells[other][source]]
            may &= ~free | (occupied & of == 0)
        for index in range(len(TERMINALS)):
            here = (guard >= GuardKind.LIES) & (guard <= GuardKind.LIES_NOT) & (of >> 4 == index)
            lies = self._lie(index, states.terminals[index])[source] == of & 15
            may &= ~here | (lies == (guard == GuardKind.LIES))
        picked = np.flatnonzero(may)
        block = self._spending(states.at(source[picked]), source[picked], column(COSTS)[picked])
        kept, after = block
        rows = picked[kept.chosen]
        cell_sets = list(after.cells)
        cell_sets[unit] = column(AFTER)[rows]
        changed = self._elsewhere(after._replace(cells=tuple(cell_sets)), column(GROUND)[rows])
        return Block(source[rows], changed, column(COSTS)[rows])

    def _elsewhere(self, states: Columns, grounds: Numbers) -> Columns:
        """What events of trains do to the ground."""
        manager, terminals, cells = states.manager.copy(), list(states.terminals), list(states.cells)
        for number, (left, locks, unlocks) in enumerate(self.grounds.things):
            if not (left or locks or unlocks):
                continue
            at = np.flatnonzero(grounds == number)
            if not len(at):
                continue
            if left:
                made = self._boundary(manager[at])
                manager[at] = made[:, 0]
                self._send(cells, at, made[:, 1:])
            for index in (*locks, *unlocks):
                locked = np.full(len(at), int(index in locks))
                terminals[index] = terminals[index].copy()
                made = self._by_hand[index](terminals[index][at], locked)
                terminals[index][at] = made[:, 0]
                self._send(cells, at, made[:, 1:])
        return Columns(manager, tuple(terminals), states.left, tuple(cells))

    def _send(self, cells: list[Numbers], at: Numbers, effects: Numbers) -> None:
        """Telegrams on their way to the units of some of the states."""
        for unit in self._units:
            some = np.flatnonzero(effects[:, unit])
            if len(some):
                cells[unit] = cells[unit].copy()
                where = at[some]
                cells[unit][where] = self.cells[unit].sent(cells[unit][where], effects[some, unit])[:, 0]

    def _to_manager(self, states: Columns, unit: int) -> Block:
        table = self.cells[unit].rows
        source = np.flatnonzero(table.column(SAID)[states.cells[unit]] >= 0)
        some = states.at(source)
        made = self._manager_hears[unit](some.manager, table.column(SAID)[some.cells[unit]])
        cells, effects = list(some.cells), made[:, 2:].copy()
        cells[unit] = self.cells[unit].heard(cells[unit], made[:, 1], effects[:, unit])[:, 0]
        effects[:, unit] = 0
        self._send(cells, np.arange(len(source)), effects)
        return _untroubled(source, some._replace(manager=made[:, 0], cells=tuple(cells)))

    def _to_terminal(self, states: Columns, unit: int, index: int) -> Block:
        head = self.cells[unit].rows.column(HEAD + index + 1)
        source = np.flatnonzero(head[states.cells[unit]] >= 0)
        some = states.at(source)
        made = self._terminal_hears[index][unit](some.terminals[index], head[some.cells[unit]])
        cells, terminals = list(some.cells), list(some.terminals)
        terminals[index] = made[:, 0]
        cells[unit] = self.cells[unit].without_first[index + 1](cells[unit])[:, 0]
        self._send(cells, np.arange(len(source)), made[:, 1:])
        return _untroubled(source, some._replace(terminals=tuple(terminals), cells=tuple(cells)))

    def _of_manager(self, states: Columns, choices: Choices) -> Block:
        source, column = choices.of(states.manager)
        may = np.ones(len(source), bool)
        about, near = column(ABOUT), np.zeros(len(source), bool)
        for unit, cells in enumerate(self.cells):
            cell = states.cells[unit][source]
            speaks, shown = (cells.rows.column(c)[cell] for c in (SPEAKS, SEEN_OR_SHOWN))
            oldest = cells.rows.column(OLDEST)[cell]
            true = (speaks == 0) | ((column(CORRECTS) != 0) & (oldest == NEVER))
            true &= shown == column(STANDS)
            may &= (about != unit) | (true == (column(TROUBLE) == UnwishedFor.NONE))
            early = oldest < self._managers.column(EPOCH)[states.manager[source]]
            may &= (about != unit) | (column(QUIET) == 0) | (oldest == NEVER)
            may &= (column(WORD) == 0) | ~early
            near |= cells.rows.column(NEAR)[cell] != 0
        return self._at_ground(states, source, column, may, near, None)

    def _of_terminal(self, states: Columns, index: int) -> Block:
        source, column = self._terminal_choices[index].of(states.terminals[index])
        near = np.zeros(len(source), bool)
        for unit, cells in enumerate(self.cells):
            near |= cells.rows.column(NEAR + index + 1)[states.cells[unit][source]] != 0
        return self._at_ground(states, source, column, np.ones(len(source), bool), near, index)

    def _at_ground(
        self,
        states: Columns,
        source: Numbers,
        column: Callable[[int], Numbers],
        may: Which,
        near: Which,
        index: int | None,
    ) -> Block:
        trouble = np.where((column(TROUBLE) == UnwishedFor.NONE) & near, UnwishedFor.DELAY, column(TROUBLE))
        picked = np.flatnonzero(may)
        kept, after = self._spending(states.at(source[picked]), source[picked], trouble[picked])
        rows = picked[kept.chosen]
        cells = list(after.cells)
        effects = np.stack([column(EFFECT + unit)[rows] for unit in self._units], axis=1)
        self._send(cells, np.arange(len(rows)), effects)
        if index is None:
            after = after._replace(manager=column(NEXT)[rows])
        else:
            terminals = list(after.terminals)
            terminals[index] = column(NEXT)[rows]
            after = after._replace(terminals=tuple(terminals))
        return Block(source[rows], after._replace(cells=tuple(cells)), trouble[rows])

    class _Chosen(NamedTuple):
        chosen: Numbers

    def _spending(self, states: Columns, source: Numbers, trouble: Numbers) -> tuple[_Chosen, Columns]:
        """Those whose budget has something left, which is spent."""
        left = self._spent(states.left, trouble)[:, 0] if len(source) else states.left
        chosen = np.flatnonzero(left >= 0)
        return self._Chosen(chosen), states.at(chosen)._replace(left=left[chosen])

    # states that are one ----------------------------------------------------------------------------------------------

    def _settled(self, states: Columns) -> Columns:
        self._add_rows()
        cells = list(states.cells)
        grants = self._managers.column(GRANTS)[states.manager]
        for unit, table in enumerate(self.cells):
            idle = (grants >> unit & 1 == 0) & (table.rows.column(GRANTED)[cells[unit]] != 0)
            at = np.flatnonzero(idle)
            if len(at):
                cells[unit] = cells[unit].copy()
                cells[unit][at] = table.forgets(cells[unit][at])[:, 0]
        return self._in_order(states._replace(cells=tuple(cells)))

    def _in_order(self, states: Columns) -> Columns:
        in_use = self._managers.column(TOKENS)[states.manager]
        for index, rows in enumerate(self._terminals):
            in_use = in_use | rows.column(MEMORY)[states.terminals[index]]
        for unit, cells in enumerate(self.cells):
            in_use = in_use | cells.rows.column(IN_USE)[states.cells[unit]]
        epoch = self._managers.column(EPOCH)[states.manager]
        counter = self._managers.column(COUNTER)[states.manager]
        different, inverse = np.unique(np.stack((in_use, epoch, counter)), axis=1, return_inverse=True)
        wrong = np.array([not tokens.in_order(*row) for row in different.T.tolist()], bool)
        at = np.flatnonzero(wrong[inverse.reshape(-1)])
        if not len(at):
            return states
        bits, which = np.unique(in_use[at], return_inverse=True)
        number = np.array([self._bits.number(b) for b in bits.tolist()], np.int64)[which]
        some = states.at(at)
        manager = states.manager.copy()
        manager[at] = self._manager_anew(some.manager, number)[:, 0]
        terminals, cells_ = [t.copy() for t in states.terminals], [c.copy() for c in states.cells]
        for index, anew in enumerate(self._terminal_anew):
            terminals[index][at] = anew(some.terminals[index], number)[:, 0]
        for unit, cells in enumerate(self.cells):
            of_unit = np.array([cells.in_use.number(b) for b in bits.tolist()], np.int64)[which]
            cells_[unit][at] = cells.anew(some.cells[unit], of_unit)[:, 0]
        self._add_rows()
        return Columns(manager, tuple(terminals), states.left, tuple(cells_))

    def _add_rows(self) -> None:
        """Columns of what has been found since."""
        for number in range(len(self._managers), len(self.parties.managers.things)):
            manager = self.parties.managers.things[number]
            register = manager.kept.register
            may_grant = manager.power and register.defined
            self._managers.add(
                (
                    manager.epoch,
                    register.counter if manager.power else -1,
                    tokens.of_manager(manager),
                    self.parties.manager_grants(number),
                    may_grant,
                    mask_of(register.unswept),
                    bool(manager.bad),
                    *self.parties.held_by_register(number),
                )
            )
        for rows, known in zip(self._terminals, self.parties.terminals, strict=True):
            for terminal in known.things[len(rows) :]:
                rows.add((lie_code(terminal), tokens.of_terminal(terminal)))

    def _lie(self, index: int, terminals: Numbers) -> Numbers:
        self._add_rows()
        return self._terminals[index].column(LIE)[terminals]

    # what must hold ---------------------------------------------------------------------------------------------------

    def broken(self, keys: Keys) -> Which:
        """In which states a rule is broken; `Composition.broken` says which."""
        self._add_rows()
        states = self.columns(keys)
        columns = [cells.rows.column for cells in self.cells]
        occupied = [columns[u](OCCUPIED)[states.cells[u]] for u in self._units]
        held = [columns[u](HELD)[states.cells[u]] for u in self._units]
        bad = self.collided(keys)
        for one, other in combinations(self._units, 2):
            both_know = (held[one] >= 0) & (held[other] >= 0)
            bad |= both_know & (held[one] & held[other] != 0)
        manager = states.manager
        on_sight = self._managers.column(ON_SIGHT)[manager]
        may_grant = self._managers.column(MAY_GRANT)[manager] != 0
        for unit in self._units:
            bad |= (held[unit] >= 0) & (occupied[unit] & ~held[unit] != 0)
            mine = self._managers.column(HOLDS + unit)[manager]
            bad |= may_grant & (occupied[unit] & ~mine & ~on_sight != 0)
            for index in range(len(TERMINALS)):
                need = columns[unit](NEEDS + index)[states.cells[unit]]
                bad |= (need != 0) & (self._lie(index, states.terminals[index]) != need)
        bad |= self._managers.column(BAD)[manager] != 0
        return bad

    def collided(self, keys: Keys) -> Which:
        """In which states two trains stand in one section."""
        cells = self.columns(keys).cells
        occupied = [self.cells[u].rows.column(OCCUPIED)[cells[u]] for u in self._units]
        bad = np.zeros(len(keys), bool)
        for one, other in combinations(occupied, 2):
            bad |= one & other != 0
        return bad

    def finished(self, keys: Keys) -> Which:
        """In which states every train has come and gone, and the manager could let the next one in."""
        self._add_rows()
        states, managers = self.columns(keys), self._managers.column
        done = [managers(HOLDS + unit)[states.manager] == 0 for unit in self._units]
        done += [managers(MAY_GRANT)[states.manager] != 0]
        done += [self.cells[u].rows.column(FINISHED)[states.cells[u]] != 0 for u in self._units]
        all_: Which = np.all(done, axis=0)
        return all_

    # tables -----------------------------------------------------------------------------------------------------------

    def _effects(self, peer: int, sends: Sends) -> tuple[int, ...]:
        """What is sent down, as an effect for each unit."""
        by_unit = (tuple((2 * peer + 1, t) for u, t in sends if u == unit) for unit in self._units)
        return tuple(self.cells[unit].effects.number(of) for unit, of in enumerate(by_unit))

    def _heard(self, unit: int, manager: int, said: int) -> tuple[int, ...]:
        telegram, granted = self.cells[unit].said.things[said]
        made = self.parties.make(StepKind.MANAGER_HEARS, manager, unit, telegram, granted)
        return made.state, made.granted, *self._effects(0, made.sends)

    def _t_heard(self, index: int, unit: int, terminal: int, telegram: int) -> tuple[int, ...]:
        made = self.parties.make(StepKind.TERMINAL_HEARS, index, terminal, unit, telegram)
        return made.state, *self._effects(index + 1, made.sends)

    def _passed(self, manager: int) -> tuple[int, ...]:
        made = self.parties.make(StepKind.BOUNDARY_PASSED, manager)
        return made.state, *self._effects(0, made.sends)

    def _locked(self, index: int, terminal: int, locked: int) -> tuple[int, ...]:
        made = self.parties.make(StepKind.LOCKED_BY_HAND, index, terminal, locked)
        return made.state, *self._effects(index + 1, made.sends)

    def _manager_events(self, manager: int) -> list[Sequence[int]]:
        return [self._event_row(0, e) for e in self.parties.make(StepKind.MANAGER_EVENTS, manager)]

    def _persons_err(self, manager: int) -> list[Sequence[int]]:
        return [self._event_row(0, e) for e in self.parties.make(StepKind.PERSONS_ERR, manager)]

    def _terminal_events(self, index: int, terminal: int) -> list[Sequence[int]]:
        found = self.parties.make(StepKind.TERMINAL_EVENTS, index, terminal)
        return [self._event_row(index + 1, e) for e in found]

    def _event_row(self, peer: int, event: LocalEvent) -> Sequence[int]:
        effects = self._effects(peer, event.sends)
        return (
            event.state,
            event.trouble,
            event.about,
            event.stands,
            event.word,
            event.corrects,
            event.quiet,
            *effects,
        )

    def _manager_in_order(self, manager: int, bits: int) -> tuple[int]:
        return (self.parties.make(StepKind.MANAGER_ANEW, manager, self._bits.things[bits]),)

    def _terminal_in_order(self, index: int, terminal: int, bits: int) -> tuple[int]:
        return (self.parties.make(StepKind.TERMINAL_ANEW, index, terminal, self._bits.things[bits]),)

    def _spend(self, left: int, trouble: int) -> tuple[int]:
        budget = self.lefts.things[left]
        if trouble == UnwishedFor.NONE or budget[trouble - 1] == ANY:
            return (left,)
        if budget[trouble - 1] == 0:
            return (-1,)
        return (self.lefts.number((*budget[: trouble - 1], budget[trouble - 1] - 1, *budget[trouble:])),)


def _untroubled(source: Numbers, after: Columns) -> Block:
    return Block(source, after, np.zeros(len(source), np.int64))


__all__ = ["EFFECT_BITS", "TOKEN_BITS", "Expansion", "Keys"]
