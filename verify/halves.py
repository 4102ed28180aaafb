"""What may follow from many states, by halves: the ground and one train make a half, of which each is looked at once.

For the checker alone. States come as numbers of the tables of a certificate; what is found and is in none of them gets
greater numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from verify import tokens
from verify.explored_line import ANY, BIT, TERMINALS, UnwishedFor, mask_of
from verify.happening import GuardKind
from verify.parties import ExploredParties, LocalEvent, Numbered, Sends, StepKind, renaming
from verify.terminal import LIES, lie_code
from verify.train import PEERS, TrainPlace

Numbers = NDArray[np.int64]
Queues = tuple[tuple[int, ...], ...]
Cell = tuple[int, Queues, int]  # train, telegrams by way, correlation of the last grant
Effects = tuple[tuple[int, int, int], ...]  # telegrams to units: to whom, by way, which
Ground = tuple[tuple[int, ...], tuple[int, ...]]  # manager and terminals, what is left of the budgets
HELD_UNKNOWN: Final = -1
_NEVER: Final = 99
_FEW: Final = 1024
_SHIFT: Final = 21  # numbers of parts are below 2 ** 21
_WORDS: Final = 9


def each(compute: Callable[..., int], *columns: Numbers) -> Numbers:
    """`compute` of each row of the columns, made once for each different row."""
    key = columns[0]
    if any(len(column) and int(column.max()) >> _SHIFT for column in columns):
        raise OverflowError(f"a part of a state has a number of 2 ** {_SHIFT} or more")
    for column in columns[1:]:
        key = key << _SHIFT | column
    different, inverse = np.unique(key, return_inverse=True)
    made = np.empty(len(different), np.int64)
    for index, number in enumerate(different.tolist()):
        of = [number >> _SHIFT * i & (1 << _SHIFT) - 1 for i in range(len(columns) - 1)]
        made[index] = compute(number >> _SHIFT * (len(columns) - 1), *reversed(of))
    return made[inverse]


class Facts:
    """What is looked at of numbered things, a row for each, found as they come."""

    def __init__(
        self, names: Sequence[str], count: Callable[[], int], find: Callable[[int], Sequence[int]]
    ) -> None:
        self._at: Final = {name: index for index, name in enumerate(names)}
        self._count, self._find = count, find
        self._rows: Numbers = np.zeros((_FEW, len(names)), np.int64)
        self._found = 0

    def column(self, name: str) -> Numbers:
        """One fact of all that were found."""
        wanted = self._count()
        while len(self._rows) < wanted:
            self._rows = np.concatenate((self._rows, np.zeros_like(self._rows)))
        for number in range(self._found, wanted):
            self._rows[number] = self._find(number)
        self._found = wanted
        return self._rows[:, self._at[name]]


class Followed(NamedTuple):
    """What follows: from which state (by index), to what ground and cells, with what trouble."""

    source: Numbers
    ground: Numbers
    cells: list[Numbers]
    trouble: Numbers


class Halves:
    """The line by its halves."""

    def __init__(
        self, parties: ExploredParties, grounds: Sequence[Ground], cells: Sequence[Sequence[Cell]]
    ) -> None:
        self.parties: Final = parties
        self._units: Final = range(len(parties.units))
        self._grounds: Final = Numbered[Ground]()
        self._cells: Final = [Numbered[Cell]() for _ in self._units]
        self._effects: Final = Numbered[Effects]()
        self._effects.number(())
        for ground in grounds:
            self._grounds.number(ground)
        for numbered, known in zip(self._cells, cells, strict=True):
            for cell in known:
                numbered.number(cell)
        self.grounds_named: Final = len(grounds)
        self.cells_named: Final = [len(known) for known in cells]
        lies = [f"lies{i}" for i in range(len(TERMINALS))]
        holds = [f"holds{unit}" for unit in self._units]
        self.of_grounds: Final = Facts(
            ("epoch", "counter", "tokens", "grants", "defined", "on_sight", "bad", *lies, *holds),
            lambda: len(self._grounds.things),
            self._ground_facts,
        )
        near = [f"near{i}" for i in range(len(PEERS))]
        needs = [f"needs{i}" for i in range(len(TERMINALS))]
        names = (
            "granted",
            "stands",
            "shown",
            "held",
            "speaks",
            "finished",
            "oldest",
            "tokens",
            *near,
            *needs,
        )
        self.of_cells: Final = [
            Facts(names, partial(self._cells_found, unit), partial(self._cell_facts, unit))
            for unit in self._units
        ]

    @property
    def grounds(self) -> Sequence[Ground]:
        """All grounds found."""
        return self._grounds.things

    @property
    def cells(self) -> Sequence[Sequence[Cell]]:
        """All cells found, by unit."""
        return [numbered.things for numbered in self._cells]

    def start(self) -> tuple[Numbers, list[Numbers]]:
        """A day under way, before the first train comes."""
        ground = self._grounds.number(((0,) * (1 + len(TERMINALS)), tuple(self.parties.line.budgets)))
        nothing: Queues = ((),) * (2 * len(PEERS))
        cells = [np.array([n.number((0, nothing, 0))]) for n in self._cells]
        return np.array([ground]), cells

    # facts ------------------------------------------------------------------------------------------------------------

    def _ground_facts(self, number: int) -> Sequence[int]:
        (manager, *terminals), _ = self._grounds.things[number]
        known, kinds = self.parties.managers.things[manager], self.parties.terminals
        register, stood = known.kept.register, [k.things[t] for k, t in zip(kinds, terminals, strict=True)]
        in_use = tokens.of_manager(known)
        for terminal in stood:
            in_use |= tokens.of_terminal(terminal)
        return (
            known.epoch,
            register.counter if known.power else -1,
            in_use,
            self.parties.manager_grants(manager),
            known.power and register.defined,
            mask_of(register.unswept),
            bool(known.bad),
            *map(lie_code, stood),
            *self.parties.held_by_register(manager),
        )

    def _cells_found(self, unit: int) -> int:
        return len(self._cells[unit].things)

    def _cell_facts(self, unit: int, number: int) -> Sequence[int]:
        train_number, air, granted = self._cells[unit].things[number]
        model, train = self.parties.train_models[unit], self.parties.trains[unit].things[train_number]
        telegrams, authority = self.parties.telegrams.things, train.duty.authority
        stands, in_use, needs = model.occupied(train), tokens.of_train(train), dict[str, int]()
        for telegram in (t for queue in air for t in queue):
            in_use |= tokens.of_telegram(telegrams[telegram])
        for span in model.plan(train).spans:
            if stands & BIT[span.section_id]:
                needs |= {needed.terminal_id: LIES[needed.position] for needed in span.points}
        silent = not train.power or train.place is TrainPlace.GONE
        knows = not silent and (authority.on_line or authority.leaving)
        return (
            granted,
            stands,
            model.seen_or_shown(train),
            mask_of(authority.held) if knows else HELD_UNKNOWN,
            model.speaks(train),
            train.place is TrainPlace.GONE and not authority.perhaps_on_line,
            min((telegrams[t].epoch for t in air[1]), default=_NEVER),
            in_use,
            *(bool(air[2 * peer] or air[2 * peer + 1]) for peer in range(len(PEERS))),
            *(needs.get(terminal, 0) for terminal in TERMINALS),
        )

    # what follows -----------------------------------------------------------------------------------------------------

    def following(self, ground: Numbers, cells: Sequence[Numbers]) -> Iterator[Followed]:
        """All that may follow, counted as one where it is."""
        for unit in self._units:
            yield self._as_one(self._of_halves(ground, cells, unit))
        yield self._as_one(self._of_ground(ground, cells))

    def _of_halves(self, ground: Numbers, cells: Sequence[Numbers], unit: int) -> Followed:
        pairs, which = np.unique(ground << _SHIFT | cells[unit], return_inverse=True)
        rows, counts = list[tuple[int, ...]](), list[int]()
        for pair in pairs.tolist():
            before = len(rows)
            rows += self._half(unit, pair >> _SHIFT, pair & (1 << _SHIFT) - 1)
            counts.append(len(rows) - before)
        source, row = _joined(rows, np.array(counts, np.int64), which, 5)
        for other in self._units:
            if other != unit:
                occupied = self.of_cells[other].column("stands")[cells[other][source]]
                may = occupied & row[:, 0] == 0
                source, row = source[may], row[may]
        after = [column[source] for column in cells]
        after[unit] = row[:, 2]
        for other in self._units:
            if other != unit:
                after[other] = self._sent(other, after[other], row[:, 3])
        return Followed(source, row[:, 1], after, row[:, 4])

    def _sent(self, unit: int, cells: Numbers, effects: Numbers) -> Numbers:
        some = np.flatnonzero(effects)
        if len(some):
            cells = cells.copy()
            cells[some] = each(partial(self._with, unit), cells[some], effects[some])
        return cells

    def _half(self, unit: int, number: int, cell: int) -> Iterator[tuple[int, ...]]:
        """Rows: sections that no other may stand in, ground, cell, telegrams to others, trouble."""
        (manager, *terminals), left = self._grounds.things[number]
        train, air, granted = self._cells[unit].things[cell]
        make, none, loss = self.parties.make, UnwishedFor.NONE, _spent(left, UnwishedFor.LOSS)
        for way, queue in enumerate(air):
            if not queue:
                continue
            rest, telegram, (peer, to_unit) = _put(air, way, queue[1:]), queue[0], divmod(way, 2)
            if loss is not None:
                lost = self._grounds.number(((manager, *terminals), loss))
                yield 0, lost, self._cell(unit, train, rest, granted), 0, UnwishedFor.LOSS
            parts, remembered, after, sends = [manager, *terminals], granted, train, ()
            if to_unit:
                made = make(StepKind.UNIT_HEARS, unit, train, peer, telegram)
                after, rest = made.state, _up(rest, made.sends)
            elif peer == 0:
                made = make(StepKind.MANAGER_HEARS, manager, unit, telegram, granted)
                parts[0], remembered, sends = made.state, made.granted, made.sends
            else:
                made = make(StepKind.TERMINAL_HEARS, peer - 1, terminals[peer - 1], unit, telegram)
                parts[peer], sends = made.state, made.sends
            mine, others = _down(rest, unit, peer, sends)
            changed = self._grounds.number((tuple(parts), left))
            yield 0, changed, self._cell(unit, after, mine, remembered), self._effects.number(others), none
        for event in make(StepKind.UNIT_EVENTS, unit, train):
            yield from self._event(unit, event, (manager, *terminals), left, self._cells[unit].things[cell])

    def _event(
        self, unit: int, event: LocalEvent, parts: tuple[int, ...], left: tuple[int, ...], cell: Cell
    ) -> Iterator[tuple[int, ...]]:
        _, air, granted = cell
        trouble = event.trouble or (UnwishedFor.DELAY if any(air) else UnwishedFor.NONE)
        rest, guard, free = _spent(left, trouble), event.guard, 0
        if rest is None:
            return
        if guard.kind is GuardKind.FREE:
            free = guard.of
        elif guard.position is not None:
            lies = (
                lie_code(self.parties.terminals[guard.of].things[parts[guard.of + 1]]) == LIES[guard.position]
            )
            if lies is not (guard.kind is GuardKind.LIES):
                return
        changed, air, others = list(parts), _up(air, event.sends), Effects()
        if event.left:
            made = self.parties.make(StepKind.BOUNDARY_PASSED, changed[0])
            changed[0] = made.state
            air, others = _down(air, unit, 0, made.sends)
        for index in (*event.locks, *event.unlocks):
            locked = int(index in event.locks)
            made = self.parties.make(StepKind.LOCKED_BY_HAND, index, changed[index + 1], locked)
            changed[index + 1] = made.state
            air, more = _down(air, unit, index + 1, made.sends)
            others += more
        after = self._cell(unit, event.state, air, granted)
        yield free, self._grounds.number((tuple(changed), rest)), after, self._effects.number(others), trouble

    def _of_ground(self, ground: Numbers, cells: Sequence[Numbers]) -> Followed:
        grounds, which = np.unique(ground, return_inverse=True)
        rows, counts = list[tuple[int, ...]](), list[int]()
        for number in grounds.tolist():
            before = len(rows)
            rows += self._ground_events(number)
            counts.append(len(rows) - before)
        source, row = _joined(rows, np.array(counts, np.int64), which, _WORDS + len(self._units))
        after, peer, trouble, word, about, stands, corrects, quiet, epoch = (row[:, i] for i in range(_WORDS))
        may, near = np.ones(len(source), bool), np.zeros(len(source), bool)
        for unit, facts in enumerate(self.of_cells):
            cell = cells[unit][source]
            may &= (word == 0) | (facts.column("oldest")[cell] >= epoch)
            hears = facts.column("oldest")[cell] != _NEVER
            true = (facts.column("speaks")[cell] == 0) | ((corrects != 0) & ~hears)
            true &= facts.column("shown")[cell] == stands
            may &= (about != unit) | (quiet == 0) | ~hears
            may &= (about != unit) | (true == (trouble == UnwishedFor.NONE))
            for at in range(len(PEERS)):
                near |= (peer == at) & (facts.column(f"near{at}")[cell] != 0)
        trouble = np.where((trouble == UnwishedFor.NONE) & near, UnwishedFor.DELAY, trouble)
        source, after, trouble, row = source[may], after[may], trouble[may], row[may]
        after = each(self._ground_spent, after, trouble)
        may = after >= 0
        source, after, trouble, row = source[may], after[may], trouble[may], row[may]
        sent = [self._sent(u, column[source], row[:, _WORDS + u]) for u, column in enumerate(cells)]
        return Followed(source, after, sent, trouble)

    def _ground_spent(self, number: int, trouble: int) -> int:
        parts, left = self._grounds.things[number]
        rest = _spent(left, UnwishedFor(trouble))
        return -1 if rest is None else self._grounds.number((parts, rest))

    def _ground_events(self, number: int) -> Iterator[tuple[int, ...]]:
        """Rows: ground, peer, trouble, whether a word, about whom, where that stands, whether it corrects and
        waits until nothing is on the air to that unit, and the boot that it is said in; then telegrams by unit.
        """
        parts, left = self._grounds.things[number]
        epoch, make = self.parties.managers.things[parts[0]].epoch, self.parties.make
        errs = make(StepKind.PERSONS_ERR, parts[0]) if left[UnwishedFor.WORD - 1] else ()
        by_peer = [(0, (*make(StepKind.MANAGER_EVENTS, parts[0]), *errs))]
        by_peer += [
            (index + 1, make(StepKind.TERMINAL_EVENTS, index, parts[index + 1]))
            for index in range(len(TERMINALS))
        ]
        for peer, event in ((peer, event) for peer, events in by_peer for event in events):
            after = self._grounds.number(((*parts[:peer], event.state, *parts[peer + 1 :]), left))
            sends = [
                tuple((to, 2 * peer + 1, t) for to, t in event.sends if to == unit) for unit in self._units
            ]
            said = event.word, event.about, event.stands, event.corrects, event.quiet, epoch
            yield after, peer, event.trouble, *map(int, said), *map(self._effects.number, sends)

    # what counts as one -----------------------------------------------------------------------------------------------

    def _as_one(self, found: Followed) -> Followed:
        """Without correlations of grants that can be repeated no more, and with tokens counted anew."""
        ground, cells = found.ground, list(found.cells)
        grants = self.of_grounds.column("grants")[ground]
        in_use = self.of_grounds.column("tokens")[ground]
        for unit, facts in enumerate(self.of_cells):
            idle = (grants >> unit & 1 == 0) & (facts.column("granted")[cells[unit]] != 0)
            at = np.flatnonzero(idle)
            cells[unit] = cells[unit].copy()
            cells[unit][at] = each(partial(self._forgot, unit), cells[unit][at])
            in_use = in_use | facts.column("tokens")[cells[unit]]
        epoch, counter = (self.of_grounds.column(name)[ground] for name in ("epoch", "counter"))
        key = (in_use << 8) | (epoch << 5) | (counter + 1)
        different, which = np.unique(key, return_inverse=True)
        order = [tokens.in_order(k >> 8, k >> 5 & 7, (k & 31) - 1) for k in different.tolist()]
        at = np.flatnonzero(~np.array(order, bool)[which])
        bits, number = np.unique(in_use[at], return_inverse=True)
        known = bits.tolist()
        ground = ground.copy()
        ground[at] = each(partial(self._ground_anew, known), ground[at], number)
        for unit in self._units:
            of = cells[unit]
            of[at] = each(partial(self._cell_anew, unit, known), of[at], number)
        return Followed(found.source, ground, cells, found.trouble)

    def _ground_anew(self, known: Sequence[int], number: int, which: int) -> int:
        bits = known[which]
        (manager, *terminals), left = self._grounds.things[number]
        fresh = [self.parties.make(StepKind.TERMINAL_ANEW, i, t, bits) for i, t in enumerate(terminals)]
        return self._grounds.number(((self.parties.make(StepKind.MANAGER_ANEW, manager, bits), *fresh), left))

    def _cell_anew(self, unit: int, known: Sequence[int], cell: int, which: int) -> int:
        bits = known[which]
        train, air, granted = self._cells[unit].things[cell]
        make, telegrams = self.parties.make, self.parties.telegrams.things
        fresh = tuple(
            tuple(
                make(StepKind.TELEGRAM_ANEW, t, bits) if tokens.of_telegram(telegrams[t]) else t
                for t in queue
            )
            for queue in air
        )
        return self._cell(unit, make(StepKind.UNIT_ANEW, unit, train, bits), fresh, granted)

    def _forgot(self, unit: int, cell: int) -> int:
        train, air, _ = self._cells[unit].things[cell]
        return self._cell(unit, train, air, 0)

    def _with(self, unit: int, cell: int, effect: int) -> int:
        train, air, granted = self._cells[unit].things[cell]
        for to, way, telegram in self._effects.things[effect]:
            if to == unit:
                air = _put(air, way, (*air[way], telegram))
        return self._cell(unit, train, air, granted)

    def _cell(self, unit: int, train: int, air: Queues, granted: int) -> int:
        """The number of a cell, its correlations counted anew in their order."""
        telegrams, numbers = self.parties.telegrams.things, self.parties.trains[unit].things[train].numbers
        carried = {t: telegrams[t].correlation for queue in air for t in queue}
        renamed, counted = renaming(
            (*(n for _, n in numbers.open), *carried.values(), granted), numbers.correlation
        )
        if counted != numbers.correlation or any(before != after for before, after in renamed):
            by, make = dict(renamed), self.parties.make
            if counted != numbers.correlation or any(by.get(n, n) != n for _, n in numbers.open):
                train = make(StepKind.UNIT_RENAMED, unit, train, renamed, counted)
            new = {
                t: make(StepKind.TELEGRAM_RENAMED, t, by[n]) for t, n in carried.items() if by.get(n, n) != n
            }
            air = tuple(tuple(new.get(t, t) for t in queue) for queue in air)
            granted = by.get(granted, granted)
        return self._cells[unit].number((train, air, granted))


def _joined(
    rows: Sequence[tuple[int, ...]], counts: Numbers, which: Numbers, width: int
) -> tuple[Numbers, Numbers]:
    """For each state its rows, one behind another: whose they are, and the rows."""
    table = np.array(rows, np.int64).reshape(len(rows), width)
    firsts, count = (np.cumsum(counts) - counts)[which], counts[which]
    source = np.repeat(np.arange(len(which)), count)
    within = np.arange(len(source)) - np.repeat(np.cumsum(count) - count, count)
    return source, table[np.repeat(firsts, count) + within]


def _put(air: Queues, way: int, queue: tuple[int, ...]) -> Queues:
    return (*air[:way], queue, *air[way + 1 :])


def _up(air: Queues, sends: Sends) -> Queues:
    for peer, telegram in sends:
        air = _put(air, 2 * peer, (*air[2 * peer], telegram))
    return air


def _down(air: Queues, unit: int, peer: int, sends: Sends) -> tuple[Queues, Effects]:
    """A peer's telegrams to this unit are on the air; those to others, by unit and way."""
    way = 2 * peer + 1
    for telegram in (t for to, t in sends if to == unit):
        air = _put(air, way, (*air[way], telegram))
    return air, tuple((to, way, t) for to, t in sends if to != unit)


def _spent(left: tuple[int, ...], trouble: UnwishedFor) -> tuple[int, ...] | None:
    """What is left of the budgets; None: nothing of this one."""
    if trouble is UnwishedFor.NONE or left[trouble - 1] == ANY:
        return left
    at = trouble - 1
    return (*left[:at], left[at] - 1, *left[at + 1 :]) if left[at] else None
