"""How the parties' steps make up the line, one state at a time: which events there are and what they change elsewhere.

Written plainly, for the checker and for stories. The search does the same to many states at once in a way of its own
(`verify.expansion`); neither uses the other, and a test compares them state by state.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final, NamedTuple

from network.model import Position
from verify import tokens
from verify.explored_line import ANY, BIT, PORTAL, SECTIONS, TERMINALS, UnwishedFor, mask_of
from verify.happening import GuardKind
from verify.parties import ExploredParties, LocalEvent, Sends, StepKind, renaming
from verify.terminal import LIES, lie_code
from verify.train import PEERS, TrainPlace

Queues = tuple[tuple[int, ...], ...]  # by peer: telegrams from the unit, then telegrams to it, oldest first
TWO_TRAINS: Final = "two trains in one section"
HEARS, LOSES = "hears", "loses"
NO_TELEGRAMS: Final[Queues] = ((),) * (2 * len(PEERS))


class TrainCell(NamedTuple):
    """A train with the telegrams from and to its unit, and the correlation of the manager's last grant to it."""

    train: int
    air: Queues = NO_TELEGRAMS
    granted: int = 0


class StateOfLine(NamedTuple):
    """A state of the whole: numbers of local states, and what is left of the budgets."""

    manager: int
    terminals: tuple[int, ...]
    left: tuple[int, ...]
    cells: tuple[TrainCell, ...]


class Following(NamedTuple):
    """What may follow: who did what, with which telegram (-1: none) from or to whom. What has a trouble need not be."""

    who: str
    what: str
    trouble: UnwishedFor
    state: StateOfLine
    telegram: int = -1
    other: str = ""


class TrainView(NamedTuple):
    """What the rules of the whole look at of one train."""

    occupied: int
    seen_or_shown: int
    held: int | None  # None: its unit does not know, or says nothing
    speaks: bool
    finished: bool
    needs: tuple[int, ...]  # by terminal: how points under it must lie (0: it is on none)


class Composition:
    """Successors, and what must hold, of states of the line."""

    def __init__(self, parties: ExploredParties) -> None:
        self.parties: Final = parties
        self._units: Final = range(len(parties.units))
        self._views: Final[dict[tuple[int, int], TrainView]] = {}
        self._told_apart: Final[dict[tuple[int, TrainCell], TrainCell]] = {}
        self._cell_bits: Final[dict[tuple[int, TrainCell], int]] = {}
        self._ground_bits: Final[tuple[dict[int, int], dict[tuple[int, int], int]]] = ({}, {})

    def start(self) -> StateOfLine:
        """A day under way, before the first train comes."""
        cells = tuple(TrainCell(0) for _ in self._units)
        return StateOfLine(0, (0,) * len(TERMINALS), tuple(self.parties.line.budgets), cells)

    def following(self, state: StateOfLine) -> Iterator[Following]:
        """All that may follow."""
        for found in (
            *self._deliveries(state),
            *self._train_events(state),
            *self._manager_events(state),
            *self._terminal_events(state),
        ):
            yield found._replace(state=self._settled(found.state))

    # telegrams ------------------------------------------------------------------------------------------------------

    def _deliveries(self, state: StateOfLine) -> Iterator[Following]:
        for unit in self._units:
            for way, queue in enumerate(state.cells[unit].air):
                if not queue:
                    continue
                rest = _with_queue(state, unit, way, queue[1:])
                ends = self.parties.units[unit], PEERS[way // 2]
                sender, hearer = reversed(ends) if way % 2 else ends
                heard = self._heard(rest, unit, way, queue[0])
                yield Following(hearer, HEARS, UnwishedFor.NONE, heard, queue[0], sender)
                if (left := _spend(state.left, UnwishedFor.LOSS)) is not None:
                    yield Following(
                        sender, LOSES, UnwishedFor.LOSS, rest._replace(left=left), queue[0], hearer
                    )

    def _heard(self, state: StateOfLine, unit: int, way: int, telegram: int) -> StateOfLine:
        peer, to_unit = divmod(way, 2)
        cell = state.cells[unit]
        if to_unit:
            made = self.parties.make(StepKind.UNIT_HEARS, unit, cell.train, peer, telegram)
            return _sent_up(_with_cell(state, unit, cell._replace(train=made.state)), unit, made.sends)
        if peer == 0:
            made = self.parties.make(StepKind.MANAGER_HEARS, state.manager, unit, telegram, cell.granted)
            state = _with_cell(state, unit, cell._replace(granted=made.granted))
            return _sent_down(state._replace(manager=made.state), 0, made.sends)
        made = self.parties.make(StepKind.TERMINAL_HEARS, peer - 1, state.terminals[peer - 1], unit, telegram)
        return _sent_down(_with_terminal(state, peer - 1, made.state), peer, made.sends)

    # what happens at the parties --------------------------------------------------------------------------------------

    def _train_events(self, state: StateOfLine) -> Iterator[Following]:
        for unit in self._units:
            for event in self.parties.make(StepKind.UNIT_EVENTS, unit, state.cells[unit].train):
                trouble = event.trouble or _delay(state.cells[unit].air)
                left = _spend(state.left, trouble)
                if left is None or not self._guarded(state, unit, event):
                    continue
                cell = state.cells[unit]._replace(train=event.state)
                after = _sent_up(_with_cell(state, unit, cell)._replace(left=left), unit, event.sends)
                yield Following(self.parties.units[unit], event.name, trouble, self._elsewhere(after, event))

    def _guarded(self, state: StateOfLine, unit: int, event: LocalEvent) -> bool:
        guard = event.guard
        if guard.kind is GuardKind.NONE:
            return True
        if guard.kind is GuardKind.FREE:
            others = (self.view(state, other) for other in self._units if other != unit)
            return all(not other.occupied & guard.of for other in others)
        assert guard.position is not None
        lies = self._lie(state, guard.of) == LIES[guard.position]
        return lies is (guard.kind is GuardKind.LIES)

    def _lie(self, state: StateOfLine, index: int) -> int:
        return lie_code(self.parties.terminals[index].things[state.terminals[index]])

    def _elsewhere(self, state: StateOfLine, event: LocalEvent) -> StateOfLine:
        """What an event of a train does to the ground: its contact counts it out, its crew takes or gives back keys."""
        if event.left:
            made = self.parties.make(StepKind.BOUNDARY_PASSED, state.manager)
            state = _sent_down(state._replace(manager=made.state), 0, made.sends)
        for index in (*event.locks, *event.unlocks):
            locked = int(index in event.locks)
            made = self.parties.make(StepKind.LOCKED_BY_HAND, index, state.terminals[index], locked)
            state = _sent_down(_with_terminal(state, index, made.state), index + 1, made.sends)
        return state

    def _manager_events(self, state: StateOfLine) -> Iterator[Following]:
        errs = state.left[UnwishedFor.WORD - 1] > 0
        kinds = (StepKind.MANAGER_EVENTS, StepKind.PERSONS_ERR) if errs else (StepKind.MANAGER_EVENTS,)
        for event in (event for kind in kinds for event in self.parties.make(kind, state.manager)):
            if event.word and self._early(state):
                continue
            if event.about >= 0:
                about: int = event.about
                view, hears = self.view(state, about), state.cells[about].air[1] != ()
                if event.quiet and hears:
                    continue
                may = not view.speaks or (event.corrects and not hears)
                true = may and view.seen_or_shown == event.stands
                if true is not (event.trouble is UnwishedFor.NONE):
                    continue
            trouble = event.trouble or _delay(queue for cell in state.cells for queue in cell.air[:2])
            if (left := _spend(state.left, trouble)) is not None:
                after = state._replace(manager=event.state, left=left)
                yield Following("manager", event.name, trouble, _sent_down(after, 0, event.sends))

    def _early(self, state: StateOfLine) -> bool:
        """Whether a telegram of an earlier boot of the manager may still take effect."""
        epoch = self.parties.managers.things[state.manager].epoch
        return any(
            self.parties.telegrams.things[t].epoch < epoch for cell in state.cells for t in cell.air[1]
        )

    def _terminal_events(self, state: StateOfLine) -> Iterator[Following]:
        for index, terminal_id in enumerate(TERMINALS):
            near = _delay(q for cell in state.cells for q in cell.air[2 * index + 2 : 2 * index + 4])
            for event in self.parties.make(StepKind.TERMINAL_EVENTS, index, state.terminals[index]):
                trouble = event.trouble or near
                if (left := _spend(state.left, trouble)) is not None:
                    after = _with_terminal(state, index, event.state)._replace(left=left)
                    after = _sent_down(after, index + 1, event.sends)
                    yield Following(terminal_id, event.name, trouble, after)

    # states that are one ----------------------------------------------------------------------------------------------

    def _settled(self, state: StateOfLine) -> StateOfLine:
        """With correlations counted anew, and none kept of a grant that can be repeated no more."""
        grants = self.parties.manager_grants(state.manager)
        kept = (
            cell if grants >> unit & 1 else cell._replace(granted=0) for unit, cell in enumerate(state.cells)
        )
        state = state._replace(cells=tuple(self._renamed(unit, cell) for unit, cell in enumerate(kept)))
        manager = self.parties.managers.things[state.manager]
        counter = manager.kept.register.counter if manager.power else -1
        bits = self._tokens_in_use(state)
        return state if tokens.in_order(bits, manager.epoch, counter) else self._anew(state, bits)

    def _tokens_in_use(self, state: StateOfLine) -> int:
        parties, bits = self.parties, 0
        for unit, cell in enumerate(state.cells):
            bits |= self._bits_of(unit, cell)
        of_manager, of_terminals = self._ground_bits
        if state.manager not in of_manager:
            of_manager[state.manager] = tokens.of_manager(parties.managers.things[state.manager])
        for index, terminal in enumerate(state.terminals):
            if (index, terminal) not in of_terminals:
                of_terminals[index, terminal] = tokens.of_terminal(parties.terminals[index].things[terminal])
            bits |= of_terminals[index, terminal]
        return bits | of_manager[state.manager]

    def _bits_of(self, unit: int, cell: TrainCell) -> int:
        bits = self._cell_bits.get((unit, cell))
        if bits is None:
            bits = tokens.of_train(self.parties.trains[unit].things[cell.train])
            for telegram in (t for queue in cell.air for t in queue):
                bits |= tokens.of_telegram(self.parties.telegrams.things[telegram])
            self._cell_bits[unit, cell] = bits
        return bits

    def _anew(self, state: StateOfLine, bits: int) -> StateOfLine:
        make = self.parties.make
        cells = tuple(
            TrainCell(
                make(StepKind.UNIT_ANEW, unit, cell.train, bits),
                tuple(tuple(self._telegram_anew(t, bits) for t in queue) for queue in cell.air),
                cell.granted,
            )
            for unit, cell in enumerate(state.cells)
        )
        terminals = tuple(make(StepKind.TERMINAL_ANEW, i, t, bits) for i, t in enumerate(state.terminals))
        return StateOfLine(make(StepKind.MANAGER_ANEW, state.manager, bits), terminals, state.left, cells)

    def _telegram_anew(self, telegram: int, bits: int) -> int:
        has_token = tokens.of_telegram(self.parties.telegrams.things[telegram])
        return self.parties.make(StepKind.TELEGRAM_ANEW, telegram, bits) if has_token else telegram

    def _renamed(self, unit: int, cell: TrainCell) -> TrainCell:
        found = self._told_apart.get((unit, cell))
        if found is not None:
            return found
        numbers = self.parties.trains[unit].things[cell.train].numbers
        telegrams = {t: self.parties.telegrams.things[t].correlation for queue in cell.air for t in queue}
        in_use = (*(n for _, n in numbers.open), *telegrams.values(), cell.granted)
        renamed, counted = renaming(in_use, numbers.correlation)
        by = dict(renamed)
        new = {
            t: t if by.get(n, n) == n else self.parties.make(StepKind.TELEGRAM_RENAMED, t, by[n])
            for t, n in telegrams.items()
        }
        train = cell.train
        if counted != numbers.correlation or any(by.get(n, n) != n for _, n in numbers.open):
            train = self.parties.make(StepKind.UNIT_RENAMED, unit, train, renamed, counted)
        air = tuple(tuple(new[t] for t in queue) for queue in cell.air)
        after = TrainCell(train, air, by.get(cell.granted, cell.granted))
        self._told_apart[unit, cell] = after
        return after

    # what must hold ---------------------------------------------------------------------------------------------------

    def view(self, state: StateOfLine, unit: int) -> TrainView:
        """What is seen of a train."""
        key = unit, state.cells[unit].train
        if key not in self._views:
            self._views[key] = self._view(*key)
        return self._views[key]

    def _view(self, unit: int, number: int) -> TrainView:
        model, train = self.parties.train_models[unit], self.parties.trains[unit].things[number]
        occupied, authority = model.occupied(train), train.duty.authority
        knows = train.power and train.place is not TrainPlace.GONE
        needs = {
            TERMINALS.index(needed.terminal_id): LIES[needed.position]
            for span in model.plan(train).spans
            if occupied & BIT[span.section_id]
            for needed in span.points
        }
        return TrainView(
            occupied,
            model.seen_or_shown(train),
            mask_of(authority.held) if knows and (authority.on_line or authority.leaving) else None,
            model.speaks(train),
            train.place is TrainPlace.GONE and not authority.perhaps_on_line,
            tuple(needs.get(index, 0) for index in range(len(TERMINALS))),
        )

    def finished(self, state: StateOfLine) -> bool:
        """Whether every train has come and gone, its unit knows that, and the manager could let the next one in."""
        manager = self.parties.managers.things[state.manager]
        free = manager.power and manager.kept.register.defined
        held = self.parties.held_by_register(state.manager)
        return free and not any(held) and all(self.view(state, unit).finished for unit in self._units)

    def broken(self, state: StateOfLine) -> str:
        """Which rule is broken, in words; empty: none."""
        views = [self.view(state, unit) for unit in self._units]
        for one, view in enumerate(views):
            if any(view.occupied & other.occupied for other in views[one + 1 :]):
                return TWO_TRAINS
            if any((view.held or 0) & (other.held or 0) for other in views[one + 1 :]):
                return "two units hold one section"
            if view.held is not None and view.occupied & ~view.held:
                return "a train stands in what its unit does not hold"
            if any(need and self._lie(state, index) != need for index, need in enumerate(view.needs)):
                return "points do not lie, or are not locked, as the train on them needs"
        manager = self.parties.managers.things[state.manager]
        register = manager.kept.register
        if manager.power and register.defined:
            on_sight = mask_of(register.unswept)
            held = self.parties.held_by_register(state.manager)
            if any(view.occupied & ~mine & ~on_sight for view, mine in zip(views, held, strict=True)):
                return "free in a defined register, and a train stands in it"
        return manager.bad


def _with_cell(state: StateOfLine, unit: int, cell: TrainCell) -> StateOfLine:
    return state._replace(cells=(*state.cells[:unit], cell, *state.cells[unit + 1 :]))


def _with_queue(state: StateOfLine, unit: int, way: int, queue: tuple[int, ...]) -> StateOfLine:
    cell = state.cells[unit]
    return _with_cell(state, unit, cell._replace(air=(*cell.air[:way], queue, *cell.air[way + 1 :])))


def _with_terminal(state: StateOfLine, index: int, terminal: int) -> StateOfLine:
    return state._replace(terminals=(*state.terminals[:index], terminal, *state.terminals[index + 1 :]))


def _sent_up(state: StateOfLine, unit: int, sends: Sends) -> StateOfLine:
    """A unit's telegrams, each to its peer."""
    for peer, telegram in sends:
        state = _with_queue(state, unit, 2 * peer, (*state.cells[unit].air[2 * peer], telegram))
    return state


def _sent_down(state: StateOfLine, peer: int, sends: Sends) -> StateOfLine:
    """The telegrams of the manager or of a terminal, each to its unit."""
    for unit, telegram in sends:
        queue = state.cells[unit].air[2 * peer + 1]
        state = _with_queue(state, unit, 2 * peer + 1, (*queue, telegram))
    return state


def _delay(queues: Iterable[tuple[int, ...]]) -> UnwishedFor:
    """What it costs when something happens at a party with these telegrams under way."""
    return UnwishedFor.DELAY if any(queues) else UnwishedFor.NONE


def _spend(left: tuple[int, ...], trouble: UnwishedFor) -> tuple[int, ...] | None:
    """What is left of the budgets; None: nothing of this one is."""
    if trouble is UnwishedFor.NONE:
        return left
    at = trouble - 1
    if left[at] == ANY:
        return left
    return None if left[at] == 0 else (*left[:at], left[at] - 1, *left[at + 1 :])


__all__ = ["PORTAL", "SECTIONS", "Composition", "Following", "Position", "StateOfLine", "TrainCell"]
