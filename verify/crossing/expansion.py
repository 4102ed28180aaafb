"""What may follow from many states of a crossing and its train at once, by tables of what may follow at each.

A state is one number of 64 bits: what is left of the budgets, the gate (device, equipment, judge), and the cell of the
train (its unit, and what is on the air to and from it). Whatever happens concerns two of these at a time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from verify.crossing.composition import CrossingWhole
from verify.crossing.explored_crossing import ON_AIR_MAX, CrossingTrouble, ExploredCrossing
from verify.crossing.facts import GateKey, gate_key, has_passed, rests, seen_of
from verify.crossing.gate import GateModel, GateState, GateStep, Rider, Shut
from verify.crossing.rider import RiderModel, RiderState, RiderStep, Told, of_before
from verify.on_air import InAir
from verify.parties import Numbered
from verify.search import Keys
from verify.tables import Choices, GrowingRows, Numbers, Once

CELL_BITS, GATE_BITS, EFFECT_BITS, LEFT_BITS, FACT_BITS, TOLD_BITS = 26, 20, 18, 12, 5, 3
Tagged = tuple[tuple[int, bool], ...]  # telegrams of the device, and whether the closure that is was so then
# train, telegrams to the device and from it, networks lost
CellKey = tuple[int, tuple[int, ...], Tagged, bool]
# columns of a cell, and of what may follow from one
FACT, HEAD, PASSED_BY = range(3)
AFTER, COSTS, TOLD, ANEW = range(4)
# of a gate
BROKEN, RESTS = range(2)
EFFECT, CEASES, OPENS, TROUBLE, ALONE, UNPROVEN = range(1, 7)


class Parts(NamedTuple):
    """States as columns."""

    left: Numbers
    gate: Numbers
    cell: Numbers

    def at(self, which: Numbers | NDArray[np.bool_]) -> Parts:
        """Some of them."""
        return Parts(self.left[which], self.gate[which], self.cell[which])


def rider_of(fact: int) -> Rider:
    """What the judge sees of a train, by its bits."""
    return Rider(*(bool(fact >> i & 1) for i in range(len(Rider._fields))))


class CrossingExpansion:
    """Successors of states, and rules, for whole arrays."""

    def __init__(self, explored: ExploredCrossing) -> None:
        self.explored: Final = explored
        self.riders, self.gates = RiderModel(explored), GateModel(explored)
        self.rider_states: Final = Numbered[RiderState]()
        self.telegrams: Final = Numbered[InAir]()
        self.cells: Final = Numbered[CellKey]()
        self.lefts: Final = Numbered[tuple[int, ...]]()
        self.effects: Final = Numbered[Tagged]()
        self.gate_states: Final[list[GateState]] = []
        self._gate_numbers: Final[dict[GateKey, int]] = {}
        self._cell_rows, self._gate_rows = GrowingRows(3), GrowingRows(2)
        self._cell_choices: Final = Choices(4, self._of_cell)
        self._gate_choices: Final = Choices(7, self._of_gate)
        self._hears: Final = Once(self._gate_hears, 4, GATE_BITS, 20)
        self._spent: Final = Once(self._spend, 1, LEFT_BITS, 4)
        self._told: Final = Once(self._gate_told, 1, GATE_BITS, TOLD_BITS, 1)
        self._judged: Final = Once(self._gate_judged, 1, GATE_BITS, FACT_BITS, 1, 1)
        self._sent: Final = Once(self._cell_sent, 1, CELL_BITS, EFFECT_BITS, 1, 1)
        self.effects.number(())
        self.lefts.number(tuple(explored.budgets))
        self._cell(RiderState(), (), (), cut=False)
        self._gate(self.gates.start())

    # numbers -------------------------------------------------------------------------------------------------------

    def _cell(self, rider: RiderState, up: tuple[int, ...], down: Tagged, *, cut: bool) -> int:
        number = self.cells.number((self.rider_states.number(rider), up, down, cut))
        if number == len(self._cell_rows):
            coming = (self.telegrams.things[t] for t, _ in down)
            fact = sum(bit << i for i, bit in enumerate(seen_of(rider, coming, cut=cut)))
            self._cell_rows.add((fact, up[0] if up else -1, has_passed(rider)))
        return number

    def _gate(self, gate: GateState) -> int:
        key = gate_key(gate)
        number = self._gate_numbers.setdefault(key, len(self.gate_states))
        if number == len(self.gate_states):
            self.gate_states.append(gate)
            self._gate_rows.add((gate.judge.broken, rests(gate)))
        return number

    def _effect(self, sends: Sequence[InAir], gate: GateState) -> int:
        closed = gate.judge.shut is not Shut.NOT
        return self.effects.number(tuple((self.telegrams.number(s), closed) for s in sends))

    # what may follow at the train -----------------------------------------------------------------------------

    def _of_cell(self, number: int) -> list[Sequence[int]]:
        rider_number, up, down, cut = self.cells.things[number]
        rider, found = self.rider_states.things[rider_number], list[Sequence[int]]()
        if up:
            found.append((self._cell(rider, up[1:], down, cut=cut), CrossingTrouble.LOSS, 0, 0))
        if down:
            found.append((self._cell(rider, up, down[1:], cut=cut), CrossingTrouble.LOSS, 0, 0))
            telegram, of_now = down[0]
            heard = self.riders.hear(rider, self.telegrams.things[telegram], of_now)
            found.append(self._stepped(heard, up, down[1:], cut=cut))
        for step in self.riders.events(rider):
            if not (step.repeats and up):
                found.append(self._stepped(step, up, down, cut=cut))
        if cut:
            found.append((self._cell(rider, up, down, cut=False), 0, 0, 0))
        else:
            found.append((self._cell(rider, (), (), cut=True), CrossingTrouble.CARRIERS, 0, 0))
        return found

    def _stepped(self, step: RiderStep, up: tuple[int, ...], down: Tagged, *, cut: bool) -> Sequence[int]:
        if step.anew:
            up = tuple(self._of_before(t) for t in up)
            down = tuple((self._of_before(t), of_now) for t, of_now in down)
        if not cut:
            up = (*up, *map(self.telegrams.number, step.sends))[-ON_AIR_MAX:]
        return self._cell(step.state, up, down, cut=cut), step.trouble, step.told, step.anew

    def _of_before(self, telegram: int) -> int:
        return self.telegrams.number(of_before(self.telegrams.things[telegram]))

    def _cell_sent(self, number: int, effect: int, ceases: int, heard: int) -> tuple[int]:
        """With what the device says on its way; `ceases`: its closure is over; `heard`: it took the first telegram."""
        rider, up, down, cut = self.cells.things[number]
        if ceases:
            down = tuple((t, False) for t, _ in down)
        if not cut:
            down = (*down, *self.effects.things[effect])[-ON_AIR_MAX:]
        return (self._cell(self.rider_states.things[rider], up[heard:], down, cut=cut),)

    # at the gate ------------------------------------------------------------------------------------------------

    def whole(self, key: int) -> CrossingWhole:
        """A state as the composition has it."""
        left, gate, cell = (int(numbers[0]) for numbers in self.parts(np.array([key], np.uint64)))
        rider, up, down, cut = self.cells.things[cell]
        telegrams = self.telegrams.things
        return CrossingWhole(
            self.rider_states.things[rider],
            self.gate_states[gate],
            tuple(telegrams[t] for t in up),
            tuple((telegrams[t], of_now) for t, of_now in down),
            cut,
            self.lefts.things[left],
        )

    def _row(self, step: GateStep) -> tuple[int, int, int, int]:
        return (self._gate(step.state), self._effect(step.sends, step.state), step.ceases, step.opens)

    def _of_gate(self, number: int) -> list[Sequence[int]]:
        steps = self.gates.events(self.gate_states[number])
        return [(*self._row(s), s.trouble, s.alone, s.unproven) for s in steps]

    def _gate_hears(self, number: int, telegram: int) -> Sequence[int]:
        return self._row(self.gates.hear(self.gate_states[number], self.telegrams.things[telegram]))

    def _gate_told(self, number: int, told: int, anew: int) -> tuple[int]:
        gate = self.gates.told(self.gate_states[number], Told(told))
        return (self._gate(self.gates.anew(gate) if anew else gate),)

    def _gate_judged(self, number: int, fact: int, ceases: int, opens: int) -> tuple[int]:
        gate, rider = self.gate_states[number], rider_of(fact)
        return (self._gate(self.gates.judged(gate, rider, ceases=bool(ceases), opens=bool(opens))),)

    def _spend(self, number: int, trouble: int) -> tuple[int]:
        left = list(self.lefts.things[number])
        if trouble:
            left[trouble - 1] -= 1
        return (-1 if min(left) < 0 else self.lefts.number(tuple(left)),)

    # all at once ------------------------------------------------------------------------------------------------

    def start(self) -> Keys:
        """The one state in which all begins."""
        return np.zeros(1, np.uint64)

    def parts(self, keys: Keys) -> Parts:
        """States as columns."""
        rest = keys.astype(np.int64)
        gate = rest >> CELL_BITS & (1 << GATE_BITS) - 1
        return Parts(rest >> CELL_BITS + GATE_BITS, gate, rest & (1 << CELL_BITS) - 1)

    def packed(self, parts: Parts) -> Keys:
        """States as numbers."""
        for numbers, bits in zip(parts, (LEFT_BITS, GATE_BITS, CELL_BITS), strict=True):
            if len(numbers) and int(numbers.max()) >> bits:
                raise OverflowError(f"a table is full: {int(numbers.max())} is not below 2 ** {bits}")
        return ((parts.left << GATE_BITS | parts.gate) << CELL_BITS | parts.cell).astype(np.uint64)

    def following(self, keys: Keys) -> tuple[Numbers, Keys, Numbers]:
        """Successors: from which (by index), what, and with what trouble."""
        states = self.parts(keys)
        blocks = list(self._blocks(states))
        source = np.concatenate([b[0] for b in blocks])
        trouble = np.concatenate([b[2] for b in blocks])
        after = np.concatenate([self.packed(b[1]) for b in blocks])
        return source, after, trouble

    def _blocks(self, states: Parts) -> Iterator[tuple[Numbers, Parts, Numbers]]:
        whose, column = self._cell_choices.of(states.cell)
        gate = self._told(states.gate[whose], column(TOLD), column(ANEW))[:, 0]
        yield self._afforded(whose, states.left[whose], gate, column(AFTER), column(COSTS))
        whose, column = self._gate_choices.of(states.gate)
        fact = self._cell_rows.column(FACT)[states.cell[whose]]
        may = (column(ALONE) == 0) | (fact >> Rider._fields.index("comes") & 1 == 0)
        may &= (column(UNPROVEN) == 0) | (fact >> Rider._fields.index("believes") & 1 == 0)
        row = [column(index)[may] for index in range(TROUBLE + 1)]
        yield self._gate_done(whose[may], states.at(whose[may]), row, np.zeros(int(may.sum()), np.int64))
        head = self._cell_rows.column(HEAD)[states.cell]
        spoken = np.flatnonzero(head >= 0)
        heard = self._hears(states.gate[spoken], head[spoken])
        free = np.zeros(len(spoken), np.int64)
        row = [*heard.T, free]
        yield self._gate_done(spoken, states.at(spoken), row, free + 1)

    def _gate_done(
        self, whose: Numbers, states: Parts, row: Sequence[Numbers], heard: Numbers
    ) -> tuple[Numbers, Parts, Numbers]:
        fact = self._cell_rows.column(FACT)[states.cell]
        gate = self._judged(row[AFTER], fact, row[CEASES], row[OPENS])[:, 0]
        cell = self._sent(states.cell, row[EFFECT], row[CEASES], heard)[:, 0]
        return self._afforded(whose, states.left, gate, cell, row[TROUBLE])

    def _afforded(
        self, whose: Numbers, left: Numbers, gate: Numbers, cell: Numbers, trouble: Numbers
    ) -> tuple[Numbers, Parts, Numbers]:
        spent = self._spent(left, trouble)[:, 0]
        may = spent >= 0
        return whose[may], Parts(spent[may], gate[may], cell[may]), trouble[may]

    def broken(self, keys: Keys) -> NDArray[np.bool_]:
        """Which break a rule."""
        found: NDArray[np.bool_] = self._gate_rows.column(BROKEN)[self.parts(keys).gate] != 0
        return found

    def finished(self, keys: Keys) -> NDArray[np.bool_]:
        """In which the train has passed, and the road is open again."""
        states = self.parts(keys)
        passed = self._cell_rows.column(PASSED_BY)[states.cell] != 0
        rests: NDArray[np.bool_] = self._gate_rows.column(RESTS)[states.gate] != 0
        done: NDArray[np.bool_] = passed & rests
        return done
