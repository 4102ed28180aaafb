"""A train with the telegrams from and to its unit, as a number, for the search: what can come of it by itself, and what
the ground makes of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

from verify import tokens
from verify.explored_line import BIT, TERMINALS, UnwishedFor, mask_of
from verify.happening import GuardKind
from verify.parties import ExploredParties, LocalEvent, Numbered, Sends, StepKind, renaming
from verify.tables import Choices, GrowingRows, NumbersInUse, Once
from verify.terminal import LIES
from verify.train import PEERS, TrainPlace

Air = tuple[tuple[int, ...], ...]
# train, telegrams by way (from and to each peer), correlation of the last grant
CellKey = tuple[int, Air, int]
WAYS: Final = 2 * len(PEERS)
NEVER: Final = 99
HELD_UNKNOWN: Final = -1
CELL_BITS, EFFECT_BITS, TOKEN_BITS, CORRELATION_BITS = 21, 20, 20, 10
# columns of a cell
TRAIN, GRANTED, SAID, OCCUPIED, HELD, SPEAKS, FINISHED, IN_USE, OLDEST, SEEN_OR_SHOWN = range(10)
# by peer; by peer: the first telegram; by terminal
NEAR, HEAD, NEEDS = 10, 10 + len(PEERS), 10 + 2 * len(PEERS)
# columns of a choice
AFTER, COSTS, GUARD, GUARD_OF, GROUND = range(5)


class TrainCells:
    """All cells of one unit."""

    def __init__(
        self,
        parties: ExploredParties,
        unit: int,
        grounds: Numbered[tuple[bool, tuple[int, ...], tuple[int, ...]]],
    ) -> None:
        self._parties: Final = parties
        self._unit: Final = unit
        self._grounds: Final = grounds
        self.keys: Final = Numbered[CellKey]()
        self.in_states: Final = NumbersInUse()  # most cells only come between two states
        self.effects: Final = Numbered[Sends]()
        self.said: Final = Numbered[tuple[int, int]]()
        self.rows: Final = GrowingRows(NEEDS + len(TERMINALS))
        self.choices: Final = Choices(5, self._choices)
        self.sent: Final = Once(self._sent, 1, CELL_BITS, EFFECT_BITS)
        self.without_first: Final = tuple(
            Once(partial(self._first_gone, 2 * peer), 1, CELL_BITS) for peer in range(len(PEERS))
        )
        self.heard: Final = Once(self._heard, 1, CELL_BITS, CORRELATION_BITS, EFFECT_BITS)
        self.forgets: Final = Once(self._forgets, 1, CELL_BITS)
        self.in_use: Final = Numbered[int]()
        self.anew: Final = Once(self._anew, 1, CELL_BITS, TOKEN_BITS)
        self.effects.number(())
        self.number(0, ((),) * WAYS, 0)

    def named(self) -> tuple[CellKey, ...]:
        """Those that are part of a state, as states number them."""
        return tuple(self.keys.things[number] for number in map(int, self.in_states.things))

    def number(self, train: int, air: Air, granted: int) -> int:
        """The number of a cell, with its correlations counted anew."""
        if (as_it_is := self.keys.known((train, air, granted))) is not None:
            return as_it_is
        telegrams = self._parties.telegrams.things
        numbers = self._parties.trains[self._unit].things[train].numbers
        carried = {t: telegrams[t].correlation for queue in air for t in queue}
        in_use = (*(n for _, n in numbers.open), *carried.values(), granted)
        renamed, counted = renaming(in_use, numbers.correlation)
        by = dict(renamed)
        make = self._parties.make
        changed = {
            t: make(StepKind.TELEGRAM_RENAMED, t, by[n]) for t, n in carried.items() if by.get(n, n) != n
        }
        if counted != numbers.correlation or any(by.get(n, n) != n for _, n in numbers.open):
            train = make(StepKind.UNIT_RENAMED, self._unit, train, renamed, counted)
        air = tuple(tuple(changed.get(t, t) for t in queue) for queue in air)
        key = train, air, by.get(granted, granted)
        cell = self.keys.number(key)
        if cell == len(self.rows):
            self.rows.add(self._row(*key))
        return cell

    def _row(self, number: int, air: Air, granted: int) -> Sequence[int]:
        telegrams, model = self._parties.telegrams.things, self._parties.train_models[self._unit]
        train = self._parties.trains[self._unit].things[number]
        authority, occupied = train.duty.authority, model.occupied(train)
        knows = train.power and train.place is not TrainPlace.GONE
        held = mask_of(authority.held) if knows and (authority.on_line or authority.leaving) else HELD_UNKNOWN
        needs = {
            needed.terminal_id: LIES[needed.position]
            for span in model.plan(train).spans
            if occupied & BIT[span.section_id]
            for needed in span.points
        }
        in_use = tokens.of_train(train)
        for telegram in (t for queue in air for t in queue):
            in_use |= tokens.of_telegram(telegrams[telegram])
        heads = [air[2 * peer][0] if air[2 * peer] else -1 for peer in range(len(PEERS))]
        said = self.said.number((heads[0], granted)) if heads[0] >= 0 else -1
        return (
            number,
            granted,
            said,
            occupied,
            held,
            model.speaks(train),
            train.place is TrainPlace.GONE and not authority.perhaps_on_line,
            in_use,
            min((telegrams[t].epoch for t in air[1]), default=NEVER),
            model.seen_or_shown(train),
            *(bool(air[2 * peer] or air[2 * peer + 1]) for peer in range(len(PEERS))),
            *heads,
            *(needs.get(terminal, 0) for terminal in TERMINALS),
        )

    # what can come of a cell by itself -------------------------------------------------------------------------------

    def _choices(self, cell: int) -> list[Sequence[int]]:
        train, air, granted = self.keys.things[cell]
        make, found = self._parties.make, list[Sequence[int]]()
        for way, queue in enumerate(air):
            if not queue:
                continue
            found.append((self._popped(cell, way), UnwishedFor.LOSS, 0, 0, 0))
            if way % 2:
                heard = make(StepKind.UNIT_HEARS, self._unit, train, way // 2, queue[0])
                rest = (*air[:way], queue[1:], *air[way + 1 :])
                after = self.number(heard.state, _sent_up(rest, heard.sends), granted)
                found.append((after, UnwishedFor.NONE, 0, 0, 0))
        delay = UnwishedFor.DELAY if any(air) else UnwishedFor.NONE
        for event in make(StepKind.UNIT_EVENTS, self._unit, train):
            after = self.number(event.state, _sent_up(air, event.sends), granted)
            ground = self._grounds.number((event.left, event.locks, event.unlocks))
            found.append((after, event.trouble or delay, *_guard(event), ground))
        return found

    def _first_gone(self, way: int, cell: int) -> tuple[int]:
        return (self._popped(cell, way),)

    def _popped(self, cell: int, way: int) -> int:
        train, air, granted = self.keys.things[cell]
        return self.number(train, (*air[:way], air[way][1:], *air[way + 1 :]), granted)

    # what the ground makes of it -------------------------------------------------------------------------------------

    def _sent(self, cell: int, effect: int) -> tuple[int]:
        """With telegrams more on their way to the unit."""
        train, air, granted = self.keys.things[cell]
        ways = list(air)
        for way, telegram in self.effects.things[effect]:
            ways[way] = (*ways[way], telegram)
        return (self.number(train, tuple(ways), granted),)

    def _heard(self, cell: int, granted: int, effect: int) -> tuple[int]:
        """The manager has heard the first telegram to it, remembers this correlation of its last grant, and answers."""
        train, air, _ = self.keys.things[cell]
        ways = [air[0][1:], *air[1:]]
        for way, telegram in self.effects.things[effect]:
            ways[way] = (*ways[way], telegram)
        return (self.number(train, tuple(ways), granted),)

    def _forgets(self, cell: int) -> tuple[int]:
        """No request can be a repetition of the manager's last grant."""
        train, air, _ = self.keys.things[cell]
        return (self.number(train, air, 0),)

    def _anew(self, cell: int, which: int) -> tuple[int]:
        """With tokens counted anew among those in use."""
        train, air, granted = self.keys.things[cell]
        bits, make, telegrams = self.in_use.things[which], self._parties.make, self._parties.telegrams.things
        fresh = tuple(
            tuple(
                make(StepKind.TELEGRAM_ANEW, t, bits) if tokens.of_telegram(telegrams[t]) else t
                for t in queue
            )
            for queue in air
        )
        return (self.number(make(StepKind.UNIT_ANEW, self._unit, train, bits), fresh, granted),)


def _guard(event: LocalEvent) -> tuple[int, int]:
    guard = event.guard
    if guard.kind in (GuardKind.LIES, GuardKind.LIES_NOT):
        assert guard.position is not None
        return guard.kind, guard.of << 4 | LIES[guard.position]
    return guard.kind, guard.of


def _sent_up(air: Air, sends: Sends) -> Air:
    ways = list(air)
    for peer, telegram in sends:
        ways[2 * peer] = (*ways[2 * peer], telegram)
    return tuple(ways)
